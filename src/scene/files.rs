//! The files that a scene is read from, and the memory that it may take: sizes are checked before any is taken.

use std::cell::Cell;
use std::collections::{BTreeMap, BTreeSet};
use std::io::{Error, ErrorKind, Read, Result};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// How much memory a scene may take, and what it has taken, bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Memory {
    /// The most that it may take.
    pub limit: u64,
    /// What it holds already.
    pub taken: u64,
}

impl Memory {
    /// The limit where nothing else is said: 16 GiB.
    pub const USUAL: u64 = 16 << 30;

    /// Nothing taken yet of so many bytes.
    #[must_use]
    pub fn new(limit: u64) -> Self {
        Self { limit, taken: 0 }
    }

    /// What is left of it.
    #[must_use]
    pub fn left(&self) -> u64 {
        self.limit.saturating_sub(self.taken)
    }

    /// An error of kind `OutOfMemory` with all three numbers where so many bytes more are too many.
    pub fn need(&self, bytes: u64) -> Result<()> {
        if bytes <= self.left() {
            return Ok(());
        }
        let [asked, taken, limit] = [bytes, self.taken, self.limit].map(in_words);
        let words = format!("{asked} of memory asked for beside {taken}, where --limit-memory is {limit}");
        Err(Error::new(ErrorKind::OutOfMemory, words))
    }
}

impl Default for Memory {
    fn default() -> Self {
        Self::new(Self::USUAL)
    }
}

/// Bytes as people write them.
fn in_words(bytes: u64) -> String {
    const NAMES: [&str; 5] = ["bytes", "KiB", "MiB", "GiB", "TiB"];
    let step = (bytes.max(1).ilog2() / 10).min(4);
    let value = bytes as f64 / 1024f64.powi(step as i32);
    if step == 0 { format!("{bytes} bytes") } else { format!("{value:.1} {}", NAMES[step as usize]) }
}

/// Where a scene's files are read from, and the memory that they take.
#[derive(Debug, Default)]
pub struct Files {
    /// Files in memory, instead of those on disk.
    held: Option<BTreeMap<PathBuf, Vec<u8>>>,
    memory: Cell<Memory>,
}

/// What was read so far: no output may take its place.
static INPUTS: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

fn inputs() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    INPUTS.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Whether the file of this whole path, without links, has been read.
#[must_use]
pub fn was_read(path: &Path) -> bool {
    inputs().contains(path)
}

impl Files {
    /// Files on disk, and how many bytes a scene may take.
    #[must_use]
    pub fn on_disk(limit: u64) -> Self {
        Self { held: None, memory: Cell::new(Memory::new(limit)) }
    }

    /// These files only, by their paths, and how many bytes a scene may take.
    pub fn held(files: impl IntoIterator<Item = (PathBuf, Vec<u8>)>, limit: u64) -> Self {
        Self { held: Some(files.into_iter().collect()), memory: Cell::new(Memory::new(limit)) }
    }

    /// What is taken, and the limit.
    pub fn memory(&self) -> Memory {
        self.memory.get()
    }

    /// An error where so many bytes for a while are too many.
    pub fn need(&self, bytes: u64) -> Result<()> {
        self.memory.get().need(bytes)
    }

    /// The same of bytes that the scene keeps; they are taken from now on.
    pub fn take(&self, bytes: u64) -> Result<()> {
        let memory = self.memory.get();
        memory.need(bytes)?;
        self.memory.set(Memory { taken: memory.taken + bytes, ..memory });
        Ok(())
    }

    /// A plain file's bytes; of those, `copies` times as many have to fit the memory.
    pub fn read(&self, path: &Path, copies: u64) -> Result<Vec<u8>> {
        if let Some(held) = &self.held {
            let bytes = held.get(path).ok_or_else(|| Error::new(ErrorKind::NotFound, "no such file"))?;
            self.need(copies.saturating_mul(bytes.len() as u64))?;
            return Ok(bytes.clone());
        }
        // What is no plain file may block or never end.
        if !std::fs::metadata(path)?.is_file() {
            return Err(Error::new(ErrorKind::Unsupported, "not a plain file"));
        }
        self.stream(path, copies)
    }

    /// The same of whatever can be read: a pipe, too.
    pub fn stream(&self, path: &Path, copies: u64) -> Result<Vec<u8>> {
        let file = std::fs::File::open(path)?;
        if let Ok(place) = path.canonicalize() {
            inputs().insert(place);
        }
        let length = file.metadata()?.len();
        self.need(copies.saturating_mul(length))?;
        let most = self.memory.get().left() / copies.max(1);
        let mut bytes = Vec::with_capacity(length as usize);
        file.take(most.saturating_add(1)).read_to_end(&mut bytes)?;
        self.need(copies.saturating_mul(bytes.len() as u64))?;
        Ok(bytes)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn memory_is_taken_until_there_is_none() {
        let files = Files::held([("a".into(), vec![0; 600])], 4096);
        assert_eq!(files.read(Path::new("a"), 2).expect("it fits").len(), 600);
        files.take(3 << 10).expect("it fits");
        let error = |result: Result<Vec<u8>>| result.err().map(|e| e.to_string()).unwrap_or_default();
        let words = "1.2 KiB of memory asked for beside 3.0 KiB, where --limit-memory is 4.0 KiB";
        assert_eq!(error(files.read(Path::new("a"), 2)), words);
        assert_eq!(error(files.read(Path::new("b"), 2)), "no such file");
        assert!(files.need(1024).is_ok() && files.need(1025).is_err() && files.need(u64::MAX).is_err());
        assert_eq!(files.memory(), Memory { limit: 4096, taken: 3072 });
    }

    #[test]
    fn what_never_ends_is_cut_off() {
        let files = Files::on_disk(1 << 16);
        let error = files.read(Path::new("/dev/zero"), 1).expect_err("no plain file").to_string();
        assert_eq!(error, "not a plain file");
        let error = files.stream(Path::new("/dev/zero"), 1).expect_err("too long").to_string();
        assert!(error.starts_with("64.0 KiB of memory asked for"), "{error}");
    }
}
