//! Divides triangles that are long against the distances over which radiosity changes near an edge of the shape, so
//! that light and radiosity do not depend on how a shape was cut into triangles: a CAD program's box has twelve. One
//! value for a triangle that reaches from edge to edge misses that change, and a mean of two sides at the vertices that
//! they share is wrong on both.
//!
//! That distance is taken as `sqrt(1 / (sigma_tr sigma_t'))` in the channel where it is shortest: between the mean free
//! path, where the dipole's profile begins to fall, and its tail. A triangle is halved while its longest edge is longer
//! than `STEP` times that and than `GRADE` times the distance to the nearest crease. None is divided below `FINEST`
//! of the object, where what happens at its edges no longer matters to means and pictures, and none near a crease stays
//! longer than `COARSEST` of it, since diffusion in a small object is sensitive to its corners. In an object in which a
//! triangle is divided, none stays longer than `WIDEST` of it, since irradiance is one value a triangle, too.
//! The parts of a triangle lie in its plane, but shading interpolates the normals at the corners of the whole: those of
//! the parts would show each triangle of a coarse smooth mesh as a facet.
//! Smooth shapes, and meshes like scans in which such triangles are few or hardly too long, stay as they are; so do
//! built-in shapes, whose `detail` says how fine they are, and objects that deform, whose vertices a device moves.
//!
//! Measured on a box of 12 triangles, 20 mm, of marble, skin1 and whole milk, which becomes one of 25,152: means of
//! radiosity over its sides are within 4e-4 of those of a box of 49,152 triangles, pictures within an L2 of 1.7 % of a
//! picture of 786,432 triangles with receivers at pixels (the other box: 1.6 %).

use glam::DVec3;
use rayon::prelude::*;
use rstar::RTree;
use rstar::primitives::Line;

use crate::error::{Input, Result};
use crate::scene::{Material, Memory, Mesh};

/// The longest edge near a crease, in units of the distance over which radiosity changes there.
const STEP: f64 = 0.5;
/// A mesh is divided where triangles are more than this factor too long on more than this share of its surface.
const MUCH: f64 = 2.0;
const SHARE: f64 = 0.05;
/// The most parts of an object, or four times its triangles: slivers, as of a disc's fan, would become very many.
const MOST: usize = 1 << 17;
/// The smallest sigma_tr that counts, as a share of sigma_t'.
const CLEAREST: f64 = 0.01;
/// The longest edge as a share of the distance to the nearest crease.
const GRADE: f64 = 0.3;
/// What edges need not be shorter than, as a share of the object's diagonal.
const FINEST: f64 = 1.0 / 64.0;
/// What edges near a crease must not be longer than, likewise, in an object that is small against that distance.
const COARSEST: f64 = 1.0 / 32.0;
/// What no edge must be longer than in an object that is divided, likewise.
const WIDEST: f64 = 1.0 / 16.0;

/// Tells which triangles of an object are too long.
pub struct Long {
    creases: RTree<Line<[f64; 3]>>,
    /// What edges need not be shorter than.
    least: f64,
    /// What edges must not be longer than.
    most: f64,
}

impl Long {
    /// None if no triangle of this mesh is too long.
    #[must_use]
    pub fn of(mesh: &Mesh, material: &Material) -> Option<Self> {
        // The tree of a subdivided mesh is that of its splits.
        if material.opaque.is_some() || !mesh.splits.is_empty() || mesh.detailed {
            return None;
        }
        let distance = |c: usize| {
            let (a, s) = (material.sigma_a[c], material.sigma_s_prime[c]);
            let sigma = (3.0 * a * (a + s)).sqrt().max(CLEAREST * (a + s));
            1.0 / (sigma.sqrt() * (a + s).sqrt())
        };
        let (low, high) = mesh.bounds();
        let across = (high - low).length();
        let step = STEP * (0..3).map(distance).fold(f64::INFINITY, f64::min);
        let least = step.clamp(FINEST * across, COARSEST * across);
        // Summed in order, so that every run decides alike.
        let area = |which: &dyn Fn([DVec3; 3]) -> bool| -> f64 {
            let faces = (0..mesh.triangles.len()).filter_map(|face| mesh.corners(face));
            let area_of = |[a, b, c]: [DVec3; 3]| 0.5 * (b - a).cross(c - a).length();
            faces.filter(|&corners| which(corners)).map(area_of).sum()
        };
        // Creases are found where lengths alone leave it open.
        let much = SHARE * area(&|_| true);
        if area(&|corners| longest(corners) > MUCH * least) <= much {
            return None;
        }
        let creases = mesh.creases().into_iter().map(|[a, b]| Line::new(a.to_array(), b.to_array())).collect();
        let long = Self { creases: RTree::bulk_load(creases), least, most: WIDEST * across };
        (area(&|corners| long.near_a_crease(corners, MUCH)) > much).then_some(long)
    }

