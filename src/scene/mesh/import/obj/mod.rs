//! Reads Wavefront OBJ: positions and faces as they are in the file, polygons cut into triangles.
//!
//! Materials, groups, points and lines are ignored, so that an error in them, or a missing `.mtl` file, does not
//! matter; nor does one in normals, which are made where they are missing. Texture coordinates, the library that names
//! a texture, and the colours of vertices are read only if a texture is requested.

use super::polygon::Cutter;
use super::{Coordinates, LARGEST, MOST_UV, Soup, Texels, bytes_of, colors, text_of};
use crate::error::Input;
use crate::scene::files::Files;
use crate::scene::range::Checked;
use glam::DVec3;
use std::borrow::Cow;
use std::path::Path;

mod fault;
mod mtl;
mod uv;

pub(in crate::scene) use mtl::map_kd;

/// Memory that the text takes beside the file's bytes, in bytes per byte.
const COPIES: u64 = 3;
/// Memory per word of the text until the mesh is clean, bytes: that of a face's corner with texture coordinates.
const BYTES: u64 = 150;

/// Reads a file's bytes; an error carries the line if one statement is to blame.
pub(super) fn read(files: &Files, bytes: &[u8], wanted: Option<Coordinates<'_>>, normals: bool) -> Checked<Soup> {
    // Names and comments may be in any encoding; what matters is ASCII.
    let text = text_that_fits(files, bytes)?;
    let Parsed { mut soup, cuts, .. } = parse(&text, false)?;
    let colored = wanted.is_some_and(|wanted| wanted.own);
    if is_colored(&text) && !colored {
        soup.notes.push(colors::LEFT_OUT.to_owned());
    }
    let faces = soup.input_face.clone();
    let cuts = faces.into_iter().zip(cuts);
    soup.uvs = match wanted {
        None => None,
        Some(_) if colored => Some(colors::corners(soup.triangles.len())),
        Some(wanted) => Some(uv::corners(&text, cuts.clone()).map_err(|fault| fault.key(wanted.key))?),
    };
    soup.normals = if normals { uv::normals(&text, cuts) } else { None };
    Ok(soup)
}

/// The colours of the vertices as a texture: linear, or sRGB if any is above 1, as where they go up to 255.
pub(super) fn texture(files: &Files, bytes: &[u8]) -> Checked<Texels> {
    let text = text_that_fits(files, bytes)?;
    if !is_colored(&text) {
        let fault = Input::new("the vertices have no colours").found("no `v x y z r g b`");
        let expected = "vertices with colours, `mtl` for the texture of the material library, or the name of an image";
        return Err(fault.expected(expected));
    }
    let Parsed { soup, colors: all, .. } = parse(&text, true)?;
    let whole = all.iter().flatten().any(|x| *x > 1.0);
    let light = |x: f64| if whole { colors::linear(f64::from(colors::share(x / 255.0))) } else { colors::share(x) };
    let colors_at = |corners: &[u32; 3]| corners.map(|corner| all[corner as usize].map(light));
    colors::checked(soup.triangles.iter().map(colors_at))
}

/// Whether the first vertex has a colour.
pub(super) fn is_colored(text: &str) -> bool {
    statements(text)
        .find(|(_, statement)| statement.split_whitespace().next() == Some("v"))
        .is_some_and(|(_, statement)| color(&statement.split_whitespace().skip(1).collect::<Vec<_>>()).is_some())
}

/// The colour among the numbers of a vertex.
fn color<'a>(numbers: &[&'a str]) -> Option<[&'a str; 3]> {
    let color = *numbers.get(3..)?.first_chunk::<3>()?;
    color.iter().all(|word| word.parse().is_ok_and(|x: f64| x.is_finite())).then_some(color)
}

/// The text of a file, once it is checked that parsing it fits the memory.
fn text_that_fits<'a>(files: &Files, bytes: &'a [u8]) -> Checked<Cow<'a, str>> {
    let need = |bytes: u64| files.need(bytes).map_err(|error| super::unread(&error));
    need(COPIES * bytes.len() as u64)?;
    let text = text_of(bytes);
    need(text.split_ascii_whitespace().count() as u64 * BYTES)?;
    Ok(text)
}

/// Reads the text of a file.
fn text(files: &Files, path: &Path) -> Checked<String> {
    Ok(text_of(&bytes_of(files, path, 1 + COPIES)?).into_owned())
}

/// The parsed contents of a file.
#[derive(Default)]
struct Parsed {
    soup: Soup,
    /// For each triangle, which corners of its face it has.
    cuts: Vec<[u32; 3]>,
    /// Colours of the vertices, if they were asked for.
    colors: Vec<[f64; 3]>,
}

