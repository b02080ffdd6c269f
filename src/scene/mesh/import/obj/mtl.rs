//! The texture that a mesh's material library names.

use super::{statements, text};
use crate::error::Input;
use crate::scene::files::Files;
use crate::scene::range::Checked;
use std::path::{Path, PathBuf};

/// Maximum number of libraries of a mesh.
const MOST: usize = 64;
/// Memory that reading a library takes, in bytes per byte of the file.
const COPIES: u64 = 100;

/// The file of the only `map_Kd` in the libraries that this mesh file names, relative to the library. The materials'
/// colours, and which face has which material, are ignored.
pub(in crate::scene) fn map_kd(files: &Files, mesh: &Path) -> Checked<PathBuf> {
    let text = text(files, mesh)?;
    let library = |(line, statement): (usize, std::borrow::Cow<'_, str>)| {
        let name = statement.trim_start().strip_prefix("mtllib")?.trim().to_owned();
        (!name.is_empty()).then_some((line, name))
    };
    let mut textures = Vec::new();
    let mut libraries = Vec::new();
    for (line, name) in statements(&text).filter_map(library) {
        if libraries.len() == MOST {
            let fault = Input::new("too many material libraries").file(mesh).line(line);
            return Err(fault.expected(format!("at most {MOST}")));
        }
        let path = mesh.parent().unwrap_or(Path::new("")).join(name.replace('\\', "/"));
        let fault = |found: String| {
            let fault = Input::new(format!("{}: the material library cannot be read", path.display()));
            fault.file(mesh).line(line).found(found)
        };
        let bytes = files.read(&path, COPIES).map_err(|error| fault(error.to_string()))?;
        // Ignore colours, so that errors in them do not matter.
        let matters = |line: &&str| matches!(line.split_whitespace().next(), Some("newmtl" | "map_Kd"));
        let text = String::from_utf8_lossy(&bytes);
        let kept = text.lines().filter(matters).collect::<Vec<_>>().join("\n");
        let (materials, _) = tobj::load_mtl_buf(&mut kept.as_bytes()).map_err(|error| fault(error.to_string()))?;
        let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
        for material in materials {
            if let Some(image) = material.diffuse_texture {
                textures.push((material.name, folder.join(image.replace('\\', "/"))));
            }
        }
        libraries.push(path);
    }
    if libraries.is_empty() {
        let fault = Input::new("the mesh names no material library").file(mesh);
        return Err(fault.expected("an `mtllib` statement, or the name of an image"));
    }
    if let [(_, image)] = textures.as_slice() {
        return Ok(image.clone());
    }
    let names: Vec<&str> = textures.iter().map(|(name, _)| name.as_str()).collect();
    let found = match names.len() {
        0 => "no `map_Kd`".to_owned(),
        count => format!("{count}: {}", names.join(", ")),
    };
    let what = "one material with a texture is supported in a library";
    Err(Input::new(what).file(&libraries[0]).found(found).expected("exactly one `map_Kd`, or the name of an image"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_texture_is_found_and_others_are_named() {
        let folder = tempfile::tempdir().expect("a folder");
        let at = |name: &str| folder.path().join(name);
        let found = |mesh: &str, library: &str| {
            std::fs::write(at("a.obj"), mesh).expect("written");
            std::fs::create_dir_all(at("sub")).expect("a folder");
            std::fs::write(at("sub/a b.mtl"), library).expect("written");
            map_kd(&Files::default(), &at("a.obj")).map_err(|fault| fault.to_string())
        };
        let mesh = "# x\nmtllib sub\\a b.mtl\nf 1 2 3\n";
        let one = "newmtl plain\nKd 1 0 0\nnewmtl bark\nmap_Kd pictures\\a bark.png\n";
        assert_eq!(found(mesh, one), Ok(at("sub/pictures/a bark.png")));
        let two = format!("{one}newmtl leaf\nmap_Kd leaf.png\n");
        let cases = [
            (mesh, two.as_str(), "a b.mtl: one material with a texture is supported in a library; found 2: bark, leaf"),
            (mesh, "newmtl plain\n", "found no `map_Kd`; expected exactly one `map_Kd`, or the name of an image"),
            ("f 1 2 3\n", one, "a.obj: the mesh names no material library; expected an `mtllib` statement"),
            ("v 0 0 0\nmtllib gone.mtl\n", one, "a.obj:2: "),
            ("mtllib gone.mtl\n", one, "gone.mtl: the material library cannot be read; found "),
        ];
        for (mesh, library, expected) in cases {
            let error = found(mesh, library).expect_err(expected);
            assert!(error.contains(expected), "{error}");
        }
    }
}
