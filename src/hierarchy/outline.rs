//! A tree under construction: the two parts and the centroid of each cluster.

use super::{NONE, Tree};
use glam::DVec3;
use rayon::prelude::*;

/// Clusters by id: the faces first (`0 .. faces`), then the merged ones in order of creation.
pub(super) struct Outline {
    /// Number of faces.
    pub faces: usize,
    /// The two parts of cluster `faces + k`.
    pub parts: Vec<[u32; 2]>,
    /// Centroid of each cluster, in the mesh's unit of length.
    pub centroid: Vec<DVec3>,
}

impl Outline {
    /// An outline of faces only, with nothing merged yet.
    pub fn new(centroid: Vec<DVec3>) -> Self {
        let faces = centroid.len();
        Self { faces, parts: Vec::with_capacity(faces.saturating_sub(1)), centroid }
    }

    /// Merges two clusters and returns the id of the new one.
    pub fn merge(&mut self, parts: [u32; 2], centroid: DVec3) -> u32 {
        let id = self.centroid.len() as u32;
        self.parts.push(parts);
        self.centroid.push(centroid);
        id
    }

    /// Merges two clusters, with the midpoint of their centroids as the new centroid, and returns the id of the new
    /// one.
    pub fn join(&mut self, a: u32, b: u32) -> u32 {
        let [p, q] = [a, b].map(|part| self.centroid[part as usize]);
        self.merge([a, b], 0.5 * (p + q))
    }

    /// Joins `members` under one root, halving them recursively at the median centroid along the longest axis of their
    /// centroids' bounds; ties are broken by id. Ranges of more than `block` members are split at multiples of `block`,
    /// so that whole blocks are clusters. `members` must not be empty. Returns the id of the root.
    pub fn split_at_medians(&mut self, members: &mut [u32], block: usize) -> u32 {
        // Ranges in breadth-first order: the two halves of a range come after it. The ranges of a level are disjoint
        // and in order, so that they are halved at the same time.
        let mut cuts = vec![(0, members.len())];
        let mut level = 0..1;
        while !level.is_empty() {
            let (mut rest, mut first) = (&mut *members, 0);
            let mut open = Vec::new();
            for &(start, end) in cuts[level.clone()].iter().filter(|(start, end)| end - start > 1) {
                let (_, from) = std::mem::take(&mut rest).split_at_mut(start - first);
                let (range, after) = from.split_at_mut(end - start);
                open.push((start, range));
                (rest, first) = (after, end);
            }
            let halves = open.into_par_iter().with_min_len(16).flat_map_iter(|(start, range)| {
                let end = start + range.len();
                let middle = start + self.halve(range, block);
                [(start, middle), (middle, end)]
            });
            let halves: Vec<_> = halves.collect();
            level = cuts.len()..cuts.len() + halves.len();
            cuts.extend(halves);
        }
        // Join backwards, so that both halves exist before their range. Each range of more than one member takes the
        // last two ranges that are not taken yet.
        let mut id = vec![NONE; cuts.len()];
        let mut last = cuts.len();
        for k in (0..cuts.len()).rev() {
            let (start, end) = cuts[k];
            id[k] = if end - start > 1 {
                last -= 2;
                self.join(id[last], id[last + 1])
            } else {
                members[start]
            };
        }
        id[0]
    }

    /// Reorders the members into a lower and an upper half and returns the size of the lower one.
    fn halve(&self, members: &mut [u32], block: usize) -> usize {
        let place = |id: u32| self.centroid[id as usize];
        let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        for &member in members.iter() {
            low = low.min(place(member));
            high = high.max(place(member));
        }
        let size = high - low;
        let axis = if size.x >= size.y && size.x >= size.z {
            0
        } else if size.y >= size.z {
            1
        } else {
            2
        };
        let half = members.len() / 2;
        let middle = if members.len() > block { half.next_multiple_of(block) } else { half };
        members.select_nth_unstable_by(middle, |&a, &b| place(a)[axis].total_cmp(&place(b)[axis]).then(a.cmp(&b)));
        middle
    }

    /// Flattens the tree, depth first. The part nearer to the last leaf written goes left, so that consecutive leaves
    /// are close in space.
    pub fn flatten(&self, root: u32) -> Tree {
        let nodes = self.centroid.len();
        let mut tree = Tree {
            skip: vec![0; nodes],
            parent: Vec::with_capacity(nodes),
            face: Vec::with_capacity(nodes),
            level: Vec::with_capacity(nodes),
        };
        let mut last = self.centroid[root as usize];
        let mut open = vec![(root, NONE, 0)];
        while let Some((id, parent, level)) = open.pop() {
            let node = tree.face.len() as u32;
            tree.parent.push(parent);
            tree.level.push(level);
            if (id as usize) < self.faces {
                tree.face.push(id);
                last = self.centroid[id as usize];
                continue;
            }
            tree.face.push(NONE);
            let [a, b] = self.parts[id as usize - self.faces];
            let far = |part: u32| self.centroid[part as usize].distance_squared(last);
            let (left, right) = if far(b) < far(a) { (b, a) } else { (a, b) };
            open.extend([(right, node, level + 1), (left, node, level + 1)]);
        }
        // A subtree ends where its right child's subtree ends; children come after their parents.
        for i in (0..nodes).rev() {
            let leaf = tree.face[i] != NONE;
            tree.skip[i] = if leaf { i as u32 + 1 } else { tree.skip[tree.skip[i + 1] as usize] };
        }
        tree
    }
}
