//! Reads mesh files: positions and triangles as they are in the file, polygons cut into triangles. The content tells
//! the format; the name's ending matters only where the content does not.

use super::Mesh;
use crate::error::Input;
use crate::scene::files::{Files, packed};
use crate::scene::range::Checked;
use crate::scene::skin::{Pose, Rig};
use glam::DVec3;
use std::borrow::Cow;
use std::io::ErrorKind;
use std::path::Path;
use toml::{Table, Value};

mod colors;
mod gltf;
mod obj;
mod ply;
mod polygon;
mod stl;

pub(in crate::scene) use obj::map_kd;

/// The formats, for messages.
pub(in crate::scene) const FORMATS: &str = "Wavefront OBJ, PLY, STL or glTF 2.0";

/// The largest coordinate a mesh may have; its cube is still far from overflow.
const LARGEST: f64 = 1e30;
/// The largest absolute texture coordinate: points in a texture are still distinguished after 10,000 repetitions.
const MOST_UV: f64 = 1e4;

/// Size and texels of a texture, rows from the top, r g b, linear.
pub(in crate::scene) type Texels = ([u32; 2], Vec<[f32; 3]>);

/// Which texture coordinates a mesh must have.
#[derive(Debug, Clone, Copy)]
pub(in crate::scene) struct Coordinates<'a> {
    /// The key of the texture, for errors.
    pub key: &'a str,
    /// Whether they are those of the texture that the mesh file brings along.
    pub own: bool,
}

/// Triangles as read, not yet cleaned.
#[derive(Debug, Default)]
pub(super) struct Soup {
    /// Vertices that faces use, in the order of first use.
    pub positions: Vec<DVec3>,
    /// Corners, as indices into `positions`.
    pub triangles: Vec<[u32; 3]>,
    /// For each triangle the face of the file it came from, from 0.
    pub input_face: Vec<u32>,
    /// Texture coordinates of each triangle's corners, if requested.
    pub uvs: Option<Vec<[[f64; 2]; 3]>>,
    /// Normals of each triangle's corners, of any length, if requested and the file has some; 0 at corners without.
    pub normals: Option<Vec<[DVec3; 3]>>,
    /// Vertices of the file that no face uses.
    pub unused: usize,
    /// What the file has that is ignored, one line each.
    pub notes: Vec<String>,
}

/// A format of mesh files.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::scene) enum Format {
    /// Wavefront OBJ.
    Obj,
    /// Polygon file format, ascii or binary.
    Ply,
    /// Stereolithography, ascii or binary.
    Stl,
    /// glTF 2.0, as text or GLB.
    Gltf,
}

/// The first words of statements in a Wavefront OBJ file.
const STATEMENTS: [&str; 14] =
    ["v", "vt", "vn", "vp", "f", "l", "p", "o", "g", "s", "mtllib", "usemtl", "usemap", "cstype"];

impl Format {
    /// The format of a file with these bytes; none if it is no mesh by content and name.
    pub fn of(path: &Path, bytes: &[u8]) -> Option<Self> {
        let bytes = bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes);
        let start = bytes.trim_ascii_start();
        let line = |bytes: &[u8], word: &[u8]| {
            let rest = bytes.split_at_checked(word.len()).filter(|(first, _)| first.eq_ignore_ascii_case(word));
            rest.is_some_and(|(_, rest)| rest.first().is_none_or(u8::is_ascii_whitespace))
        };
        // Binary STL has no mark but its length, and may begin like ascii STL.
        if stl::is_binary(bytes)
            || line(start, b"solid") && start.windows(5).any(|word| word.eq_ignore_ascii_case(b"facet"))
        {
            return Some(Self::Stl);
        }
        let json = start.starts_with(b"{");
        if bytes.starts_with(b"glTF") || json && start.windows(7).any(|word| word == b"\"asset\"") {
            return Some(Self::Gltf);
        }
        if line(bytes, b"ply") {
            return Some(Self::Ply);
        }
        if is_obj(bytes) {
            return Some(Self::Obj);
        }
        let end = path.extension().and_then(|end| end.to_str()).unwrap_or_default().to_ascii_lowercase();
        match end.as_str() {
            "obj" => Some(Self::Obj),
            "ply" => Some(Self::Ply),
            "stl" => Some(Self::Stl),
            "gltf" | "glb" => Some(Self::Gltf),
            _ => None,
        }
    }
}

