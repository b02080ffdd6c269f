//! The limit of memory for a scene, a mesh or a table.

use clap::Args;

use milkglass::scene::{Files, Memory};

/// The limit, as an option of every command that loads files.
#[derive(Args, Clone)]
pub(super) struct MemoryArgument {
    /// Memory limit, such as 500M, 16G or a number of bytes: a request beyond it is refused before anything is
    /// allocated.
    #[arg(long, value_name = "SIZE", default_value_t = Size(Memory::USUAL), value_parser = parse)]
    limit_memory: Size,
}

/// Bytes.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Size(u64);

impl std::fmt::Display for Size {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self.0 {
            bytes if bytes.is_multiple_of(1 << 30) => write!(out, "{}G", bytes >> 30),
            bytes => write!(out, "{bytes}"),
        }
    }
}

impl MemoryArgument {
    /// The argument as words of a command line.
    pub(super) fn words(&self) -> Vec<String> {
        vec!["--limit-memory".into(), self.limit_memory.to_string()]
    }

    /// Access to files on disk within this limit.
    pub(super) fn files(&self) -> Files {
        Files::on_disk(self.limit_memory.0)
    }
}

/// Parses `500M`: a number above 0, and optionally K, M, G or T, powers of 1024.
fn parse(text: &str) -> Result<Size, String> {
    let (number, steps) = match text.trim_end_matches(|c: char| c.is_ascii_alphabetic()) {
        digits if digits.len() == text.len() => (digits, 0),
        digits => {
            let unit = text[digits.len()..].to_ascii_uppercase();
            let unit = unit.strip_suffix("IB").or_else(|| unit.strip_suffix('B')).unwrap_or(&unit).to_owned();
            (digits, ["", "K", "M", "G", "T"].iter().position(|name| *name == unit).unwrap_or(9) as u32)
        }
    };
    let bytes = number.parse::<u64>().ok().filter(|&n| n > 0 && steps < 9);
    let bytes = bytes.and_then(|n| n.checked_mul(1 << (10 * steps.min(4))));
    bytes.map(Size).ok_or_else(|| "expected a number of bytes above 0, or one with K, M, G or T".into())
}

#[cfg(test)]
mod tests {
    use crate::cli::memory::*;

    #[test]
    fn sizes_have_units() {
        for (text, bytes) in [("1", 1), ("500M", 500 << 20), ("16g", 16 << 30), ("2KiB", 2048), ("3TB", 3 << 40)] {
            assert_eq!(parse(text), Ok(Size(bytes)), "{text}");
        }
        for bad in ["", "0", "G", "-1", "1.5G", "4X", "99999999999T", "1 G", "\u{e9}G"] {
            assert!(parse(bad).is_err(), "{bad}");
        }
        assert_eq!(Size(Memory::USUAL).to_string(), "16G");
    }
}
