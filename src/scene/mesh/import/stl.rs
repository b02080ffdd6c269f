//! Reads STL, ascii and binary: triangles whose corners are joined where they coincide.
//!
//! Read by hand: the crate stl_io ends at the first `endsolid`, so that it drops all but one of several solids, and its
//! errors have no line.

use super::{Coordinates, Soup, checked, no_coordinates, text_of, unread};
use crate::error::Input;
use crate::scene::files::Files;
use crate::scene::range::Checked;
use glam::DVec3;
use std::collections::HashMap;

/// Bytes before the triangles of a binary file, and per triangle.
const HEAD: usize = 84;
const TRIANGLE: usize = 50;
/// Memory per triangle until the mesh is clean, bytes.
const BYTES: u64 = 400;

/// Whether a file is binary STL: its length follows from the number of triangles that it states.
pub(super) fn is_binary(bytes: &[u8]) -> bool {
    stated(bytes).is_some_and(|count| count.checked_mul(TRIANGLE).is_some_and(|body| body + HEAD == bytes.len()))
}

/// The number of triangles of a binary file, and of the bytes after them, which some programs write.
fn triangles(bytes: &[u8]) -> Option<(usize, usize)> {
    let count = stated(bytes)?;
    let after = bytes.len().checked_sub(count.checked_mul(TRIANGLE)?.checked_add(HEAD)?)?;
    // A text, read as a binary file, states far more triangles than it has bytes for.
    (count > 0 || after == 0).then_some((count, after))
}

/// The number of triangles that a binary file states.
fn stated(bytes: &[u8]) -> Option<usize> {
    let count = bytes.get(80..HEAD)?.first_chunk::<4>()?;
    usize::try_from(u32::from_le_bytes(*count)).ok()
}

/// Reads a file's bytes; an error carries the line if one is to blame.
pub(super) fn read(files: &Files, bytes: &[u8], wanted: Option<Coordinates<'_>>) -> Checked<Soup> {
    no_coordinates(wanted, "STL")?;
    let mut corners = Corners::default();
    let mut notes = Vec::new();
    if let Some((count, after)) = triangles(bytes) {
        files.need(count as u64 * BYTES).map_err(|error| unread(&error))?;
        if after > 0 {
            notes.push(format!("ignored: {after} bytes after the last triangle"));
        }
        for triangle in bytes[HEAD..].chunks_exact(TRIANGLE).take(count) {
            // A normal, three corners, and two bytes that mean nothing.
            let numbers = triangle.as_chunks::<4>().0.iter().map(|four| f64::from(f32::from_le_bytes(*four)));
            let numbers: Vec<f64> = numbers.skip(3).collect();
            numbers.as_chunks().0.iter().try_for_each(|corner| corners.push(DVec3::from_array(*corner)))?;
        }
    } else {
        let text = text_of(bytes);
        let lines = text.lines().count() as u64;
        files.need(2 * bytes.len() as u64 + lines * BYTES / 3).map_err(|error| unread(&error))?;
        if !text.trim_start().get(..5).is_some_and(|word| word.eq_ignore_ascii_case("solid")) {
            let found = format!("{} bytes, which state {:?} triangles", bytes.len(), stated(bytes).unwrap_or(0));
            let fault = Input::new("the mesh file is neither ascii nor binary STL").found(found);
            return Err(fault.expected("`solid`, or a file of 84 bytes and 50 per triangle"));
        }
        let after = ascii(&text, &mut corners)?;
        if after > 0 {
            notes.push(format!("ignored: {after} lines after the last solid"));
        }
    }
    Ok(Soup { notes, ..corners.soup()? })
}

/// Corners of triangles, each three in turn, with one vertex per position.
#[derive(Default)]
struct Corners {
    positions: Vec<DVec3>,
    known: HashMap<[u64; 3], u32>,
    corners: Vec<u32>,
}