    /// Whether a triangle is too long.
    #[must_use]
    pub fn is(&self, corners: [DVec3; 3]) -> bool {
        longest(corners) > self.most || self.near_a_crease(corners, 1.0)
    }

    /// Whether a triangle is longer than this factor of what it may be by creases alone.
    fn near_a_crease(&self, corners: [DVec3; 3], factor: f64) -> bool {
        let long = longest(corners);
        let [a, b, c] = corners;
        let nearest = || {
            let found = self.creases.nearest_neighbor_iter_with_distance_2(((a + b + c) / 3.0).to_array()).next();
            found.map_or(f64::INFINITY, |(_, squared)| squared.sqrt())
        };
        long > factor * self.least && long > factor * GRADE * nearest()
    }
}

/// A mesh whose long triangles were divided.
#[derive(Clone)]
pub struct Divided {
    pub mesh: Mesh,
    /// For each part the triangle that it came from.
    pub from: Vec<u32>,
    /// How many parts are too long still, since dividing them would make too many.
    pub left: usize,
}

/// Divides the long triangles of a mesh; none if no triangle is too long.
pub fn divide(mesh: &Mesh, material: &Material, memory: &Memory) -> Result<Option<Divided>> {
    let Some(long) = Long::of(mesh, material) else { return Ok(None) };
    // Normals of a file have parted the vertices of its own creases.
    let mut fine = mesh.clone();
    if fine.normals.is_none() {
        fine = mesh.parted();
        fine.normals = Some(fine.vertex_normals());
    }
    let mut from: Vec<u32> = (0..).take(mesh.triangles.len()).collect();
    // Parts that are short enough stay so.
    let mut open = vec![true; from.len()];
    loop {
        let wanted = |(face, open): (usize, &bool)| *open && fine.corners(face).is_some_and(|corners| long.is(corners));
        let cut: Vec<bool> = open.par_iter().enumerate().map(wanted).collect();
        let more = cut.iter().filter(|cut| **cut).count();
        if more == 0 || more + cut.len() > MOST.max(4 * mesh.triangles.len()) {
            return Ok(Some(Divided { mesh: fine, from, left: more }));
        }
        memory.need((more + cut.len()) as u64 * Mesh::BYTES).map_err(|error| {
            let what = "triangles that are long against the mean free path do not fit the memory when divided";
            Input::new(what).key("transport.receivers").found(error).expected("a finer mesh, or faces")
        })?;
        let (finer, parents) = fine.bisect(|face| cut[face]);
        open = parents.iter().map(|&part| cut[part as usize]).collect();
        from = parents.iter().map(|&part| from[part as usize]).collect();
        fine = finer;
    }
}

/// The length of a triangle's longest edge.
fn longest([a, b, c]: [DVec3; 3]) -> f64 {
    a.distance_squared(b).max(b.distance_squared(c)).max(c.distance_squared(a)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Scene, Shape};

    /// The divided mesh of this one, enlarged.
    fn divided(shape: Shape, detail: u32, factor: f64) -> Divided {
        let object = Scene::load("sphere").expect("a scene").objects.remove(0);
        let mut mesh = Mesh { detailed: false, ..shape.build(detail) };
        mesh.positions.iter_mut().for_each(|position| *position *= factor);
        // A ball has no creases: a missing triangle makes some.
        if shape == Shape::Sphere {
            mesh.triangles.pop();
            mesh.input_face.pop();
            mesh.open_edges = 3;
        }
        divide(&mesh, &object.material, &Memory::default()).expect("memory").expect("long triangles")
    }

    #[test]
    fn parts_have_the_normals_of_the_whole() {
        let ball = divided(Shape::Sphere, 1, 10.0);
        let normals = ball.mesh.normals.clone().expect("normals");
        assert!(ball.mesh.triangles.len() > 1000 && normals.len() == ball.mesh.positions.len());
        // Those of the parts themselves are up to 20 degrees off.
        let off = |normals: &[DVec3]| {
            let angles = normals.iter().zip(&ball.mesh.positions).map(|(n, p)| n.angle_between(*p).to_degrees());
            angles.fold(0.0, f64::max)
        };
        let flat = Mesh { normals: None, ..ball.mesh.clone() }.vertex_normals();
        assert!(off(&normals) < 5.0 && off(&flat) > 10.0, "{} {}", off(&normals), off(&flat));
        // A box keeps its corners.
        let cube = divided(Shape::Slab, 1, 20.0).mesh;
        let normals = cube.normals.expect("normals");
        assert!(normals.iter().all(|n| n.abs().max_element() > 0.999_999));
    }
}
