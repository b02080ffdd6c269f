//! The tree with up to eight children a node, for rays: eight boxes are loaded and tested at once.
//!
//! Nodes of the binary tree are left out where their parent has room for their children. From the leaves up, a node
//! stays a part of its parent as long as its own parts fit; where they do not, the child with more parts becomes a wide
//! node. So nearly all wide nodes are full, and those that are not are at the top.

use std::cmp::Reverse;

use super::Tree;

/// A child of a wide node.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Child {
    /// The child's node in the binary tree.
    pub node: u32,
    /// The child's wide node, if it has children.
    pub wide: Option<u32>,
}

/// The children of each wide node, those with children first, by falling size.
///
/// A way through the tree that puts off all but the last of these has at most 7/3 log2 n + 1 nodes waiting among n
/// triangles, 73 among 2^31: while it is below the k-th largest of a node's children, k - 1 are waiting, and it has at
/// most 1/k of the triangles left, so each halving adds at most (k - 1) / log2 k, which is 7/3 at the most.
pub type WideTree = Vec<Vec<Child>>;

/// The wide tree of a tree, the root first, with at most `most` (2 or more) children a node. A single triangle is the
/// only child of the root. An empty tree has none.
#[must_use]
pub fn widen(tree: &Tree, most: usize) -> WideTree {
    // The number of places that each node takes in its parent: 1 if it is a wide node or a leaf.
    let mut parts = vec![1usize; tree.nodes()];
    for node in (0..tree.nodes()).rev() {
        let Some([left, right]) = tree.children(node) else { continue };
        while parts[left] + parts[right] > most {
            let larger = if parts[left] < parts[right] { right } else { left };
            parts[larger] = 1;
        }
        parts[node] = parts[left] + parts[right];
    }

    let mut wide: WideTree = Vec::new();
    let mut roots = if tree.nodes() > 0 { vec![0] } else { Vec::new() };
    let mut next = 0;
    while let Some(&root) = roots.get(next) {
        next += 1;
        let mut children = Vec::with_capacity(most);
        let mut open = vec![root];
        while let Some(node) = open.pop() {
            match tree.children(node).filter(|_| node == root || parts[node] > 1) {
                Some(pair) => open.extend(pair),
                None => children.push(node),
            }
        }
        children.sort_by_key(|&node| Reverse(tree.skip[node] - node as u32));
        let child = |node: usize| {
            let wide = (!tree.is_leaf(node)).then_some(roots.len() as u32);
            roots.extend(wide.map(|_| node));
            Child { node: node as u32, wide }
        };
        wide.push(children.into_iter().map(child).collect());
    }
    wide
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::super::{median, outline::Outline};
    use super::*;

    /// The most wide nodes that wait on the way through a tree, and the leaves that it meets.
    fn walk(wide: &WideTree) -> (usize, Vec<u32>) {
        let (mut waiting, mut most, mut leaves) = (vec![0], 0, Vec::new());
        while let Some(node) = waiting.pop() {
            for child in &wide[node as usize] {
                match child.wide {
                    Some(wide) => waiting.push(wide),
                    None => leaves.push(child.node),
                }
            }
            most = most.max(waiting.len());
        }
        (most, leaves)
    }

    fn checked(tree: &Tree) -> WideTree {
        let wide = widen(tree, 8);
        assert!(wide.iter().all(|children| (1..=8).contains(&children.len())));
        let (most, mut leaves) = walk(&wide);
        leaves.sort_unstable();
        assert!(leaves.into_iter().map(|leaf| leaf as usize).eq(tree.leaves()), "each leaf once");
        let bound = (tree.nodes().div_ceil(2) as f64).log2() * 7.0 / 3.0 + 1.0;
        assert!(most as f64 <= bound, "{most} wait, {bound} may");
        wide
    }

    /// A strip of triangles.
    fn strip(faces: u32) -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let at = |k: u32| DVec3::new(f64::from(k / 2), f64::from(k % 2), 0.0);
        ((0..faces + 2).map(at).collect(), (0..faces).map(|k| [k, k + 1, k + 2]).collect())
    }

    #[test]
    fn each_leaf_is_met_once_and_few_nodes_wait() {
        for faces in [1, 2, 7, 8, 9, 16, 17, 100, 4_111] {
            let (positions, triangles) = strip(faces);
            let wide = checked(&median::build(&positions, &triangles, 16));
            // Full nodes of eight would be (n - 1) / 7.
            let least = (faces as usize - 1).div_ceil(7).max(1);
            assert!(wide.len() <= least + least / 4 + 1, "{faces} faces: {} wide nodes, {least} full ones", wide.len());
        }
        assert!(widen(&Tree::default(), 8).is_empty());
    }

    #[test]
    fn chains_stay_within_the_bound() {
        let faces = 3_000;
        for turned in [false, true] {
            let mut chain = Outline::new(vec![DVec3::ZERO; faces as usize]);
            let joined = (1..faces).fold(0, |rest, face| {
                let parts = if turned { [face, rest] } else { [rest, face] };
                chain.merge(parts, DVec3::ZERO)
            });
            checked(&chain.flatten(joined));
        }
    }
}
