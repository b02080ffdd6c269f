//! sigma_0 of the CDRF from balls of a material: the light that leaves them by the dipole and by a random walk, and
//! the sigma_0 that fits best (Kubo et al. 2010, section 4.2 and figure 6).
//!
//! A ball in parallel light: at an angle theta from the light, max(cos theta, 0) enters and B(theta) leaves, relative
//! to what leaves a plane under normal incidence. The CDRF predicts f(theta, sigma_0 / r).

pub mod dipole;
pub mod fit;
pub mod plot;
pub mod walk;

use std::f64::consts::PI;

/// Number of angles: the midpoints of equal parts of 0 to pi.
pub const ANGLES: usize = 36;

/// Angle `k`, radian.
#[must_use]
pub fn angle(k: usize) -> f64 {
    PI * (k as f64 + 0.5) / ANGLES as f64
}

/// Light that leaves a ball, relative to what leaves a plane under normal incidence.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// The ball's radius, length.
    pub radius: f64,
    /// The value at each angle.
    pub values: Vec<f64>,
    /// Its standard error; zero for the dipole.
    pub errors: Vec<f64>,
}
