//! sigma_0 of the CDRF from balls of a material: the light that leaves them by the dipole, and the sigma_0 that fits
//! best (Kubo et al. 2010, section 4.2 and figure 6).
//!
//! A ball in parallel light: at an angle theta from the light, max(cos theta, 0) enters and B(theta) leaves, relative
//! to the light that leaves a plane under normal incidence. The CDRF predicts f(theta, sigma_0 / r).

pub mod dipole;
pub mod fit;
pub mod usual;

use std::f64::consts::PI;

/// Number of angles: the midpoints of equal parts of 0 to pi.
pub const ANGLES: usize = 36;

/// Angle `k`, radian.
#[must_use]
pub fn angle(k: usize) -> f64 {
    PI * (k as f64 + 0.5) / ANGLES as f64
}

/// Light that leaves a ball, relative to the light that leaves a plane under normal incidence.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    /// The ball's radius, length.
    pub radius: f64,
    /// The value at each angle.
    pub values: Vec<f64>,
    /// Its standard error; zero for the dipole.
    pub errors: Vec<f64>,
}

/// Radii of the balls that sigma_0 is fitted to, in mean free paths.
pub const PATHS: [f64; 6] = [2.0, 5.0, 10.0, 20.0, 50.0, 100.0];

/// Largest factor, either way, between the averaged mean free path and the channel's own.
const APART: f64 = 4.0;

/// Radii of the balls for a channel: [`PATHS`] times the mean free path averaged over the channels, since all channels
/// light the same object. Where the channel's own mean free path is much longer or shorter, the average is clamped to a
/// factor of 4 of it: far larger balls would tell nothing about the channel.
#[must_use]
pub fn radii(mean_paths: [f64; 3], channel: usize) -> [f64; 6] {
    let own = mean_paths[channel];
    let mean = mean_paths.iter().map(|path| path / 3.0).sum::<f64>().clamp(own / APART, own * APART);
    PATHS.map(|paths| paths * mean)
}
