//! An open plane, and boxes with rounded edges: a cube, and a slab with a bump on it.

use super::Mesh;
use super::number;
use glam::DVec3;
use std::collections::HashMap;
use std::f64::consts::FRAC_PI_4;

/// An open square in the xz-plane, 1 x 1, facing +y, of `cells` x `cells` squares.
pub(super) fn plane(cells: u32) -> Mesh {
    let side = cells as usize + 1;
    let at = |k: usize| k as f64 / f64::from(cells) - 0.5;
    let positions = (0..side * side).map(|k| DVec3::new(at(k % side), 0.0, at(k / side))).collect();
    let squares = (0..side - 1).flat_map(|row| (0..side - 1).map(move |column| row * side + column));
    let triangles = squares.flat_map(|a| {
        let [b, c, d] = [a + 1, a + side, a + side + 1];
        [[a, c, d], [a, d, b]].map(|corners| corners.map(number))
    });
    let mesh = Mesh::made(positions, triangles.collect());
    Mesh { open_edges: 4 * cells as usize, ..mesh }
}

/// Radius of the cube's rounded edges.
const SOFT: f64 = 0.1;

/// The slab's thickness, the radius of its edges, and the bump's radius and height.
const THICK: f64 = 0.2;
const ROUND: f64 = 0.04;
const WIDE: f64 = 0.24;
const HIGH: f64 = 0.2;

/// A closed slab of 1 x 0.2 x 1 with rounded edges and a smooth round bump of 0.2 in the middle of its top, with
/// `cells` along a side.
pub(super) fn bump(cells: u32) -> Mesh {
    rounded(cells, DVec3::new(0.5, THICK / 2.0, 0.5), ROUND, |p, out| {
        let distance = (p.x.hypot(p.z) / WIDE).min(1.0);
        let lift = if out.y > 0.999 { HIGH * (1.0 - distance * distance).powi(3) } else { 0.0 };
        DVec3::Y * lift
    })
}

/// A closed cube of 1 with rounded edges, with `cells` along a side.
pub(super) fn cube(cells: u32) -> Mesh {
    rounded(cells, DVec3::splat(0.5), SOFT, |_, _| DVec3::ZERO)
}

/// A closed box with half extents `half` and edges of radius `round`, of nearly square cells, `cells` in a length of 1.
/// `lift` displaces its points by their position on the box with sharp edges and their normal.
fn rounded(cells: u32, half: DVec3, round: f64, lift: impl Fn(DVec3, DVec3) -> DVec3) -> Mesh {
    // Along each axis: the straight part in equal steps, and the roundings in equal angles.
    let step = 1.0 / f64::from(cells);
    let turns = ((2.0 * FRAC_PI_4 * round / step) as u32 / 2).max(3);
    let axes = half.to_array().map(|half| {
        let flat = half - round;
        let steps = ((2.0 * flat / step).round() as u32).max(1);
        let turn = |k: u32| flat + round * (FRAC_PI_4 * f64::from(k) / f64::from(turns)).tan();
        let mut places: Vec<f64> = (1..=turns).rev().map(|k| -turn(k)).collect();
        places.extend((0..=steps).map(|k| flat * (2.0 * f64::from(k) / f64::from(steps) - 1.0)));
        places.extend((1..=turns).map(turn));
        places
    });

    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    let mut numbers = HashMap::new();
    let mut vertex = |place: [usize; 3]| {
        *numbers.entry(place).or_insert_with(|| {
            let on_box = DVec3::new(axes[0][place[0]], axes[1][place[1]], axes[2][place[2]]);
            let inner = on_box.clamp(round - half, half - round);
            let out = (on_box - inner).normalize_or_zero();
            positions.push(inner + round * out + lift(on_box, out));
            number(positions.len() - 1)
        })
    };
    for axis in 0..3 {
        let (u, v) = ((axis + 1) % 3, (axis + 2) % 3);
        for side in [0, axes[axis].len() - 1] {
            for i in 0..axes[u].len() - 1 {
                for j in 0..axes[v].len() - 1 {
                    let corners = [(0, 0), (1, 0), (1, 1), (0, 1)].map(|(di, dj)| {
                        let mut place = [side; 3];
                        (place[u], place[v]) = (i + di, j + dj);
                        vertex(place)
                    });
                    let [a, b, c, d] = corners;
                    // Diagonals run away from the middle, so that the bump is symmetric.
                    let inward = (2 * i < axes[u].len() - 1) == (2 * j < axes[v].len() - 1);
                    let two = if inward { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] };
                    triangles.extend(two.map(|[p, q, r]| if side > 0 { [p, q, r] } else { [p, r, q] }));
                }
            }
        }
    }
    Mesh::made(positions, triangles)
}
