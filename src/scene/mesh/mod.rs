//! Triangle meshes: read from a file or built as a shape, cleaned, and oriented outwards.

mod bust;
mod butterfly;
mod candle;
mod clean;
mod creases;
mod detail;
mod edges;
mod fish;
mod gecko;
mod import;
mod lotus;
mod morph;
mod nesting;
mod nets;
mod orient;
mod refine;
mod relief;
mod shape;
mod split;
mod sweep;
mod twice;
mod uv;
mod walk;
mod wrap;

pub(super) use import::{Coordinates, FORMATS, Format, Texels, animations, map_kd, own_texture, scene_of};
pub(super) use refine::Origin;
pub use shape::Shape;

use super::files::Files;
use super::range::Checked;
use crate::error::Input;
use crate::phases::phase;
use glam::DVec3;
use rayon::prelude::*;
use std::path::Path;

/// A triangle mesh without degenerate faces, unused vertices or duplicate vertices.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Mesh {
    /// Vertices, in scene units.
    pub positions: Vec<DVec3>,
    /// Corners of each triangle, as indices into `positions`; the outward normal is
    /// `(p1 - p0) x (p2 - p0)`.
    pub triangles: Vec<[u32; 3]>,
    /// For each triangle the face of the input it came from, from 0; a polygon counts as one face.
    pub input_face: Vec<u32>,
    /// Texture coordinates of each triangle's corners, if it has any, one entry per triangle: (0, 0) is the lower left,
    /// (1, 1) the upper right corner of the texture.
    pub uvs: Option<Vec<[[f64; 2]; 3]>>,
    /// Unit normals of the vertices that shading interpolates in place of those of the triangles around them: a file
    /// may have some, and the parts of a divided triangle lie in its plane, and have the normals of the whole.
    pub normals: Option<Vec<DVec3>>,
    /// While the mesh is read: normals of each triangle's corners in its file, 0 where there is none.
    pub corner_normals: Option<Vec<[DVec3; 3]>>,
    /// The number of edges with one triangle only; 0 when the mesh is closed.
    pub open_edges: usize,
    /// For a subdivided mesh, how often each triangle was split in four: the four parts are consecutive, the middle one
    /// last. Empty for any other mesh.
    pub splits: Vec<u8>,
    /// Whether the scene says how fine it is, by the `detail` of a built-in shape.
    pub detailed: bool,
}

/// Minimum extent of a mesh in a file, for which its volume does not underflow.
const SMALLEST: f64 = 1e-30;
/// Maximum pairs of point and triangle that are tested to find a light inside a medium.
const MOST_INSIDE: usize = 1 << 31;

impl Mesh {
    /// Memory per triangle, with its share of the vertices, while a mesh is built, bytes.
    pub const BYTES: u64 = 150;

    /// Reads, cleans and orients a mesh file or a part of it; repairs and warnings are added to `report`. `wanted` are
    /// texture coordinates, if there is a texture: every corner must then have them. `normals` says whether those of
    /// the file are used, if it has some.
    pub(super) fn read(
        files: &Files,
        path: &Path,
        part: Option<u32>,
        wanted: Option<Coordinates<'_>>,
        normals: bool,
        report: &mut Vec<String>,
    ) -> Checked<Self> {
        let soup = phase("reading meshes", || import::read(files, path, part, wanted, normals))?;
        let clean = || clean::clean(soup, report).map_err(|fault| fault.file(path));
        let (mut mesh, _) = phase("cleaning meshes", clean)?;
        let (low, high) = mesh.bounds();
        let extent = (high - low).max_element();
        if extent < SMALLEST {
            let fault = Input::new("the mesh is too small").file(path).found(format!("{extent:e} across"));
            return Err(fault.expected(format!("at least {SMALLEST:e}")));
        }
        let orient = || orient::orient(&mut mesh, report).map_err(|fault| fault.file(path));
        phase("orienting meshes", orient)?;
        Ok(mesh.with_normals_of_corners(report))
    }

    /// A mesh built here, which is known to be clean, closed unless the caller says otherwise, and oriented outwards.
    fn made(positions: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Self {
        let input_face = (0..triangles.len()).filter_map(|face| u32::try_from(face).ok()).collect();
        Self { positions, triangles, input_face, ..Self::default() }
    }

    /// The lowest and highest corner of the bounding box, in scene units.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        let first = self.positions.first().copied().unwrap_or_default();
        let both = |(low, high): (DVec3, DVec3), p: &DVec3| (low.min(*p), high.max(*p));
        self.positions.iter().fold((first, first), both)
    }

    /// The corners of a triangle; `None` past the last one.
    pub fn corners(&self, triangle: usize) -> Option<[DVec3; 3]> {
        let [a, b, c] = *self.triangles.get(triangle)?;
        let at = |index: u32| self.positions.get(index as usize).copied();
        Some([at(a)?, at(b)?, at(c)?])
    }

    /// Unit normals of the vertices from the triangles around them, weighted by area; where those cancel, that of one
    /// of them.
    pub fn vertex_normals(&self) -> Vec<DVec3> {
        let mut around = vec![Vec::new(); self.positions.len()];
        for &[a, b, c] in &self.triangles {
            let [p, q, r] = [a, b, c].map(|v| self.positions[v as usize]);
            let area = 0.5 * (q - p).cross(r - p);
            [a, b, c].into_iter().for_each(|v| around[v as usize].push((area, area.length())));
        }
        around.iter().map(|faces| vertex_normal(faces.iter().copied()).normalize_or_zero()).collect()
    }

    /// The number of triangles at each vertex.
    pub fn round(&self) -> Vec<u32> {
        let mut round = vec![0; self.positions.len()];
        self.triangles.iter().flatten().for_each(|&vertex| round[vertex as usize] += 1);
        round
    }

