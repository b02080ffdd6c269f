//! What the transport may miss at a receiver: the laws of the error estimate, which `gather` sums and `push` closes.
//! `glsl/transport/gather/estimate.glsl` says the same.
//!
//! Each link adds the square of what it may miss: links err to either side. Their laws are those of the oracle, by
//! chi = tau q2(sigma s) / (2 s^2), with three changes. The oracle takes a law at a cluster's nearest point; here it is
//! taken at the centroid and grows by e^(sigma sqrt(tau)), since the profile falls by that from one to the other. An
//! expansion for a whole block is of second order in the emitter's spread and the receiver's offset together, so the
//! third order is lost in both: (tau + offset^2)^3 is at most 4 (tau^3 + offset^6), which needs two sums instead of four.
//! And what was dropped is all of one sign, so it adds up before it is squared.

use crate::dipole::jet::Jets;
use crate::layout::Moment;

/// The whole estimate is so many times the root of the squares: links of one cluster may err together.
const SAFETY: f64 = 2.0;
/// Rounding to `f32`, of profile and sums, as a share of the radiosity.
const ROUNDING: f64 = 2e-6;
/// The third order in both spreads, squared, from the two that are summed.
const BOTH: f64 = 4.0;

/// Trace of a cluster's second moments.
fn spread(m: &Moment) -> f64 {
    m.diagonal.iter().copied().map(f64::from).sum()
}

/// What a link by moments of this order misses, squared.
pub fn moments(jets: &Jets, c: usize, m: &Moment, d2: f64, order: u32) -> f64 {
    let chi = jets.unit_chi(c, d2) * spread(m);
    let share = match order {
        2 => 0.2 * chi.powf(1.5),
        1 => chi,
        _ => chi.sqrt(),
    };
    let nearer = (jets.dipole(c).sigma * spread(m).sqrt()).exp();
    (f64::from(m.weight) * jets.at(c, d2).value * share.min(1.0) * nearer).powi(2)
}

/// What an expansion misses at a block's radius, squared.
pub fn bend(jets: &Jets, c: usize, m: &Moment, d2: f64, radius: f64) -> f64 {
    let chi = jets.unit_chi(c, d2) * radius * radius;
    (f64::from(m.weight) * jets.at(c, d2).value * (0.35 * chi.powf(1.5)).min(1.0)).powi(2)
}

/// What a triangle's 6 area points miss, squared.
pub fn points(jets: &Jets, c: usize, m: &Moment, d2: f64) -> f64 {
    let chi = jets.unit_chi(c, d2) * spread(m);
    (f64::from(m.weight) * jets.at(c, d2).value * (0.09 * chi.powi(3)).min(1.0)).powi(2)
}

/// What the edge form of a triangle of this value misses, squared: a share by the nodes of an edge, and by how large the
/// triangle is against the reach of the light in the material (measured: next to exact at 0.1, a few % at 3 and 3 nodes).
pub fn edge(sigma: f64, m: &Moment, nodes: u32, value: f64) -> f64 {
    let size = (sigma * spread(m).sqrt()).min(3.0);
    let share = match nodes {
        3 => 5e-3 * size,
        6 => 4e-4 * size * size,
        _ => 1e-6 * size * size,
    };
    (share * value).powi(2)
}

/// What a dropped cluster would have given: e^(-sigma s) is on average sinh(t)/t times that of the centre, over a line
/// of this spread with t = sigma sqrt(3 tau) for half its length.
pub fn dropped(jets: &Jets, c: usize, m: &Moment, d2: f64) -> f64 {
    let t = jets.dipole(c).sigma * (3.0 * spread(m)).sqrt();
    let grown = if t > 1e-2 { t.sinh() / t } else { 1.0 };
    f64::from(m.weight) * jets.at(c, d2).value * grown
}

/// The estimate of a receiver: from its own squares, those of its block at its centre and its radius, its offset and
/// that radius, its radiosity before it is clamped.
pub fn close(sigma: f64, own: f64, [center, rim]: [f64; 2], [offset, radius]: [f64; 2], sum: f64) -> f64 {
    let nearer = (2.0 * sigma * offset).exp();
    let out = if radius > 0.0 { offset / radius } else { 0.0 };
    let block = BOTH * nearer * (center + rim * out.powi(6));
    SAFETY * (own + block).sqrt() + ROUNDING * sum.abs() + (-sum).max(0.0)
}
