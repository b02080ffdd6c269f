//! Near triangles: single and double layer of a flat triangle of even density, by area points or by its edges.
//!
//! Over the edges, with h the receiver's height over the plane, r the distance from its foot, r_m the least such
//! distance (0 inside the triangle, or where it is below h) and s_m the distance from the receiver there:
//! `int e^(-k s)/s dA = e^(-k s_m) sum R int q phi1 / (s + s_m) dt` and
//! `h int (1 + k s) e^(-k s)/s^3 dA = e^(-k s_m) (h/s_m) sum R int q (1 + k s_m phi1) / (s (s + s_m)) dt`, with
//! `phi1 = (1 - e^(-k (s - s_m))) / (k (s - s_m))` and `q = (r^2 - r_m^2) / r^2`.

use glam::DVec3;

use super::far::{kernel, slope};
use crate::dipole::distance2;
use crate::dipole::form_factor::footprint::{Edge, Footprint};
use crate::dipole::form_factor::gauss::Node;
use crate::dipole::form_factor::points::SIX;
use crate::layout::{Buffers, ELONGATED, PART_WIDTH};
use crate::state::wide;

/// Single and double layer of density 1.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Both {
    pub single: f64,
    pub double: f64,
}

/// Both layers by 6 area points, per area; `normal` is the unit normal.
pub(super) fn sampled(k: f64, corners: &[DVec3; 3], normal: DVec3, x: DVec3) -> Both {
    let mut sum = Both::default();
    for [u, v, w, weight] in SIX {
        let d = x - (u * corners[0] + v * corners[1] + w * corners[2]);
        let s = d.length();
        sum.single += weight * kernel(k, s);
        sum.double -= weight * slope(k, s) * d.dot(normal);
    }
    sum
}

/// The vector from a triangle's centroid to the place of its light, in one channel.
pub(super) fn depth(data: &Buffers, face: usize, c: usize) -> DVec3 {
    let deposit = &data.deposits[face];
    wide([deposit.red, deposit.green, deposit.blue][c])
}

/// Whether the light that a triangle deposits is too near to a place for area points in some channel; exact on every
/// device.
pub(super) fn too_near(data: &Buffers, node: usize, area_distance: f32, x: [f32; 3]) -> bool {
    let (center, reach) = (data.clusters[node].center, area_distance.max(0.0));
    let deposit = &data.deposits[data.topology[node].face as usize];
    let place = |depth: [f32; 3]| [0, 1, 2].map(|i| center[i] + depth[i]);
    [deposit.red, deposit.green, deposit.blue].into_iter().any(|depth| distance2(x, place(depth)) < reach * reach)
}

fn phi1(x: f64) -> f64 {
    if x == 0.0 { 1.0 } else { -(-x).exp_m1() / x }
}

/// The integrals over one edge, without their factors; an elongated triangle's edge is taken in parts of even width in
/// asinh(t / S), over which the integrands are smooth, however near the receiver is to the edge's line.
fn edge(edge: &Edge, k: f64, at: [f64; 3], elongated: bool, nodes: &[Node]) -> Both {
    let r_line = edge.sense * edge.offset;
    if r_line == 0.0 {
        return Both::default();
    }
    let s_line = r_line.hypot(at[0]);
    let [u1, u2] = if elongated { [edge.start, edge.end].map(|t| (t / s_line).asinh()) } else { [0.0; 2] };
    let parts = ((u2 - u1) / f64::from(PART_WIDTH)).ceil().clamp(1.0, 8.0) as usize;
    let place = |k: usize| match k {
        0 => edge.start,
        k if k == parts => edge.end,
        k => s_line * (u1 + (u2 - u1) * k as f64 / parts as f64).sinh(),
    };
    let each = (0..parts).map(|part| part_of_edge([place(part), place(part + 1)], r_line, k, at, nodes));
    each.fold(Both::default(), |sum, one| Both { single: sum.single + one.single, double: sum.double + one.double })
}

/// The integrals from `t[0]` to `t[1]` along an edge.
fn part_of_edge(t: [f64; 2], r_line: f64, k: f64, [h, rim, s_m]: [f64; 3], nodes: &[Node]) -> Both {
    let s_line = r_line.hypot(h);
    let [w1, w2] = t.map(|t| t / (s_line + s_line.hypot(t)));
    let (middle, half) = (0.5 * (w1 + w2), 0.5 * (w2 - w1));
    let mut sum = Both::default();
    for node in nodes {
        let w = middle + half * node.x;
        let ratio = 1.0 / ((1.0 - w) * (1.0 + w));
        let (s, t) = (s_line * (1.0 + w * w) * ratio, 2.0 * s_line * w * ratio);
        let r2 = r_line * r_line + t * t;
        let (past, q) = if h < rim {
            let past = (r2 - rim * rim).max(0.0);
            (past, past / r2)
        } else {
            (r2, 1.0)
        };
        let phi = phi1(k * past / (s + s_m));
        // dt = s 2 dw / (1 - w^2).
        let common = 2.0 * r_line * half * node.weight * ratio * q / (s + s_m);
        sum.single += common * s * phi;
        sum.double += common * (1.0 + k * s_m * phi);
    }
    sum
}