    /// For each half-edge its twin, that of the only other triangle at this edge, or `u32::MAX`; half-edge `3 t + k`
    /// runs from corner `k` of triangle `t` to the next one.
    pub fn twins(&self) -> Vec<u32> {
        edges::Edges::of(&self.triangles).twin
    }

    /// The enclosed volume in cubic scene units, negative when the mesh is inside out; for an open mesh, the volume of
    /// the cone from the first vertex.
    pub fn volume(&self) -> f64 {
        let apex = self.positions.first().copied().unwrap_or_default();
        let corners = (0..self.triangles.len()).filter_map(|triangle| self.corners(triangle));
        corners.map(|[a, b, c]| (a - apex).dot((b - apex).cross(c - apex)) / 6.0).sum()
    }

    /// The first of these points that lies in the medium: the winding number of the surface about it is 1, or more
    /// where parts overlap. It is 0 in a cavity, and between 0 and 1 on the surface. A mesh with an open edge has no
    /// inside. Of very many points only every n-th is tested.
    pub fn first_inside(&self, points: &[DVec3]) -> Option<DVec3> {
        let (low, high) = self.bounds();
        let boxed = |p: &&DVec3| p.cmpge(low).all() && p.cmple(high).all();
        let faces: Vec<u32> = (0..).take(self.triangles.len()).collect();
        let inside = |p: &&DVec3| nesting::winding(self, &faces, **p) > 0.999;
        if self.open_edges > 0 {
            return None;
        }
        // Limit the work: test every `step`-th point only.
        let boxed: Vec<&DVec3> = points.iter().filter(boxed).collect();
        let step = (boxed.len() * self.triangles.len()).div_ceil(MOST_INSIDE).max(1);
        boxed.par_iter().step_by(step).find_first(|p| inside(p)).copied().copied()
    }

    /// Moves the centre of the bounding box to the origin and scales the largest extent to `size`; returns that centre
    /// and the factor. `key` is the key of the size, for errors.
    pub(super) fn resize(&mut self, size: f64, key: &str) -> Checked<(DVec3, f64)> {
        let (low, high) = self.bounds();
        let extent = (high - low).max_element();
        if extent <= 0.0 {
            return Err(Input::new("the mesh has no extent").key(key));
        }
        let (middle, factor) = (low + (high - low) / 2.0, size / extent);
        for position in &mut self.positions {
            *position = (*position - middle) * factor;
        }
        Ok((middle, factor))
    }
}

/// A sum of vector areas vanishes below this share of the areas: only rounding is left.
const VANISHED: f64 = 1e-5;

/// The vector area at a vertex with faces of these vector areas and areas: their sum, or where it vanishes, as between
/// two sides of a sheet, that of the first face with an area.
pub fn vertex_normal(faces: impl Iterator<Item = (DVec3, f64)> + Clone) -> DVec3 {
    let area: f64 = faces.clone().map(|(_, area)| area).sum();
    let sum: DVec3 = faces.clone().map(|(normal, _)| normal).sum();
    let mut whole = faces.filter(|(_, area)| *area > 0.0).map(|(normal, _)| normal);
    if sum.length() > VANISHED * area { sum } else { whole.next().unwrap_or_default() }
}

/// The index of a vertex as `u32`; shapes have far fewer than 2^32.
fn number(index: usize) -> u32 {
    u32::try_from(index).unwrap_or(u32::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normals_that_cancel_are_those_of_a_triangle() {
        let up = (DVec3::new(0.0, 0.0, 2.0), 2.0);
        let down = (DVec3::new(0.0, 1e-7, -2.0), 2.0);
        assert_eq!(vertex_normal([up, down].into_iter()), up.0);
        let none = (DVec3::ZERO, 0.0);
        assert_eq!(vertex_normal([none, down, up].into_iter()), down.0);
        assert_eq!(vertex_normal([none, none].into_iter()), DVec3::ZERO);
        let side = (DVec3::X, 1.0);
        assert_eq!(vertex_normal([up, down, side].into_iter()), up.0 + down.0 + DVec3::X);
    }

    #[test]
    fn resizing_centres_and_scales() {
        let mut mesh = Shape::Slab.build(4);
        for position in &mut mesh.positions {
            *position = *position * 7.0 + DVec3::new(100.0, 3.0, -5.0);
        }
        mesh.resize(20.0, "size").expect("it has an extent");
        let (low, high) = mesh.bounds();
        assert!((low - DVec3::new(-10.0, -10.0, -2.0)).length() < 1e-12);
        assert!((high - DVec3::new(10.0, 10.0, 2.0)).length() < 1e-12);
        mesh.positions.truncate(1);
        assert!(mesh.resize(20.0, "size").is_err_and(|e| e.to_string().contains("no extent")));
    }

    #[test]
    fn the_whole_way_from_a_file() {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.obj");
        let cube = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0 0 1\nv 1 0 1\nv 1 1 1\nv 0 1 1\n\
                    f 1 2 3 4\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";
        std::fs::write(&path, cube).expect("written");
        let mut report = Vec::new();
        let mesh = Mesh::read(&Files::default(), &path, None, None, true, &mut report).expect("a cube");
        assert_eq!((mesh.triangles.len(), mesh.open_edges), (12, 0));
        assert_eq!(mesh.input_face, [0, 0, 1, 1, 2, 2, 3, 3, 4, 4, 5, 5]);
        assert!((mesh.volume() - 1.0).abs() < 1e-12);
        assert_eq!(report, ["reversed: 2 faces in 1 of 1 connected parts pointed the wrong way"]);
    }
}
