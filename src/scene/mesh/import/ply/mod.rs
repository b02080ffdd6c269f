//! Reads PLY, ascii and binary of either byte order: element `vertex`, with positions, normals, texture coordinates and
//! colours, and lists of corners in element `face`, cut into triangles.

use super::polygon::Cutter;
use super::{Coordinates, MOST_UV, Soup, Texels, checked, colors, compact, text_of, unread};
use crate::error::Input;
use crate::scene::files::Files;
use crate::scene::range::Checked;
use glam::DVec3;
use ply_rs_bw::parser::{ParseError, Parser, Reader};
use ply_rs_bw::ply::{ElementDef, Encoding, Header, PropertyAccess, PropertyType, ScalarType};
use std::borrow::Cow;

mod ascii;
mod elements;
use ascii::Lines;
use elements::{Face, Other, Vertex};

/// Memory per vertex, face and corner until the mesh is clean, bytes.
const BYTES: u64 = 200;

/// The contents of a file.
struct Ply {
    vertices: Vec<Vertex>,
    faces: Vec<Face>,
    /// Whether vertices have normals, texture coordinates and colours.
    has_normal: bool,
    has_uv: bool,
    has_color: bool,
}

/// The triangles of all faces.
#[derive(Default)]
struct Cut {
    triangles: Vec<[u32; 3]>,
    /// For each triangle the face that it came from, and the corners of the face that it has.
    input_face: Vec<u32>,
    corners: Vec<[u32; 3]>,
}

/// Reads a file's bytes; an error carries the line if one is to blame.
pub(super) fn read(files: &Files, bytes: &[u8], wanted: Option<Coordinates<'_>>, normals: bool) -> Checked<Soup> {
    let ply = Ply::read(files, bytes)?;
    let Cut { triangles, input_face, corners } = ply.cut()?;
    let uvs = match wanted {
        None => None,
        Some(wanted) if wanted.own && ply.has_color => Some(colors::corners(triangles.len())),
        Some(wanted) => Some(ply.uvs(wanted.key, &input_face, &corners)?),
    };
    let normal = |corner: u32| DVec3::from_array(ply.vertices[corner as usize].normal);
    let normals = (normals && ply.has_normal).then(|| triangles.iter().map(|corners| corners.map(normal)).collect());
    let used = ply.faces.iter().filter(|face| face.corners.len() > 2).flat_map(|face| &face.corners);
    let (soup, _) = compact(&ply.positions()?, used.copied(), triangles, input_face);
    let ignored = ply.has_color && !wanted.is_some_and(|wanted| wanted.own);
    Ok(Soup { uvs, normals, notes: ignored.then(|| colors::LEFT_OUT.to_owned()).into_iter().collect(), ..soup })
}

/// The colours of the vertices as a texture.
pub(super) fn texture(files: &Files, bytes: &[u8]) -> Checked<Texels> {
    let ply = Ply::read(files, bytes)?;
    if !ply.has_color {
        let fault = Input::new("the vertices have no colours").found("no properties red, green and blue");
        return Err(fault.expected("properties red, green and blue, or the name of an image"));
    }
    let triangles = ply.cut()?.triangles;
    let colors = triangles.iter().map(|corners| corners.map(|corner| ply.vertices[corner as usize].color));
    colors::checked(colors)
}

