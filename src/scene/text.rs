//! The text of a scene: a built-in one, a file, or what is made for a mesh alone.

use super::around_mesh;
use super::builtin::BUILTIN;
use super::files::{Files, packed};
use super::locate;
use super::mesh::{FORMATS, Format, scene_of};
use super::range::Checked;
use crate::error::Input;
use std::path::{Path, PathBuf};

/// Maximum size of a scene file, bytes.
const MOST_TEXT: usize = 1 << 22;
/// Memory that reading a scene file takes, in bytes per byte of the file.
const COPIES: u64 = 400;

/// The TOML text of a scene and where it comes from.
#[derive(Debug)]
pub(super) struct Text {
    /// The built-in name, or the file name without its extension.
    pub name: String,
    /// The text.
    pub toml: String,
    /// For error messages.
    pub file: PathBuf,
    /// The folder that paths in the text are relative to.
    pub folder: PathBuf,
    /// Whether it is that of a mesh alone.
    pub alone: bool,
    /// Notes on such a mesh, one per entry.
    pub report: Vec<String>,
}

impl Text {
    /// Finds a built-in scene, a scene file or a mesh, and makes the scene of a mesh alone.
    pub fn find(name_or_path: &str, files: &Files) -> Checked<Self> {
        // A built-in scene.
        let built_in = BUILTIN.iter().find(|(name, ..)| name.eq_ignore_ascii_case(name_or_path));
        if let Some(&(name, toml, _)) = built_in {
            let (name, toml) = (name.to_owned(), toml.to_owned());
            let file = PathBuf::from(&name);
            return Ok(Self { name, toml, file, folder: PathBuf::new(), alone: false, report: Vec::new() });
        }
        let path = Path::new(name_or_path);
        if !files.exists(path) {
            let names: Vec<&str> = BUILTIN.iter().map(|(name, ..)| *name).collect();
            let what = "neither a built-in scene nor a file";
            let what = locate::with_suggestion(what, name_or_path, &names);
            let expected = format!("a file, or one of {}", names.join(", "));
            return Err(Input::new(what).found(name_or_path).expected(expected));
        }

        // A mesh alone, or a scene file.
        let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let file = path.to_path_buf();
        let fault = |found: String, expected: &str| {
            Input::new("the scene file cannot be read").file(path).found(found).expected(expected)
        };
        let kinds = &format!("a scene in TOML, or a mesh in {FORMATS}");
        let bytes = files.stream(path, 1).map_err(|error| fault(error.to_string(), kinds))?;
        if let Some(found) = packed(&bytes) {
            return Err(fault(found.to_owned(), kinds));
        }
        if Format::of(path, &bytes).is_some() {
            let around = toml::from_str(&around_mesh(name_or_path)).unwrap_or_default();
            let (table, report) = scene_of(files, path, &bytes, around)?;
            let toml = toml::to_string(&table).unwrap_or_default();
            return Ok(Self { name, toml, file, folder: PathBuf::new(), alone: true, report });
        }
        if bytes.len() > MOST_TEXT {
            return Err(fault(format!("{} bytes", bytes.len()), &format!("at most {MOST_TEXT} bytes, {kinds}")));
        }
        files.need(COPIES * bytes.len() as u64).map_err(|error| fault(error.to_string(), kinds))?;
        let toml = String::from_utf8(bytes).map_err(|error| fault(error.utf8_error().to_string(), kinds))?;
        let named = path.extension().is_some_and(|end| end.eq_ignore_ascii_case("toml"));
        if let (false, Err(error)) = (named, toml::from_str::<toml::Table>(&toml)) {
            // A file with another ending need not be meant as TOML: name the formats too.
            let fault = locate::from_toml(&error, &toml, path);
            let what = format!("neither a mesh nor a scene in TOML: {}", fault.what);
            return Err(Input { what, expected: Some(kinds.clone()), ..fault });
        }
        let folder = path.parent().map(Path::to_path_buf).unwrap_or_default();
        Ok(Self { name, toml, file, folder, alone: false, report: Vec::new() })
    }
}
