//! Which triangles share which edges.

use rayon::slice::ParallelSliceMut;

/// No half-edge: the edge is open, or has three faces or more.
pub(super) const NONE: u32 = u32::MAX;

/// The edges of a mesh. Half-edge `3 t + k` runs from corner `k` of triangle `t` to the next one.
#[derive(Debug)]
pub(super) struct Edges {
    /// For each half-edge its twin, that of the only other face at this edge, or [`NONE`].
    pub twin: Vec<u32>,
    /// Number of edges with one face.
    pub open: usize,
    /// Number of edges with three or more faces.
    pub crowded: usize,
}

impl Edges {
    /// Finds the edges of triangles with three different corners.
    pub fn of(triangles: &[[u32; 3]]) -> Self {
        // Sort half-edges by their two ends, so that those of an edge are adjacent.
        let ends = |&[a, b, c]: &[u32; 3]| [(a, b), (b, c), (c, a)];
        let key = |(a, b): (u32, u32)| u64::from(a.min(b)) << 32 | u64::from(a.max(b));
        let mut sorted: Vec<(u64, u32)> = triangles.iter().flat_map(ends).map(key).zip(0..).collect();
        sorted.par_sort_unstable();

        let mut edges = Self { twin: vec![NONE; sorted.len()], open: 0, crowded: 0 };
        for edge in sorted.chunk_by(|a, b| a.0 == b.0) {
            match edge {
                [_] => edges.open += 1,
                [(_, a), (_, b)] => {
                    edges.twin[*a as usize] = *b;
                    edges.twin[*b as usize] = *a;
                }
                _ => edges.crowded += 1,
            }
        }
        edges
    }
}

/// The vertex a half-edge starts at.
pub(super) fn start(triangles: &[[u32; 3]], half: u32) -> u32 {
    triangles[half as usize / 3][half as usize % 3]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pairs_faces_and_counts_the_rest() {
        let square = Edges::of(&[[0, 1, 2], [0, 2, 3]]);
        assert_eq!((square.open, square.crowded), (4, 0));
        assert_eq!(square.twin, [NONE, NONE, 3, 2, NONE, NONE]);
        let three = Edges::of(&[[0, 1, 2], [0, 1, 3], [1, 0, 4]]);
        assert_eq!((three.open, three.crowded), (6, 1));
        assert!(three.twin.iter().all(|&twin| twin == NONE));
    }
}
