//! Skins: vertices that follow joints, after morph targets have moved them, by linear blend.

use glam::{DMat4, DVec3};

/// Joints and morph targets that vertices follow. A mesh node without joints is a joint itself.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Rig {
    /// Positions of the object's vertices in the frames in which they are bound.
    pub base: Vec<DVec3>,
    /// Number of joints of a vertex, at least 1.
    pub joints: usize,
    /// For each vertex its joints, as numbers of matrices, and their weights, whose sum is 1.
    pub influences: Vec<(u32, f64)>,
    /// Number of morph targets of a vertex.
    pub targets: usize,
    /// For each vertex its displacements by the targets at weight 1.
    pub ways: Vec<DVec3>,
    /// For each vertex the row of weights that holds for its targets.
    pub rows: Vec<u32>,
}

/// A pose of a [`Rig`].
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Pose {
    /// For each joint, from the frame in which vertices are bound to the object's own.
    pub matrices: Vec<DMat4>,
    /// Weights of the morph targets, `targets` a row.
    pub weights: Vec<f64>,
}

impl Rig {
    /// Most joints of a vertex.
    pub const MOST_JOINTS: usize = 64;
    /// Most morph targets of a vertex.
    pub const MOST_TARGETS: usize = 1024;

    /// Memory per vertex, bytes.
    #[must_use]
    pub fn bytes(joints: usize, targets: usize) -> u64 {
        40 * (1 + joints as u64 + targets as u64)
    }

    /// The rig of these of its vertices, in this order.
    #[must_use]
    pub fn of(&self, vertices: &[u32]) -> Self {
        fn pick<T: Clone>(list: &[T], each: usize, vertices: &[u32]) -> Vec<T> {
            vertices.iter().flat_map(|&v| &list[v as usize * each..][..each]).cloned().collect()
        }
        Self {
            base: pick(&self.base, 1, vertices),
            joints: self.joints,
            influences: pick(&self.influences, self.joints, vertices),
            targets: self.targets,
            ways: pick(&self.ways, self.targets, vertices),
            rows: pick(&self.rows, 1, vertices),
        }
    }

    /// Where a pose places the vertices, in the object's own frame.
    #[must_use]
    pub fn place(&self, pose: &Pose) -> Vec<DVec3> {
        let place = |vertex: usize| {
            let row = self.rows[vertex] as usize * self.targets;
            let ways = &self.ways[vertex * self.targets..][..self.targets];
            let base = self.base[vertex]
                + ways.iter().zip(&pose.weights[row..]).map(|(way, weight)| *way * *weight).sum::<DVec3>();
            let influences = &self.influences[vertex * self.joints..][..self.joints];
            let placed = |&(joint, weight): &(u32, f64)| weight * pose.matrices[joint as usize].transform_point3(base);
            influences.iter().filter(|(_, weight)| *weight != 0.0).map(placed).sum()
        };
        (0..self.base.len()).map(place).collect()
    }
}
