//! Files that appear whole or not at all: written beside their place, then moved there.

use std::io::Cursor;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard};

use crate::error::{Input, Result};

/// What is being written now, and is to be removed if the program is stopped.
static PARTS: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn parts() -> MutexGuard<'static, Vec<PathBuf>> {
    PARTS.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
}

/// A file or folder that is not where it belongs yet; removed when dropped.
#[derive(Debug)]
pub struct Part(PathBuf);

impl Part {
    /// At this path, at which nothing is yet.
    pub fn new(path: PathBuf) -> Self {
        parts().push(path.clone());
        Self(path)
    }

    /// Its path.
    pub fn path(&self) -> &Path {
        &self.0
    }
}

impl Drop for Part {
    fn drop(&mut self) {
        let mut parts = parts();
        remove(&self.0);
        parts.retain(|part| *part != self.0);
    }
}

fn remove(path: &Path) {
    let _ = if path.is_dir() { std::fs::remove_dir_all(path) } else { std::fs::remove_file(path) };
}

/// Removes all parts and runs `last`, which does not return; nothing new is begun meanwhile.
pub fn abandon(last: impl FnOnce()) {
    let parts = parts();
    parts.iter().for_each(|part| remove(part));
    last();
}

/// Lets `write` fill a file beside `path`, then moves it there: a reader never sees half of it. What is no ordinary file,
/// as a device or a pipe, is written as it is.
pub fn write_whole(path: &Path, write: impl FnOnce(&Path) -> std::result::Result<(), String>) -> Result<()> {
    let fault = |what: String| Input::new(format!("could not be written: {what}")).file(path).into();
    match std::fs::metadata(path) {
        Ok(known) if known.is_dir() => return Err(fault("it is a folder".into())),
        Ok(known) if !known.is_file() => return write(path).map_err(fault),
        _ => {}
    }
    let mut name = std::ffi::OsString::from(".");
    name.push(path.file_name().unwrap_or_default());
    name.push(format!(".{}.part", std::process::id()));
    let part = Part::new(path.with_file_name(name));
    write(part.path()).and_then(|()| std::fs::rename(part.path(), path).map_err(|e| e.to_string())).map_err(fault)
}

/// The same for what a library encodes: it writes to memory, because a file's last bytes may fail where it does not look.
pub fn encode_whole(
    path: &Path,
    encode: impl FnOnce(&mut Cursor<Vec<u8>>) -> std::result::Result<(), String>,
) -> Result<()> {
    let mut bytes = Cursor::default();
    let done = encode(&mut bytes);
    write_whole(path, |beside| {
        done.and_then(|()| std::fs::write(beside, bytes.into_inner()).map_err(|e| e.to_string()))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_failed_write_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let failed = write_whole(&path, |beside| {
            std::fs::write(beside, "half").unwrap();
            Err("full".into())
        });
        assert!(failed.unwrap_err().to_string().contains("a.png: could not be written: full"));
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
        write_whole(&path, |beside| std::fs::write(beside, "whole").map_err(|e| e.to_string())).unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "whole");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
        let folded = write_whole(folder.path(), |_| Ok(())).unwrap_err();
        assert!(folded.to_string().contains("it is a folder"), "{folded}");
    }

    #[test]
    fn a_device_is_written_and_not_replaced() {
        let null = Path::new("/dev/null");
        if null.exists() {
            write_whole(null, |same| {
                assert_eq!(same, null);
                std::fs::write(same, "text").map_err(|e| e.to_string())
            })
            .unwrap();
            assert!(!null.metadata().unwrap().is_file());
        }
    }
}
