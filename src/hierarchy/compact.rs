//! Measures how compact the clusters of a tree are on a mesh that may have moved since the tree was built.

use std::f64::consts::TAU;

use glam::DVec3;

use super::Tree;

/// Smaller clusters are ignored: emitter lists hold larger clusters or single triangles.
const FEWEST: usize = 16;

/// The mean ratio of a cluster's root-mean-square radius to that of a flat disc of equal area, over all clusters of at
/// least 16 triangles except the root: about 1 for round flat patches, more for elongated or folded ones. 1 if there is
/// no such cluster.
#[must_use]
pub fn relative_radius(tree: &Tree, positions: &[DVec3], triangles: &[[u32; 3]]) -> f64 {
    // Per node, children first: number of triangles, area, centroid, mean squared distance from the centroid.
    let mut sums = vec![(0, 0.0, DVec3::ZERO, 0.0); tree.nodes()];
    let (mut sum, mut count) = (0.0, 0);
    for node in (0..tree.nodes()).rev() {
        sums[node] = match tree.children(node) {
            None => {
                let [a, b, c] = triangles[tree.face[node] as usize].map(|v| positions[v as usize]);
                let edges = (b - a).length_squared() + (c - b).length_squared() + (a - c).length_squared();
                (1, 0.5 * (b - a).cross(c - a).length(), (a + b + c) / 3.0, edges / 36.0)
            }
            Some([left, right]) => {
                let (l, r) = (sums[left], sums[right]);
                let area = l.1 + r.1;
                let center = l.2.lerp(r.2, if area > 0.0 { r.1 / area } else { 0.5 });
                let about = |part: (usize, f64, DVec3, f64)| part.1 * (part.3 + part.2.distance_squared(center));
                (l.0 + r.0, area, center, if area > 0.0 { (about(l) + about(r)) / area } else { 0.0 })
            }
        };
        let (faces, area, _, square) = sums[node];
        if faces >= FEWEST && node > 0 && area > 0.0 {
            sum += (TAU * square / area).sqrt();
            count += 1;
        }
    }
    if count > 0 { sum / f64::from(count) } else { 1.0 }
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
