//! A binary tree of face clusters over a triangle mesh, built once on the CPU.
//!
//! Section 5.1 of Mertens et al. 2003: leaves are the triangles, inner nodes are clusters of them. Nodes are stored
//! depth first, so that a traversal needs no stack: from node `i` it continues at `i + 1` to descend, or at `skip[i]`
//! to pass over the subtree. [`face_cluster`] builds the tree bottom up from adjacent faces, [`median`] top down by
//! median splits, [`split`] from the 4-to-1 subdivision of the mesh.

pub mod border;
pub mod compact;
pub mod face_cluster;
pub mod median;
mod outline;
pub mod split;
pub mod wide;

use glam::DVec3;

/// Stands for "no node" in [`Tree::parent`] and "no face" in [`Tree::face`].
pub const NONE: u32 = u32::MAX;

/// A binary tree whose leaves are single triangles: `2 n - 1` nodes for `n` faces, depth first.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Tree {
    /// For each node the first node after its subtree, in `i + 1 ..= nodes`; `i + 1` at a leaf.
    pub skip: Vec<u32>,
    /// For each node its parent, less than its own index; [`NONE`] at the root.
    pub parent: Vec<u32>,
    /// For each node the mesh face it stands for; [`NONE`] at an inner node.
    pub face: Vec<u32>,
    /// For each node its distance from the root in edges; 0 at the root.
    pub level: Vec<u32>,
}

impl Tree {
    /// Number of nodes: 0 for an empty mesh, else `2 n - 1`.
    #[must_use]
    pub fn nodes(&self) -> usize {
        self.skip.len()
    }

    /// Whether node `i` is a single face.
    #[must_use]
    pub fn is_leaf(&self, i: usize) -> bool {
        self.face[i] != NONE
    }

    /// The left and right child of node `i`; none at a leaf.
    #[must_use]
    pub fn children(&self, i: usize) -> Option<[usize; 2]> {
        (!self.is_leaf(i)).then(|| [i + 1, self.skip[i + 1] as usize])
    }

    /// Node indices of the leaves, ascending.
    pub fn leaves(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.nodes()).filter(|&i| self.is_leaf(i))
    }

    /// The largest level: 0 for a single face and for an empty tree.
    #[must_use]
    pub fn depth(&self) -> u32 {
        self.level.iter().copied().max().unwrap_or(0)
    }

    /// Checks that this is a well-formed tree over the faces `0 .. faces`, each at exactly one leaf.
    ///
    /// # Errors
    /// The first violated rule, with the node.
    pub fn check(&self, faces: usize) -> Result<(), String> {
        let nodes = self.nodes();
        let expected = if faces == 0 { 0 } else { 2 * faces - 1 };
        let lengths = [self.parent.len(), self.face.len(), self.level.len()];
        if nodes != expected || lengths != [nodes; 3] {
            return Err(format!("{nodes} nodes, columns {lengths:?}; expected {expected}"));
        }
        let mut seen = vec![false; faces];
        for i in 0..nodes {
            let end = self.skip[i] as usize;
            if end <= i || end > nodes {
                return Err(format!("node {i}: skip {end} outside {}..={nodes}", i + 1));
            }
            if i == 0 && (self.parent[0] != NONE || self.level[0] != 0 || end != nodes) {
                return Err("node 0 is not the root of all nodes".to_owned());
            }
            match self.children(i) {
                None => {
                    let face = self.face[i] as usize;
                    if end != i + 1 || face >= faces || seen[face] {
                        return Err(format!("leaf {i}: skip {end}, face {face} out of range or twice"));
                    }
                    seen[face] = true;
                }
                Some(pair) => self.check_inner(i, pair)?,
            }
        }
        Ok(())
    }

    fn check_inner(&self, i: usize, [left, right]: [usize; 2]) -> Result<(), String> {
        let end = self.skip[i] as usize;
        if left >= end || right >= end || self.skip[right] as usize != end {
            return Err(format!("node {i}: children {left} and {right} do not fill it up to {end}"));
        }
        for child in [left, right] {
            if self.parent[child] as usize != i || self.level[child] != self.level[i] + 1 {
                return Err(format!("node {child}: parent or level does not fit node {i}"));
            }
        }
        Ok(())
    }
}

/// Area of a face, length^2, and the mean of its corners.
fn face_area_and_centroid(positions: &[DVec3], triangle: [u32; 3]) -> (f64, DVec3) {
    let [a, b, c] = triangle.map(|index| positions[index as usize]);
    (0.5 * (b - a).cross(c - a).length(), (a + b + c) / 3.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_check_finds_each_broken_rule() {
        let good = Tree { skip: vec![3, 2, 3], parent: vec![NONE, 0, 0], face: vec![NONE, 1, 0], level: vec![0, 1, 1] };
        assert_eq!(good.check(2), Ok(()));
        assert_eq!(good.children(0), Some([1, 2]));
        assert!(good.check(3).is_err());
        let spoil: [fn(&mut Tree); 6] = [
            |t| t.skip[1] = 3,
            |t| t.skip[0] = 2,
            |t| t.parent[2] = 1,
            |t| t.face[1] = 0,
            |t| t.level[1] = 2,
            |t| t.parent.truncate(2),
        ];
        for change in spoil {
            let mut bad = good.clone();
            change(&mut bad);
            assert!(bad.check(2).is_err());
        }
    }
}
