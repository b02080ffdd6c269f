//! Interpolating subdivision: every triangle is split in four, with new vertices by the modified butterfly scheme
//! (Zorin, Schroeder, Sweldens 1996, after Dyn, Levin, Gregory 1990), while existing vertices stay in place.
//!
//! On an edge between vertices of valence six the stencil has eight points: weights 1/2 for the ends, 1/8 for the two
//! opposite corners, -1/16 for the four wings. For an end of another valence the stencil is its ring of neighbours plus
//! 3/4 of itself; if both ends are such, the mean of the two is taken. On a border the stencil has four points of the
//! border. A wing missing beyond a border is replaced by the corner of the triangle within, reflected at its edge;
//! vertices on a border count as regular.

use super::Mesh;
use super::edges::NONE;
use super::walk::{Surface, after, before};
use glam::DVec3;
use std::f64::consts::TAU;

/// Subdivides a mesh `levels` times.
pub(super) fn butterfly(base: &Mesh, levels: u32) -> Mesh {
    let mut mesh = Mesh { splits: vec![0; base.triangles.len()], ..base.clone() };
    for _ in 0..levels {
        let (mut fine, _) = mesh.split(|_| true);
        let surface = Surface::of(&mesh);
        for half in 0..3 * mesh.triangles.len() {
            // The middle part comes last; its corners are the midpoints of the edges, in their order.
            let middle = fine.triangles[4 * (half / 3) + 3][half % 3];
            if surface.twin[half] == NONE || half < surface.twin[half] as usize {
                fine.positions[middle as usize] = surface.middle(half as u32);
            }
        }
        fine.open_edges = 2 * mesh.open_edges;
        mesh = fine;
    }
    mesh
}

impl Surface<'_> {
    /// The corner opposite this edge in the other triangle; without one, this triangle's own corner, reflected at the
    /// edge's midpoint.
    fn wing(&self, half: u32) -> DVec3 {
        match self.across(half) {
            NONE => self.place(half) + self.place(after(half)) - self.place(before(half)),
            twin => self.place(before(twin)),
        }
    }

    /// The new vertex on an edge.
    fn middle(&self, half: u32) -> DVec3 {
        let (a, b) = (self.place(half), self.place(after(half)));
        let twin = self.across(half);
        if twin == NONE {
            let (c, d) = (self.along(half), self.back(half));
            return 9.0 / 16.0 * (a + b) - (c + d) / 16.0;
        }
        let ends = [half, twin].map(|half| self.extraordinary(half));
        match ends {
            [Some(p), Some(q)] => 0.5 * (p + q),
            [Some(p), None] | [None, Some(p)] => p,
            [None, None] => {
                let sides = self.place(before(half)) + self.place(before(twin));
                let wings = [after(half), before(half), after(twin), before(twin)].map(|half| self.wing(half));
                0.5 * (a + b) + 0.125 * sides - wings.into_iter().sum::<DVec3>() / 16.0
            }
        }
    }

    /// The new vertex by the stencil of the half-edge's start, if that is an interior vertex of a valence other than
    /// six, and at least three: the scheme has no weights below.
    fn extraordinary(&self, half: u32) -> Option<DVec3> {
        let (fan, whole) = self.fan(half);
        if !whole || fan.len() == 6 || fan.len() < 3 {
            return None;
        }
        let ring = fan.iter().zip(ring(fan.len())).map(|(&out, weight)| weight * self.place(after(out)));
        Some(0.75 * self.place(half) + ring.sum::<DVec3>())
    }

    /// The border vertex after the end of a half-edge on the border.
    fn along(&self, half: u32) -> DVec3 {
        let mut next = after(half);
        while self.across(next) != NONE {
            next = after(self.across(next));
        }
        self.place(after(next))
    }

    /// The border vertex before the start of a half-edge on the border.
    fn back(&self, half: u32) -> DVec3 {
        let mut last = before(half);
        while self.across(last) != NONE {
            last = before(self.across(last));
        }
        self.place(last)
    }
}