/// Whether the first line of a text that is no comment is a statement of Wavefront OBJ.
fn is_obj(bytes: &[u8]) -> bool {
    let mut lines = bytes.split(|byte| b"\r\n".contains(byte)).map(<[u8]>::trim_ascii);
    let Some(line) = lines.find(|line| !line.is_empty() && !line.starts_with(b"#")) else { return false };
    let mut words = line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
    let first = words.next().unwrap_or_default();
    // `v = 1` is TOML.
    STATEMENTS.iter().any(|word| word.as_bytes() == first) && words.next().is_none_or(|word| !word.starts_with(b"="))
}

/// Reads a file, or a part of it; every error carries the file, and the line if one statement is to blame. `wanted` are
/// texture coordinates, if the mesh is to have any; `normals` says whether it is to have those of the file.
pub(super) fn read(
    files: &Files,
    path: &Path,
    part: Option<u32>,
    wanted: Option<Coordinates<'_>>,
    normals: bool,
) -> Checked<Soup> {
    let bytes = bytes_of(files, path, 1)?;
    let format = Format::of(path, &bytes);
    if let (Some(part), Some(Format::Obj | Format::Ply | Format::Stl)) = (part, format) {
        let fault = Input::new("a file in this format has no parts").file(path).found(format!("part = {part}"));
        return Err(fault.expected("no key `part`, or a glTF file, whose parts are its materials"));
    }
    let read = match format {
        Some(Format::Gltf) => gltf::read(files, path, &bytes, part, (wanted, normals)),
        Some(Format::Obj) => obj::read(files, &bytes, wanted, normals),
        Some(Format::Ply) => ply::read(files, &bytes, wanted, normals),
        Some(Format::Stl) => stl::read(files, &bytes, wanted),
        None => Err(Input::new("the mesh is in no format that can be read").expected(FORMATS)),
    };
    let soup = read.map_err(|fault| fault.file(path))?;
    files.take(soup.triangles.len() as u64 * Mesh::BYTES).map_err(|error| unread(&error).file(path))?;
    Ok(soup)
}

/// The texture that a mesh file, or a part of it, brings along.
pub(in crate::scene) fn own_texture(files: &Files, path: &Path, part: Option<u32>) -> Checked<Texels> {
    let bytes = bytes_of(files, path, 1)?;
    let texels = match Format::of(path, &bytes) {
        Some(Format::Gltf) => gltf::texture(files, path, &bytes, part),
        Some(Format::Ply) => ply::texture(files, &bytes),
        Some(Format::Obj) => obj::texture(files, &bytes),
        _ => Err(Input::new("a file in this format brings no texture along")
            .expected("OBJ or PLY with vertex colours, or glTF")),
    };
    texels.map_err(|fault| fault.file(path))
}

/// The scene of a mesh file alone, and notes on it; `around` is the scene of a mesh that brings nothing but its shape
/// along.
pub(in crate::scene) fn scene_of(
    files: &Files,
    path: &Path,
    bytes: &[u8],
    mut around: Table,
) -> Checked<(Table, Vec<String>)> {
    match Format::of(path, bytes) {
        Some(Format::Gltf) => return gltf::scene(files, path, bytes, around).map_err(|fault| fault.file(path)),
        format if brings_colors(files, bytes, format) => {
            let object = around.get_mut("object").and_then(Value::as_array_mut).and_then(|objects| objects.first_mut());
            if let Some(Value::Table(material)) = object.and_then(|object| object.get_mut("material")) {
                material.insert("texture".into(), "mesh".into());
            }
        }
        _ => {}
    }
    Ok((around, Vec::new()))
}

/// Whether the vertices of a file have colours, not too many for a texture.
fn brings_colors(files: &Files, bytes: &[u8], format: Option<Format>) -> bool {
    match format {
        Some(Format::Obj) => obj::is_colored(&text_of(bytes)) && obj::texture(files, bytes).is_ok(),
        Some(Format::Ply) => ply::texture(files, bytes).is_ok(),
        _ => false,
    }
}

