//! Fit of sigma_0: the value whose f comes closest to the light that leaves balls of several radii, weighted by
//! surface area.

use super::{Curve, angle};
use crate::shading::reflectance::cdrf;

/// The result of a fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fit {
    /// sigma_0, length.
    pub sigma_0: f64,
    /// The factor on f.
    pub scale: f64,
    /// Root mean square residual, relative to the light that leaves a plane under normal incidence.
    pub residual: f64,
    /// Largest residual, in the same unit.
    pub worst: f64,
}

/// For each angle of each curve: the weight by surface area, f at this sigma_0, and the curve's value.
fn parts(curves: &[Curve], sigma_0: f64) -> impl Iterator<Item = (f64, f64, f64)> + '_ {
    let curve_parts = move |curve: &Curve| {
        let (sigma, count) = (sigma_0 / curve.radius, curve.values.len());
        let part = move |k: usize| (angle(k).sin(), cdrf(angle(k).cos(), sigma));
        curve.values.clone().into_iter().zip((0..count).map(part)).map(|(value, (share, f))| (share, f, value))
    };
    curves.iter().flat_map(curve_parts)
}

/// The residuals at a sigma_0, with f scaled by 1 or, if `free`, by the best factor.
fn at(curves: &[Curve], sigma_0: f64, free: bool) -> Fit {
    let all: Vec<_> = parts(curves, sigma_0).collect();
    let sum = |term: &dyn Fn(&(f64, f64, f64)) -> f64| all.iter().map(term).sum::<f64>();
    let scale = if free { sum(&|(w, f, b)| w * f * b) / sum(&|(w, f, _)| w * f * f) } else { 1.0 };
    let squares = sum(&|(w, f, b)| w * (scale * f - b).powi(2)) / sum(&|(w, ..)| *w);
    let worst = all.iter().map(|(_, f, b)| (scale * f - b).abs()).fold(0.0, f64::max);
    Fit { sigma_0, scale, residual: squares.sqrt(), worst }
}

/// The best sigma_0 for all curves together; `length` is an initial guess, right within a factor of a thousand.
#[must_use]
pub fn fit(curves: &[Curve], length: f64, free: bool) -> Fit {
    let left = |log: f64| at(curves, log.exp(), free).residual;
    // The minimum on a coarse logarithmic grid, then golden-section search around it.
    let step = 0.25;
    let place = |k: i32| length.ln() + step * f64::from(k);
    let near = (-28..=28).map(place).min_by(|a, b| left(*a).total_cmp(&left(*b))).unwrap_or(0.0);
    let golden = 0.5 * (5f64.sqrt() - 1.0);
    let (mut low, mut high) = (near - step, near + step);
    for _ in 0..40 {
        let (a, b) = (high - golden * (high - low), low + golden * (high - low));
        if left(a) < left(b) { high = b } else { low = a }
    }
    at(curves, (0.5 * (low + high)).exp(), free)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shading::balls::ANGLES;

    #[test]
    fn what_is_a_cdrf_is_found() {
        let curve = |radius: f64| Curve {
            radius,
            values: (0..ANGLES).map(|k| 1.2 * cdrf(angle(k).cos(), 0.7 / radius)).collect(),
            errors: vec![0.0; ANGLES],
        };
        let found = fit(&[curve(1.0), curve(3.0), curve(9.0)], 2.0, true);
        assert!((found.sigma_0 - 0.7).abs() < 1e-5 && (found.scale - 1.2).abs() < 1e-5, "{found:?}");
        assert!(found.residual < 1e-5 && found.worst < 1e-4, "{found:?}");
        let off = Curve { values: vec![1.0; ANGLES], ..curve(2.0) };
        let off = fit(&[off], 2.0, false);
        assert!(off.residual > 0.3 && off.scale == 1.0);
    }
}
