//! The median-split tree: faces are halved at the median centroid along the longest axis, down to single faces.
//!
//! It needs no connectivity and is balanced. Section 5.1 of Mertens et al. 2003 leaves the choice of clusters open;
//! this tree is the default of scheme `blocks`, and the fallback of `face_cluster`.

use super::outline::Outline;
use super::{Tree, face_area_and_centroid};
use glam::DVec3;

/// Builds the median-split tree over `triangles`: indices into `positions`, all in range, fewer than 2^31 triangles.
/// Ranges of more than `block` faces (1 or more) are split at multiples of `block`, so that whole blocks are clusters.
/// An empty mesh gives an empty tree.
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