impl Ply {
    fn read(files: &Files, bytes: &[u8]) -> Checked<Self> {
        let (head, rest) = halves(bytes);
        let header = Parser::<Other>::new().read_header(&mut Reader::new(head.as_bytes()));
        let header = header.map_err(|error| fault(&error))?;
        fits(files, &header, rest.len())?;
        let text = if header.encoding == Encoding::Ascii { text_of(rest) } else { Cow::default() };
        let (mut reader, mut lines) = (Reader::new(rest), Lines::of(&text, head.lines().count()));
        let (vertices, faces) = (Vec::new(), Vec::new());
        let mut ply = Self { vertices, faces, has_normal: false, has_uv: false, has_color: false };
        for (name, element) in &header.elements {
            let has = |names: &[&str]| names.iter().all(|name| element.properties.contains_key(*name));
            match name.as_str() {
                "vertex" => {
                    if !has(&["x", "y", "z"]) {
                        let fault = Input::new("the vertices have no position").found(properties(element));
                        return Err(fault.expected("properties x, y and z"));
                    }
                    ply.has_normal = has(&["nx", "ny", "nz"]);
                    ply.has_uv = has(&["u", "v"]) || has(&["s", "t"]) || has(&["texture_u", "texture_v"]);
                    ply.has_color = has(&["red", "green", "blue"]);
                    ply.vertices = elements(&mut reader, &mut lines, element, &header)?;
                }
                "face" => {
                    if !has(&["vertex_indices"]) && !has(&["vertex_index"]) {
                        let fault = Input::new("the faces have no corners").found(properties(element));
                        return Err(fault.expected("a list vertex_indices or vertex_index"));
                    }
                    ply.faces = elements(&mut reader, &mut lines, element, &header)?;
                }
                _ => drop(elements::<Other>(&mut reader, &mut lines, element, &header)?),
            }
        }
        Ok(ply)
    }

    fn positions(&self) -> Checked<Vec<DVec3>> {
        self.vertices.iter().enumerate().map(|(number, vertex)| checked(vertex.position.into(), number)).collect()
    }

    /// The faces' triangles.
    fn cut(&self) -> Checked<Cut> {
        let (mut cut, mut cutter, positions) = (Cut::default(), Cutter::default(), self.positions()?);
        for (face, number) in self.faces.iter().zip(0..) {
            let outside = |corner: &&u32| **corner as usize >= self.vertices.len();
            if let Some(corner) = face.corners.iter().find(outside) {
                let found = if *corner == u32::MAX { "a negative number".into() } else { corner.to_string() };
                let fault =
                    Input::new("a face names a vertex that is not there").found(format!("{found} in face {number}"));
                return Err(fault.expected(format!("numbers from 0 and below {}", self.vertices.len())));
            }
            for &corners in cutter.cut(face.corners.iter().map(|&corner| positions[corner as usize])) {
                cut.triangles.push(corners.map(|corner| face.corners[corner as usize]));
                cut.input_face.push(number);
                cut.corners.push(corners);
            }
        }
        if cut.triangles.is_empty() {
            let fault =
                Input::new("the mesh has no faces").found(format!("{} faces of element `face`", self.faces.len()));
            return Err(fault.expected("a PLY file with faces of three or more corners"));
        }
        Ok(cut)
    }

    /// Texture coordinates of the corners of all triangles: those of faces, or else those of vertices. Triangle
    /// k has the corners `corners[k]` of face `input_face[k]`.
    fn uvs(&self, key: &str, input_face: &[u32], corners: &[[u32; 3]]) -> Checked<Vec<[[f64; 2]; 3]>> {
        let of_faces = self.faces.iter().any(|face| !face.uvs.is_empty());
        let mut all = Vec::with_capacity(self.faces.len());
        for (face, number) in self.faces.iter().zip(0u32..) {
            let places: Vec<[f64; 2]> = match of_faces {
                true => face.uvs.as_chunks().0.to_vec(),
                false if self.has_uv => face.corners.iter().map(|&corner| self.vertices[corner as usize].uv).collect(),
                false => Vec::new(),
            };
            let fine = |place: &[f64; 2]| place.iter().all(|x| x.abs() <= MOST_UV);
            if places.len() < face.corners.len() || !places.iter().all(fine) {
                let fault = Input::new("the mesh has no texture coordinates, or not at every corner").key(key);
                let expected = "properties u and v of vertices from -10,000 to 10,000, or a list texcoord of faces";
                return Err(fault.found(format!("{places:?} at face {number}")).expected(expected));
            }
            all.push(places);
        }
        let places = |(face, corners): (&u32, &[u32; 3])| corners.map(|corner| all[*face as usize][corner as usize]);
        Ok(input_face.iter().zip(corners).map(places).collect())
    }
}

