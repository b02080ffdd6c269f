//! The estimated error of the transport at a receiver: the laws that `gather` sums and from which `push` computes the
//! estimate. `glsl/transport/blocks/estimate.glsl` states the same laws.
//!
//! Each link adds the square of its error, because links err in either direction. Their laws are those of the oracle,
//! in chi = tau q2(sigma s) / (2 s^2), with three changes. First, the oracle evaluates a law at a cluster's nearest
//! point; here it is evaluated at the centroid and multiplied by e^(sigma sqrt(tau)), the factor by which the profile
//! falls from that point to the centroid. Second, an expansion for a whole block is of second order in the emitter's
//! spread and the receiver's offset together, so the third order of both is lost: (tau + offset^2)^3 is at most
//! 4 (tau^3 + offset^6), which needs two sums instead of four. Third, the factors are measured, so that each law
//! alone has the right magnitude: a third moment is a small share of tau^1.5, hence 0.15 where the oracle has 0.5,
//! and few offsets lie in the worst direction, hence 0.4. Dropped emitters all err in the same direction, so they are
//! summed before the sum is squared.
//!
//! Positions are rounded to `f32` in internal units: a corner, and the centroid of a receiver or of a cluster, moves by
//! at most u = sqrt(3) 2^-24 m, where m is the largest coordinate. B is an integral of a positive kernel over
//! triangles, so a relative bound on the integrand bounds B:
//! - Area: a triangle of perimeter P and area A, all of whose corners move by u, grows by at most P u / 2, to first
//!   order; in the mean over the surface, that is u / rho of the area, rho = 2 sum A / sum P: the triangles' mean
//!   inradius.
//! - Distance: -d ln R / dr = (r / s^2) (3 + 3a + a^2) / (1 + a) <= 3 r / s^2 + sigma <= 3 / (2 z) + sigma for a source
//!   at depth z, a = sigma s and s^2 = r^2 + z^2. Receiver and emitter move, by 2 u together. Where z or 1 / sigma is
//!   far below rho, nearly all light comes from the receiver's own triangle, around whose centroid the integral only
//!   changes with its border, at distance rho: hence z + rho, and at most 1 / rho for sigma.
//!
//! The bound u (1 / rho + 2 (1.5 / (z + rho) + min(sigma, 1 / rho))) is a property of object and channel. Roundings are
//! independent of one another, so a measured part of it is taken, `DISPLACED`.

use crate::dipole::derivatives::{ClusterMoments, GroupProfile};
use crate::layout::{ESTIMATE_BOTH, ESTIMATE_SAFETY, ESTIMATE_STEEPEST};

/// Rounding of profile and sums to `f32`, as a share of the radiosity.
const ROUNDING: f64 = 2e-6;
/// The error by rounded positions as a share of its bound: corners are rounded independently of one another, and errors
/// from all sides cancel in part. Measured on two marble balls 300 to 30,000 radii apart, the median receiver errs by
/// 0.01 of the bound, and 99 of 100 by less than 0.05 to 0.2 of it.
const DISPLACED: f64 = 0.1;

/// Squared error of a link by moments of this order.
pub fn moments(jets: &GroupProfile, c: usize, m: &ClusterMoments, d2: f64, order: u32) -> f64 {
    let chi = jets.unit_chi(c, d2) * m.trace();
    let share = match order {
        2 => 0.15 * chi.powf(1.5),
        1 => chi,
        _ => chi.sqrt(),
    };
    let nearer = (jets.dipole(c).sigma * m.trace().sqrt()).min(ESTIMATE_STEEPEST).exp();
    (m.weight * jets.at(c, d2).value * share.min(1.0) * nearer).powi(2)
}

/// Squared error of an expansion at a block's radius.
pub fn bend(jets: &GroupProfile, c: usize, m: &ClusterMoments, d2: f64, radius: f64) -> f64 {
    let chi = jets.unit_chi(c, d2) * radius * radius;
    (m.weight * jets.at(c, d2).value * 0.4 * chi.powf(1.5) / (1.0 + 0.4 * chi)).powi(2)
}

/// Squared error of a triangle's 6 area points.
pub fn points(jets: &GroupProfile, c: usize, m: &ClusterMoments, d2: f64) -> f64 {
    let chi = jets.unit_chi(c, d2) * m.trace();
    (m.weight * jets.at(c, d2).value * (0.006 * chi.powi(3)).min(1.0)).powi(2)
}