/// Names of the animations of a mesh file, and how long they last, in seconds; empty for formats without animations.
pub(in crate::scene) fn animations(files: &Files, path: &Path) -> Checked<Vec<(String, f64)>> {
    let bytes = bytes_of(files, path, 1)?;
    match Format::of(path, &bytes) {
        Some(Format::Gltf) => gltf::animations(files, path, &bytes).map_err(|fault| fault.file(path)),
        _ => Ok(Vec::new()),
    }
}

/// The mesh of a file or a part of it, its rig, and its poses at rest and `at` a time in seconds of an animation, which
/// is given by its number.
pub(super) fn animated(
    files: &Files,
    path: &Path,
    part: Option<u32>,
    at: (usize, f64),
) -> Checked<(Soup, Rig, [Pose; 2])> {
    let bytes = bytes_of(files, path, 1)?;
    gltf::animated(files, path, &bytes, part, at).map_err(|fault| fault.file(path))
}

/// Reads the bytes of a mesh file; `copies` times its size must fit the memory.
fn bytes_of(files: &Files, path: &Path, copies: u64) -> Checked<Vec<u8>> {
    let bytes = files.read(path, copies).map_err(|error| match error.kind() {
        ErrorKind::NotFound => Input::new("there is no such mesh file").file(path),
        ErrorKind::Unsupported => {
            Input::new("the mesh is not a plain file").file(path).expected(format!("a file in {FORMATS}"))
        }
        _ => unread(&error).file(path),
    })?;
    match packed(&bytes) {
        Some(found) => Err(Input::new("the mesh file cannot be read").file(path).found(found).expected(FORMATS)),
        None => Ok(bytes),
    }
}

/// The text of a file in any encoding that extends ASCII, without a byte order mark; carriage returns become line feeds
/// in a file that has none.
fn text_of(bytes: &[u8]) -> Cow<'_, str> {
    let text = String::from_utf8_lossy(bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes));
    // Classic Mac OS ended lines by carriage returns alone.
    if text.contains('\r') && !text.contains('\n') { Cow::Owned(text.replace('\r', "\n")) } else { text }
}

fn unread(error: &std::io::Error) -> Input {
    Input::new("the mesh file cannot be read").found(error)
}

/// Fails if texture coordinates are wanted from a format that has none.
fn no_coordinates(wanted: Option<Coordinates<'_>>, format: &str) -> Checked<()> {
    match wanted {
        None => Ok(()),
        Some(wanted) => {
            let fault = Input::new("the mesh has no texture coordinates").key(wanted.key).found(format);
            Err(fault.expected("a material without texture, or a mesh with texture coordinates"))
        }
    }
}

/// Keeps the vertices that faces use, in the order of first use: `corners` are those of all faces. Also returns the old
/// number of each.
fn compact(
    positions: &[DVec3],
    corners: impl Iterator<Item = u32>,
    triangles: Vec<[u32; 3]>,
    input_face: Vec<u32>,
) -> (Soup, Vec<u32>) {
    let mut soup = Soup { triangles, input_face, ..Soup::default() };
    let mut number = vec![u32::MAX; positions.len()];
    let mut from = Vec::new();
    for corner in corners {
        let old = corner as usize;
        if number[old] == u32::MAX {
            number[old] = soup.positions.len() as u32;
            soup.positions.push(positions[old]);
            from.push(corner);
        }
    }
    soup.triangles.iter_mut().flatten().for_each(|corner| *corner = number[*corner as usize]);
    soup.unused = positions.len() - soup.positions.len();
    (soup, from)
}

/// Checks that the coordinates of a vertex, numbered from 0, are finite and at most [`LARGEST`].
fn checked(position: DVec3, vertex: usize) -> Checked<DVec3> {
    if position.is_finite() && position.abs().max_element() <= LARGEST {
        return Ok(position);
    }
    let found = format!("[{}, {}, {}] at vertex {vertex}", position.x, position.y, position.z);
    let fault = Input::new("a coordinate is not finite or too large").found(found);
    Err(fault.expected("three numbers of at most 1e30"))
}

#[cfg(test)]
mod tests;
