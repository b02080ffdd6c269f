//! Invariants of the face-cluster and median trees, on regular and degenerate meshes.

use super::sphere::icosphere;
use crate::population::seeded::Seeded;
use glam::DVec3;
use milkglass::internals::hierarchy::compact::{Sample, relative_radius};
use milkglass::internals::hierarchy::face_cluster::{self, DEEPEST, Method};
use milkglass::internals::hierarchy::{Tree, median};
use proptest::prelude::*;

/// Builds both trees twice, checks them, and returns the face-cluster tree.
fn both(positions: &[DVec3], triangles: &[[u32; 3]]) -> (Tree, Method) {
    let (merged, method) = face_cluster::build(positions, triangles);
    let split = median::build(positions, triangles, 1);
    merged.check(triangles.len()).unwrap();
    split.check(triangles.len()).unwrap();
    assert!(merged.depth() <= DEEPEST);
    assert!(split.depth() <= triangles.len().max(1).next_power_of_two().ilog2());
    assert_eq!(merged, face_cluster::build(positions, triangles).0);
    assert_eq!(split, median::build(positions, triangles, 1));
    (merged, method)
}

/// A flat grid of `n` x `n` squares, two triangles each.
fn grid(n: u32) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let vertex = |x: u32, y: u32| y * (n + 1) + x;
    let mut triangles = Vec::new();
    for y in 0..n {
        for x in 0..n {
            let [a, b] = [vertex(x, y), vertex(x + 1, y)];
            let [c, d] = [vertex(x + 1, y + 1), vertex(x, y + 1)];
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    let place = |i: u32| DVec3::new(f64::from(i % (n + 1)), f64::from(i / (n + 1)), 0.0);
    ((0..(n + 1) * (n + 1)).map(place).collect(), triangles)
}

#[test]
fn the_smallest_meshes() {
    let positions = [DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::ONE];
    assert_eq!(both(&positions, &[]).0.nodes(), 0);
    let one = both(&positions, &[[0, 1, 2]]).0;
    assert_eq!((one.nodes(), one.depth(), one.face[0]), (1, 0, 0));
    assert_eq!(both(&positions, &[[0, 1, 2], [1, 3, 2]]).0.nodes(), 3);
}

#[test]
fn a_grid_merges_into_compact_clusters() {
    let (positions, triangles) = grid(48);
    let (tree, method) = both(&positions, &triangles);
    assert_eq!(method, Method::Merged);
    assert!(tree.depth() <= 30, "depth {}", tree.depth());
    // A compact cluster of m faces is about sqrt(m) wide.
    for i in 0..tree.nodes() {
        let faces = (tree.skip[i] as usize - i).div_ceil(2);
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for k in (i..tree.skip[i] as usize).filter(|&k| tree.is_leaf(k)) {
            for v in triangles[tree.face[k] as usize] {
                low = low.min(positions[v as usize]);
                high = high.max(positions[v as usize]);
            }
        }
        assert!((high - low).length() <= 3.5 * (faces as f64).sqrt() + 1.0, "{faces}");
    }
}

#[test]
fn a_sphere_stays_shallow() {
    let (positions, triangles) = icosphere(5);
    let (tree, method) = both(&positions, &triangles);
    assert_eq!(method, Method::Merged);
    assert!(tree.depth() <= 32, "depth {}", tree.depth());
}

#[test]
fn two_components_part_at_the_root() {
    let (positions, triangles) = grid(8);
    let count = positions.len() as u32;
    let mut twice = positions.clone();
    twice.extend(positions.iter().map(|p| p + DVec3::new(3.0, 0.0, 5.0)));
    let mut faces = triangles.clone();
    faces.extend(triangles.iter().map(|t| t.map(|v| v + count)));
    let tree = both(&twice, &faces).0;
    for child in tree.children(0).unwrap() {
        let inside = child..tree.skip[child] as usize;
        let second = |k: &usize| tree.face[*k] as usize >= triangles.len();
        let leaves: Vec<_> = inside.filter(|&k| tree.is_leaf(k)).collect();
        assert_eq!(leaves.len(), triangles.len());
        assert!(leaves.iter().all(second) || !leaves.iter().any(second));
    }
}

#[test]
fn triangles_that_share_an_edge_are_joined_before_those_that_share_a_corner() {
    // Two pairs of triangles that meet at corner 0 alone: across it the centroids are nearest.
    let at = |x: f64, y: f64| DVec3::new(x, y, 0.0);
    let positions =
        [at(0.0, 0.0), at(2.0, 1.0), at(2.0, -1.0), at(8.0, 0.0), at(-2.0, 1.0), at(-2.0, -1.0), at(-8.0, 0.0)];
    let tree = both(&positions, &[[0, 2, 1], [2, 3, 1], [0, 4, 5], [5, 4, 6]]).0;
    for child in tree.children(0).unwrap() {
        let mut faces: Vec<u32> = (child..tree.skip[child] as usize).map(|k| tree.face[k]).collect();
        faces.retain(|&face| face != u32::MAX);
        faces.sort_unstable();
        assert!(faces == [0, 1] || faces == [2, 3], "{faces:?}");
    }
}

#[test]
fn the_relative_radius_of_rectangles_is_known() {
    // 4 x 4 cells of 1.1 x 1, two triangles each: below the root only the halves of 16 triangles count, 2.2 x 4.
    let (mut positions, triangles) = grid(4);
    positions.iter_mut().for_each(|p| p.x *= 1.1);
    let tree = median::build(&positions, &triangles, 1);
    let [w, h] = [2.2f64, 4.0];
    let expected = (std::f64::consts::TAU * ((w * w + h * h) / 12.0) / (w * h)).sqrt();
    let found = relative_radius(&tree, &positions, &triangles);
    assert!((found / expected - 1.0).abs() < 1e-12, "{found} {expected}");
    // A sample of the triangles shows how much wider clusters become.
    let (positions, triangles) = grid(64);
    let tree = median::build(&positions, &triangles, 1);
    let some = Sample::of(&tree, 1000);
    assert!((500..=1000).contains(&some.faces.len()), "{}", some.faces.len());
    let growth = |wide: f64| {
        let places: Vec<DVec3> = positions.iter().map(|p| *p * DVec3::new(wide, 1.0, 1.0)).collect();
        let corners = some.faces.iter().map(|&face| triangles[face as usize].map(|v| places[v as usize]));
        [some.relative_radius(corners), relative_radius(&tree, &places, &triangles)]
    };
    let ([some, all], [wider, all_wider]) = (growth(1.0), growth(4.0));
    assert!((wider / some - all_wider / all).abs() < 0.03 && wider > 1.2 * some, "{some} {all} {wider} {all_wider}");
    // With fewer triangles there is nothing to measure.
    let (positions, triangles) = grid(3);
    let tree = median::build(&positions, &triangles, 1);
    assert_eq!(relative_radius(&tree, &positions, &triangles), 1.0);
}

#[test]
fn fans_of_slivers_and_growing_areas() {
    // A fan of thin triangles around one vertex.
    let mut positions = vec![DVec3::ZERO];
    positions.extend((0..3000).map(|k| {
        let angle = f64::from(k) * 2e-3;
        DVec3::new(angle.cos(), angle.sin(), 0.0)
    }));
    let fan: Vec<_> = (1..3000).map(|k| [0, k, k + 1]).collect();
    assert_eq!(both(&positions, &fan).1, Method::Merged);
    // A strip whose faces grow by a constant factor: greedy merging turns it into a chain.
    let positions: Vec<_> = (0..300).map(|k| DVec3::new(2f64.powi(k), f64::from(k % 2) * 2f64.powi(k), 0.0)).collect();
    let strip: Vec<_> = (0..298).map(|k| [k, k + 1, k + 2]).collect();
    assert_eq!(both(&positions, &strip).1, Method::TooDeep);
    // Many faces on one edge, and faces without area: with equal vertices, or with distinct vertices at one point.
    let mut random = Seeded(1);
    let mut positions = vec![DVec3::ZERO, DVec3::X];
    positions.extend((0..2000).map(|_| random.direction()));
    let book: Vec<_> = (2..2002).map(|k| [0, 1, k]).collect();
    both(&positions, &book);
    both(&positions, &vec![[3, 3, 3]; 500]);
    both(&vec![DVec3::ONE; 900], &(0..300).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect::<Vec<_>>());
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]
    #[test]
    fn random_soups(seed: u64, faces in 0usize..200, vertices in 1u64..120, extent in -3i32..200) {
        let mut random = Seeded(seed);
        let positions: Vec<_> =
            (0..vertices).map(|_| random.direction() * random.log_between(1e-3, 10f64.powi(extent))).collect();
        let triangles: Vec<_> =
            (0..faces).map(|_| std::array::from_fn(|_| (random.bits() % vertices) as u32)).collect();
        both(&positions, &triangles);
    }
}