impl Corners {
    fn push(&mut self, position: DVec3) -> Checked<()> {
        let position = checked(position, self.corners.len())?;
        // Adding 0 turns -0 into 0.
        let key = (position + DVec3::ZERO).to_array().map(f64::to_bits);
        let next = self.positions.len() as u32;
        let vertex = *self.known.entry(key).or_insert(next);
        if vertex == next {
            self.positions.push(position);
        }
        self.corners.push(vertex);
        Ok(())
    }

    fn soup(self) -> Checked<Soup> {
        let triangles = self.corners.as_chunks().0.to_vec();
        if triangles.is_empty() {
            return Err(Input::new("the mesh has no faces").found("no triangle").expected("an STL file with facets"));
        }
        let input_face = (0..).take(triangles.len()).collect();
        Ok(Soup { positions: self.positions, triangles, input_face, ..Soup::default() })
    }
}

/// Reads the facets of every solid; normals, names and the words around loops are passed over. Returns the number of
/// lines after the solids that are no statements.
fn ascii(text: &str, corners: &mut Corners) -> Checked<usize> {
    let (mut of_facet, mut ended, mut after) = (0, false, 0);
    for (line, words) in text.lines().enumerate().map(|(line, text)| (line + 1, text)) {
        let mut words = words.split_ascii_whitespace();
        let first = words.next().map(str::to_ascii_lowercase);
        ended = match first.as_deref() {
            Some("endsolid") => true,
            Some("solid" | "facet" | "vertex") => false,
            _ => ended,
        };
        match first.as_deref() {
            Some("vertex") => {
                let numbers: Vec<f64> = words.map_while(|word| word.parse().ok()).collect();
                let [x, y, z] = numbers[..] else {
                    let fault = Input::new("a vertex is not three numbers").line(line);
                    return Err(fault.found(format!("{} numbers", numbers.len())).expected("such as `vertex 0 1 2`"));
                };
                of_facet += 1;
                corners.push(DVec3::new(x, y, z)).map_err(|fault| fault.line(line))?;
            }
            Some("endfacet") if of_facet != 3 => {
                let fault = Input::new("a facet has not three corners").line(line);
                return Err(fault.found(of_facet).expected("three lines `vertex` in each facet"));
            }
            Some("endfacet") => of_facet = 0,
            Some("solid" | "endsolid" | "facet" | "outer" | "endloop") | None => {}
            Some(_) if ended => after += 1,
            Some(other) => {
                let fault = Input::new("not a statement of ascii STL").line(line).found(format!("`{other}`"));
                return Err(fault.expected("solid, facet, outer loop, vertex, endloop, endfacet, endsolid"));
            }
        }
    }
    if of_facet == 0 {
        return Ok(after);
    }
    Err(Input::new("the file ends within a facet").found(format!("{of_facet} corners")).expected("`endfacet`"))
}

#[cfg(test)]
mod tests {
    use super::super::Format;
    use super::*;
    use std::path::Path;

    const TWO: &str = "solid a b\nfacet normal 0 0 0\n outer loop\n  vertex 0 0 0\n  VERTEX 1 0 0\n  vertex 0 1e0 0\n \
                       endloop\nendfacet\nendsolid a b\n\nsolid\nfacet normal 0 0 1\nouter loop\nvertex 1 0 0\n\
                       vertex -0 1 0\nvertex .5 .5 1.\nendloop\nendfacet\nendsolid\n";

    fn of(bytes: &[u8]) -> Result<Soup, String> {
        read(&Files::default(), bytes, None).map_err(|fault| fault.to_string())
    }

    #[test]
    fn all_solids_of_an_ascii_file_are_one_connected_mesh() {
        let soup = of(TWO.as_bytes()).expect("two triangles");
        assert_eq!(soup.triangles, [[0, 1, 2], [1, 2, 3]]);
        assert_eq!((soup.positions[3], soup.unused), (DVec3::new(0.5, 0.5, 1.0), 0));
    }