/// Squared error of the edge form of a triangle, given its value: a share of the value that depends on the nodes per
/// edge and on the size of the triangle relative to how far light reaches in the material (measured: almost exact at
/// 0.1, a few % at 3 with 3 nodes).
pub fn edge(sigma: f64, m: &ClusterMoments, nodes: u32, value: f64) -> f64 {
    let size = (sigma * m.trace().sqrt()).min(3.0);
    let share = match nodes {
        3 => 5e-3 * size,
        6 => 4e-4 * size * size,
        _ => 1e-6 * size * size,
    };
    (share * value).powi(2)
}

/// The light that a dropped cluster would have sent: over a line of this spread, e^(-sigma s) is on average sinh(t)/t
/// times its value at the centre, where t = sigma sqrt(3 tau) stands for half the line's length.
pub fn dropped(jets: &GroupProfile, c: usize, m: &ClusterMoments, d2: f64) -> f64 {
    let t = (jets.dipole(c).sigma * (3.0 * m.trace()).sqrt()).min(ESTIMATE_STEEPEST);
    let grown = if t > 1e-2 { t.sinh() / t } else { 1.0 };
    m.weight * jets.at(c, d2).value * grown
}

/// The error by rounding to `f32`, as a share of the radiosity: rounding of values, and of positions up to `most` from
/// the origin, in triangles of this mean inradius.
pub fn rounding(sigma: f64, depth: f64, inradius: f64, most: f64) -> f64 {
    let moved = 3.0f64.sqrt() * 2.0f64.powi(-24) * most;
    let steepest = 1.5 / (depth + inradius) + sigma.min(1.0 / inradius);
    ROUNDING + (DISPLACED * moved * (1.0 / inradius + 2.0 * steepest)).min(1.0)
}

/// The estimate of a receiver, from its own squared error, its block's squared errors at the centre and at the
/// radius, its offset and that radius, and its radiosity before clamping to 0. `rounding` is a share of the radiosity.
pub fn close(
    [sigma, rounding]: [f64; 2],
    own: f64,
    [center, rim]: [f64; 2],
    [offset, radius]: [f64; 2],
    sum: f64,
) -> f64 {
    let nearer = (2.0 * sigma * offset).min(ESTIMATE_STEEPEST).exp();
    let out = if radius > 0.0 { offset / radius } else { 0.0 };
    let block = ESTIMATE_BOTH * nearer * (center + rim * out.powi(6));
    ESTIMATE_SAFETY * (own + block).sqrt() + rounding * sum.abs() + (-sum).max(0.0)
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use crate::transport::blocks::estimate::*;

    #[test]
    fn what_is_clamped_is_added() {
        assert_eq!(close([1.0, ROUNDING], 0.0, [0.0; 2], [0.1, 0.2], -0.5), 0.5 + ROUNDING * 0.5);
        let without = close([1.0, ROUNDING], 4e-6, [1e-6, 2e-6], [0.1, 0.2], 0.0);
        assert!(
            (close([1.0, ROUNDING], 4e-6, [1e-6, 2e-6], [0.1, 0.2], -0.5) - without - 0.5 - ROUNDING * 0.5).abs()
                < 1e-12
        );
        assert!(without > 2e-3 * ESTIMATE_SAFETY);
    }

    #[test]
    fn nothing_overflows() {
        let m = ClusterMoments { weight: 1.0, center: DVec3::ZERO, moments: [DVec3::splat(0.1), DVec3::ZERO] };
        let params = crate::layout::ObjectParams {
            strength: [0.08; 3],
            sigma: [0.0, 30.0, 2e6],
            z_real: [1e-6; 3],
            z_virtual: [3e-6; 3],
            tint: [1.0; 3],
            ..Default::default()
        };
        let jets = GroupProfile::new(&params, 7);
        for (c, d2) in [0.0, 1e-6, 0.5].into_iter().flat_map(|d2| jets.channels().map(move |c| (c, d2))) {
            let all = [
                moments(&jets, c, &m, d2, 2),
                bend(&jets, c, &m, d2, 0.3),
                points(&jets, c, &m, d2),
                edge(jets.dipole(c).sigma, &m, 3, 0.5),
                dropped(&jets, c, &m, d2).powi(2),
            ];
            assert!(all.iter().all(|x| x.is_finite() && *x < 1e37), "{c} {d2}: {all:?}");
        }
    }
}
