//! Subdivision of triangles at the midpoints of their edges: in four, or in two at the longest edge. A neighbour that
//! is not split keeps its edge: the new vertices lie on it, which leaves T-junctions but no gaps.

use super::Mesh;
use glam::DVec3;
use std::collections::HashMap;

/// A mesh as it is subdivided.
struct Finer {
    mesh: Mesh,
    /// For each new triangle the one that it came from.
    from: Vec<u32>,
    /// Vertices at the midpoints of edges.
    middles: HashMap<[u32; 2], u32>,
}

impl Finer {
    fn of(mesh: &Mesh) -> Self {
        let mut fine = Mesh { positions: mesh.positions.clone(), open_edges: mesh.open_edges, ..Mesh::default() };
        fine.uvs = mesh.uvs.as_ref().map(|_| Vec::new());
        fine.normals.clone_from(&mesh.normals);
        Self { mesh: fine, from: Vec::new(), middles: HashMap::new() }
    }

    fn middle(&mut self, p: u32, q: u32) -> u32 {
        let Mesh { positions, normals, .. } = &mut self.mesh;
        *self.middles.entry([p.min(q), p.max(q)]).or_insert_with(|| {
            positions.push(0.5 * (positions[p as usize] + positions[q as usize]));
            if let Some(normals) = normals {
                normals.push((normals[p as usize] + normals[q as usize]).normalize_or(normals[p as usize]));
            }
            positions.len() as u32 - 1
        })
    }

    /// Takes over a triangle of the old mesh as it is.
    fn keep(&mut self, old: &Mesh, face: usize) {
        self.mesh.push(old.triangles[face], old.input_face[face], old.uvs.as_ref().map(|uvs| uvs[face]));
        self.mesh.splits.extend(old.splits.get(face));
        self.from.push(face as u32);
    }
}

impl Mesh {
    /// Splits the triangles that `cut` selects in four, the middle part last, and returns for each new triangle the one
    /// that it came from. Vertices keep their numbers.
    #[must_use]
    pub fn split(&self, cut: impl Fn(usize) -> bool) -> (Self, Vec<u32>) {
        let mut fine = Finer::of(self);
        for (face, &[a, b, c]) in self.triangles.iter().enumerate() {
            if !cut(face) {
                fine.keep(self, face);
                continue;
            }
            let [ab, bc, ca] = [[a, b], [b, c], [c, a]].map(|[p, q]| fine.middle(p, q));
            let parts = self.uvs.as_ref().map(|uvs| {
                let [a, b, c] = uvs[face];
                let [ab, bc, ca] = [halfway(a, b), halfway(b, c), halfway(c, a)];
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            });
            for (k, triangle) in [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]].into_iter().enumerate() {
                fine.mesh.push(triangle, self.input_face[face], parts.map(|parts| parts[k]));
                fine.mesh.splits.extend(self.splits.get(face).map(|times| times + 1));
                fine.from.push(face as u32);
            }
        }
        (fine.mesh, fine.from)
    }

    /// Splits the triangles that `cut` selects in two at the middle of their longest edge, and returns for each new
    /// triangle the one that it came from. Vertices keep their numbers; how often a triangle was split in four is
    /// forgotten.
    #[must_use]
    pub fn bisect(&self, cut: impl Fn(usize) -> bool) -> (Self, Vec<u32>) {
        let mut fine = Finer::of(self);
        for (face, triangle) in self.triangles.iter().enumerate() {
            if !cut(face) {
                fine.keep(self, face);
                continue;
            }
            let length = |k: &usize| {
                let [p, q] = [*k, (k + 1) % 3].map(|k| self.positions[triangle[k] as usize]);
                DVec3::distance_squared(p, q)
            };
            let k = (0..3).max_by(|a, b| length(a).total_cmp(&length(b))).unwrap_or(0);
            let [a, b, c] = [k, k + 1, k + 2].map(|k| triangle[k % 3]);
            let ab = fine.middle(a, b);
            let parts = self.uvs.as_ref().map(|uvs| {
                let [a, b, c] = [k, k + 1, k + 2].map(|k| uvs[face][k % 3]);
                [[a, halfway(a, b), c], [halfway(a, b), b, c]]
            });
            for (part, triangle) in [[a, ab, c], [ab, b, c]].into_iter().enumerate() {
                fine.mesh.push(triangle, self.input_face[face], parts.map(|parts| parts[part]));
                fine.from.push(face as u32);
            }
        }
        fine.mesh.splits.clear();
        (fine.mesh, fine.from)
    }

    fn push(&mut self, triangle: [u32; 3], input_face: u32, uvs: Option<[[f64; 2]; 3]>) {
        self.triangles.push(triangle);
        self.input_face.push(input_face);
        if let (Some(all), Some(uvs)) = (&mut self.uvs, uvs) {
            all.push(uvs);
        }
    }
}

fn halfway(p: [f64; 2], q: [f64; 2]) -> [f64; 2] {
    [0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1])]
}

#[cfg(test)]
mod tests {
    use super::super::Shape;

    #[test]
    fn parts_fill_the_whole_and_share_their_middles() {
        let ball = Shape::Sphere.build_textured(1);
        let (fine, from) = ball.split(|face| face % 3 != 0);
        let cut = (0..80).filter(|face| face % 3 != 0).count();
        assert_eq!((fine.triangles.len(), from.len()), (80 + 3 * cut, 80 + 3 * cut));
        assert!((fine.volume() - ball.volume()).abs() < 1e-12);
        let (whole, _) = ball.split(|_| true);
        assert_eq!(whole.positions.len(), ball.positions.len() + 120);
        // The middle part has its parent's centroid, in space and in the texture.
        let center = |[a, b, c]: [glam::DVec3; 3]| (a + b + c) / 3.0;
        for face in 0..80 {
            let [middle, parent] = [whole.corners(4 * face + 3).unwrap(), ball.corners(face).unwrap()].map(center);
            assert!(middle.distance(parent) < 1e-14);
            let sum = |mesh: &super::Mesh, face: usize, axis: usize| {
                mesh.uvs.as_ref().unwrap()[face].iter().map(|uv| uv[axis]).sum::<f64>()
            };
            assert!((0..2).all(|axis| (sum(&whole, 4 * face + 3, axis) - sum(&ball, face, axis)).abs() < 1e-12));
        }
    }

    #[test]
    fn halves_fill_the_whole() {
        let ball = Shape::Sphere.build_textured(1);
        let (fine, from) = ball.bisect(|face| face % 2 == 0);
        assert_eq!((fine.triangles.len(), from.len(), fine.splits.len()), (120, 120, 0));
        assert!((fine.volume() - ball.volume()).abs() < 1e-12);
        // A sliver becomes short parts: in four, they would be 1/128 long from 16,384 parts on.
        let mut thin =
            super::Mesh::made(vec![glam::DVec3::ZERO, glam::DVec3::X, 0.01 * glam::DVec3::Y], vec![[0, 1, 2]]);
        let long = |mesh: &super::Mesh, face: usize| {
            let [a, b, c] = mesh.corners(face).unwrap();
            a.distance(b).max(b.distance(c)).max(c.distance(a)) > 1.0 / 128.0
        };
        while (0..thin.triangles.len()).any(|face| long(&thin, face)) {
            thin = thin.bisect(|face| long(&thin, face)).0;
        }
        assert!(thin.triangles.len() < 8000, "{}", thin.triangles.len());
    }
}
