//! One primitive of a glTF mesh, in the frame of its node: triangles, morph targets, the influence of joints, texture
//! coordinates and colours.

use super::document::{Document, extension, number, numbers};
use crate::error::Input;
use crate::scene::files::Files;
use crate::scene::mesh::import::colors::share;
use crate::scene::range::Checked;
use glam::DVec3;
use gltf::json::mesh::{Mode, Primitive, Semantic};
use gltf::json::texture::Info;
use gltf::json::validation::Checked::Valid;

/// What a primitive contributes to a mesh.
pub(super) struct Piece {
    /// Positions of the vertices, without morph targets.
    pub positions: Vec<DVec3>,
    /// Displacements of the vertices by each morph target at weight 1; empty for a target without positions.
    pub targets: Vec<Vec<DVec3>>,
    /// Joints of each vertex, with weights whose sum is 1; `joint_count` a vertex. Empty if the primitive has no
    /// joints.
    pub joints: Vec<(u32, f64)>,
    /// The number of joints of a vertex, a multiple of 4.
    pub joint_count: usize,
    /// Triangles.
    pub triangles: Vec<[u32; 3]>,
}

impl Piece {
    /// Reads a primitive; none if it has no triangles.
    pub fn read(document: &Document, files: &Files, primitive: &Primitive) -> Checked<Option<Self>> {
        let Some(positions) = attribute(primitive, Semantic::Positions) else { return Ok(None) };
        document.check_plain(primitive)?;
        let vectors = |index| -> Checked<Vec<DVec3>> {
            Ok(document.vectors(files, index)?.into_iter().map(DVec3::from_array).collect())
        };
        let positions = vectors(positions)?;
        let Some(triangles) = triangles(document, files, primitive, positions.len())? else { return Ok(None) };
        let targets = primitive.targets.iter().flatten().map(|target| match target.positions {
            Some(index) => same(vectors(index.value())?, positions.len(), "a morph target"),
            None => Ok(Vec::new()),
        });
        let targets = targets.collect::<Checked<_>>()?;
        let (joints, joint_count) = joints(document, files, primitive, positions.len())?;
        Ok(Some(Self { positions, targets, joints, joint_count, triangles }))
    }

    /// The position of a vertex with these weights of morph targets.
    pub fn morphed(&self, vertex: usize, weights: &[f64]) -> DVec3 {
        let ways = self.targets.iter().zip(weights).filter(|(_, weight)| **weight != 0.0);
        let ways = ways.filter_map(|(target, weight)| Some(*target.get(vertex)? * *weight));
        self.positions[vertex] + ways.sum::<DVec3>()
    }
}

/// The accessor of an attribute.
fn attribute(primitive: &Primitive, semantic: Semantic) -> Option<usize> {
    primitive.attributes.get(&Valid(semantic)).map(|index| index.value())
}

/// Checks that a list has one entry per vertex.
fn same<T>(list: Vec<T>, vertices: usize, what: &str) -> Checked<Vec<T>> {
    if list.len() == vertices {
        return Ok(list);
    }
    let fault = Input::new(format!("{what} has not one entry per vertex")).found(list.len());
    Err(fault.expected(vertices))
}

/// Triangles of a primitive; none for points and lines.
fn triangles(
    document: &Document,
    files: &Files,
    primitive: &Primitive,
    vertices: usize,
) -> Checked<Option<Vec<[u32; 3]>>> {
    let mode = match primitive.mode {
        Valid(mode) => mode,
        _ => return Err(Input::new("a primitive's mode is not one of glTF's").expected("0 to 6")),
    };
    if !matches!(mode, Mode::Triangles | Mode::TriangleStrip | Mode::TriangleFan) {
        return Ok(None);
    }
    let corners: Vec<u32> = match primitive.indices {
        Some(index) => document.vectors::<1>(files, index.value())?.into_iter().map(|[x]| x as u32).collect(),
        None => (0..).take(vertices).collect(),
    };
    if let Some(corner) = corners.iter().find(|corner| **corner as usize >= vertices) {
        let fault = Input::new("a triangle names a vertex that is not there").found(corner);
        return Err(fault.expected(format!("numbers from 0 and below {vertices}")));
    }
    Ok(Some(match mode {
        Mode::TriangleStrip => {
            let three = corners.windows(3).enumerate();
            let turned = three.map(|(k, three)| {
                let [a, b, c] = [three[0], three[1], three[2]];
                if k % 2 == 0 { [a, b, c] } else { [b, a, c] }
            });
            // Strips are joined by triangles with a repeated corner.
            turned.filter(|[a, b, c]| a != b && b != c && c != a).collect()
        }
        Mode::TriangleFan => {
            let first = corners.first().copied().unwrap_or_default();
            corners.windows(2).skip(1).map(|pair| [first, pair[0], pair[1]]).collect()
        }
        _ => corners.as_chunks().0.to_vec(),
    }))
}

