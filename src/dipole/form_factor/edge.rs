//! The form factor as a line integral over the triangle's edges, free of cancellation.
//!
//! Equation 10 of Mertens et al. 2003 is `J = sum over edges of int [g(h) - g(s)] dtheta` with
//! `g(s) = e^(-sigma s) / s`. The paper evaluates the two parts separately and subtracts; here they are joined
//! analytically (`s - s_m = (r^2 - r_m^2) / (s + s_m)`), so that `1/r^2` cancels at the foot:
//!
//! `J = g(s_m) sum R int q [1 + sigma s_m phi1(sigma (s - s_m))] / ((s + s_m) s) dt`,
//! `phi1(x) = (1 - e^(-x)) / x`, `q = (r^2 - r_m^2) / r^2`.
//!
//! The constant `g(s_m)` can be chosen freely where the foot is outside (the angles sum to 0); choosing it at the
//! nearest point keeps the relative error small far away. For a foot inside, or nearer than `h`, `r_m = 0`. There is
//! no test for inside or outside and no sign rule: `R` carries the sign.
//!
//! The quadrature runs in `w = tan(psi/2) = t / (S + s)`, where `psi` is the angle at the source:
//! `s = S (1+w^2)/(1-w^2)`, `t = 2 S w/(1-w^2)`, `dt/s = 2 dw/(1-w^2)`. The map is rational, so a shader needs no
//! trigonometric function, whose precision Vulkan does not specify.

use super::Distance;
use super::footprint::{Edge, Footprint};
use super::gauss::Node;
use crate::dipole::profile::Dipole;
use glam::DVec3;

/// The form factor of a triangle by quadrature over its edges, no unit, in [0, total].
///
/// `triangle`: corners, counter-clockwise. `indices`: their vertex indices in the mesh. `x_o`: the receiving point.
/// `nodes`: the rule used on each edge ([`super::gauss::SIX`] for scheme `links`). A triangle without area gives 0.
/// Unclamped Table 1 gives infinity where the integral diverges.
#[must_use]
pub fn edge_form(
    triangle: &[DVec3; 3],
    indices: [u32; 3],
    x_o: DVec3,
    dipole: &Dipole,
    distance: Distance,
    nodes: &[Node],
) -> f64 {
    weighed(triangle, indices, x_o, dipole, distance, |f, sigma, h| integral(f, sigma, h, nodes))
}

/// The sum over both sources of the dipole, each with its depth as the numerator (equation 7). `source` is the integral
/// for a source of this extinction and height.
pub(super) fn weighed(
    triangle: &[DVec3; 3],
    indices: [u32; 3],
    x_o: DVec3,
    dipole: &Dipole,
    distance: Distance,
    source: impl Fn(&Footprint, f64, f64) -> f64,
) -> f64 {
    let Some(footprint) = Footprint::new(triangle, indices, x_o) else {
        return 0.0;
    };
    let heights = distance.heights(footprint.delta, dipole);
    let mut sum = 0.0;
    for (z, h) in dipole.depths().into_iter().zip(heights) {
        sum += z * source(&footprint, dipole.sigma, h);
    }
    dipole.strength * sum
}

/// `J`: the integral of `p(s)` over the triangle for one source, 1/length.
///
/// `sigma`: extinction, 1/length. `height`: of the source over the triangle's plane, length.
#[must_use]
pub fn integral(footprint: &Footprint, sigma: f64, height: f64, nodes: &[Node]) -> f64 {
    around(&footprint.edges, footprint.nearest, sigma, height, |edge, source| edge.in_w(source, nodes))
}

/// [`integral`] by quadrature in `psi`.
#[must_use]
pub fn integral_psi(footprint: &Footprint, sigma: f64, height: f64, nodes: &[Node]) -> f64 {
    around(&footprint.edges, footprint.nearest, sigma, height, |edge, source| edge.in_psi(source, nodes))
}

/// What the three edges add to `J`, 1/length. An edge that two triangles of a plane share cancels bit for bit if both
/// use the constant of the foot (inside, or nearer than the height).
#[must_use]
pub fn terms(footprint: &Footprint, sigma: f64, height: f64, nodes: &[Node]) -> [f64; 3] {
    let source = Source::new(sigma, height, footprint.nearest);
    let term = |edge: &Edge| source.constant() * edge.in_w(&source, nodes);
    let [a, b, c] = &footprint.edges;
    [term(a), term(b), term(c)]
}

/// `J` of the area that these edges enclose, with the line integral of each by `line`; `nearest`: distance in the plane
/// from the foot to that area.
pub(super) fn around(
    edges: &[Edge],
    nearest: f64,
    sigma: f64,
    height: f64,
    line: impl Fn(&Edge, &Source) -> f64,
) -> f64 {
    let source = Source::new(sigma, height, nearest);
    // A source inside the triangle (unclamped Table 1 only): the integral diverges.
    if source.reference == 0.0 {
        return f64::INFINITY;
    }
    source.constant() * edges.iter().map(|edge| line(edge, &source)).sum::<f64>()
}

