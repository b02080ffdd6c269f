//! Output of commands: plain text, tables and sizes on stdout; messages on stderr; files.

use std::io::Write;
use std::path::Path;
use std::time::SystemTime;

use chrono::{DateTime, SecondsFormat, Utc};

use milkglass::error::{Input, Result};
use milkglass::internals::view::atomic_file::write_atomically;
use milkglass::measure::table::Table;

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

/// A table with aligned columns as text.
pub(super) fn table<'a>(heads: impl IntoIterator<Item = &'a str>, rows: Vec<Vec<String>>) -> String {
    Table::plain(heads, rows).text()
}

/// The date and time now: UTC, `2026-01-31T23:59:59Z`.
pub(super) fn now() -> String {
    DateTime::<Utc>::from(SystemTime::now()).to_rfc3339_opts(SecondsFormat::Secs, true)
}

/// Writes a file, whole or not at all.
pub(super) fn write(path: &Path, content: impl AsRef<[u8]>) -> Result<()> {
    write_atomically(path, |beside| std::fs::write(beside, content).map_err(|error| error.to_string()))
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
