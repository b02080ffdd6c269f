//! The output folder of a report, a gallery or a case. It must be new or empty, or hold an earlier one; files of the
//! same names are replaced, the page last, and all others are left alone. Everything is first written to a temporary
//! folder: a file appears whole or not at all, and a run that fails before [`Folder::fill`] changes nothing.

use std::fs;
use std::path::{Path, PathBuf};

use crate::error::{Error, Input, Result};
use crate::view::atomic_file::Part;

/// What a folder holds.
#[derive(Debug, PartialEq, Eq)]
pub struct Kind {
    /// The name of the file that is written last: the page.
    pub page: &'static str,
    /// Identifies an earlier one; must be among the page's first 600 bytes.
    pub mark: &'static str,
    /// Its name in messages.
    pub called: &'static str,
}

/// A report.
pub const REPORT: Kind = Kind { page: "index.html", mark: "content=\"milkglass report\"", called: "report" };
/// A gallery.
pub const GALLERY: Kind = Kind { page: "index.html", mark: "content=\"milkglass gallery\"", called: "gallery" };
/// A case to replay.
pub const CASE: Kind = Kind { page: "replay.json", mark: "\"milkglass_case\"", called: "case" };

/// The output folder. The report goes to a temporary folder first, which is removed on drop.
#[derive(Debug)]
pub struct Folder {
    target: PathBuf,
    beside: Part,
    /// Whether the target existed before.
    old: bool,
    page: &'static str,
}

impl Folder {
    /// Checks the rules, and that the folder is writable, before anything is measured.
    pub fn open(target: &Path, kind: &Kind, key: &str) -> Result<Self> {
        let fault = |what: &str| Input::new(what).key(key).found(target.display());
        let expected = format!("a new folder, an empty one, or one with an earlier {}", kind.called);
        let old = target.exists();
        let part = format!(".{}.{}.part", kind.called, std::process::id());
        let beside = if old {
            let list = fs::read_dir(target).map_err(|e| fault(&format!("not a folder: {e}")).expected(&expected))?;
            let page = fs::read_to_string(target.join(kind.page)).unwrap_or_default();
            if list.count() > 0 && !page.get(..page.len().min(600)).is_some_and(|start| start.contains(kind.mark)) {
                return Err(fault("the folder holds something else, which is not written over")
                    .expected(&expected)
                    .into());
            }
            target.join(part)
        } else {
            let name = target.file_name().ok_or_else(|| fault("not a folder's name").expected(&expected))?;
            target.with_file_name(format!(".{}{part}", name.to_string_lossy()))
        };
        let beside = Part::new(beside);
        fs::create_dir(beside.path())
            .map_err(|e| fault(&format!("the folder can't be written: {e}")).expected(&expected))?;
        Ok(Self { target: target.to_path_buf(), beside, old, page: kind.page })
    }

    /// Writes a file and moves it to the target, in the place of the old one. In a new folder the page `empty` comes
    /// first, so that the folder is known for what it is.
    pub fn put(&self, name: &str, bytes: &[u8], empty: &str) -> Result<()> {
        let write = |name: &str, bytes: &[u8]| -> std::io::Result<()> {
            let part = self.beside.path().join(name);
            fs::write(&part, bytes)?;
            fs::rename(part, self.target.join(name))
        };
        let begin = || -> std::io::Result<()> {
            fs::create_dir_all(&self.target)?;
            if self.target.join(self.page).exists() { Ok(()) } else { write(self.page, empty.as_bytes()) }
        };
        let done = begin().and_then(|()| write(name, bytes));
        done.map_err(|e| Error::from(Input::new(format!("could not be written: {e}")).file(&self.target.join(name))))
    }

    /// Removes a file that was put, if it is there.
    pub fn remove(&self, name: &str) -> Result<()> {
        let path = self.target.join(name);
        match fs::remove_file(&path) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => {
                Err(Input::new(format!("could not be removed: {error}")).file(&path).into())
            }
            _ => Ok(()),
        }
    }

    /// Writes all files, then moves them to the target, the page last.
    pub fn fill(self, page: &str, files: &[(String, Vec<u8>)]) -> Result<()> {
        let write =
            |name: &str, bytes: &[u8]| -> std::io::Result<()> { fs::write(self.beside.path().join(name), bytes) };
        let all = || files.iter().map(|(name, bytes)| (name.as_str(), bytes.as_slice()));
        let all = || all().chain([(self.page, page.as_bytes())]);
        let done = all().try_for_each(|(name, bytes)| write(name, bytes)).and_then(|()| match self.old {
            false => fs::rename(self.beside.path(), &self.target),
            true => all().try_for_each(|(name, _)| fs::rename(self.beside.path().join(name), self.target.join(name))),
        });
        done.map_err(|e| Error::from(Input::new(format!("could not be written: {e}")).file(&self.target)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(folder: &Path) -> Vec<String> {
        let name = |entry: std::io::Result<fs::DirEntry>| entry.unwrap().file_name().into_string().unwrap();
        let mut names: Vec<_> = fs::read_dir(folder).unwrap().map(name).collect();
        names.sort();
        names
    }

    #[test]
    fn a_report_replaces_a_report_and_nothing_else() {
        let here = tempfile::tempdir().unwrap();
        let target = here.path().join("r");
        let page = format!("<meta {}>", REPORT.mark);
        let files = |text: &str| vec![("a.csv".to_string(), text.as_bytes().to_vec())];
        Folder::open(&target, &REPORT, "-o").unwrap().fill(&page, &files("1")).unwrap();
        assert_eq!(names(&target), ["a.csv", REPORT.page]);
        fs::write(target.join("mine"), "kept").unwrap();
        Folder::open(&target, &REPORT, "-o").unwrap().fill(&page, &files("2")).unwrap();
        assert_eq!((names(&target).len(), fs::read_to_string(target.join("a.csv")).unwrap()), (3, "2".into()));
        // A run that fails leaves the old report as it was.
        drop(Folder::open(&target, &REPORT, "-o").unwrap());
        assert_eq!((names(&target).len(), names(here.path())), (3, vec!["r".to_string()]));

        // One file after another: what was put stays.
        let target = here.path().join("s");
        for (text, empty) in [("1", "empty"), ("2", "never written")] {
            let folder = Folder::open(&target, &REPORT, "-o").unwrap();
            folder.put("a.csv", text.as_bytes(), &page.replace("<meta", empty)).unwrap();
            folder.put("b.csv", b"b", "never written").unwrap();
            drop(folder);
            assert_eq!(names(&target), ["a.csv", "b.csv", REPORT.page]);
            assert_eq!(fs::read_to_string(target.join("a.csv")).unwrap(), text);
            assert!(fs::read_to_string(target.join(REPORT.page)).unwrap().starts_with("empty"));
        }
        assert_eq!(names(here.path()), ["r", "s"]);

        let other = here.path().join("other");
        fs::create_dir(&other).unwrap();
        drop(Folder::open(&other, &REPORT, "-o").unwrap());
        fs::write(other.join(REPORT.page), "a page of someone's").unwrap();
        let fault = Folder::open(&other, &REPORT, "-o").unwrap_err();
        assert!(fault.to_string().contains("not written over") && fault.exit_code() == 2, "{fault}");
        for bad in
            [other.join(REPORT.page), other.join("no").join("such"), PathBuf::from("/"), PathBuf::from("/proc/report")]
        {
            let fault = Folder::open(&bad, &REPORT, "-o").unwrap_err();
            assert!(fault.exit_code() == 2 && fault.to_string().starts_with("-o: "), "{fault}");
        }
    }
}
