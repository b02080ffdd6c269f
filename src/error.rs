//! The program's error type: whose fault it is, where, what was found and what was expected.

use std::path::{Path, PathBuf};

/// What went wrong, sorted by whose fault it is. The variant decides the program's exit code.
///
/// ```
/// use milkglass::{Error, Scene};
///
/// let Err(Error::Input(fault)) = Scene::parse("my.toml", "[[light]]\ntype = \"sun\"", &[]) else { unreachable!() };
/// assert_eq!((fault.line, fault.found.as_deref()), (Some(2), Some("sun")));
/// ```
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// The user's input: arguments, scene, mesh, CSV. Exit code 2.
    #[error("{0}")]
    Input(Input),
    /// There is no such device, or the device failed. Exit code 3.
    #[error("{doing}: {what}")]
    Device {
        /// What the program was doing when it happened.
        doing: String,
        /// The driver's answer, in words.
        what: String,
    },
    /// The lists of links are too long to keep between frames. Exit code 3.
    #[error("keeping lists between frames: {what}")]
    TooMuchToKeep {
        /// Their size, and the limit.
        what: String,
        /// What sets that limit.
        limited_by: KeepLimit,
    },
    /// A check that the user asked for did not pass. Exit code 1.
    #[error("{0}")]
    Check(String),
}

/// What limits the memory for lists kept between frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum KeepLimit {
    /// The memory that `--limit-memory` leaves.
    MemoryOption,
    /// The memory of the device, or the host's largest allocation.
    Device,
}

impl std::fmt::Display for KeepLimit {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        out.write_str(match self {
            Self::MemoryOption => "--limit-memory leaves",
            Self::Device => "the device keeps",
        })
    }
}

/// A fault in the user's input: file, line, key, the value found and the values accepted.
#[derive(Debug, Default)]
pub struct Input {
    /// The file, or empty for an argument.
    pub file: PathBuf,
    /// The line in that file, counted from 1.
    pub line: Option<usize>,
    /// The key, column or option at fault.
    pub key: Option<String>,
    /// What is wrong, as a sentence without a full stop.
    pub what: String,
    /// The value found there.
    pub found: Option<String>,
    /// The values that would have been accepted.
    pub expected: Option<String>,
}

impl std::fmt::Display for Input {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        if !self.file.as_os_str().is_empty() {
            write!(out, "{}", self.file.display())?;
            if let Some(line) = self.line {
                write!(out, ":{line}")?;
            }
            write!(out, ": ")?;
        }
        if let Some(key) = &self.key {
            write!(out, "{}: ", short(key))?;
        }
        write!(out, "{}", self.what)?;
        if let Some(found) = &self.found {
            write!(out, "; found {}", short(found))?;
        }
        if let Some(expected) = &self.expected {
            write!(out, "; expected {expected}")?;
        }
        Ok(())
    }
}

/// Text from the input, truncated to a readable length.
fn short(text: &str) -> std::borrow::Cow<'_, str> {
    const MOST: usize = 400;
    match text.char_indices().nth(MOST) {
        Some((end, _)) => format!("{}... ({} bytes)", &text[..end], text.len()).into(),
        None => text.into(),
    }
}

impl Input {
    /// A fault described by one sentence.
    pub fn new(what: impl Into<String>) -> Self {
        Self { what: what.into(), ..Self::default() }
    }
    /// In this file.
    #[must_use]
    pub fn file(mut self, file: &Path) -> Self {
        self.file = file.to_path_buf();
        self
    }
    /// At this line, counted from 1.
    #[must_use]
    pub fn line(mut self, line: usize) -> Self {
        self.line = Some(line);
        self
    }
    /// Under this key, column or option.
    #[must_use]
    pub fn key(mut self, key: impl Into<String>) -> Self {
        self.key = Some(key.into());
        self
    }
    /// The value that was found.
    #[must_use]
    pub fn found(mut self, found: impl ToString) -> Self {
        self.found = Some(found.to_string());
        self
    }
    /// The values that would have been accepted.
    #[must_use]
    pub fn expected(mut self, expected: impl ToString) -> Self {
        self.expected = Some(expected.to_string());
        self
    }
}

impl From<Input> for Error {
    fn from(input: Input) -> Self {
        Self::Input(input)
    }
}

impl Error {
    /// A device fault: what the program was doing, and the driver's answer.
    pub fn device(doing: impl Into<String>, what: impl ToString) -> Self {
        Self::Device { doing: doing.into(), what: what.to_string() }
    }

    /// The process exit code: 1 a failed check, 2 bad input, 3 a device.
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::Check(_) => 1,
            Self::Input(_) => 2,
            Self::Device { .. } | Self::TooMuchToKeep { .. } => 3,
        }
    }

    /// Whether the device is at fault: it failed, or it has too little memory.
    #[must_use]
    pub fn is_device_fault(&self) -> bool {
        matches!(self, Self::Device { .. } | Self::TooMuchToKeep { .. })
    }
}

/// The program's result type.
pub type Result<T> = std::result::Result<T, Error>;
