//! Whether deformations spoil an object's tree: whether its clusters become wider than those of a new tree would be.
//! It is judged by some of its triangles, on the host, so that a frame need not deform all of them there.

use glam::DVec3;

use super::shape::{records, rest};
use super::units::Units;
use crate::hierarchy::Tree;
use crate::hierarchy::compact::Sample;
use crate::scene::{Hierarchy, Object};
use crate::state::wide;

/// How much wider than at rest a tree's clusters may become before it is rebuilt for the deformed shape. In the scene
/// `twist`, at 1.05, 1.09, 1.13 and 1.16 a new tree took 11, 18, 28 and 45 % off a frame's time (one run on
/// lavapipe); it was built in about 15 ms.
const SPOILT: f64 = 1.05;

/// The most triangles that are looked at.
const MOST: usize = 2048;

/// A corner of a triangle at rest.
#[derive(Clone, Copy, Debug)]
struct Corner {
    vertex: usize,
    place: [f32; 3],
    normal: [f32; 3],
}

/// Triangles of an object, and how compact the clusters of its tree are over them at rest.
#[derive(Clone, Debug)]
pub struct Compactness {
    sample: Sample,
    /// The triangles' corners.
    corners: Vec<[Corner; 3]>,
    at_rest: f64,
}

impl Compactness {
    /// For an object and its tree.
    #[must_use]
    pub fn new(object: &Object, tree: &Tree, units: Units) -> Self {
        let (places, normals) = rest(object, units.own(object));
        let corner = |v: u32| Corner { vertex: v as usize, place: places[v as usize], normal: normals[v as usize] };
        let sample = Sample::of(tree, MOST);
        let corners: Vec<_> =
            sample.faces.iter().map(|&face| object.mesh.triangles[face as usize].map(corner)).collect();
        let at_rest = sample.relative_radius(corners.iter().map(|corners| corners.map(|corner| wide(corner.place))));
        Self { sample, corners, at_rest }
    }

    /// How much wider clusters have become by an object's deformations, if that spoils the tree, which is then built
    /// over the deformed vertices instead of those at rest. Depends on the current shape alone, not on earlier ones.
    /// Trees of 4-to-1 splits are never rebuilt: they would be the same for any shape.
    #[must_use]
    pub fn spoilt(&self, object: &Object, hierarchy: Hierarchy, units: Units) -> Option<f64> {
        if matches!(hierarchy, Hierarchy::Butterfly | Hierarchy::ShrinkWrap) {
            return None;
        }
        let deforms = records(object, units.own(object));
        let place = |Corner { vertex, place, normal }: Corner| -> DVec3 { wide(deforms.moved(vertex, place, normal)) };
        let now = self.sample.relative_radius(self.corners.iter().map(|corners| corners.map(place)));
        let growth = now / self.at_rest;
        (growth > SPOILT).then_some(growth)
    }
}