    #[test]
    fn binary_files_give_the_same_and_may_begin_like_ascii() {
        let soup = of(TWO.as_bytes()).expect("two triangles");
        let mut bytes = b"solid binary".to_vec();
        bytes.resize(80, b' ');
        bytes.extend(2u32.to_le_bytes());
        for corners in &soup.triangles {
            bytes.extend([9f32; 3].map(f32::to_le_bytes).concat());
            for corner in corners {
                let place = soup.positions[*corner as usize].to_array();
                bytes.extend(place.map(|x| (x as f32).to_le_bytes()).concat());
            }
            bytes.extend([0, 0]);
        }
        let other = of(&bytes).expect("two triangles");
        assert_eq!((&other.positions, &other.triangles), (&soup.positions, &soup.triangles));
        bytes[90..94].copy_from_slice(&f32::NAN.to_le_bytes());
        assert!(of(&bytes).is_ok(), "normals do not matter");
        bytes[96..100].copy_from_slice(&f32::NAN.to_le_bytes());
        assert!(
            of(&bytes).is_err_and(|words| words.starts_with("a coordinate is not finite or too large; found [NaN"))
        );
    }

    #[test]
    fn keywords_are_in_any_case_and_lines_end_in_any_way() {
        for text in [TWO.to_uppercase(), TWO.replace('\n', "\r\n"), TWO.replace('\n', "\r"), format!("\u{feff}{TWO}")] {
            assert_eq!(of(text.as_bytes()).expect("two triangles").triangles, [[0, 1, 2], [1, 2, 3]], "{text:?}");
            assert_eq!(Format::of(Path::new("a"), text.as_bytes()), Some(Format::Stl), "{text:?}");
        }
    }

    #[test]
    fn bytes_after_the_last_triangle_are_counted() {
        let corners = [0.0f32, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0].map(f32::to_le_bytes).concat();
        let whole = [&[b' '; 80][..], &1u32.to_le_bytes(), &corners, &[0; 2]].concat();
        for after in [1, 2, 50, 1000] {
            let soup = of(&[&whole[..], &vec![7; after]].concat()).expect("a triangle");
            assert_eq!(soup.notes, [format!("ignored: {after} bytes after the last triangle")]);
        }
        assert!(of(&whole).expect("a triangle").notes.is_empty() && of(&whole[..133]).is_err());
        for after in ["\0", "\x1a\n", "made by hand"] {
            let soup = of(format!("{TWO}{after}").as_bytes()).expect("two triangles");
            assert_eq!(
                (soup.triangles.len(), soup.notes),
                (2, vec!["ignored: 1 lines after the last solid".to_owned()])
            );
        }
    }

    #[test]
    fn faults_have_their_line() {
        let cases = [
            ("solid\nvertex 1 2\n", "a vertex is not three numbers; found 2 numbers"),
            ("solid\nvertex 1 2 x\n", "a vertex is not three numbers; found 2 numbers"),
            ("solid\nvertex 1 2 inf\n", "a coordinate is not finite or too large; found [1, 2, inf] at vertex 0"),
            ("solid\nendfacet\n", "a facet has not three corners; found 0"),
            ("solid\nface\n", "not a statement of ascii STL; found `face`; expected solid"),
        ];
        for (text, expected) in cases {
            let fault = read(&Files::default(), text.as_bytes(), None).expect_err(text);
            assert!(fault.line == Some(2) && fault.to_string().starts_with(expected), "{fault}");
        }
        assert!(of(b"solid\nvertex 1 2 3").is_err_and(|words| words.starts_with("the file ends within a facet")));
        assert!(of(b"solid\n").is_err_and(|words| words.starts_with("the mesh has no faces")));
        assert!(of(b"cut").is_err_and(|words| words.starts_with("the mesh file is neither ascii nor binary STL")));
    }
}
