//! The texture that a mesh's material library names.

use super::{statements, text, text_of};
use crate::error::Input;
use crate::scene::files::{Files, packed};
use crate::scene::range::Checked;
use std::path::{Path, PathBuf};

/// Maximum number of libraries of a mesh.
const MOST: usize = 64;
/// Memory that reading a library takes, in bytes per byte of the file.
const COPIES: u64 = 100;

/// Options of textures, and how many values each has: those with 3 have up to 3 numbers.
const OPTIONS: [(&str, usize); 12] = [
    ("-blendu", 1),
    ("-blendv", 1),
    ("-bm", 1),
    ("-boost", 1),
    ("-cc", 1),
    ("-clamp", 1),
    ("-imfchan", 1),
    ("-mm", 2),
    ("-o", 3),
    ("-s", 3),
    ("-t", 3),
    ("-texres", 1),
];

/// The file of the only `map_Kd` in the libraries that this mesh file names, relative to the library. The materials'
/// colours, and which face has which material, are ignored; so are options, which are added to `report`.
pub(in crate::scene) fn map_kd(files: &Files, mesh: &Path, report: &mut Vec<String>) -> Checked<PathBuf> {
    let text = text(files, mesh)?;
    let library = |(line, statement): (usize, std::borrow::Cow<'_, str>)| {
        let name = statement.trim_start().strip_prefix("mtllib")?.trim().to_owned();
        (!name.is_empty()).then_some((line, name))
    };
    let mut textures = Vec::new();
    let mut libraries = Vec::new();
    let beside = |name: &str| mesh.parent().unwrap_or(Path::new("")).join(name.replace('\\', "/"));
    // A name may have spaces, or there are several.
    let names = |(line, all): (usize, String)| {
        let several = |all: &str| all.split_whitespace().any(|name| files.exists(&beside(name)));
        let names: Vec<String> = match !files.exists(&beside(&all)) && several(&all) {
            true => all.split_whitespace().map(str::to_owned).collect(),
            false => vec![all],
        };
        names.into_iter().map(move |name| (line, name))
    };
    for (line, name) in statements(&text).filter_map(library).flat_map(names) {
        if libraries.len() == MOST {
            let fault = Input::new("too many material libraries").file(mesh).line(line);
            return Err(fault.expected(format!("at most {MOST}")));
        }
        let path = beside(&name);
        let fault = |found: String| {
            let fault = Input::new(format!("{}: the material library cannot be read", path.display()));
            fault.file(mesh).line(line).found(found)
        };
        textures.extend(textures_of(files, &path, report, &fault)?);
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

/// The materials of a library that have a texture, with its file.
fn textures_of(
    files: &Files,
    path: &Path,
    report: &mut Vec<String>,
    fault: &dyn Fn(String) -> Input,
) -> Checked<Vec<(String, PathBuf)>> {
    let mut textures = Vec::new();
    let bytes = files.read(path, COPIES).map_err(|error| fault(error.to_string()))?;
    if let Some(found) = packed(&bytes) {
        return Err(fault(found.to_owned()));
    }
    // Ignore colours, so that errors in them do not matter.
    let matters = |line: &&str| matches!(line.split_whitespace().next(), Some("newmtl" | "map_Kd"));
    let text = text_of(&bytes);
    let kept = text.lines().filter(matters).collect::<Vec<_>>().join("\n");
    let (materials, _) = tobj::load_mtl_buf(&mut kept.as_bytes()).map_err(|error| fault(error.to_string()))?;
    let folder = path.parent().unwrap_or(Path::new("")).to_path_buf();
    for material in materials {
        if let Some(image) = material.diffuse_texture {
            let (options, image) = split(&image);
            if image.is_empty() {
                return Err(fault(format!("`map_Kd {}` without a file", options.join(" "))));
            }
            if !options.is_empty() {
                report.push(format!("{}: ignored: {} of map_Kd", path.display(), options.join(" ")));
            }
            textures.push((material.name, folder.join(image.replace('\\', "/"))));
        }
    }
    Ok(textures)
}

/// The options of a `map_Kd`, with their values, and the file, whose name may have spaces.
fn split(mut rest: &str) -> (Vec<&str>, &str) {
    let mut options = Vec::new();
    let next = |rest: &'_ str| rest.split_once(char::is_whitespace).map_or(rest.len(), |(word, _)| word.len());
    while let Some(option) = OPTIONS.iter().find(|option| rest.get(..next(rest)) == Some(option.0)) {
        let (mut values, all) = (0, rest);
        rest = rest[next(rest)..].trim_start();
        // Up to three numbers, or words of a fixed number.
        while values < option.1 && (option.1 < 3 || rest[..next(rest)].parse::<f64>().is_ok()) {
            rest = rest[next(rest)..].trim_start();
            values += 1;
        }
        options.push(all[..all.len() - rest.len()].trim_end());
    }
    (options, rest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_statement_names_several_libraries_and_options_are_said() {
        let of = |mesh: &str, map: &str| {
            let library = format!("newmtl b\nmap_Kd {map}\n");
            let all = [("m.obj", mesh), ("a.mtl", "newmtl a\nKd 1 0 0\n"), ("b.mtl", library.as_str())];
            let files = Files::held(all.map(|(name, text)| (name.into(), text.into())), 1 << 20);
            let mut report = Vec::new();
            let found = map_kd(&files, Path::new("m.obj"), &mut report).map_err(|fault| fault.to_string());
            (found, report)
        };
        let bark = || Ok(PathBuf::from("my bark.png"));
        assert_eq!(of("mtllib a.mtl b.mtl\n", "my bark.png"), (bark(), Vec::new()));
        assert_eq!(of("mtllib a.mtl\rmtllib b.mtl\r", "my bark.png"), (bark(), Vec::new()));
        for options in ["-s 1 2 3", "-o 0.5", "-clamp on -mm 0 1 -bm 0.3", "-blendu off -s 2 2 -imfchan r"] {
            let said = vec![format!("b.mtl: ignored: {options} of map_Kd")];
            assert_eq!(of("mtllib b.mtl\n", &format!("{options}  my bark.png")), (bark(), said), "{options}");
        }
        assert_eq!(of("mtllib b.mtl\n", "-x.png").0, Ok(PathBuf::from("-x.png")));
        let words = of("mtllib b.mtl\n", "-s 1 1 1").0.expect_err("no file");
        assert!(words.contains("found `map_Kd -s 1 1 1` without a file"), "{words}");
    }

    #[test]
    fn one_texture_is_found_and_others_are_named() {
        let folder = tempfile::tempdir().expect("a folder");
        let at = |name: &str| folder.path().join(name);
        let found = |mesh: &str, library: &str| {
            std::fs::write(at("a.obj"), mesh).expect("written");
            std::fs::create_dir_all(at("sub")).expect("a folder");
            std::fs::write(at("sub/a b.mtl"), library).expect("written");
            map_kd(&Files::default(), &at("a.obj"), &mut Vec::new()).map_err(|fault| fault.to_string())
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
