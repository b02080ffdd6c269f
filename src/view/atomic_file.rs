//! Files that appear whole or not at all: written beside their destination, then moved there.

use std::fs::File;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::io::{Cursor, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU32, Ordering};
use std::sync::{Mutex, MutexGuard};

use crate::error::{Error, Input, Result};
use crate::scene::was_read;

/// Partial files and folders, to be removed if the program is stopped.
static PARTS: Mutex<Vec<PathBuf>> = Mutex::new(Vec::new());

fn parts() -> MutexGuard<'static, Vec<PathBuf>> {
    PARTS.lock().unwrap_or_else(std::sync::PoisonError::into_inner)
}

/// A file or folder that has not been moved to its destination yet; removed when dropped.
#[derive(Debug)]
pub struct Part(PathBuf);

impl Part {
    /// A part at this path, where nothing exists yet.
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

/// Removes all parts and runs `last`, which does not return; holds the lock, so that no new part is begun.
pub fn abandon(last: impl FnOnce()) {
    let parts = parts();
    parts.iter().for_each(|part| remove(part));
    last();
}

/// Lets `write` fill a file beside `path`, then moves it there: a reader never sees half of it. If `path` is a device
/// or a pipe rather than a regular file, it is written directly.
pub fn write_atomically(path: &Path, write: impl FnOnce(&Path) -> std::result::Result<(), String>) -> Result<()> {
    let fault = |what: String| unwritten(path, &what);
    let Some(path) = &destination(path)? else { return write(path).map_err(fault) };
    let part = beside(path);
    write(part.path()).and_then(|()| std::fs::rename(part.path(), path).map_err(|e| e.to_string())).map_err(fault)
}

/// A file that is written piece by piece, beside `path`; removed when dropped unfinished. A device or a pipe is written
/// directly.
pub struct Pending {
    path: PathBuf,
    file: File,
    /// Bytes of the pieces that are written.
    written: u64,
    part: Option<(Part, PathBuf)>,
}

impl Pending {
    /// An empty file that will be at this path.
    pub fn new(path: &Path) -> Result<Self> {
        let part = destination(path)?.map(|place| (beside(&place), place));
        let file = File::create(part.as_ref().map_or(path, |(part, _)| part.path()));
        let file = file.map_err(|error| unwritten(path, &error.to_string()))?;
        Ok(Self { path: path.into(), file, written: 0, part })
    }

    /// Writes a piece; what was written of one that does not fit is taken back.
    pub fn add(&mut self, bytes: &[u8]) -> Result<()> {
        if let Err(error) = self.file.write_all(bytes) {
            if self.part.is_some() {
                let back = |file: &mut File| {
                    file.set_len(self.written).and_then(|()| file.seek(SeekFrom::Start(self.written)))
                };
                back(&mut self.file).map_err(|error| unwritten(&self.path, &error.to_string()))?;
            }
            return Err(unwritten(&self.path, &error.to_string()));
        }
        self.written += bytes.len() as u64;
        Ok(())
    }

    /// Moves the file to its path, or to another name in the same folder, and returns where it is; None for a device.
    pub fn finish(self, name: Option<&str>) -> Result<Option<PathBuf>> {
        let Some((part, place)) = self.part else { return Ok(None) };
        let place = match name {
            Some(name) => destination(&place.with_file_name(name))?.unwrap_or(place),
            None => place,
        };
        std::fs::rename(part.path(), &place).map_err(|error| unwritten(&place, &error.to_string()))?;
        Ok(Some(place))
    }
}

fn unwritten(path: &Path, what: &str) -> Error {
    Input::new(format!("could not be written: {what}")).file(path).into()
}

/// [`target`]; an error if that file was read.
fn destination(path: &Path) -> Result<Option<PathBuf>> {
    match target(path).map_err(|what| unwritten(path, &what))? {
        Some(place) if was_read(&place) => {
            Err(unwritten(path, "it was read to make this; give the output another name"))
        }
        place => Ok(place),
    }
}

/// Most symbolic links that are followed one after another, as many as Linux follows.
const MOST_LINKS: usize = 40;

/// The path of the regular file at a path, or of the one to be created: links are followed, also to files that do not
/// exist yet. None for a device or a pipe, which is written directly; an error for a folder or a file that may not be
/// written.
fn target(path: &Path) -> std::result::Result<Option<PathBuf>, String> {
    match std::fs::metadata(path) {
        Ok(known) if known.is_dir() => return Err("it is a folder".into()),
        Ok(known) if !known.is_file() => return Ok(None),
        // It could be replaced all the same.
        Ok(known) if known.permissions().readonly() => return Err("it is write-protected".into()),
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => return Err(error.to_string()),
        _ => {}
    }
    let mut place = path.to_path_buf();
    for _ in 0..MOST_LINKS {
        let Ok(next) = std::fs::read_link(&place) else { break };
        place = place.parent().unwrap_or(Path::new("")).join(next);
    }
    Ok(Some(place.canonicalize().unwrap_or(place)))
}

/// Whether a path is that of a device or a pipe, whose name does not tell a format.
#[must_use]
pub fn is_device(path: &Path) -> bool {
    std::fs::metadata(path).is_ok_and(|known| !known.is_file() && !known.is_dir())
}

/// A part beside a path. Its name is short, because that of the path may be as long as names can be; it contains a
/// hash of the path's name, because processes on other machines may have the same number and write other files of
/// this folder.
fn beside(path: &Path) -> Part {
    static NEXT: AtomicU32 = AtomicU32::new(0);
    let number = NEXT.fetch_add(1, Ordering::Relaxed);
    let mut name = DefaultHasher::new();
    path.file_name().hash(&mut name);
    Part::new(path.with_file_name(format!(".{:016x}.{}-{number}.part", name.finish(), std::process::id())))
}

/// How a file is written.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Written {
    /// Whole, in place of what was there.
    Replaced,
    /// Where it is, after what was there, also in a folder where no other file can be made.
    Appended,
}

