//! The borders of clusters: the directed edges of a cluster's triangles without those that two of them share in
//! opposite directions.
//!
//! On a surface without holes a border is the closed curve around the cluster; the border of a closed surface is
//! empty. Borders depend on the triangles' indices alone and stay as the shape changes.

use super::Tree;

/// The borders of a tree's inner nodes.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Borders {
    /// For each node its first edge and the number of its edges; 0 at leaves, for closed surfaces and for borders that
    /// are too long.
    pub runs: Vec<[u32; 2]>,
    /// The edges: two vertices, the cluster on the left.
    pub edges: Vec<[u32; 2]>,
}

/// An edge from its lower to its higher vertex, and how often it is walked that way, less how often it is walked back.
type Walked = ([u32; 2], i32);

/// The borders of a tree over `triangles`, which are in the order of its leaves; borders of more than `most` edges are
/// left out.
#[must_use]
pub fn borders(tree: &Tree, triangles: &[[u32; 3]], most: usize) -> Borders {
    let mut runs = vec![[0; 2]; tree.nodes()];
    let mut edges = Vec::new();
    let mut face = triangles.len();
    // Backwards, both children of a node come before it, and their borders lie on the stack.
    let mut stack: Vec<Vec<Walked>> = Vec::new();
    for node in (0..tree.nodes()).rev() {
        if tree.is_leaf(node) {
            face -= 1;
            stack.push(around(triangles[face]));
            continue;
        }
        let border = match (stack.pop(), stack.pop()) {
            (Some(left), Some(right)) => merged(&left, &right),
            _ => Vec::new(),
        };
        let count: usize = border.iter().map(|walked| walked.1.unsigned_abs() as usize).sum();
        if count <= most {
            runs[node] = [edges.len() as u32, count as u32];
            for &([low, high], times) in &border {
                let edge = if times > 0 { [low, high] } else { [high, low] };
                edges.extend((0..times.unsigned_abs()).map(|_| edge));
            }
        }
        stack.push(border);
    }
    Borders { runs, edges }
}

/// The edges of a triangle, in order.
fn around([a, b, c]: [u32; 3]) -> Vec<Walked> {
    let walk = |from: u32, to: u32| if from < to { ([from, to], 1) } else { ([to, from], -1) };
    let mut edges = vec![walk(a, b), walk(b, c), walk(c, a)];
    edges.sort_unstable();
    edges
}

/// The edges of two clusters, in order, without those that cancel.
fn merged(left: &[Walked], right: &[Walked]) -> Vec<Walked> {
    let mut all = Vec::with_capacity(left.len() + right.len());
    let (mut i, mut j) = (0, 0);
    while i < left.len() || j < right.len() {
        let next = match (left.get(i), right.get(j)) {
            (Some(a), Some(b)) if a.0 == b.0 => (a.0, a.1 + b.1),
            (Some(&a), Some(b)) if a.0 < b.0 => a,
            (_, Some(&b)) => b,
            (Some(&a), None) => a,
            (None, None) => break,
        };
        i += usize::from(left.get(i).is_some_and(|a| a.0 == next.0));
        j += usize::from(right.get(j).is_some_and(|b| b.0 == next.0));
        if next.1 != 0 {
            all.push(next);
        }
    }
    all
}
