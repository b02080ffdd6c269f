//! File access and memory limit of a scene: sizes are checked before memory is allocated.

use std::borrow::Cow;
use std::cell::Cell;
use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsString;
use std::io::{Error, ErrorKind, Read, Result};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// Memory limit of a scene, and the memory it has taken, bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Memory {
    /// The limit.
    pub limit: u64,
    /// The memory taken so far.
    pub taken: u64,
}

impl Memory {
    /// The default limit: 16 GiB.
    pub const USUAL: u64 = 16 << 30;

    /// A limit with nothing taken yet.
    #[must_use]
    pub fn new(limit: u64) -> Self {
        Self { limit, taken: 0 }
    }

    /// The memory left.
    #[must_use]
    pub fn left(&self) -> u64 {
        self.limit.saturating_sub(self.taken)
    }

    /// Returns an error of kind `OutOfMemory` that states `bytes`, the memory taken and the limit, if `bytes` more do
    /// not fit.
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

/// A number of bytes in a readable unit.
fn in_words(bytes: u64) -> String {
    const NAMES: [&str; 5] = ["bytes", "KiB", "MiB", "GiB", "TiB"];
    let step = (bytes.max(1).ilog2() / 10).min(4);
    let value = bytes as f64 / 1024f64.powi(step as i32);
    if step == 0 { format!("{bytes} bytes") } else { format!("{value:.1} {}", NAMES[step as usize]) }
}

/// Source of a scene's files, and its memory limit.
#[derive(Debug, Default)]
pub struct Files {
    /// Files in memory, instead of those on disk.
    held: Option<BTreeMap<PathBuf, Vec<u8>>>,
    memory: Cell<Memory>,
}

/// Files read so far; no output may overwrite them.
static INPUTS: Mutex<BTreeSet<PathBuf>> = Mutex::new(BTreeSet::new());

fn inputs() -> MutexGuard<'static, BTreeSet<PathBuf>> {
    INPUTS.lock().unwrap_or_else(PoisonError::into_inner)
}

/// Whether the file at this canonical path has been read.
#[must_use]
pub fn was_read(path: &Path) -> bool {
    inputs().contains(path)
}

/// The contents of pipes, which can be read only once.
static PIPES: Mutex<BTreeMap<PathBuf, Vec<u8>>> = Mutex::new(BTreeMap::new());

fn pipes() -> MutexGuard<'static, BTreeMap<PathBuf, Vec<u8>>> {
    PIPES.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The first of 256 characters for private use, which stand for bytes of a path that are no UTF-8.
#[cfg(unix)]
const BYTE: u32 = 0x0010_f800;

/// A path as text, whatever its bytes are.
#[must_use]
pub fn text_of_path(path: OsString) -> String {
    #[cfg(unix)]
    {
        use std::os::unix::ffi::OsStrExt;
        let mut text = String::new();
        for chunk in path.as_bytes().utf8_chunks() {
            text.push_str(chunk.valid());
            text.extend(chunk.invalid().iter().filter_map(|byte| char::from_u32(BYTE + u32::from(*byte))));
        }
        text
    }
    #[cfg(not(unix))]
    path.to_string_lossy().into_owned()
}

/// The path that a text of [`text_of_path`] stands for.
#[must_use]
pub fn path_of_text(text: &Path) -> Cow<'_, Path> {
    #[cfg(unix)]
    if let Some(text) = text.to_str().filter(|text| text.chars().any(|letter| letter as u32 & !0xff == BYTE)) {
        use std::os::unix::ffi::OsStringExt;
        let bytes = text.chars().flat_map(|letter| match letter as u32 {
            byte if byte & !0xff == BYTE => vec![byte as u8],
            _ => letter.to_string().into_bytes(),
        });
        return Cow::Owned(OsString::from_vec(bytes.collect()).into());
    }
    Cow::Borrowed(text)
}

/// The compression or encoding that has to be undone before a file of these bytes can be read, if any.
#[must_use]
pub(super) fn packed(bytes: &[u8]) -> Option<&'static str> {
    // UTF-16 without a mark: two bytes a letter, one of them 0.
    let wide = |low: usize| bytes.len() >= 8 && (0..8).all(|k| (bytes[k] == 0) == (k % 2 != low));
    if bytes.starts_with(b"\xff\xfe") || bytes.starts_with(b"\xfe\xff") || wide(0) || wide(1) {
        return Some("UTF-16 text, not UTF-8");
    }
    let marks: [(&[u8], &str); 4] = [
        (b"\x1f\x8b", "data packed by gzip"),
        (b"PK\x03\x04", "a zip archive"),
        (b"\x28\xb5\x2f\xfd", "data packed by zstd"),
        (b"\xfd7zXZ\0", "data packed by xz"),
    ];
    marks.iter().find(|(mark, _)| bytes.starts_with(mark)).map(|(_, words)| *words)
}