/// Both layers by the edges; `own`: the receiver lies in the triangle's plane. Both are 0 for a triangle without area.
pub(super) fn by_edges(k: f64, corners: &[DVec3; 3], id: [u32; 3], x: DVec3, own: bool, nodes: &[Node]) -> Both {
    let Some(footprint) = Footprint::new(corners, id, x) else { return Both::default() };
    let height = if own { 0.0 } else { footprint.delta };
    let (h, rim) = (height.abs(), footprint.nearest);
    let s_m = if h < rim { h.hypot(rim) } else { h };
    let mut sum = Both::default();
    let [a, b, c] = *corners;
    let longest = [b - a, c - b, a - c].map(DVec3::length_squared).into_iter().fold(0.0, f64::max);
    let elongated = longest > f64::from(ELONGATED) * (b - a).cross(c - a).length();
    for one in footprint.edges.iter().map(|one| edge(one, k, [h, rim, s_m], elongated, nodes)) {
        sum.single += one.single;
        sum.double += one.double;
    }
    let fall = (-k * s_m).exp() / (4.0 * std::f64::consts::PI);
    let of_height = if s_m > 0.0 { height / s_m } else { 0.0 };
    Both { single: fall * sum.single.max(0.0), double: fall * of_height * sum.double.max(0.0) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dipole::form_factor::gauss::legendre;

    /// Both layers by many small triangles.
    fn fine(k: f64, corners: &[DVec3; 3], x: DVec3, levels: u32) -> Both {
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
        if levels == 0 {
            let area = 0.5 * normal.length();
            let one = sampled(k, corners, normal.normalize(), x);
            return Both { single: area * one.single, double: area * one.double };
        }
        let [a, b, c] = *corners;
        let [ab, bc, ca] = [0.5 * (a + b), 0.5 * (b + c), 0.5 * (c + a)];
        let parts = [[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]];
        let parts = parts.map(|part| fine(k, &part, x, levels - 1));
        parts
            .iter()
            .fold(Both::default(), |sum, one| Both { single: sum.single + one.single, double: sum.double + one.double })
    }

    #[test]
    fn edges_give_the_sum_over_small_triangles() {
        let corners = [DVec3::new(0.1, 0.0, 0.2), DVec3::new(1.1, 0.1, 0.0), DVec3::new(0.3, 0.9, -0.1)];
        let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
        let normal = (corners[1] - corners[0]).cross(corners[2] - corners[0]).normalize();
        let nodes = legendre(12);
        for k in [0.0, 0.5, 4.0] {
            for x in
                [middle + 0.3 * normal, middle - 0.4 * normal, DVec3::new(1.4, 0.7, 0.1), DVec3::new(-0.5, 0.2, 0.4)]
            {
                let (found, exact) = (by_edges(k, &corners, [4, 1, 2], x, false, &nodes), fine(k, &corners, x, 6));
                let close = |a: f64, b: f64| (a - b).abs() < 2e-5 * exact.single;
                assert!(
                    close(found.single, exact.single) && close(found.double, exact.double),
                    "{k} {x}: {found:?} {exact:?}"
                );
            }
            // At its own centroid: the points of the sum never meet it, and it converges slowly.
            let own = by_edges(k, &corners, [0, 1, 2], middle, true, &nodes);
            let exact = fine(k, &corners, middle, 8).single;
            assert!((own.single / exact - 1.0).abs() < 5e-3 && own.double == 0.0, "{k}: {own:?} {exact}");
        }
    }

    #[test]
    fn the_double_layer_of_a_closed_surface_is_its_solid_angle() {
        // Inside a tetrahedron: -1 for a layer of 1; outside: 0.
        let corner = |x: f64, y: f64, z: f64| DVec3::new(x, y, z);
        let corners = [corner(0.0, 0.0, 0.0), corner(1.0, 0.1, 0.0), corner(0.2, 1.0, 0.1), corner(0.3, 0.2, 0.9)];
        let nodes = legendre(12);
        for (x, wanted) in [(corner(0.35, 0.3, 0.22), -1.0), (corner(1.0, 1.0, 1.0), 0.0)] {
            let sides = [[0u32, 2, 1], [0, 1, 3], [1, 2, 3], [0, 3, 2]];
            let double =
                |side: &[u32; 3]| by_edges(0.0, &side.map(|v| corners[v as usize]), *side, x, false, &nodes).double;
            let sum: f64 = sides.iter().map(double).sum();
            assert!((sum - wanted).abs() < 1e-5, "{sum} {wanted}");
        }
    }

    #[test]
    fn slivers_need_no_more_nodes() {
        // A hundred to one and a thousand to one, from their own centroids and beside them.
        for width in [1e-2, 1e-3] {
            let corners = [DVec3::ZERO, DVec3::X, DVec3::new(0.4, width, 0.0)];
            let middle = (corners[0] + corners[1] + corners[2]) / 3.0;
            for x in [middle, middle + 0.3 * width * DVec3::Y + 0.2 * width * DVec3::Z, middle + 0.1 * DVec3::X] {
                let [few, many] = [6, 12].map(|n| by_edges(0.3, &corners, [0, 1, 2], x, x.z == 0.0, &legendre(n)));
                let off = (few.single / many.single - 1.0).abs().max((few.double - many.double).abs() / many.single);
                assert!(off < 2e-4, "{width} {x}: {off:.1e}, {few:?} {many:?}");
            }
            // In closed form for k = 0, at the own centroid: the sum over edges of R (asinh(t2 / R) - asinh(t1 / R)).
            let found = by_edges(0.0, &corners, [0, 1, 2], middle, true, &legendre(6)).single;
            let edge = |a: DVec3, b: DVec3| {
                let u = (b - a).normalize();
                let r = (a - middle).cross(u).z;
                r * (((b - middle).dot(u) / r).asinh() - ((a - middle).dot(u) / r).asinh())
            };
            let exact =
                (0..3).map(|e| edge(corners[e], corners[(e + 1) % 3])).sum::<f64>() / (4.0 * std::f64::consts::PI);
            assert!((found / exact - 1.0).abs() < 2e-4, "{width}: {found} {exact}");
        }
    }
}
