//! The tree of a mesh made by 4-to-1 splits: every triangle that was split is a cluster of its four parts.
//!
//! Section 5.1.2 of Mertens et al. 2003. Nodes are binary, so that a split takes two levels: the middle part is paired
//! with the first corner's part, the other two corners' parts with each other, then the two pairs are joined. The
//! triangles of the base are joined as in [`face_cluster`].

use super::outline::Outline;
use super::{Tree, face_area_and_centroid, face_cluster};
use face_cluster::Method;
use glam::DVec3;

/// Builds the tree over `triangles` (indices into `positions`, all in range, fewer than 2^31 triangles), and says how
/// the tree of the base was built. `splits` gives for each triangle how often it was split; the four parts of a
/// triangle are consecutive, the middle one last. If `splits` does not describe such parts, all triangles are taken as
/// the base.
#[must_use]
pub fn build(positions: &[DVec3], triangles: &[[u32; 3]], splits: &[u8]) -> (Tree, Method) {
    let centroid = triangles.iter().map(|t| face_area_and_centroid(positions, *t).1).collect();
    let mut forest = Forest { triangles, splits, next: 0, outline: Outline::new(centroid) };
    let mut bases = Vec::new();
    while forest.next < triangles.len() {
        match forest.cluster(0) {
            Some(base) => bases.push(base),
            None => return face_cluster::build(positions, triangles),
        }
    }
    let corners: Vec<[u32; 3]> = bases.iter().map(|base| base.1).collect();
    let (top, method) = face_cluster::build(positions, &corners);
    // Put the tree of the base on top; children come after their parents.
    let mut outline = forest.outline;
    let mut ids = vec![0; top.nodes()];
    for node in (0..top.nodes()).rev() {
        ids[node] = match top.children(node) {
            None => bases[top.face[node] as usize].0,
            Some([left, right]) => outline.join(ids[left], ids[right]),
        };
    }
    match ids.first() {
        Some(&root) => (outline.flatten(root), method),
        None => (Tree::default(), method),
    }
}

struct Forest<'a> {
    triangles: &'a [[u32; 3]],
    splits: &'a [u8],
    /// The first triangle that is not in a cluster yet.
    next: usize,
    outline: Outline,
}

impl Forest<'_> {
    /// The next triangle that was split `times` times, or the cluster of its parts if it was split further: cluster id
    /// and corners. `None` if `splits` is inconsistent.
    fn cluster(&mut self, times: u8) -> Option<(u32, [u32; 3])> {
        let found = *self.splits.get(self.next)?;
        if found == times {
            self.next += 1;
            return Some((self.next as u32 - 1, *self.triangles.get(self.next - 1)?));
        }
        if found < times {
            return None;
        }
        let [a, b, c, middle] = [0; 4].map(|_| self.cluster(times + 1));
        let (a, b, c, middle) = (a?, b?, c?, middle?);
        let near = self.outline.join(a.0, middle.0);
        let far = self.outline.join(b.0, c.0);
        Some((self.outline.join(near, far), [a.1[0], b.1[1], c.1[2]]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A mesh with one triangle per entry of `splits`, each with vertices of its own.
    fn cut(splits: &[u8]) -> (Vec<DVec3>, Vec<[u32; 3]>) {
        let positions = (0..3 * splits.len() as u32).map(|k| DVec3::new(f64::from(k), f64::from(k % 3), 0.0)).collect();
        (positions, (0..splits.len() as u32).map(|k| [3 * k, 3 * k + 1, 3 * k + 2]).collect())
    }

    #[test]
    fn parts_of_a_triangle_are_a_cluster() {
        // An unsplit base triangle, one split whose third part is split again, and one split once.
        let splits = [0, 1, 1, 2, 2, 2, 2, 1, 1, 1, 1, 1];
        let (positions, triangles) = cut(&splits);
        let (tree, method) = build(&positions, &triangles, &splits);
        assert_eq!((tree.check(12), method), (Ok(()), Method::Merged));
        let clusters: Vec<Vec<u32>> = (0..tree.nodes())
            .map(|node| {
                let mut faces: Vec<u32> = (node..tree.skip[node] as usize).map(|k| tree.face[k]).collect();
                faces.retain(|&face| face != super::super::NONE);
                faces.sort_unstable();
                faces
            })
            .collect();
        for whole in [&[3, 4, 5, 6][..], &[1, 2, 3, 4, 5, 6, 7], &[8, 9, 10, 11], &[1, 7], &[2, 3, 4, 5, 6]] {
            assert!(clusters.iter().any(|cluster| cluster == whole), "{whole:?} in {clusters:?}");
        }
    }

    #[test]
    fn other_numbers_make_face_clusters() {
        for splits in [&[][..], &[0, 0, 0], &[1, 1, 1, 1], &[0, 1, 1, 1], &[1, 1, 2, 1], &[2; 4]] {
            let (positions, triangles) = cut(&[0; 4]);
            let expected = face_cluster::build(&positions, &triangles).0;
            let (tree, _) = build(&positions, &triangles, splits);
            assert_eq!((tree.check(4), tree == expected), (Ok(()), splits != [1; 4]), "{splits:?}");
        }
        assert_eq!(build(&[], &[], &[]).0, Tree::default());
    }
}
