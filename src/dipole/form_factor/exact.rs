//! The form factor to almost full precision: the edge form on graded panels.
//!
//! The same line integral as [`super::edge`], but in `t`, with 24 nodes on each of many panels that shrink towards
//! the foot and towards both ends of the edge. Too slow for rendering; it is the reference that the quadratures are
//! tested against. With 6 nodes per panel it is the reference for sums over all triangles.

use super::Distance;
use super::edge::{Source, around, weighed};
use super::footprint::{Edge, Footprint};
use super::gauss::{Node, legendre};
use crate::dipole::profile::Dipole;
use glam::DVec3;
use std::sync::LazyLock;

static RULE: LazyLock<Vec<Node>> = LazyLock::new(|| legendre(24));
static FEW: LazyLock<Vec<Node>> = LazyLock::new(|| legendre(6));

/// The form factor of a triangle, no unit; scaled error about 1e-14. Arguments as
/// [`super::edge::edge_form`].
#[must_use]
pub fn edge_form_exact(
    triangle: &[DVec3; 3],
    indices: [u32; 3],
    x_o: DVec3,
    dipole: &Dipole,
    distance: Distance,
) -> f64 {
    weighed(triangle, indices, x_o, dipole, distance, integral)
}

/// [`edge_form_exact`] with a quarter of the nodes; scaled error below 1e-8.
#[must_use]
pub fn edge_form_fine(
    triangle: &[DVec3; 3],
    indices: [u32; 3],
    x_o: DVec3,
    dipole: &Dipole,
    distance: Distance,
) -> f64 {
    let integral = |footprint: &Footprint, sigma, height| {
        around(&footprint.edges, footprint.nearest, sigma, height, |edge, source| panels(edge, source, &FEW))
    };
    weighed(triangle, indices, x_o, dipole, distance, integral)
}

/// `J` of [`super::edge::integral`] to almost full precision, 1/length.
#[must_use]
pub fn integral(footprint: &Footprint, sigma: f64, height: f64) -> f64 {
    around(&footprint.edges, footprint.nearest, sigma, height, |edge, source| panels(edge, source, &RULE))
}

/// The line integral of one edge, signed, no unit.
fn panels(edge: &Edge, source: &Source, rule: &[Node]) -> f64 {
    if edge.offset == 0.0 {
        return 0.0;
    }
    let mut sum = 0.0;
    for pair in breakpoints(edge, source).windows(2) {
        let (middle, half) = (0.5 * (pair[0] + pair[1]), 0.5 * (pair[1] - pair[0]));
        for node in rule {
            let t = middle + half * node.x;
            let r2 = edge.offset * edge.offset + t * t;
            let s = (r2 + source.height * source.height).sqrt();
            let density = source.density(s, r2);
            sum += node.weight * half * density / ((s + source.reference) * s);
        }
    }
    edge.sense * edge.offset * sum
}

/// Points along the edge in rising order: its ends, the foot, and steps doubling away from each.
fn breakpoints(edge: &Edge, source: &Source) -> Vec<f64> {
    // The integrand varies over S (geometry), sqrt(S/sigma) (extinction near the foot) and 1/sigma (extinction away
    // from it); start below the smallest.
    let nearest = edge.offset.hypot(source.height);
    let extinct = if source.sigma > 0.0 { 1.0 / source.sigma } else { f64::INFINITY };
    let finest = 0.5 * nearest.min((nearest * extinct).sqrt()).min(extinct);
    let length = edge.end - edge.start;
    let mut places = vec![edge.start, edge.end];
    for centre in [edge.start, 0.0, edge.end] {
        places.push(centre);
        // Steps below 2^-60 of the length have nothing left to resolve.
        let mut step = finest.max(length * 2.0_f64.powi(-60));
        while step < length + centre.abs() {
            places.extend([centre - step, centre + step]);
            step *= 2.0;
        }
    }
    places.retain(|&t| t >= edge.start && t <= edge.end);
    places.sort_by(f64::total_cmp);
    places.dedup();
    places
}