/// The joints of all vertices, and how many each has.
fn joints(
    document: &Document,
    files: &Files,
    primitive: &Primitive,
    vertices: usize,
) -> Checked<(Vec<(u32, f64)>, usize)> {
    let mut sets = Vec::new();
    for set in 0.. {
        let pair = (attribute(primitive, Semantic::Joints(set)), attribute(primitive, Semantic::Weights(set)));
        let (Some(joints), Some(weights)) = pair else { break };
        let joints = same(document.vectors::<4>(files, joints)?, vertices, "attribute JOINTS")?;
        sets.push((joints, same(document.vectors::<4>(files, weights)?, vertices, "attribute WEIGHTS")?));
    }
    let mut all = Vec::with_capacity(4 * sets.len() * vertices);
    for vertex in 0..vertices {
        let sum: f64 = sets.iter().flat_map(|(_, weights)| weights[vertex]).sum();
        for (joints, weights) in &sets {
            let share = |k: usize| if sum > 0.0 { weights[vertex][k] / sum } else { f64::from(u8::from(k == 0)) };
            all.extend((0..4).map(|k| (joints[vertex][k] as u32, share(k))));
        }
    }
    Ok((all, 4 * sets.len()))
}

/// Texture coordinates of the vertices for a texture, or as they are in set 0 if there is none; (0, 0) is the lower
/// left. None if the primitive has none.
pub(super) fn uvs(
    document: &Document,
    files: &Files,
    primitive: &Primitive,
    info: Option<&Info>,
) -> Checked<Option<Vec<[f64; 2]>>> {
    let transform = info.and_then(|info| extension!(info, "KHR_texture_transform"));
    let set = number(transform, "texCoord", info.map_or(0.0, |info| f64::from(info.tex_coord))) as u32;
    let Some(index) = attribute(primitive, Semantic::TexCoords(set)) else { return Ok(None) };
    let [x, y] = numbers(transform, "offset", [0.0; 2]);
    let [width, height] = numbers(transform, "scale", [1.0; 2]);
    let (s, c) = number(transform, "rotation", 0.0).sin_cos();
    // As in the extension's example: a quarter turn takes (u, v) to (v, 1 - u) if the offset is (0, 1).
    let place = |[u, v]: [f64; 2]| {
        let (u, v) = (width * u, height * v);
        [x + c * u + s * v, 1.0 - (y - s * u + c * v)]
    };
    Ok(Some(document.vectors(files, index)?.into_iter().map(place).collect()))
}

/// Normals of the vertices; none if the primitive has none.
pub(super) fn normals(document: &Document, files: &Files, primitive: &Primitive) -> Checked<Option<Vec<DVec3>>> {
    let Some(index) = attribute(primitive, Semantic::Normals) else { return Ok(None) };
    Ok(Some(document.vectors(files, index)?.into_iter().map(DVec3::from_array).collect()))
}

/// Colours of the vertices, r g b, linear, 0 to 1; none if the primitive has none.
pub(super) fn colors(document: &Document, files: &Files, primitive: &Primitive) -> Checked<Option<Vec<[f32; 3]>>> {
    let Some(index) = attribute(primitive, Semantic::Colors(0)) else { return Ok(None) };
    let (values, width) = document.numbers(files, index, &[3, 4])?;
    let color = |rgb: &[f64]| [0, 1, 2].map(|k| share(rgb[k]));
    Ok(Some(values.chunks_exact(width).map(color).collect()))
}
