//! Creases: edges at which a surface ends or turns sharply.

use super::Mesh;
use super::edges::{Edges, NONE, start};
use super::walk::after;
use glam::DVec3;

/// The cosine of the angle between the normals of two triangles from which on their edge is a crease: 45 degrees.
const SHARP: f64 = std::f64::consts::FRAC_1_SQRT_2;

impl Mesh {
    /// The ends of each edge that has one triangle only, or three and more, or two whose normals are more than 45
    /// degrees apart.
    #[must_use]
    pub fn creases(&self) -> Vec<[DVec3; 2]> {
        let edges = Edges::of(&self.triangles);
        let place = |half: u32| self.positions[start(&self.triangles, half) as usize];
        let once = |&(half, &twin): &(u32, &u32)| twin == NONE || half < twin;
        let sharp = (0..).zip(&edges.twin).filter(once).filter(|&(half, &twin)| self.is_crease(half, twin));
        sharp.map(|(half, _)| [place(half), place(after(half))]).collect()
    }

    /// The same triangles, whose corners on two sides of a crease are two vertices, so that nothing is interpolated
    /// across it. Vertices keep their numbers; new ones follow them.
    #[must_use]
    pub fn parted(&self) -> Self {
        let edges = Edges::of(&self.triangles);
        // Corners of one vertex, joined across the edges that are no creases.
        let mut joined: Vec<u32> = (0..edges.twin.len() as u32).collect();
        let start_of = |half: u32| start(&self.triangles, half);
        for (half, &twin) in (0..).zip(&edges.twin).filter(|&(half, &twin)| twin != NONE && half < twin) {
            if self.is_crease(half, twin) {
                continue;
            }
            for corner in [half, after(half)] {
                let other = if start_of(twin) == start_of(corner) { twin } else { after(twin) };
                let [first, second] = [corner, other].map(|corner| root(&mut joined, corner));
                joined[first.max(second) as usize] = first.min(second);
            }
        }
        let mut fine = self.clone();
        let mut first = vec![NONE; self.positions.len()];
        let mut vertex = vec![NONE; joined.len()];
        for corner in 0..joined.len() as u32 {
            let (old, root) = (start_of(corner) as usize, root(&mut joined, corner) as usize);
            if vertex[root] == NONE && first[old] == NONE {
                (first[old], vertex[root]) = (corner, old as u32);
            } else if vertex[root] == NONE {
                vertex[root] = fine.positions.len() as u32;
                fine.positions.push(self.positions[old]);
            }
            fine.triangles[corner as usize / 3][corner as usize % 3] = vertex[root];
        }
        fine
    }

    /// Whether the edge of these two half-edges, or of the first alone, is a crease.
    fn is_crease(&self, half: u32, twin: u32) -> bool {
        let normal = |half: u32| {
            self.corners(half as usize / 3).map_or(DVec3::ZERO, |[a, b, c]| (b - a).cross(c - a).normalize_or_zero())
        };
        twin == NONE || normal(half).dot(normal(twin)) < SHARP
    }
}

/// The first corner that this one is joined with.
fn root(joined: &mut [u32], mut corner: u32) -> u32 {
    while joined[corner as usize] != corner {
        joined[corner as usize] = joined[joined[corner as usize] as usize];
        corner = joined[corner as usize];
    }
    corner
}

#[cfg(test)]
mod tests {
    use super::super::Shape;
    use super::*;

    #[test]
    fn a_box_has_twelve_and_a_ball_none() {
        let cube = Shape::Slab.build(1);
        let (low, high) = cube.bounds();
        let size = high - low;
        let all: f64 = cube.creases().iter().map(|[a, b]| a.distance(*b)).sum();
        assert!((all - 4.0 * (size.x + size.y + size.z)).abs() < 1e-9, "{all} of {size}");
        assert!(Shape::Sphere.build(0).creases().is_empty());
        assert_eq!(Shape::Plane.build(1).creases().len(), 4);
    }

    #[test]
    fn vertices_are_parted_at_creases_only() {
        let cube = Mesh::made(
            (0..8).map(|k| DVec3::new(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2))).collect(),
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
                .into_iter()
                .flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]])
                .collect(),
        );
        assert_eq!(cube.creases().len(), 12);
        let parted = cube.parted();
        assert_eq!(parted.positions.len(), 24);
        assert!((0..12).all(|face| parted.corners(face) == cube.corners(face)));
        // Both triangles of a side still share two vertices.
        let shared = |a: [u32; 3], b: [u32; 3]| a.iter().filter(|v| b.contains(v)).count();
        assert!(parted.triangles.chunks(2).all(|side| shared(side[0], side[1]) == 2));
        let ball = Shape::Sphere.build(1);
        assert_eq!(ball.parted(), ball);
    }
}
