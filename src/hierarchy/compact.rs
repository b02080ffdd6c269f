//! Measures how compact the clusters of a tree are on a mesh that may have moved since the tree was built.

use std::f64::consts::TAU;

use glam::DVec3;

use super::Tree;

/// Smaller clusters are ignored: emitter lists hold larger clusters or single triangles.
const FEWEST: usize = 16;
/// A cluster with fewer triangles in a sample is ignored: its radius would be too uncertain.
const FEWEST_TAKEN: usize = 4;

/// Some of a tree's triangles, evenly spread over its leaves, with the clusters that join them.
#[derive(Clone, Debug)]
pub struct Sample {
    /// The triangles, in the order in which `relative_radius` takes their corners.
    pub faces: Vec<u32>,
    /// The fewest of these triangles that a cluster must have to count.
    fewest: usize,
    /// How clusters are put together, children first: true adds the next triangle, false joins the last two clusters.
    steps: Vec<bool>,
}

impl Sample {
    /// A sample of at most `most` of the tree's triangles.
    #[must_use]
    pub fn of(tree: &Tree, most: usize) -> Self {
        let step = tree.nodes().div_ceil(2).div_ceil(most.max(1)).max(1);
        let (mut leaf, mut faces, mut steps) = (0, Vec::new(), Vec::new());
        let mut counts = vec![0usize; tree.nodes()];
        for node in (0..tree.nodes()).rev() {
            counts[node] = match tree.children(node) {
                None => {
                    leaf += 1;
                    usize::from(leaf % step == step.div_ceil(2) % step)
                }
                Some([left, right]) => counts[left] + counts[right],
            };
            match tree.children(node) {
                None if counts[node] > 0 => {
                    faces.push(tree.face[node]);
                    steps.push(true);
                }
                Some([left, right]) if counts[left] > 0 && counts[right] > 0 => steps.push(false),
                _ => {}
            }
        }
        Self { faces, fewest: FEWEST.div_ceil(step).max(FEWEST_TAKEN), steps }
    }

    /// The mean ratio of a cluster's root-mean-square radius to that of a flat disc of equal area, over all clusters
    /// of at least 16 triangles but the root: about 1 for round flat patches, more for elongated or folded
    /// ones. 1 if there is no such cluster. `corners` are those of each triangle in `faces`.
    pub fn relative_radius(&self, mut corners: impl Iterator<Item = [DVec3; 3]>) -> f64 {
        /// Number of triangles, area, centroid, mean squared distance from the centroid.
        type Sums = (usize, f64, DVec3, f64);
        let mut open: Vec<Sums> = Vec::new();
        let (mut sum, mut count) = (0.0, 0);
        for (number, &leaf) in self.steps.iter().enumerate() {
            let next = if leaf {
                let [a, b, c] = corners.next().unwrap_or_default();
                let edges = (b - a).length_squared() + (c - b).length_squared() + (a - c).length_squared();
                (1, 0.5 * (b - a).cross(c - a).length(), (a + b + c) / 3.0, edges / 36.0)
            } else {
                // Nodes come in reverse order, so the left child was added last.
                let (l, r) = (open.pop().unwrap_or_default(), open.pop().unwrap_or_default());
                let area = l.1 + r.1;
                let center = l.2.lerp(r.2, if area > 0.0 { r.1 / area } else { 0.5 });
                let about = |part: Sums| part.1 * (part.3 + part.2.distance_squared(center));
                (l.0 + r.0, area, center, if area > 0.0 { (about(l) + about(r)) / area } else { 0.0 })
            };
            open.push(next);
            let (faces, area, _, square) = next;
            if faces >= self.fewest && number + 1 < self.steps.len() && area > 0.0 {
                sum += (TAU * square / area).sqrt();
                count += 1;
            }
        }
        if count > 0 { sum / f64::from(count) } else { 1.0 }
    }
}

/// [`Sample::relative_radius`] over all triangles of a tree.
#[must_use]
pub fn relative_radius(tree: &Tree, positions: &[DVec3], triangles: &[[u32; 3]]) -> f64 {
    let all = Sample::of(tree, usize::MAX);
    all.relative_radius(all.faces.iter().map(|&face| triangles[face as usize].map(|v| positions[v as usize])))
}

#[cfg(test)]
mod tests {
    use super::super::median;
    use super::*;

    #[test]
    fn what_is_stretched_is_less_compact_and_size_does_not_matter() {
        let at = |i: u32| DVec3::new(f64::from(i % 17), f64::from(i / 17), 0.0);
        let positions: Vec<DVec3> = (0..17 * 17).map(at).collect();
        let cell = |i: u32| [[i, i + 1, i + 17], [i + 1, i + 18, i + 17]];
        let triangles: Vec<[u32; 3]> = (0..16).flat_map(|y| (0..16).flat_map(move |x| cell(17 * y + x))).collect();
        let tree = median::build(&positions, &triangles, 16);
        let flat = relative_radius(&tree, &positions, &triangles);
        assert!((1.0..1.3).contains(&flat), "{flat}");
        let scaled: Vec<DVec3> = positions.iter().map(|p| 7.0 * *p).collect();
        assert!((relative_radius(&tree, &scaled, &triangles) / flat - 1.0).abs() < 1e-12);
        let long: Vec<DVec3> = positions.iter().map(|p| *p * DVec3::new(9.0, 1.0, 1.0)).collect();
        assert!(relative_radius(&tree, &long, &triangles) > 1.5 * flat);
    }
}
