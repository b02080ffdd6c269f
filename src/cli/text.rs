//! Output of commands: plain text, tables and sizes on stdout; messages on stderr.

use std::io::Write;

use milkglass::error::{Input, Result};

/// Writes a line to standard error; a failure to write is ignored.
macro_rules! tell {
    ($($argument:tt)*) => {{
        use std::io::Write as _;
        let _ = writeln!(std::io::stderr(), $($argument)*);
    }};
}

/// Writes a result to standard output; a closed pipe is not an error.
pub(super) fn print(text: &str) -> Result<()> {
    let mut out = std::io::stdout().lock();
    match out.write_all(text.as_bytes()).and_then(|()| out.flush()) {
        Err(error) if error.kind() != std::io::ErrorKind::BrokenPipe => {
            Err(Input::new(format!("standard output could not be written: {error}")).into())
        }
        _ => Ok(()),
    }
}

/// A table with aligned columns; columns in `right` are right-aligned.
pub(super) fn table(header: &[&str], right: &[usize], rows: &[Vec<String>]) -> String {
    let width =
        |k: usize| rows.iter().map(|row| row[k].chars().count()).chain([header[k].chars().count()]).max().unwrap_or(0);
    let widths: Vec<usize> = (0..header.len()).map(width).collect();
    let line = |cells: &mut dyn Iterator<Item = &str>| {
        let padded = cells.enumerate().map(|(k, cell)| {
            let gap = " ".repeat(widths[k].saturating_sub(cell.chars().count()));
            if right.contains(&k) { format!("{gap}{cell}") } else { format!("{cell}{gap}") }
        });
        format!("{}\n", padded.collect::<Vec<_>>().join("  ").trim_end())
    };
    let mut text = line(&mut header.iter().copied());
    for row in rows {
        text += &line(&mut row.iter().map(String::as_str));
    }
    text
}

/// Bytes in a readable unit.
pub(super) fn size(bytes: u64) -> String {
    match bytes {
        0..10_000 => format!("{bytes} B"),
        10_000..10_000_000 => format!("{:.1} KiB", bytes as f64 / 1024.0),
        _ => format!("{:.1} MiB", bytes as f64 / 1_048_576.0),
    }
}

/// The last error that a process of this program wrote, without the program's name.
pub(super) fn last_error(said: &str) -> String {
    let start = said.rfind("milkglass: ").map_or(said, |at| &said[at + "milkglass: ".len()..]);
    start.trim().to_string()
}
