//! 4-to-1 subdivision of triangles at the midpoints of their edges. A neighbour that is not split keeps its edge: the
//! new vertices lie on it, which leaves T-junctions but no gaps.

use super::Mesh;
use std::collections::HashMap;

impl Mesh {
    /// Splits some triangles in four, the middle part last, and returns for each new triangle the one that it came
    /// from. Vertices keep their numbers.
    #[must_use]
    pub fn split(&self, cut: impl Fn(usize) -> bool) -> (Self, Vec<u32>) {
        let mut fine = Self { positions: self.positions.clone(), open_edges: self.open_edges, ..Self::default() };
        fine.uvs = self.uvs.as_ref().map(|_| Vec::new());
        let mut middles: HashMap<[u32; 2], u32> = HashMap::new();
        let mut from = Vec::new();
        for (face, &[a, b, c]) in self.triangles.iter().enumerate() {
            let uvs = self.uvs.as_ref().map(|uvs| uvs[face]);
            if !cut(face) {
                fine.push([a, b, c], self.input_face[face], uvs);
                fine.splits.extend(self.splits.get(face));
                from.push(face as u32);
                continue;
            }
            let [ab, bc, ca] = [[a, b], [b, c], [c, a]].map(|[p, q]| {
                *middles.entry([p.min(q), p.max(q)]).or_insert_with(|| {
                    fine.positions.push(0.5 * (fine.positions[p as usize] + fine.positions[q as usize]));
                    fine.positions.len() as u32 - 1
                })
            });
            let parts = uvs.map(|[a, b, c]| {
                let middle = |p: [f64; 2], q: [f64; 2]| [0.5 * (p[0] + q[0]), 0.5 * (p[1] + q[1])];
                let [ab, bc, ca] = [middle(a, b), middle(b, c), middle(c, a)];
                [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]
            });
            for (k, triangle) in [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]].into_iter().enumerate() {
                fine.push(triangle, self.input_face[face], parts.map(|parts| parts[k]));
                fine.splits.extend(self.splits.get(face).map(|times| times + 1));
                from.push(face as u32);
            }
        }
        (fine, from)
    }

    fn push(&mut self, triangle: [u32; 3], input_face: u32, uvs: Option<[[f64; 2]; 3]>) {
        self.triangles.push(triangle);
        self.input_face.push(input_face);
        if let (Some(all), Some(uvs)) = (&mut self.uvs, uvs) {
            all.push(uvs);
        }
    }
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
}