/// An error if one of these files could not be written, or is the same as another, before there is work to lose. Each
/// path comes with the argument that names it.
pub fn ready<'a>(paths: impl IntoIterator<Item = (&'a str, Option<&'a PathBuf>)>) -> Result<()> {
    ready_for(paths.into_iter().map(|(key, path)| (key, path, Written::Replaced)))
}

/// The same for files that are written in different ways.
pub fn ready_for<'a>(paths: impl IntoIterator<Item = (&'a str, Option<&'a PathBuf>, Written)>) -> Result<()> {
    let mut before: Vec<(&str, PathBuf)> = Vec::new();
    for (key, path, how) in paths.into_iter().filter_map(|(key, path, how)| Some((key, path?, how))) {
        let Some(place) = target(path).map_err(|what| unwritten(path, &what))? else { continue };
        let part = beside(&place);
        let written = match how == Written::Appended && place.is_file() {
            true => std::fs::OpenOptions::new().append(true).open(&place).map(drop),
            false => std::fs::write(part.path(), ""),
        };
        written.map_err(|error| unwritten(path, &error.to_string()))?;
        // The folder exists; an empty name is the current one.
        let folder = part.path().parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        let folder = folder.canonicalize().unwrap_or_default();
        let place = place.canonicalize().unwrap_or_else(|_| folder.join(place.file_name().unwrap_or_default()));
        if let Some((other, _)) = before.iter().find(|(_, known)| *known == place) {
            return Err(Input::new(format!("the same file as {other}")).key(key).found(path.display()).into());
        }
        before.push((key, place));
    }
    Ok(())
}

/// Appends bytes to a file in one piece, so that those of programs which append at the same time do not mix. If only a
/// part of them can be written, it is taken back.
pub fn append(path: &Path, bytes: &[u8]) -> Result<()> {
    destination(path)?;
    let open = std::fs::OpenOptions::new().create(true).append(true).open(path);
    let add = |mut file: File| {
        // Released with the file. Without a lock another program may append in between: then a part stays.
        let alone = file.lock().is_ok();
        let before = file.metadata()?.len();
        let written = file.write(bytes)?;
        if alone && written < bytes.len() && file.metadata()?.len() == before + written as u64 {
            file.set_len(before)?;
        }
        Ok(written)
    };
    match open.and_then(add) {
        Ok(written) if written == bytes.len() => Ok(()),
        Ok(written) => Err(unwritten(path, &format!("there is room for {written} of {} bytes only", bytes.len()))),
        Err(error) => Err(unwritten(path, &error.to_string())),
    }
}

/// [`write_atomically`] for a library's encoder. It encodes to memory, because encoders may overlook that the last
/// bytes of a file could not be written.
pub fn encode_atomically(
    path: &Path,
    encode: impl FnOnce(&mut Cursor<Vec<u8>>) -> std::result::Result<(), String>,
) -> Result<()> {
    let mut bytes = Cursor::default();
    let done = encode(&mut bytes);
    write_atomically(path, |beside| {
        done.and_then(|()| std::fs::write(beside, bytes.into_inner()).map_err(|e| e.to_string()))
    })
}

#[cfg(test)]
mod tests {
    use crate::view::atomic_file::*;

