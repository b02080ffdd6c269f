//! Whether a mesh is a sheet without thickness: a leaf, paper, a flat character. Open meshes with small holes, such as
//! scans, are not.

use super::super::{Mesh, Scene};
use glam::DVec3;
use std::f64::consts::PI;

/// A part is a sheet if discs with rims as long as its own have at least this share of its area: flat ones have all of
/// it, a bowl half, a box without its lid a quarter, a bust without its base a tenth.
const OPEN: f64 = 1.0 / 6.0;
/// A mesh is a sheet if at least this share of its area is in parts that are.
const ENOUGH: f64 = 0.05;

/// Numbers of the translucent objects that are sheets.
pub(super) fn all(scene: &Scene) -> Vec<usize> {
    // Single scattering works on one side only.
    let is_lit_sheet = |(_, object): &(usize, &super::super::Object)| {
        object.material.opaque.is_none() && !object.material.single_scattering && is_sheet(&object.mesh)
    };
    scene.objects.iter().enumerate().filter(is_lit_sheet).map(|(number, _)| number).collect()
}

/// Vertices that are joined; each group is known by one of them.
struct Groups(Vec<u32>);

impl Groups {
    fn of(vertices: usize) -> Self {
        Self((0..vertices as u32).collect())
    }

    fn root(&mut self, mut vertex: u32) -> u32 {
        while self.0[vertex as usize] != vertex {
            // Halve the way for later searches.
            self.0[vertex as usize] = self.0[self.0[vertex as usize] as usize];
            vertex = self.0[vertex as usize];
        }
        vertex
    }

    fn join(&mut self, a: u32, b: u32) {
        let (a, b) = (self.root(a), self.root(b));
        self.0[a.max(b) as usize] = a.min(b);
    }
}

fn is_sheet(mesh: &Mesh) -> bool {
    if mesh.open_edges == 0 {
        return false;
    }
    // Normals of a file part vertices where nothing ends.
    let mesh = &if mesh.normals.is_some() { mesh.joined() } else { mesh.clone() };
    // Parts and their areas.
    let mut parts = Groups::of(mesh.positions.len());
    for &[a, b, c] in &mesh.triangles {
        parts.join(a, b);
        parts.join(b, c);
    }
    let mut areas = vec![0.0; mesh.positions.len()];
    for (triangle, corners) in mesh.triangles.iter().enumerate() {
        let area = |[a, b, c]: [DVec3; 3]| (b - a).cross(c - a).length() / 2.0;
        areas[parts.root(corners[0]) as usize] += mesh.corners(triangle).map_or(0.0, area);
    }

    // Rims and their lengths.
    let twins = mesh.twins();
    let edge = |half: usize| [half % 3, (half + 1) % 3].map(|corner| mesh.triangles[half / 3][corner]);
    let rim: Vec<[u32; 2]> = (0..twins.len()).filter(|&half| twins[half] == u32::MAX).map(edge).collect();
    let mut rims = Groups::of(mesh.positions.len());
    rim.iter().for_each(|&[a, b]| rims.join(a, b));
    let mut lengths = vec![0.0; mesh.positions.len()];
    for &[a, b] in &rim {
        lengths[rims.root(a) as usize] += mesh.positions[a as usize].distance(mesh.positions[b as usize]);
    }

    // The areas of discs with rims as long.
    let mut gaps = vec![0.0; mesh.positions.len()];
    for (vertex, length) in (0..).zip(&lengths) {
        gaps[parts.root(vertex) as usize] += length * length / (4.0 * PI);
    }
    let open: f64 = areas.iter().zip(&gaps).filter(|(area, gap)| **gap >= OPEN * **area).map(|(area, _)| area).sum();
    open >= ENOUGH * areas.iter().sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::super::super::Shape;
    use super::*;

    /// A shape without the triangles that have a corner beyond this plane.
    fn cut(shape: Shape, detail: u32, beyond: impl Fn(DVec3) -> bool) -> Mesh {
        let mut mesh = shape.build(detail);
        let whole = mesh.triangles.len();
        let positions = mesh.positions.clone();
        mesh.triangles.retain(|corners| !corners.iter().any(|corner| beyond(positions[*corner as usize])));
        assert!(mesh.triangles.len() < whole);
        mesh.open_edges = mesh.twins().iter().filter(|&&twin| twin == u32::MAX).count();
        mesh
    }

    #[test]
    fn sheets_are_told_from_bodies_with_holes() {
        let flat = Shape::Plane.build(4);
        let mut leaf = Shape::Plane.build(20);
        leaf.positions.iter_mut().for_each(|p| p.y = 0.3 * (3.0 * p.x).sin() - p.z * p.z);
        // A ribbon that turns: its area points nowhere.
        let mut ribbon = Shape::Plane.build(60);
        for p in &mut ribbon.positions {
            let (sine, cosine) = (12.0 * p.x).sin_cos();
            *p = DVec3::new(20.0 * p.x, p.z * cosine, p.z * sine);
        }
        let bowl = cut(Shape::Sphere, 4, |p| p.y > 0.05);
        for mesh in [flat, leaf, ribbon, bowl] {
            assert!(is_sheet(&mesh));
        }
        let holed = cut(Shape::Sphere, 4, |p| p.y > 0.95);
        let plinth = cut(Shape::Bust, 64, |p| p.y < 0.01);
        for mesh in [holed, plinth, Shape::Lotus.build(32)] {
            assert!(!is_sheet(&mesh), "{} open edges", mesh.open_edges);
        }
        // A pot with a leaf.
        let (mut pot, leaf) = (Shape::Sphere.build(3), Shape::Plane.build(2));
        let first = pot.positions.len() as u32;
        pot.positions.extend(leaf.positions.iter().map(|p| *p * 2.0 + 3.0 * DVec3::Y));
        pot.triangles.extend(leaf.triangles.iter().map(|corners| corners.map(|corner| corner + first)));
        pot.open_edges = leaf.open_edges;
        assert!(is_sheet(&pot));
    }
}
