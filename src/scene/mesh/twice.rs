//! Faces that a mesh has twice, whichever way round.

use rayon::prelude::*;
use std::ops::Range;

/// For each triangle whether it repeats an earlier one: its whole face, however that is cut, or the triangle alone.
/// `faces` is the face of each triangle; those of a face follow each other.
pub(super) fn find(triangles: &[[u32; 3]], faces: &[u32]) -> Vec<bool> {
    let mut again = vec![false; triangles.len()];
    let mut first = 0;
    let whole: Vec<Range<u32>> = faces
        .chunk_by(|a, b| a == b)
        .map(|face| {
            let start = first;
            first += face.len() as u32;
            start..first
        })
        .collect();
    mark(triangles, &whole, &mut again);
    if whole.len() < triangles.len() {
        let left = (0..first).filter(|&triangle| !again[triangle as usize]);
        let single: Vec<Range<u32>> = left.map(|triangle| triangle..triangle + 1).collect();
        mark(triangles, &single, &mut again);
    }
    again
}

/// Marks the triangles of polygons, each a range of them, that have the border of an earlier one.
fn mark(triangles: &[[u32; 3]], polygons: &[Range<u32>], again: &mut [bool]) {
    let triangles_of = |polygon: &Range<u32>| &triangles[polygon.start as usize..polygon.end as usize];
    // Compare borders only where their sums agree.
    let mut sums: Vec<(u64, u32)> = (0..polygons.len() as u32)
        .into_par_iter()
        .map(|number| (sum(triangles_of(&polygons[number as usize])), number))
        .collect();
    sums.par_sort_unstable();
    for same in sums.chunk_by(|a, b| a.0 == b.0).filter(|same| same.len() > 1) {
        let mut known: Vec<Vec<[u32; 2]>> = Vec::new();
        for (_, number) in same {
            let polygon = &polygons[*number as usize];
            let border = border(triangles_of(polygon));
            // A polygon whose edges all cancel has none to compare.
            if border.is_empty() {
                continue;
            }
            if known.contains(&border) {
                again[polygon.start as usize..polygon.end as usize].fill(true);
            } else {
                known.push(border);
            }
        }
    }
}

fn edges(triangle: &[u32; 3]) -> [[u32; 2]; 3] {
    let [a, b, c] = *triangle;
    [[a, b], [b, c], [c, a]].map(|[from, to]| [from.min(to), from.max(to)])
}

/// For each triangle a number for the border of its face and the way round it; equal borders have equal numbers.
pub(super) fn borders(triangles: &[[u32; 3]], faces: &[u32]) -> Vec<u64> {
    let mut all = Vec::with_capacity(triangles.len());
    let mut rest = triangles;
    for face in faces.chunk_by(|a, b| a == b) {
        let (of_face, after) = rest.split_at(face.len());
        rest = after;
        // Inner edges go both ways.
        let ways = of_face.iter().flat_map(|&[a, b, c]| [[a, b], [b, c], [c, a]]);
        let sum = ways.map(|[from, to]| mixed([from, to]).wrapping_sub(mixed([to, from]))).fold(0, u64::wrapping_add);
        all.extend(std::iter::repeat_n(sum, face.len()));
    }
    all
}

/// The edges of a polygon that only one of its triangles has, in ascending order.
fn border(triangles: &[[u32; 3]]) -> Vec<[u32; 2]> {
    let mut all: Vec<[u32; 2]> = triangles.iter().flat_map(edges).collect();
    all.sort_unstable();
    all.chunk_by(|a, b| a == b).filter(|edge| edge.len() % 2 == 1).map(|edge| edge[0]).collect()
}

/// A number for an edge in one direction: the finalizer of MurmurHash3.
fn mixed([from, to]: [u32; 2]) -> u64 {
    let mut x = u64::from(from) << 32 | u64::from(to);
    for factor in [0xff51_afd7_ed55_8ccd, 0xc4ce_b9fe_1a85_ec53] {
        x = (x ^ x >> 33).wrapping_mul(factor);
    }
    x ^ x >> 33
}

/// A number that polygons with the same border share; inner edges cancel.
fn sum(triangles: &[[u32; 3]]) -> u64 {
    triangles.iter().flat_map(edges).map(mixed).fold(0, |sum, edge| sum ^ edge)
}

#[cfg(test)]
mod tests {
    use super::{borders, find};

    #[test]
    fn a_border_is_the_same_however_its_face_is_cut() {
        let of = |triangles: &[[u32; 3]]| borders(triangles, &vec![0; triangles.len()])[0];
        assert_eq!(of(&[[0, 1, 2], [0, 2, 3]]), of(&[[3, 0, 1], [3, 1, 2]]));
        assert_ne!(of(&[[0, 1, 2], [0, 2, 3]]), of(&[[0, 2, 1], [0, 3, 2]]));
        assert_ne!(of(&[[0, 1, 2]]), of(&[[0, 1, 3]]));
        assert_eq!(borders(&[[0, 1, 2], [0, 1, 2], [1, 2, 0]], &[0, 1, 2]).len(), 3);
    }

    #[test]
    fn only_the_same_corners_in_the_same_border_are_the_same() {
        // Both ways round, from each first corner.
        assert_eq!(find(&[[0, 1, 2], [2, 1, 0], [1, 2, 0], [0, 1, 3]], &[0, 1, 2, 3]), [false, true, true, false]);
        // A quad and its other side, by the other diagonal.
        assert_eq!(find(&[[0, 1, 2], [0, 2, 3], [3, 2, 1], [3, 1, 0]], &[0, 0, 1, 1]), [false, false, true, true]);
        // A quad, and two triangles on its other side.
        assert_eq!(find(&[[0, 1, 2], [0, 2, 3], [2, 1, 0], [3, 2, 0]], &[0, 0, 1, 2]), [false, false, true, true]);
        // The same corners in another order.
        assert_eq!(find(&[[0, 1, 2], [0, 2, 3], [0, 2, 1], [0, 1, 3]], &[0, 0, 1, 1])[2..], [true, false]);
        // The first of many.
        let many: Vec<[u32; 3]> = (0..1000).map(|k| [0, 1, 2].map(|corner| corner + k % 500)).collect();
        let again = find(&many, &(0..1000).collect::<Vec<_>>());
        assert!(again.iter().enumerate().all(|(k, &is)| is == (k >= 500)));
    }
}