impl Files {
    /// Files on disk, and the scene's memory limit in bytes.
    #[must_use]
    pub fn on_disk(limit: u64) -> Self {
        Self { held: None, memory: Cell::new(Memory::new(limit)) }
    }

    /// These files only, by path, and the scene's memory limit in bytes.
    pub fn held(files: impl IntoIterator<Item = (PathBuf, Vec<u8>)>, limit: u64) -> Self {
        Self { held: Some(files.into_iter().collect()), memory: Cell::new(Memory::new(limit)) }
    }

    /// The memory taken, and the limit.
    pub fn memory(&self) -> Memory {
        self.memory.get()
    }

    /// Returns an error if `bytes` of temporary memory do not fit.
    pub fn need(&self, bytes: u64) -> Result<()> {
        self.memory.get().need(bytes)
    }

    /// The same for memory that the scene keeps, which counts as taken from now on.
    pub fn take(&self, bytes: u64) -> Result<()> {
        let memory = self.memory.get();
        memory.need(bytes)?;
        self.memory.set(Memory { taken: memory.taken + bytes, ..memory });
        Ok(())
    }

    /// Whether there is something at this path.
    pub fn exists(&self, path: &Path) -> bool {
        self.held.as_ref().map_or_else(|| path_of_text(path).exists(), |held| held.contains_key(path))
    }

    /// Reads a plain file, or a pipe that was read before; `copies` times its size must fit the memory.
    pub fn read(&self, path: &Path, copies: u64) -> Result<Vec<u8>> {
        // Anything but a plain file may block or never end.
        let real = path_of_text(path);
        if self.held.is_none() && !std::fs::metadata(&real)?.is_file() && !pipes().contains_key(&*real) {
            return Err(Error::new(ErrorKind::Unsupported, "not a plain file"));
        }
        self.stream(path, copies)
    }

    /// The same for anything that ends, such as a pipe, which is kept; terminals and other devices are refused.
    pub fn stream(&self, path: &Path, copies: u64) -> Result<Vec<u8>> {
        if let Some(held) = &self.held {
            let bytes = held.get(path).ok_or_else(|| Error::new(ErrorKind::NotFound, "no such file"))?;
            self.need(copies.saturating_mul(bytes.len() as u64))?;
            return Ok(bytes.clone());
        }
        let path = &path_of_text(path);
        let known = std::fs::metadata(path)?;
        #[cfg(unix)]
        {
            use std::os::unix::fs::FileTypeExt;
            let kind = known.file_type();
            if kind.is_char_device() || kind.is_block_device() {
                return Err(Error::new(ErrorKind::Unsupported, "a device, which may never end"));
            }
        }
        if let Some(bytes) = pipes().get(&**path).filter(|_| !known.is_file()) {
            self.need(copies.saturating_mul(bytes.len() as u64))?;
            return Ok(bytes.clone());
        }
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
        if !known.is_file() {
            pipes().insert(path.to_path_buf(), bytes.clone());
        }
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

    #[cfg(unix)]
    #[test]
    fn paths_need_not_be_utf_8() {
        use std::os::unix::ffi::OsStringExt;
        for bytes in [&b"a.obj"[..], "caf\u{e9}/\u{10ffff}.obj".as_bytes(), b"caf\xe9/\xff\x80.obj"] {
            let path = OsString::from_vec(bytes.to_vec());
            assert_eq!(*path_of_text(Path::new(&text_of_path(path.clone()))), *Path::new(&path));
        }
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join(OsString::from_vec(b"\xe9".to_vec()));
        std::fs::write(&path, "text").expect("written");
        let text = text_of_path(path.into_os_string());
        let files = Files::on_disk(1 << 16);
        assert!(files.exists(Path::new(&text)));
        assert_eq!(files.read(Path::new(&text), 1).expect("a file"), b"text");
    }

    #[test]
    fn what_never_ends_is_cut_off() {
        let files = Files::on_disk(1 << 16);
        let error = files.read(Path::new("/dev/zero"), 1).expect_err("no plain file").to_string();
        assert_eq!(error, "not a plain file");
        let error = files.stream(Path::new("/dev/zero"), 1).expect_err("a device").to_string();
        assert_eq!(error, "a device, which may never end");
    }
}