/// The names of an element's properties.
fn properties(element: &ElementDef) -> String {
    let names: Vec<&str> = element.properties.keys().map(String::as_str).collect();
    if names.is_empty() { "no properties".into() } else { names.join(", ") }
}

/// The header, with line ends and letters as the parser wants them, and what follows it.
fn halves(bytes: &[u8]) -> (Cow<'_, str>, &[u8]) {
    let end = bytes.windows(11).position(|word| matches!(word[0], b'\r' | b'\n') && &word[1..] == b"end_header");
    let (head, rest) = bytes.split_at(end.map_or(bytes.len(), |end| end + 11));
    // In a file whose lines end in carriage returns alone, a line feed after the header may be the first number.
    let alone = !head.contains(&b'\n');
    let line_end = rest.iter().position(|byte| *byte == if alone { b'\r' } else { b'\n' });
    (text_of(head), line_end.map_or(&[], |line_end| &rest[line_end + 1..]))
}

fn elements<E: PropertyAccess>(
    reader: &mut Reader<&[u8]>,
    lines: &mut Lines<'_>,
    element: &ElementDef,
    header: &Header,
) -> Checked<Vec<E>> {
    if header.encoding == Encoding::Ascii {
        return lines.elements(element);
    }
    Parser::<E>::new().read_payload_for_element(reader, element, header).map_err(|error| fault(&error))
}

/// Checks what the header states against the bytes that follow it and the memory.
fn fits(files: &Files, header: &Header, bytes: usize) -> Checked<()> {
    let binary = header.encoding != Encoding::Ascii;
    let mut least = 0usize;
    for element in header.elements.values() {
        // Characters of an ascii number and what follows it, or bytes.
        let least_size = |kind: &PropertyType| match kind {
            _ if !binary => 2,
            PropertyType::Scalar(kind) | PropertyType::List(kind, _) => width(kind),
        };
        let size: usize = element.properties.values().map(|property| least_size(&property.data_type)).sum();
        least = least.saturating_add(size.max(1).saturating_mul(element.count));
    }
    // The last line may end without a break.
    if least > bytes.saturating_add(1) {
        let fault = Input::new("the file is shorter than its header states").found(format!("{bytes} bytes after it"));
        return Err(fault.expected(format!("at least {least} bytes")));
    }
    let counts = header.elements.values().map(|element| element.count as u64).sum::<u64>();
    // Lists may fill the file: with numbers of four bytes, or of a character and a space.
    let entries = if binary { bytes as u64 / 4 } else { bytes as u64 / 2 };
    files.need(counts.saturating_mul(BYTES) + entries * 16 + bytes as u64).map_err(|error| unread(&error))
}

fn width(kind: &ScalarType) -> usize {
    match kind {
        ScalarType::Char | ScalarType::UChar => 1,
        ScalarType::Short | ScalarType::UShort => 2,
        ScalarType::Int | ScalarType::UInt | ScalarType::Float => 4,
        ScalarType::Double => 8,
    }
}

/// The parser's error: what is wrong, and the text in which it is.
fn fault(error: &ParseError) -> Input {
    let text = error.to_string();
    let text =
        text.strip_prefix("Line ").and_then(|text| text.split_once(": ")).map_or(text.as_str(), |(_, rest)| rest);
    let mut lines = text.lines().map(str::trim);
    let what = lines.next().unwrap_or_default().trim_end_matches('.');
    let fault = Input::new(format!("the mesh file is not PLY as it should be: {what}"));
    let fault = match lines.find_map(|line| line.strip_prefix("String: ")) {
        Some(found) => fault.found(found.trim_matches('\'').trim_end()),
        None => fault,
    };
    match error.line() {
        Some(line) => fault.line(line),
        None => fault,
    }
}

#[cfg(test)]
mod tests;