/// Parses the text of a file, with the colours of its vertices if they are wanted.
fn parse(text: &str, colored: bool) -> Checked<Parsed> {
    let (kept, vertices) = geometry(text, colored);
    let options = tobj::LoadOptions::default();
    let no_materials = |_: &Path| Ok(Default::default());
    let loaded = tobj::load_obj_buf(&mut kept.as_bytes(), &options, no_materials);
    let joined = match loaded {
        Ok((models, _)) => join(&models, vertices),
        Err(_) => None,
    };
    let parsed = joined.ok_or_else(|| {
        let whole = || Input::new("the mesh file is not Wavefront OBJ");
        fault::first(text, vertices).unwrap_or_else(whole)
    })?;
    if parsed.soup.triangles.is_empty() {
        let fault = Input::new("the mesh has no faces");
        return Err(fault.found("no `f` statement").expected("a Wavefront OBJ file with faces"));
    }
    Ok(parsed)
}

/// Concatenates the models; `None` when a face has too few corners or a coordinate is out of range.
fn join(models: &[tobj::Model], vertices: usize) -> Option<Parsed> {
    let (Parsed { mut soup, mut cuts, mut colors }, mut cutter) = (Parsed::default(), Cutter::default());
    let mut face = 0;
    for tobj::Model { mesh, .. } in models {
        let base = u32::try_from(soup.positions.len()).ok()?;
        for position in mesh.positions.as_chunks().0 {
            let position = DVec3::from_array(*position);
            if !position.is_finite() || position.abs().max_element() > LARGEST {
                return None;
            }
            soup.positions.push(position);
        }
        colors.extend(mesh.vertex_color.as_chunks().0);

        // Without arities all faces are triangles.
        let mut rest = mesh.indices.as_slice();
        let mut arities = mesh.face_arities.iter();
        while !rest.is_empty() || arities.len() > 0 {
            let arity = arities.next().map_or(3, |&arity| arity as usize);
            let (corners, after) = rest.split_at_checked(arity)?;
            if corners.len() < 3 {
                return None;
            }
            // tobj has checked the indices.
            let place = |corner: &u32| soup.positions[(base + corner) as usize];
            for &cut in cutter.cut(corners.iter().map(place)) {
                soup.triangles.push(cut.map(|corner| base + corners[corner as usize]));
                soup.input_face.push(face);
                cuts.push(cut);
            }
            rest = after;
            face = face.checked_add(1)?;
        }
    }
    soup.unused = vertices.saturating_sub(soup.positions.len());
    Some(Parsed { soup, cuts, colors })
}

/// The `v` and `f` statements of a file without comments and attributes, and the number of `v`; if `colored`, each has
/// a colour, which is white where the file says none.
fn geometry(text: &str, colored: bool) -> (String, usize) {
    let mut kept = String::with_capacity(text.len());
    let mut vertices = 0;
    for (_, statement) in statements(text) {
        let mut words = statement.split_whitespace();
        match words.next() {
            Some("v") => {
                // Six numbers are a position and a colour; four are homogeneous.
                let numbers: Vec<&str> = words.collect();
                let taken = if numbers.len() == 4 { 4 } else { 3 };
                kept.push('v');
                let rgb = colored.then(|| color(&numbers).unwrap_or(["1"; 3]));
                let place = numbers.iter().take(if colored { 3 } else { taken });
                place.chain(rgb.iter().flatten()).for_each(|word| push(&mut kept, word));
                vertices += 1;
            }
            Some("f") => {
                kept.push('f');
                words.for_each(|word| push(&mut kept, index_of(word)));
            }
            _ => continue,
        }
        kept.push('\n');
    }
    (kept, vertices)
}

fn push(text: &mut String, word: &str) {
    text.push(' ');
    text.push_str(word);
}

/// The position index of a corner such as `7`, `7/2`, `7//3` or `7/2/3`; `x` when it has none.
fn index_of(corner: &str) -> &str {
    match corner.split('/').next() {
        None | Some("") => "x",
        Some(index) => index,
    }
}

/// The statements of a file, each with the line it starts on; comments are cut off, and lines that
/// end in a backslash are joined.
fn statements(text: &str) -> impl Iterator<Item = (usize, Cow<'_, str>)> {
    let mut lines = text.lines().enumerate();
    std::iter::from_fn(move || {
        let (number, line) = lines.next()?;
        let mut statement = Cow::Borrowed(bare(line));
        while statement.ends_with('\\') {
            let joined = statement.to_mut();
            joined.pop();
            joined.push(' ');
            joined.push_str(lines.next().map_or("", |(_, line)| bare(line)));
        }
        Some((number + 1, statement))
    })
}

/// A line without its comment.
fn bare(line: &str) -> &str {
    line.split('#').next().unwrap_or_default().trim_end()
}

