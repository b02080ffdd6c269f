//! Surface nets: a mesh of the zero set of a function, with quadrilaterals around the edges of a grid.

use super::Mesh;
use super::number;
use glam::{DVec3, IVec3, Vec3Swizzles};
use std::collections::HashMap;

/// The closed surface where `field` goes from negative inside to positive outside, all of it between `low` and `high`,
/// on a grid of cubes with this side. Each patch of the surface in a cube gets one vertex, projected onto the surface.
/// Parts thinner than a cube vanish or merge.
pub(super) fn surface(field: impl Fn(DVec3) -> f64, low: DVec3, high: DVec3, side: f64) -> Mesh {
    let counts = ((high - low) / side).ceil().as_ivec3() + 3;
    let at = |p: IVec3| low + (p.as_dvec3() - 1.0) * side;
    let index = |p: IVec3| ((p.z * counts.y + p.y) * counts.x + p.x) as usize;
    let all = || {
        let rows = (0..counts.z).flat_map(move |z| (0..counts.y).map(move |y| (y, z)));
        rows.flat_map(move |(y, z)| (0..counts.x).map(move |x| IVec3::new(x, y, z)))
    };
    let values: Vec<f64> = all().map(|p| field(at(p))).collect();

    let inside = |p: IVec3| values[index(p)] < 0.0;

    // One quadrilateral around each edge that the surface crosses, with corners in the four cubes at the edge.
    let mut cubes = HashMap::new();
    let mut middles: Vec<(DVec3, f64)> = Vec::new();
    let mut squares = Vec::new();
    for p in all() {
        for axis in 0..3 {
            let along = IVec3::from_array(std::array::from_fn(|k| i32::from(k == axis)));
            let q = p + along;
            let inner = p.cmpgt(IVec3::ZERO).all() && q.cmplt(counts).all();
            if !inner || inside(p) == inside(q) {
                continue;
            }
            let (from, to) = (values[index(p)], values[index(q)]);
            let crossing = at(p).lerp(at(q), from / (from - to));
            let (u, v) = (along.zxy(), along.yzx());
            let mut corners = [p, p - u, p - u - v, p - v].map(|cube| {
                let ends = if from < 0.0 { (p, q) } else { (q, p) };
                let vertex = *cubes.entry((cube, patch(inside, cube, ends))).or_insert_with(|| {
                    middles.push((DVec3::ZERO, 0.0));
                    middles.len() - 1
                });
                let (sum, count) = &mut middles[vertex];
                (*sum, *count) = (*sum + crossing, *count + 1.0);
                vertex
            });
            if from >= 0.0 {
                corners.reverse();
            }
            squares.push(corners);
        }
    }

    // Vertices: smooth, then project onto the surface, four times.
    let mut positions: Vec<DVec3> = middles.iter().map(|(sum, count)| *sum / *count).collect();
    for _ in 0..4 {
        even_out(&mut positions, &squares);
        positions.iter_mut().for_each(|p| *p = onto(&field, *p, side));
    }

    // Triangles: along the shorter diagonal.
    let triangles = squares.iter().flat_map(|&[a, b, c, d]| {
        let across = positions[a].distance(positions[c]) <= positions[b].distance(positions[d]);
        let two = if across { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] };
        two.map(|corners| corners.map(number))
    });
    let triangles = triangles.collect();
    Mesh::made(positions, triangles)
}

/// The patch of the surface in a cube that separates these two corners: inside corners are connected along the cube's
/// edges, outside corners also across the diagonals of its faces.
fn patch(negative: impl Fn(IVec3) -> bool, cube: IVec3, (inside, outside): (IVec3, IVec3)) -> [i32; 2] {
    let corner = |k: i32| cube + IVec3::new(k & 1, k >> 1 & 1, k >> 2);
    let under = (0..8).filter(|&k| negative(corner(k))).fold(0, |mask, k| mask | 1 << k);
    let grow = |from: IVec3, of: i32, reach: u32| {
        let mut part = 1 << (from - cube).dot(IVec3::new(1, 2, 4));
        for k in (0..8).cycle().take(56).filter(|k| of >> k & 1 == 1) {
            if (0..8).any(|j: i32| part >> j & 1 == 1 && (j ^ k).count_ones() <= reach) {
                part |= 1 << k;
            }
        }
        part
    };
    [grow(inside, under, 1), grow(outside, !under, 2)]
}

/// Moves each vertex halfway to the mean of its neighbours.
fn even_out(positions: &mut [DVec3], squares: &[[usize; 4]]) {
    let mut means = vec![(DVec3::ZERO, 0.0); positions.len()];
    for corners in squares {
        for k in 0..4 {
            let (a, b) = (corners[k], corners[(k + 1) % 4]);
            for (to, from) in [(a, b), (b, a)] {
                means[to].0 += positions[from];
                means[to].1 += 1.0;
            }
        }
    }
    for (position, (sum, count)) in positions.iter_mut().zip(means) {
        *position = position.midpoint(sum / count);
    }
}

/// Projects a point near the surface onto it by three Newton steps along the gradient, none longer than half of `side`.
fn onto(field: impl Fn(DVec3) -> f64, mut p: DVec3, side: f64) -> DVec3 {
    let h = 1e-3 * side;
    for _ in 0..3 {
        let slope = |axis: DVec3| (field(p + axis * h) - field(p - axis * h)) / (2.0 * h);
        let gradient = DVec3::new(slope(DVec3::X), slope(DVec3::Y), slope(DVec3::Z));
        let step = field(p) * gradient / gradient.length_squared().max(1e-6);
        p -= step.clamp_length_max(side / 2.0);
    }
    p
}
