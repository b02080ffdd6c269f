//! Which rule will do for a triangle at a distance, decided before anything is integrated.
//!
//! One number foretells the error of every area rule: `chi = tau q2(sigma s) / (2 s^2)`, the leading
//! term of the midpoint rule's relative error without its sign. `tau` is the trace of the triangle's
//! second moment, `s` the distance from the source to the centroid, and `q2` comes from the second
//! derivative of `p(s) = (1 + sigma s) e^(-sigma s) / s^3`. `chi` falls as `s` grows, so that each
//! threshold is one radius: the choice at run time is a comparison of squared distances.

use crate::transport::profile::Dipole;

/// Number of area rules on the ladder: midpoint with moment, 3, 6 and 12 points.
pub const RUNGS: usize = 4;

/// Tolerances of the table below, as powers of ten.
const POWERS: [f64; 4] = [-4.0, -3.0, -2.0, -1.0];

/// Largest `chi` for each rule at each tolerance: the 99th percentile of the relative error of
/// well-shaped triangles stays within it. The last row, for 0.1, is a modest extrapolation: its 99th
/// percentile is 0.03, since beyond it the area rules can be wrong by far more than their law says.
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
    /// `tolerance` from 1e-4 to 1e-1, interpolated between powers of ten in the logarithm; outside
    /// that range the nearest end is used (below 1e-4 the rungs then keep an error of 1e-4).
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

/// For each rung the squared distance, point to centroid, from which it will do: length^2.
///
/// It holds for all three channels and, in the radial convention, for both sources (the real one,
/// being nearer, decides). The values fall from rung to rung. 0: the rung will do everywhere.
/// Infinity: nowhere, which happens where the triangle is so large against `1/sigma` that the
/// exponential varies over it at any distance (`sigma^2 tau > 2 chi`).
#[must_use]
pub fn reach(tau: f64, dipole: &[Dipole; 3], ladder: &Ladder) -> [f64; RUNGS] {
    ladder.chi.map(|chi| {
        let one = |d: &Dipole| (source_reach(tau, d.sigma, chi) - d.z_real * d.z_real).max(0.0);
        dipole.iter().map(one).fold(0.0, f64::max)
    })
}

/// The first rung that will do at the squared distance `d2`, or [`RUNGS`] for the edge form.
#[must_use]
pub fn rung(d2: f64, reach: &[f64; RUNGS]) -> usize {
    reach.iter().position(|&least| d2 >= least).unwrap_or(RUNGS)
}

/// The squared distance `s^2` from a source at which `chi` falls to `limit`.
fn source_reach(tau: f64, sigma: f64, limit: f64) -> f64 {
    if tau <= 0.0 {
        return 0.0;
    }
    // With k = 2 limit / (tau sigma^2) the condition is q2(a) = k a^2; q2/a^2 falls to 1.
    let k = 2.0 * limit / (tau * sigma * sigma);
    if k <= 1.0 {
        return f64::INFINITY;
    }
    // So little extinction that q2 = 15.
    if k > 1e32 {
        return 7.5 * tau / limit;
    }
    // The one positive root of (k-1) a^3 + (k-6) a^2 - 15 a - 15, by Newton's method from the root
    // of q2 <= a^2 + 5 a + 15: the cubic is convex from its root on, so the steps only go down.
    let m = k - 1.0;
    let mut a = (5.0 + (25.0 + 60.0 * m).sqrt()) / (2.0 * m);
    for _ in 0..64 {
        let value = ((m * a + (k - 6.0)) * a - 15.0) * a - 15.0;
        let slope = (3.0 * m * a + 2.0 * (k - 6.0)) * a - 15.0;
        let next = a - value / slope;
        if next.is_nan() || next >= a {
            break;
        }
        a = next;
    }
    (a / sigma) * (a / sigma)
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

    #[test]
    fn chi_is_at_its_limit_at_the_reach() {
        for sigma in [1e-17, 1e-6, 1e-3, 0.1, 1.0, 1.4, 1.99999] {
            for limit in [0.008, 0.1, 1.0] {
                let s2 = source_reach(limit * 0.5, sigma, limit);
                assert!((chi(limit * 0.5, sigma, s2.sqrt()) / limit - 1.0).abs() < 1e-12, "{sigma}");
            }
        }
        assert_eq!(source_reach(1.0, 2.0, 2.0), f64::INFINITY);
        assert_eq!(source_reach(1.0, 0.0, 0.1), 75.0);
    }

    #[test]
    fn edge_cases_of_the_reach() {
        let dipole = [Dipole::new(1.0, 0.0, 2.6), Dipole::new(1.0, 1e-4, 2.6), Dipole::new(2.0, 0.0, 2.6)];
        let ladder = Ladder::new(1e-3);
        assert_eq!(reach(0.0, &dipole, &ladder), [0.0; RUNGS]);
        assert_eq!(rung(0.0, &reach(0.0, &dipole, &ladder)), 0);
        let some = reach(0.5, &dipole, &ladder);
        assert!(some.is_sorted_by(|a, b| a >= b));
        assert_eq!(rung(some[1], &some), 1);
        assert_eq!(rung(some[3].next_down(), &some), RUNGS);
        assert_eq!(reach(1e9, &dipole, &ladder), [f64::INFINITY; RUNGS]);
    }
}