#[cfg(test)]
mod tests {
    use super::*;

    const SQUARE: &str = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\n";

    #[test]
    fn polygons_become_triangles_in_the_files_order() {
        let text = format!("mtllib gone.mtl\n{SQUARE}v 9 9 9\no a\nf 1/1/1 2//2 3/3 4\no b\nf -3 -2 -1\n");
        let Parsed { soup, .. } = parse(&text, false).expect("a square and a triangle");
        assert_eq!(soup.triangles, [[0, 1, 2], [0, 2, 3], [2, 3, 4]]);
        assert_eq!(soup.input_face, [0, 0, 1]);
        assert_eq!((soup.positions.len(), soup.unused), (5, 0));
    }

    #[test]
    fn concave_polygons_keep_their_area_and_coordinates() {
        let corners = ["2 1", "1 1", "1 2", "0 2", "0 0", "2 0"];
        let (mut text, mut face) = (String::new(), "f".to_owned());
        for (k, corner) in corners.iter().enumerate() {
            text += &format!("v {corner} 0\nvt {corner}\n");
            face += &format!(" {0}/{0}", k + 1);
        }
        let wanted = Some(Coordinates { key: "texture", own: false });
        let soup =
            read(&Files::default(), format!("{text}{face}\n").as_bytes(), wanted, false).expect("four triangles");
        let at = |corner: u32| soup.positions[corner as usize];
        let doubled = soup.triangles.iter().map(|&[a, b, c]| (at(b) - at(a)).cross(at(c) - at(a)).z);
        assert_eq!((soup.triangles.len(), doubled.sum::<f64>()), (4, 6.0));
        let places = soup.triangles.iter().map(|triangle| triangle.map(|corner| [at(corner).x, at(corner).y]));
        assert_eq!(soup.uvs.expect("coordinates"), places.collect::<Vec<_>>());
    }

    #[test]
    fn colours_of_vertices_are_a_texture() {
        let of = |text: &str| texture(&Files::default(), text.as_bytes()).map_err(|fault| fault.to_string());
        let three = "v 0 0 0 1 0.5 0\nv 1 0 0 0 0 0\nv 0 1 0\nf 3 1 2\n";
        let (size, texels) = of(three).expect("colours");
        assert_eq!((size, &texels[..3]), ([2, 2], &[[1.0; 3], [1.0, 0.5, 0.0], [0.0; 3]][..]));
        // Up to 255, and an opacity.
        let (_, texels) = of("v 0 0 0 255 128 0 255\nv 1 0 0 0 0 0 9\nv 0 1 0 0 0 0 9\nf 1 2 3\n").expect("colours");
        assert!(texels[0][0] == 1.0 && (texels[0][1] - 0.215_860_5).abs() < 1e-6, "{:?}", texels[0]);
        let own = |own: bool| Some(Coordinates { key: "texture", own });
        let soup = |wanted| read(&Files::default(), three.as_bytes(), wanted, false).expect("a triangle");
        assert_eq!(soup(own(true)).uvs, Some(colors::corners(1)));
        assert_eq!((soup(own(true)).notes.len(), soup(None).notes.len()), (0, 1));
        for text in [format!("{SQUARE}f 1 2 3\n"), "v 0 0 0 a b c\nv 1 0 0\nv 0 1 0\nf 1 2 3\n".into()] {
            assert!(of(&text).is_err_and(|words| words.starts_with("the vertices have no colours")));
            assert!(read(&Files::default(), text.as_bytes(), None, false).expect("a triangle").notes.is_empty());
        }
        let text = three.replace('\n', "\r");
        assert_eq!(read(&Files::default(), text.as_bytes(), None, false).expect("old line ends").triangles.len(), 1);
    }

    #[test]
    fn passes_over_what_does_not_matter() {
        let text = "# caf\u{e9}\r\nmtllib\r\nv 0 0 0 1 0 0\r\nv 2 0 0 2\r\nv 0 1 0 # here\r\n\
                    vt nonsense\r\nusemtl\r\np 1\r\nl 1 2\r\nv 5 5 5\r\nf 1/9/9 2/8 \\\r\n 3\r\n";
        let Parsed { soup, .. } = parse(text, false).expect("a triangle");
        assert_eq!(soup.positions, [DVec3::ZERO, DVec3::X, DVec3::Y]);
        assert_eq!((soup.triangles.len(), soup.unused), (1, 1));
    }

    #[test]
    fn a_statement_of_a_million_lines_is_joined_once() {
        // Joining once per line would take minutes.
        let text = format!("{SQUARE}f 1 2 3 {}4\n", "\\\n".repeat(1_000_000));
        assert_eq!(parse(&text, false).expect("a square").soup.triangles.len(), 2);
    }
}
