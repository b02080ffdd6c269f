//! How the work on the tree is divided: into chunks whose lists fit a binding, and inside a chunk into levels.

use std::ops::Range;

use rayon::prelude::*;

use crate::hierarchy::Tree;

/// A part of the tree that is linked and summed in one go.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Chunk {
    /// Its nodes, as a range of the state's `order`.
    pub nodes: Range<u32>,
    /// The same by level, the root's side first; every range lies in `nodes`.
    pub levels: Vec<Range<u32>>,
    /// The clusters of each level: its triangles come after them.
    pub clusters: Vec<Range<u32>>,
}

/// The chunks of a tree. If there are several, the first is the top of the tree, and all others are whole subtrees
/// that start from the emitters it hands down.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Schedule {
    /// The chunks, the top first.
    pub chunks: Vec<Chunk>,
    /// The blocks of receivers, cut into ranges whose lists fit a binding; empty where no blocks are used.
    pub batches: Vec<Range<u32>>,
}

impl Schedule {
    /// Cuts the tree into subtrees of at most `faces` faces; also returns the nodes in the order of processing.
    pub fn new(tree: &Tree, faces: usize) -> (Self, Vec<u32>) {
        let nodes = tree.nodes();
        let small = |node: usize| tree.skip[node] as usize - node < 2 * faces.max(1);

        // A subtree's root is a small node whose parent is not small; the nodes above these roots are the top.
        let mut chunk_of = vec![0u32; nodes];
        let mut count = 1;
        let mut node = 0;
        while node < nodes {
            if small(node) {
                chunk_of[node..tree.skip[node] as usize].fill(count);
                count += 1;
                node = tree.skip[node] as usize;
            } else {
                node += 1;
            }
        }

        // Sort by chunk and level, clusters first, by index; a tree that is one chunk has no top.
        let mut order: Vec<u32> = (0..nodes as u32).collect();
        let triangle = |i: u32| tree.skip[i as usize] == i + 1;
        order.par_sort_unstable_by_key(|&i| (chunk_of[i as usize], tree.level[i as usize], triangle(i), i));
        let mut chunks: Vec<Chunk> = Vec::new();
        let mut last = (u32::MAX, u32::MAX);
        for (at, &i) in order.iter().enumerate() {
            let at = at as u32;
            let key = (chunk_of[i as usize], tree.level[i as usize]);
            if key.0 != last.0 {
                chunks.push(Chunk { nodes: at..at, ..Chunk::default() });
            }
            if let Some(chunk) = chunks.last_mut() {
                if key != last {
                    chunk.levels.push(at..at);
                    chunk.clusters.push(at..at);
                }
                chunk.nodes.end = at + 1;
                if let Some(level) = chunk.levels.last_mut() {
                    level.end = at + 1;
                }
                if let Some(clusters) = chunk.clusters.last_mut().filter(|_| !triangle(i)) {
                    clusters.end = at + 1;
                }
            }
            last = key;
        }
        (Self { chunks, batches: Vec::new() }, order)
    }

    /// The clusters of every level that has any, up to the root: children always come before their parents.
    pub fn upward(&self) -> impl Iterator<Item = Range<u32>> + '_ {
        let all = self.chunks.iter().rev().flat_map(|chunk| chunk.clusters.iter().rev().cloned());
        all.filter(|clusters| !clusters.is_empty())
    }
}
