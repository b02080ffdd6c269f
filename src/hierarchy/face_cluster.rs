//! The face cluster hierarchy, built bottom up: the adjacent pair of clusters with the lowest cost is merged first.
//!
//! Section 5.1.1 of Mertens et al. 2003 (after Garland et al. 2001), with compactness as the only criterion: merging
//! clusters of areas `A`, `B` with centroids `a`, `b` costs `A B / (A + B) |a - b|^2`, the growth of the area-weighted
//! second moment about the centroid. Two clusters are adjacent if they contain faces that share an edge. Components
//! that share no edge are joined at the top by median splits.

use super::outline::Outline;
use super::{NONE, Tree, face_area_and_centroid, median};
use glam::DVec3;
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Maximum depth of the returned tree; greedy merging can go deeper on meshes of very uneven areas.
pub const DEEPEST: u32 = 64;

/// Work limit of greedy merging: neighbour entries visited, per face of the mesh. Ordinary meshes need about 10; a mesh
/// that exceeds the limit gets a median-split tree.
const VISITS_PER_FACE: usize = 256;

/// How a tree was built.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Method {
    /// Merged bottom up from adjacent clusters.
    Merged,
    /// Split at medians, because merging gave a tree deeper than [`DEEPEST`].
    TooDeep,
    /// Split at medians, because clusters had so many neighbours that merging exceeded its work limit.
    TooEntangled,
}

/// Builds the face cluster tree over `triangles` (indices into `positions`, all in range, fewer than 2^31 triangles),
/// or a median-split tree if merging fails; [`Method`] says which. An empty mesh gives an empty tree.
#[must_use]
pub fn build(positions: &[DVec3], triangles: &[[u32; 3]]) -> (Tree, Method) {
    if triangles.is_empty() {
        return (Tree::default(), Method::Merged);
    }
    let Some(mut merging) = Merging::new(positions, triangles).run() else {
        return (median::build(positions, triangles, 1), Method::TooEntangled);
    };
    // Join the components that no edge connects.
    let clusters = merging.outline.centroid.len() as u32;
    let mut roots: Vec<u32> = (0..clusters).filter(|&id| merging.into[id as usize] == NONE).collect();
    let root = merging.outline.split_at_medians(&mut roots, 1);
    let tree = merging.outline.flatten(root);
    if tree.depth() > DEEPEST {
        return (median::build(positions, triangles, 1), Method::TooDeep);
    }
    (tree, Method::Merged)
}

/// A possible merge: cost, as the bits of a non-negative `f64` (which sort like the value), then the two cluster ids.
type Candidate = Reverse<(u64, u32, u32)>;

struct Merging {
    outline: Outline,
    /// Area of each cluster, length^2.
    area: Vec<f64>,
    /// For each cluster a larger one that contains it, or [`NONE`] if it has not been merged: union-find links.
    into: Vec<u32>,
    /// For each unmerged cluster its neighbours; an entry may be a cluster that has been merged since.
    neighbours: Vec<Vec<u32>>,
    queue: BinaryHeap<Candidate>,
}

impl Merging {
    fn new(positions: &[DVec3], triangles: &[[u32; 3]]) -> Self {
        let faces = triangles.len();
        let (area, centroid): (Vec<f64>, Vec<DVec3>) =
            triangles.iter().map(|t| face_area_and_centroid(positions, *t)).unzip();
        let mut neighbours = vec![Vec::new(); faces];
        let pairs = adjacent(triangles);
        for &[a, b] in &pairs {
            neighbours[a as usize].push(b);
            neighbours[b as usize].push(a);
        }
        let outline = Outline::new(centroid);
        let mut merging = Self { outline, area, into: vec![NONE; faces], neighbours, queue: BinaryHeap::new() };
        let first: Vec<_> = pairs.iter().map(|&[a, b]| merging.candidate(a, b)).collect();
        merging.queue = first.into();
        merging
    }

    /// Merges until no adjacent pair is left; `None` if that exceeds the work limit.
    fn run(mut self) -> Option<Self> {
        let mut visits = VISITS_PER_FACE * self.outline.faces;
        while let Some(Reverse((_, a, b))) = self.queue.pop() {
            // Skip candidates whose clusters have been merged since.
            if self.into[a as usize] != NONE || self.into[b as usize] != NONE {
                continue;
            }
            let mut around = std::mem::take(&mut self.neighbours[a as usize]);
            around.append(&mut std::mem::take(&mut self.neighbours[b as usize]));
            visits = visits.checked_sub(around.len())?;
            let merged = self.merge(a, b);
            for neighbour in &mut around {
                *neighbour = self.present(*neighbour);
            }
            around.sort_unstable();
            around.dedup();
            around.retain(|&neighbour| neighbour != merged);
            for &neighbour in &around {
                let candidate = self.candidate(neighbour, merged);
                self.queue.push(candidate);
            }
            around.shrink_to_fit();
            self.neighbours.push(around);
        }
        Some(self)
    }

    /// A cluster's area and centroid.
    fn weight(&self, id: u32) -> (f64, DVec3) {
        (self.area[id as usize], self.outline.centroid[id as usize])
    }

    fn merge(&mut self, a: u32, b: u32) -> u32 {
        let ((area_a, at_a), (area_b, at_b)) = (self.weight(a), self.weight(b));
        let area = area_a + area_b;
        // Without area, use the midpoint.
        let share = if area > 0.0 { area_b / area } else { 0.5 };
        let merged = self.outline.merge([a, b], at_a + (at_b - at_a) * share);
        self.area.push(area);
        self.into.push(NONE);
        self.into[a as usize] = merged;
        self.into[b as usize] = merged;
        merged
    }

    fn candidate(&self, a: u32, b: u32) -> Candidate {
        let ((area_a, at_a), (area_b, at_b)) = (self.weight(a), self.weight(b));
        let area = area_a + area_b;
        let cost = if area > 0.0 { area_a * (area_b / area) * at_a.distance_squared(at_b) } else { 0.0 };
        Reverse((cost.to_bits(), a.min(b), a.max(b)))
    }

    /// The unmerged cluster that contains `id`: union-find lookup with path halving.
    fn present(&mut self, mut id: u32) -> u32 {
        while self.into[id as usize] != NONE {
            let next = self.into[id as usize];
            let after = self.into[next as usize];
            if after == NONE {
                return next;
            }
            self.into[id as usize] = after;
            id = after;
        }
        id
    }
}

/// Pairs of faces that share an edge, lower face first, each pair once.
///
/// Where more than two faces share an edge, consecutive ones by index are paired: this connects all of them without
/// pairing each with each.
fn adjacent(triangles: &[[u32; 3]]) -> Vec<[u32; 2]> {
    let mut edges = Vec::with_capacity(3 * triangles.len());
    for (face, &[a, b, c]) in triangles.iter().enumerate() {
        for (p, q) in [(a, b), (b, c), (c, a)] {
            edges.push((p.min(q), p.max(q), face as u32));
        }
    }
    edges.sort_unstable();
    let same = |w: &&[(u32, u32, u32)]| (w[0].0, w[0].1) == (w[1].0, w[1].1) && w[0].2 != w[1].2;
    let mut pairs: Vec<_> = edges.windows(2).filter(same).map(|w| [w[0].2, w[1].2]).collect();
    pairs.sort_unstable();
    pairs.dedup();
    pairs
}
