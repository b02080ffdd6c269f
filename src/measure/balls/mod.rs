//! sigma_0 of the CDRF from balls of a material: how light goes round them by the dipole and by a random walk, and
//! which sigma_0 comes nearest (Kubo et al. 2010, section 4.2 and figure 6).
//!
//! A ball in parallel light: at an angle theta from where the light stands overhead max(cos theta, 0) enters, of which
//! B(theta) leaves, as a share of what would leave a plane. The CDRF says f(theta, sigma_0 / r).

pub mod dipole;
pub mod fit;
pub mod plot;
pub mod walk;

use std::f64::consts::PI;

/// Angles that are looked at: the middles of this many equal parts of half a turn.
pub const ANGLES: usize = 36;

/// Angle `k`, radian.
#[must_use]
pub fn angle(k: usize) -> f64 {
    PI * (k as f64 + 0.5) / ANGLES as f64
}

/// Light that leaves a ball, as a share of what leaves a plane in full light.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// The ball's radius, length.
    pub radius: f64,
    /// The share at each angle.
    pub values: Vec<f64>,
    /// Its standard error; zeros where nothing is drawn at random.
    pub errors: Vec<f64>,
}
