//! The form factor of a near-planar cluster: its triangles projected onto the plane through its midpoint, across its
//! mean normal, and the resulting polygon integrated over its border.
//!
//! Section 5.1.1 of Mertens et al. 2003. Edges that two of the cluster's triangles share cancel (section 4.2), so only
//! the polygon's border counts. It may have several loops, and where the cluster folds over, parts that count twice or
//! with the opposite sign. With `C = g(h)` the line integral is right for any of them, because the border
//! winds around the foot as often as the triangles cover it; where it does not, `C = g(s_m)` keeps the relative error
//! small, as for a single triangle ([`super::edge`]).

use super::Distance;
use super::edge::around;
use super::footprint::{Edge, nearest_of};
use super::gauss::Node;
use crate::dipole::profile::Dipole;
use glam::DVec3;

/// The form factor of the polygon, no unit, at least 0.
///
/// `border`: ends of the border's edges before the projection, the cluster's inside on the left. `center` and `normal`
/// (of length 1): the plane. `x_o`: the receiving point. `nodes`: the rule used on each edge.
#[must_use]
pub fn polygon_form(
    border: &[[DVec3; 2]],
    (center, normal): (DVec3, DVec3),
    x_o: DVec3,
    dipole: &Dipole,
    distance: Distance,
    nodes: &[Node],
) -> f64 {
    // Relative to the foot of the receiving point, within the plane.
    let delta = (x_o - center).dot(normal);
    let flat = |p: DVec3| (p - x_o) - (p - x_o).dot(normal) * normal;
    let corners: Vec<[DVec3; 2]> = border.iter().map(|edge| edge.map(flat)).collect();
    let edges: Vec<Edge> = corners.iter().map(|&[a, b]| Edge::new(a, b, normal, 1.0)).collect();
    let nearest = if winding(&corners, normal) == 0 { nearest_of(&edges) } else { 0.0 };
    let heights = distance.heights(delta, dipole);
    let mut sum = 0.0;
    for (z, h) in dipole.depths().into_iter().zip(heights) {
        sum += z * around(&edges, nearest, dipole.sigma, h, |edge, source| edge.in_w(source, nodes));
    }
    (dipole.strength * sum).max(0.0)
}

/// How often the border runs around the origin, counter-clockwise about `normal`.
fn winding(corners: &[[DVec3; 2]], normal: DVec3) -> i32 {
    let (right, up) = normal.any_orthonormal_pair();
    let crossing = |&[a, b]: &[DVec3; 2]| {
        let (p, q) = (a.dot(up), b.dot(up));
        let left = a.dot(right) * q - b.dot(right) * p;
        // Upwards to the right of the origin, or downwards there.
        i32::from(p <= 0.0 && q > 0.0 && left > 0.0) - i32::from(p > 0.0 && q <= 0.0 && left < 0.0)
    };
    corners.iter().map(crossing).sum()
}

#[cfg(test)]
mod tests {
    use super::super::edge::edge_form;
    use super::super::gauss::SIX;
    use super::*;

    const CORNERS: [DVec3; 4] =
        [DVec3::ZERO, DVec3::new(1.0, 0.0, 0.0), DVec3::new(1.2, 0.9, 0.0), DVec3::new(-0.1, 0.8, 0.0)];

    #[test]
    fn the_border_of_a_quadrilateral_is_worth_its_two_triangles() {
        let dipole = Dipole::new(2.0, 0.1, 2.9);
        let [a, b, c, d] = CORNERS;
        let border = [[a, b], [b, c], [c, d], [d, a]];
        let plane = (DVec3::new(0.5, 0.5, 0.0), DVec3::Z);
        for x_o in [DVec3::new(0.4, 0.3, 0.0), DVec3::new(3.0, -0.2, 0.4), DVec3::new(0.6, 0.5, -0.7), b] {
            for distance in [Distance::Radial, Distance::Table1 { clamp: true }] {
                let whole = polygon_form(&border, plane, x_o, &dipole, distance, &SIX);
                let part = |t: [DVec3; 3], id| edge_form(&t, id, x_o, &dipole, distance, &SIX);
                let parts = part([a, b, c], [0, 1, 2]) + part([a, c, d], [0, 2, 3]);
                assert!((whole / parts - 1.0).abs() < 2e-4, "{x_o} {whole} {parts}");
            }
        }
    }

    #[test]
    fn what_folds_over_counts_as_often_as_it_covers() {
        let [a, b, c, d] = CORNERS;
        let once = [[a, b], [b, c], [c, d], [d, a]];
        assert_eq!(winding(&once.map(|edge| edge.map(|p| p - DVec3::splat(0.5))), DVec3::Z), 1);
        assert_eq!(winding(&once.map(|edge| edge.map(|p| p - DVec3::splat(0.5))), -DVec3::Z), -1);
        assert_eq!(winding(&once.map(|edge| edge.map(|p| p - DVec3::splat(3.0))), DVec3::Z), 0);
        let twice: Vec<[DVec3; 2]> = once.into_iter().chain(once).map(|e| e.map(|p| p - DVec3::splat(0.4))).collect();
        assert_eq!(winding(&twice, DVec3::Z), 2);
    }
}