/// Weights of the `count` neighbours of a vertex, from the one at the other end of the edge on; their sum is 1/4.
fn ring(count: usize) -> Vec<f64> {
    let weight = |j: usize| match (count, j) {
        (3, 0) => 5.0 / 12.0,
        (3, _) => -1.0 / 12.0,
        (4, 0) => 3.0 / 8.0,
        (4, 2) => -1.0 / 8.0,
        (4, _) => 0.0,
        _ => {
            let angle = TAU * j as f64 / count as f64;
            (0.25 + angle.cos() + 0.5 * (2.0 * angle).cos()) / count as f64
        }
    };
    (0..count).map(weight).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A grid of `n` by `n` cells of equilateral triangles, raised by `height`.
    fn grid(n: u32, height: impl Fn(f64, f64) -> f64) -> Mesh {
        let at = |k: u32| {
            let (column, row) = (f64::from(k % (n + 1)), f64::from(k / (n + 1)));
            let (x, y) = (column + 0.5 * row, 0.75f64.sqrt() * row);
            DVec3::new(x, y, height(x, y))
        };
        let cell = |k: u32| {
            let a = k / n * (n + 1) + k % n;
            [[a, a + 1, a + n + 1], [a + 1, a + n + 2, a + n + 1]]
        };
        let mesh = Mesh::made((0..(n + 1) * (n + 1)).map(at).collect(), (0..n * n).flat_map(cell).collect());
        Mesh { open_edges: 4 * n as usize, ..mesh }
    }

    #[test]
    fn weights_of_rings_sum_to_a_quarter() {
        for count in 3..12 {
            assert!((ring(count).iter().sum::<f64>() - 0.25).abs() < 1e-12, "{count}");
        }
        // For valence five the paper's first weight is 7/20.
        let five = ring(5);
        assert!((five[0] - 0.35).abs() < 1e-12 && (five[1] - five[4]).abs() < 1e-12 && five[2] < 0.0);
    }

    #[test]
    fn cubics_within_and_planes_everywhere_are_kept() {
        let plane = |x: f64, y: f64| 3.0 * x - y + 2.0;
        let fine = butterfly(&grid(6, plane), 2);
        assert!(fine.positions.iter().all(|p| (p.z - plane(p.x, p.y)).abs() < 1e-12));
        assert_eq!((fine.triangles.len(), fine.open_edges), (72 * 16, 4 * 24));
        assert_eq!(fine.splits, vec![2; 72 * 16]);
        let cubic = |x: f64, y: f64| x * x * x - 2.0 * x * y * y + y * y + 0.3 * x;
        let fine = butterfly(&grid(8, cubic), 1);
        // Without new vertices whose stencils reach over the border.
        let within = |p: &&DVec3| {
            let (row, column) = (p.y / 0.75f64.sqrt(), p.x - 0.5 * p.y / 0.75f64.sqrt());
            (1.9..6.1).contains(&row) && (1.9..6.1).contains(&column)
        };
        let inner: Vec<_> = fine.positions.iter().filter(within).collect();
        assert!(inner.len() > 50);
        assert!(inner.iter().all(|p| (p.z - cubic(p.x, p.y)).abs() < 1e-10));
    }

    #[test]
    fn vertices_stay_and_borders_depend_on_borders_alone() {
        let flat = grid(4, |x, y| (x + 2.0 * y).sin());
        let raised =
            grid(4, |x, y| (x + 2.0 * y).sin() + if x > 2.0 && x < 4.0 && y > 1.0 && y < 3.0 { 1.0 } else { 0.0 });
        let [a, b] = [&flat, &raised].map(|mesh| butterfly(mesh, 1));
        assert_eq!(a.positions[..25], flat.positions[..]);
        let border = |p: &DVec3| p.y.abs() < 0.06;
        let pairs: Vec<_> = a.positions.iter().zip(&b.positions).filter(|(p, _)| border(p)).collect();
        assert!(pairs.len() == 9 && pairs.iter().all(|(p, q)| p == q));
        assert!(a.positions != b.positions);
    }

    #[test]
    fn an_octahedron_becomes_round_and_stays_symmetric() {
        let corners = [DVec3::X, DVec3::Y, DVec3::Z, -DVec3::X, -DVec3::Y, -DVec3::Z];
        let faces = [[0, 1, 2], [1, 3, 2], [3, 4, 2], [4, 0, 2], [1, 0, 5], [3, 1, 5], [4, 3, 5], [0, 4, 5]];
        let base = Mesh::made(corners.to_vec(), faces.to_vec());
        let fine = butterfly(&base, 4);
        assert_eq!((fine.positions.len(), fine.triangles.len()), (1026, 2048));
        // Outside the flat faces, 1/sqrt(3) from the centre, and hardly outside the unit sphere.
        assert!(fine.positions.iter().all(|p| (0.75..1.05).contains(&p.length())));
        let place = |p: DVec3| fine.positions.iter().any(|q| q.distance(p) < 1e-12);
        assert!(fine.positions.iter().step_by(17).all(|p| place(-*p) && place(DVec3::new(p.y, p.z, p.x))));
    }
}