    #[test]
    fn a_failed_write_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let failed = write_atomically(&path, |beside| {
            std::fs::write(beside, "half").unwrap();
            Err("full".into())
        });
        assert!(failed.unwrap_err().to_string().contains("a.png: could not be written: full"));
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
        write_atomically(&path, |beside| std::fs::write(beside, "whole").map_err(|e| e.to_string())).unwrap();
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "whole");
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
        let folded = write_atomically(folder.path(), |_| Ok(())).unwrap_err();
        assert!(folded.to_string().contains("it is a folder"), "{folded}");
    }

    #[cfg(unix)]
    #[test]
    fn links_stay_and_what_they_lead_to_is_written() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::create_dir(at("far")).unwrap();
        let link = |to: &str, from: &str| std::os::unix::fs::symlink(to, at(from)).unwrap();
        link("far/a.png", "a.png");
        link("a.png", "b.png");
        link("c.png", "c.png");
        let write = |name: &str| {
            let path = at(name);
            ready([("-o", Some(&path))])?;
            write_atomically(&path, |beside| {
                let near = beside.parent().is_some_and(|parent| parent.ends_with("far"));
                assert_eq!(near, name != "d.png", "the part is beside the file");
                std::fs::write(beside, name).map_err(|e| e.to_string())
            })
        };
        // First nothing is there, then it is replaced.
        for name in ["b.png", "a.png"] {
            write(name).unwrap();
            assert!(at(name).is_symlink() && !at("far/a.png").is_symlink());
            assert_eq!(std::fs::read_to_string(at("far/a.png")).unwrap(), name);
        }
        assert!(write("c.png").unwrap_err().to_string().contains("c.png: could not be written"));
        assert!(at("c.png").is_symlink());
        let (left, right) = (at("a.png"), at("b.png"));
        let twice = ready([("--csv", Some(&left)), ("-o", Some(&right))]).unwrap_err();
        assert!(twice.to_string().starts_with("-o: the same file as --csv"), "{twice}");

        std::fs::write(at("d.png"), "old").unwrap();
        let mut mode = at("d.png").metadata().unwrap().permissions();
        mode.set_readonly(true);
        std::fs::set_permissions(at("d.png"), mode).unwrap();
        assert!(write("d.png").unwrap_err().to_string().contains("d.png: could not be written: it is write-protected"));
        assert_eq!(std::fs::read_to_string(at("d.png")).unwrap(), "old");
    }

    #[test]
    fn what_was_read_is_neither_replaced_nor_added_to() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.obj");
        append(&path, b"one\n").unwrap();
        append(&path, b"two\n").unwrap();
        assert_eq!(crate::scene::Files::on_disk(1 << 20).read(&path, 1).unwrap(), b"one\ntwo\n");
        let write = |part: &Path| std::fs::write(part, "three").map_err(|e| e.to_string());
        for refused in [append(&path, b"three\n"), write_atomically(&path, write)] {
            assert!(refused.unwrap_err().to_string().contains("a.obj: could not be written: it was read to make this"));
        }
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "one\ntwo\n");
    }

    /// In a folder where only root may make files.
    #[cfg(unix)]
    #[test]
    fn a_file_that_grows_needs_no_other_beside_it() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.jsonl");
        std::fs::write(&path, "one\n").unwrap();
        let mode = |mode: u32| {
            use std::os::unix::fs::PermissionsExt as _;
            std::fs::set_permissions(folder.path(), std::fs::Permissions::from_mode(mode)).unwrap();
        };
        mode(0o555);
        let beside = std::fs::write(folder.path().join("b"), "").is_ok();
        let found = [Written::Appended, Written::Replaced].map(|how| ready_for([("-o", Some(&path), how)]).is_ok());
        mode(0o755);
        assert_eq!(found, [true, beside]);
        assert_eq!(std::fs::read_to_string(&path).unwrap(), "one\n");
    }

    #[test]
    fn parts_of_other_files_have_other_names_whoever_writes_them() {
        let name = |path: &str| {
            let part = beside(Path::new(path));
            let name = part.path().file_name().and_then(|name| name.to_str()).map(str::to_owned).unwrap();
            name.split('.').nth(1).map(str::to_owned).unwrap()
        };
        assert_eq!(name("a/frame-1.png"), name("b/frame-1.png"));
        assert_ne!(name("a/frame-1.png"), name("a/frame-2.png"));
    }

    #[test]
    fn a_device_is_written_and_not_replaced() {
        let null = Path::new("/dev/null");
        if null.exists() {
            write_atomically(null, |same| {
                assert_eq!(same, null);
                std::fs::write(same, "text").map_err(|e| e.to_string())
            })
            .unwrap();
            assert!(!null.metadata().unwrap().is_file());
        }
    }
}