/// One source above the plane, and the reference distance of its constant.
pub(super) struct Source {
    /// Extinction, 1/length.
    pub sigma: f64,
    /// Height over the plane, length.
    pub height: f64,
    /// `r_m^2`, length^2: squared distance from foot to triangle, or 0 where the distance is less than the height.
    pub nearest2: f64,
    /// `s_m = sqrt(h^2 + r_m^2)`, length.
    pub reference: f64,
}

impl Source {
    pub(super) fn new(sigma: f64, height: f64, nearest: f64) -> Self {
        let nearest = if nearest < height { 0.0 } else { nearest };
        Self { sigma, height, nearest2: nearest * nearest, reference: height.hypot(nearest) }
    }

    /// `g(s_m)`, 1/length.
    fn constant(&self) -> f64 {
        (-self.sigma * self.reference).exp() / self.reference
    }

    /// `q [1 + sigma s_m phi1(sigma (s - s_m))]` at the distance `s`, with `r2` the squared distance in the plane
    /// from the foot.
    #[inline]
    pub(super) fn density(&self, s: f64, r2: f64) -> f64 {
        let excess = (r2 - self.nearest2).max(0.0);
        let q = if self.nearest2 == 0.0 { 1.0 } else { excess / r2 };
        let gap = excess / (s + self.reference);
        q * (1.0 + self.sigma * self.reference * phi1(self.sigma * gap))
    }
}

/// `(1 - e^(-x)) / x` for `x` >= 0, in (0, 1].
fn phi1(x: f64) -> f64 {
    if x == 0.0 { 1.0 } else { -(-x).exp_m1() / x }
}

impl Edge {
    /// The edge's line integral in `w`, signed, no unit (multiplied by `g(s_m)` it is its part of `J`).
    pub(super) fn in_w(&self, source: &Source, nodes: &[Node]) -> f64 {
        if self.offset == 0.0 {
            return 0.0;
        }
        let nearest = self.offset.hypot(source.height);
        let place = |t: f64| t / (nearest + nearest.hypot(t));
        let (first, last) = (place(self.start), place(self.end));
        let (middle, half) = (0.5 * (first + last), 0.5 * (last - first));
        let mut sum = 0.0;
        for node in nodes {
            let w = middle + half * node.x;
            let (up, down) = (1.0 + w * w, 1.0 - w * w);
            let (s, t) = (nearest * up / down, 2.0 * nearest * w / down);
            let density = source.density(s, self.offset * self.offset + t * t);
            sum += node.weight * density / (nearest * up + source.reference * down);
        }
        self.sense * self.offset * 2.0 * half * sum
    }

    /// The edge's line integral in `psi`, signed, no unit.
    fn in_psi(&self, source: &Source, nodes: &[Node]) -> f64 {
        if self.offset == 0.0 {
            return 0.0;
        }
        let nearest = self.offset.hypot(source.height);
        let (first, last) = (self.start.atan2(nearest), self.end.atan2(nearest));
        let (middle, half) = (0.5 * (first + last), 0.5 * (last - first));
        let mut sum = 0.0;
        for node in nodes {
            let (sin, cos) = (middle + half * node.x).sin_cos();
            let (s, t) = (nearest / cos, nearest * sin / cos);
            let density = source.density(s, self.offset * self.offset + t * t);
            sum += node.weight * density / (nearest + source.reference * cos);
        }
        self.sense * self.offset * half * sum
    }
}

#[cfg(test)]
mod tests {
    use super::super::gauss::SIX;
    use super::*;

    #[test]
    fn a_shared_edge_cancels_to_the_last_bit() {
        let (a, b) = (DVec3::new(0.13, 0.21, 0.0), DVec3::new(1.07, 0.93, 0.0));
        let left = [a, b, DVec3::new(0.2, 1.4, 0.0)];
        let right = [b, a, DVec3::new(1.3, -0.2, 0.0)];
        let x_o = DVec3::new(0.7, 0.6, 0.3);
        let one = Footprint::new(&left, [4, 7, 9], x_o).unwrap();
        let two = Footprint::new(&right, [7, 4, 2], x_o).unwrap();
        let [shared, ..] = terms(&one, 0.4, 0.8, &SIX);
        assert!(shared != 0.0);
        assert_eq!(shared, -terms(&two, 0.4, 0.8, &SIX)[0]);
    }

    #[test]
    fn a_point_on_the_edge_gets_nothing_from_it() {
        let triangle = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let footprint = Footprint::new(&triangle, [0, 1, 2], DVec3::new(0.25, 0.0, 0.0)).unwrap();
        assert_eq!(terms(&footprint, 1.0, 0.1, &SIX)[0], 0.0);
    }
}
