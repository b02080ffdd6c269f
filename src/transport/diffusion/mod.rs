//! Diffusion on the object's own surface: inside, D lap(phi) - sigma_a phi = -Q, and phi + z_b dphi/dn = 0 on the
//! surface. Green's identity makes of it an equation for the light B that leaves,
//!
//! `B(x)/2 + int B(y) [g(x, y)/z_b + dg/dn_y(x, y)] dA(y) = (1/z_b) int g(x, y + l w) weight(y) E(y) dA(y)`,
//!
//! with `g(s) = e^(-k s) / (4 pi s)`, one value a triangle and the equation at its centroid. The stages: `deposit`
//! (where light collides first: y + l w), `boundary_integrals` (the right-hand side, or the left-hand side of a
//! vector), `krylov_step` (GMRES: Saad and Schultz 1986) and `krylov_sum` (the solution). Lists of clusters are those
//! of blocks, by area.

pub mod boundary_integrals;
pub mod deposit;
mod far;
pub mod krylov_step;
pub mod krylov_sum;
mod near;
pub mod sums;

use crate::layout::ObjectParams;

/// The medium of one channel.
#[derive(Clone, Copy, Debug)]
pub struct Medium {
    /// k: one over the distance over which diffuse light falls by e, 1/length.
    pub decay: f64,
    /// z_b, length.
    pub boundary: f64,
}

impl Medium {
    /// Of a channel of an object.
    #[must_use]
    pub fn of(params: &ObjectParams, channel: usize) -> Self {
        Self { decay: params.sigma[channel].into(), boundary: params.boundary[channel].into() }
    }
}
