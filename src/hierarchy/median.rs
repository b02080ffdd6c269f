//! The plain tree: halve the faces at the median centroid along the longest axis, until one is left.
//!
//! Needs no connectivity and is always as shallow as a tree can be. Section 5.1 of Mertens et al.
//! 2003 leaves the choice of clusters open; this one is the fallback and the baseline.

use super::outline::Outline;
use super::{Tree, face_area_and_centroid};
use glam::DVec3;

/// The median-split tree over `triangles`: indices into `positions`, all in range, fewer than 2^31
/// triangles. Clusters of `block` faces (1 or more) come out full. An empty mesh gives an empty tree.
#[must_use]
pub fn build(positions: &[DVec3], triangles: &[[u32; 3]], block: usize) -> Tree {
    if triangles.is_empty() {
        return Tree::default();
    }
    let centroid = triangles.iter().map(|t| face_area_and_centroid(positions, *t).1).collect();
    let mut outline = Outline::new(centroid);
    let mut members: Vec<u32> = (0..triangles.len() as u32).collect();
    let root = outline.split_at_medians(&mut members, block);
    outline.flatten(root)
}
