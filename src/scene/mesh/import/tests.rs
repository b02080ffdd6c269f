//! Formats are told by content, and faults name the file.

use super::*;

const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

#[test]
fn the_content_tells_the_format_and_the_name_only_without_it() {
    let of = |name: &str, bytes: &[u8]| Format::of(Path::new(name), bytes);
    let facet = b"solid x\nfacet normal 0 0 1\n";
    let binary = [&b"solid but binary"[..], &[0; 64], &1u32.to_le_bytes(), &[0; 50]].concat();
    assert_eq!(of("a.stl", b"# of a printer\n\n o cube\nv 0 0 0"), Some(Format::Obj));
    assert_eq!(of("a.obj", b"ply\r\nformat ascii 1.0"), Some(Format::Ply));
    assert_eq!((of("a.obj", facet), of("a", &binary)), (Some(Format::Stl), Some(Format::Stl)));
    assert_eq!((of("a.toml", b"v = 1"), of("b.toml", b"[camera]\nfov = 3"), of("c", b"")), (None, None, None));
    assert_eq!(
        (of("d.OBJ", b""), of("e.stl", b"cut"), of("f.txt", b"solid ground")),
        (Some(Format::Obj), Some(Format::Stl), None)
    );
}

#[test]
fn file_faults_name_the_file() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("gone.obj");
    let error = read(&Files::default(), &path, None, None, true).err().map(|e| e.to_string()).unwrap_or_default();
    assert!(error.ends_with("gone.obj: there is no such mesh file"), "{error}");
    let error =
        read(&Files::default(), folder.path(), None, None, true).err().map(|e| e.to_string()).unwrap_or_default();
    assert!(error.contains(": the mesh is not a plain file; expected"), "{error}");
    for bytes in [&b""[..], b"v 0 0 0\n", b"\xfd\xfe\0\0\x80"] {
        std::fs::write(&path, bytes).expect("written");
        let error = read(&Files::default(), &path, None, None, true).err().map(|e| e.to_string()).unwrap_or_default();
        assert!(error.contains("gone.obj: the mesh has no faces; found no `f`"), "{error}");
    }
    for (bytes, words) in [
        (&b"\x1f\x8b\x08\0"[..], "data packed by gzip"),
        (b"PK\x03\x04\x14\0", "a zip archive"),
        (b"\xff\xfev\0 \0", "UTF-16 text"),
        (b"v\0 \x000\0 \0", "UTF-16 text"),
        (b"\0v\0 \x000\0 ", "UTF-16 text"),
    ] {
        std::fs::write(&path, bytes).expect("written");
        let error = read(&Files::default(), &path, None, None, true).err().map(|e| e.to_string()).unwrap_or_default();
        assert!(error.contains(&format!("gone.obj: the mesh file cannot be read; found {words}")), "{error}");
    }
    std::fs::write(&path, format!("{SQUARE}f 1 2 7\n")).expect("written");
    let error = read(&Files::default(), &path, None, None, true).err().map(|e| e.to_string()).unwrap_or_default();
    assert!(error.contains("gone.obj:5: a face names a vertex that is not there"), "{error}");
}
