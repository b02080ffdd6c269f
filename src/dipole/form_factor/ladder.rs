//! Selects the quadrature rule for a triangle at a distance, before anything is integrated.
//!
//! One number predicts the error of every area rule: `chi = tau q2(sigma s) / (2 s^2)`, the magnitude of the leading
//! term of the midpoint rule's relative error. `tau` is the trace of the triangle's second moment, `s` the distance
//! from the source to the centroid, and `q2` comes from the second derivative of
//! `p(s) = (1 + sigma s) e^(-sigma s) / s^3`. `chi` falls as `s` grows, so each threshold is one radius: the choice
//! at run time is a comparison of squared distances.

use crate::layout::{FAINTEST, FARTHEST};

/// Number of area rules on the ladder: midpoint with moment, 3, 6 and 12 points.
pub const RUNGS: usize = 4;

/// Tolerances of the table below, as powers of ten.
const POWERS: [f64; 4] = [-4.0, -3.0, -2.0, -1.0];

/// Largest `chi` for each rule at each tolerance: the 99th percentile of the relative error of well-shaped triangles
/// stays within the tolerance. The last row, for 0.1, is a modest extrapolation: its 99th percentile is 0.03, because
/// with a larger `chi` the errors of the area rules can be much larger than predicted.
const LARGEST: [[f64; RUNGS]; 4] =
    [[0.007, 0.017, 0.12, 0.35], [0.025, 0.06, 0.3, 0.7], [0.1, 0.3, 0.6, 0.9], [0.3, 0.7, 1.0, 1.2]];

/// How large `chi` may be for each area rule.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ladder {
    /// Thresholds in rising order: midpoint with moment, 3, 6, 12 points. No unit, positive.
    pub chi: [f64; RUNGS],
}

impl Ladder {
    /// The ladder for a relative error of the form factor.
    ///
    /// `tolerance` from 1e-4 to 1e-1, interpolated between powers of ten in the logarithm; outside that range the
    /// nearest end is used (for tolerances below 1e-4 the error of the rules remains 1e-4).
    #[must_use]
    pub fn new(tolerance: f64) -> Self {
        let power = tolerance.max(1e-4).log10().min(POWERS[3]);
        let row = POWERS[1..3].iter().filter(|&&p| power >= p).count();
        let part = power - POWERS[row];
        let between = |a: f64, b: f64| (a.ln() * (1.0 - part) + b.ln() * part).exp();
        let mut chi = [0.0; RUNGS];
        for (k, chi) in chi.iter_mut().enumerate() {
            *chi = between(LARGEST[row][k], LARGEST[row + 1][k]);
        }
        Self { chi }
    }
}

/// `q2(a) = (15 + 15 a + 6 a^2 + a^3) / (1 + a)` of `a = sigma s` >= 0.
#[must_use]
pub fn q2(a: f64) -> f64 {
    (15.0 + a * (15.0 + a * (6.0 + a))) / (1.0 + a)
}

/// `chi` of a triangle with second-moment trace `tau`, length^2, at the distance `s` > 0.
#[must_use]
pub fn chi(tau: f64, sigma: f64, s: f64) -> f64 {
    tau * q2(sigma * s) / (2.0 * s * s)
}

/// Distance between source and centroid beyond which `chi` stays below `limit` in every channel, with
/// q2(a) <= 15 + 5a + a^2; at most 4, four times an object's extent. A channel counts up to sigma s = 20 (e^-20 =
/// 2e-9).
#[must_use]
pub fn chi_distance(tau: f64, sigma: [f64; 3], limit: f64) -> f64 {
    let channel = |sigma: f64| {
        let k = 2.0 * limit / tau.max(1e-30) - sigma * sigma;
        let s = if k > 0.0 { (5.0 * sigma + (25.0 * sigma * sigma + 60.0 * k).sqrt()) / (2.0 * k) } else { FARTHEST };
        s.min(if sigma > 0.0 { FAINTEST / sigma } else { FARTHEST }).min(FARTHEST)
    };
    sigma.map(channel).into_iter().fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn table_values_come_back() {
        assert!((Ladder::new(1e-3).chi[2] - 0.3).abs() < 1e-12);
        assert_eq!(Ladder::new(1e-9), Ladder::new(1e-4));
        assert_eq!(Ladder::new(5.0), Ladder::new(0.1));
        assert_eq!(Ladder::new(f64::NAN), Ladder::new(1e-4));
        let middle = Ladder::new(10f64.powf(-2.5)).chi[0];
        assert!((middle - (0.1f64 * 0.025).sqrt()).abs() < 1e-12);
    }
}
