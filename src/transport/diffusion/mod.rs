//! Diffusion on the object's own surface: inside, D lap(phi) - sigma_a phi = -Q, and phi + z_b dphi/dn = 0 on the
//! surface. Green's identity turns this into an equation for the light B that leaves,
//!
//! `B(x)/2 + int B(y) [g(x, y)/z_b + dg/dn_y(x, y)] dA(y) = (1/z_b) int g(x, y + l w) weight(y) E(y) dA(y)`,
//!
//! with `g(s) = e^(-k s) / (4 pi s)`, one value a triangle and the equation at its centroid. The stages: `deposit`
//! (where light collides first: y + l w), `near_layers` (the integrals over near triangles), `boundary_integrals` (the
//! right-hand side, or the left-hand side of a vector), `krylov_step` (GMRES: Saad and Schultz 1986) and `krylov_sum`
//! (the solution). The lists of clusters are made as those of blocks are, but for the clusters' areas in place of their
//! light.

pub mod boundary_integrals;
pub mod deposit;
mod far;
pub mod krylov_step;
pub mod krylov_sum;
mod near;
pub mod near_layers;
pub mod sums;

use crate::layout::{GAIN_OF_ONE, LEAST_GAIN, ObjectParams};
use crate::state::stage::{Cpu, Gpu};
use crate::state::{Carrier, Stage};

/// Defaults of a stage of diffusion.
const fn stage(cpu: Cpu, gpu: Gpu) -> Stage {
    Stage { module: "transport/diffusion", carriers: &[Carrier::Diffusion], ..super::stage(cpu, gpu) }
}

/// The medium of one channel.
#[derive(Clone, Copy, Debug)]
pub struct Medium {
    /// k: one over the distance in which diffuse light falls by a factor of e, 1/length.
    pub decay: f64,
    /// z_b, length.
    pub boundary: f64,
}

impl Medium {
    /// The medium of an object in one channel.
    #[must_use]
    pub fn of(params: &ObjectParams, channel: usize) -> Self {
        Self { decay: params.sigma[channel].into(), boundary: params.boundary[channel].into() }
    }

    /// What the integral operator makes of even light on a ball: 1/2 + D + S/z_b, with x = k R, D = (e^-2x - 2 phi)/2,
    /// S = R phi and phi = (1 - e^-2x)/(2x). Above 1 where much light stays inside for long; near 0 where an object is
    /// so thin that light hardly meets its surface: errors of a product then grow in the solution.
    fn of_even_light(self, radius: f64) -> f64 {
        let x = self.decay * radius;
        let phi = if x < 1e-3 { 1.0 - x } else { -(-2.0 * x).exp_m1() / (2.0 * x) };
        let whole = if x < 0.3 { x * x * (1.0 - x + 0.6 * x * x) / 3.0 } else { 0.5 * (1.0 + (-2.0 * x).exp()) - phi };
        whole + radius * phi / self.boundary
    }
}

/// What the integral operator makes of even light on a ball of this area, per channel.
pub(crate) fn even_gain(params: &ObjectParams, area: f64) -> [f64; 3] {
    let radius = (area / (4.0 * std::f64::consts::PI)).sqrt();
    [0, 1, 2].map(|c| Medium::of(params, c).of_even_light(radius))
}

/// The gain that errors of clusters count relative to: what the operator makes of even light on a ball of this area,
/// the least over the channels, divided by `GAIN_OF_ONE` and clamped to `LEAST_GAIN` to 1.
pub(crate) fn layer_gain(params: &ObjectParams, area: f64) -> f64 {
    let least = even_gain(params, area).into_iter().fold(f64::INFINITY, f64::min);
    (least / f64::from(GAIN_OF_ONE)).clamp(f64::from(LEAST_GAIN), 1.0)
}
