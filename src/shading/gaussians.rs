//! A sum of Gaussians in place of the dipole's profile (d'Eon et al. 2007, section 4). All channels share the widths,
//! so that they are blurred together; weights are per channel.
//!
//! G(v, r) = e^(-r^2 / 2v) / (2 pi v). Weights are at least 0 and add up to the profile's total, so that uniform
//! light on a plane gives the right radiosity. They are a least-squares fit of r^2 R_d over the logarithm of r. The
//! widths are a geometric sequence, chosen for the best fit. The residual is the integral of |R_d - sum of w G| over
//! the plane, as a share of the total: it bounds the error for any irradiance between 0 and 1.

use std::f64::consts::{PI, TAU};

use crate::dipole::profile::Dipole;

pub use crate::layout::GAUSSIANS;

/// Radii at which the fit is evaluated.
const RADII: usize = 160;
/// Most iterations of the least squares: the constraint on the sum makes them converge slowly.
const ROUNDS: usize = 4000;
/// The share of the light that may leave beyond the last radius.
const BEYOND: f64 = 1e-3;
/// The largest standard deviation, in internal units, where the scene has unit extent.
const WIDEST: f64 = 1e6;

/// A fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Gaussians {
    /// Variances, length^2, ascending.
    pub variances: [f64; GAUSSIANS],
    /// Weights by channel, at least 0.
    pub weights: [[f64; GAUSSIANS]; 3],
    /// Residual by channel, as a share of the channel's total reflectance.
    pub residual: [f64; 3],
}

/// The integral of a channel's profile over the plane beyond the distance `r`.
fn beyond(dipole: &Dipole, r: f64) -> f64 {
    let source = |z: f64| {
        let s = r.hypot(z);
        TAU * dipole.strength * z * (-dipole.sigma * s).exp() / s
    };
    dipole.depths().into_iter().map(source).sum()
}

/// One channel's profile at the radii, times r^2, divided by its total.
struct Target {
    values: Vec<f64>,
    total: f64,
}

/// One channel's weights for these variances, as shares of the total, and the remaining sum of squares.
fn weigh(radii: &[f64], target: &Target, variances: &[f64; GAUSSIANS]) -> ([f64; GAUSSIANS], f64) {
    let rows: Vec<[f64; GAUSSIANS]> =
        radii.iter().map(|r| variances.map(|v| r * r * (-r * r / (2.0 * v)).exp() / (TAU * v))).collect();
    let sum = |term: &dyn Fn(usize) -> f64| (0..rows.len()).map(term).sum::<f64>();
    // The constraint on the sum of weights counts a thousand times as much as all radii together.
    let whole = 1e3 * sum(&|k| target.values[k].powi(2)).max(f64::MIN_POSITIVE);
    let gram: [[f64; GAUSSIANS]; GAUSSIANS] =
        std::array::from_fn(|i| std::array::from_fn(|j| sum(&|k| rows[k][i] * rows[k][j]) + whole));
    let right: [f64; GAUSSIANS] = std::array::from_fn(|i| sum(&|k| rows[k][i] * target.values[k]) + whole);
    let mut weights = [1.0 / GAUSSIANS as f64; GAUSSIANS];
    for _ in 0..ROUNDS {
        let before = weights;
        for i in 0..GAUSSIANS {
            let rest: f64 = (0..GAUSSIANS).filter(|&j| j != i).map(|j| gram[i][j] * weights[j]).sum();
            weights[i] = ((right[i] - rest) / gram[i][i]).max(0.0);
        }
        if before.iter().zip(weights).all(|(before, now)| (before - now).abs() < 1e-7) {
            break;
        }
    }
    let all: f64 = weights.iter().sum();
    let weights = weights.map(|weight| weight / all.max(f64::MIN_POSITIVE));
    let value = |k: usize| rows[k].iter().zip(weights).map(|(g, weight)| g * weight).sum::<f64>();
    (weights, sum(&|k| (value(k) - target.values[k]).powi(2)))
}

/// The fit to a material's profiles; a black channel has zero weights.
#[must_use]
pub fn fit(dipoles: &[Dipole; 3]) -> Gaussians {
    let bright = |dipole: &&Dipole| dipole.strength > 0.0;
    let nearest = dipoles.iter().map(|dipole| dipole.z_real).fold(f64::INFINITY, f64::min);
    let far = |dipole: &Dipole| {
        let mut r = dipole.z_real;
        while beyond(dipole, r) > BEYOND * dipole.total() && r < 1e3 * dipole.z_real {
            r *= 1.1;
        }
        r
    };
    let farthest = dipoles.iter().filter(bright).map(far).fold(10.0 * nearest, f64::max);
    let (low, high) = ((0.02 * nearest).ln(), farthest.ln());
    let step = (high - low) / (RADII - 1) as f64;
    let radii: Vec<f64> = (0..RADII).map(|k| (low + step * k as f64).exp()).collect();
    let targets = dipoles.each_ref().map(|dipole| {
        let total = dipole.total();
        let value = |r: &f64| if total > 0.0 { r * r * dipole.reflectance(*r) / total } else { 0.0 };
        Target { values: radii.iter().map(value).collect(), total }
    });
    let used: Vec<&Target> = targets.iter().filter(|target| target.total > 0.0).collect();

    // Standard deviations of the first and the last Gaussian: the best of a grid, then of finer grids around it.
    let variances = |[first, last]: [f64; 2]| -> [f64; GAUSSIANS] {
        std::array::from_fn(|k| (2.0 * (first + (last - first) * k as f64 / (GAUSSIANS - 1) as f64)).exp())
    };
    let left = |ends: [f64; 2]| used.iter().map(|target| weigh(&radii, target, &variances(ends)).1).sum::<f64>();
    let (mut best, mut span) = ([nearest.ln(), farthest.ln() - 1.0], [1.5, 1.5]);
    for _ in 0..6 {
        let around = |axis: usize, k: i32| best[axis] + span[axis] * f64::from(k) / 3.0;
        let grid = (-3..=3).flat_map(|i| (-3..=3).map(move |j| (i, j)));
        let places: Vec<[f64; 2]> = grid.map(|(i, j)| [around(0, i), around(1, j)]).collect();
        let rising = places.into_iter().filter(|ends| ends[1] > ends[0] + 0.5);
        let found = rising.map(|ends| (left(ends), ends)).min_by(|a, b| a.0.total_cmp(&b.0));
        best = found.map_or(best, |(_, ends)| ends);
        span = span.map(|span| 0.45 * span);
    }
    let variances = variances(best);
    let (mut weights, mut residual) = ([[0.0; GAUSSIANS]; 3], [0.0; 3]);
    for (c, target) in targets.iter().enumerate().filter(|(_, target)| target.total > 0.0) {
        let shares = weigh(&radii, target, &variances).0;
        weights[c] = shares.map(|share| share * target.total);
        let apart = |(r, value): (&f64, &f64)| {
            let sum = |(v, share): (&f64, f64)| share * r * r * (-r * r / (2.0 * v)).exp() / (TAU * v);
            TAU * step * (variances.iter().zip(shares).map(sum).sum::<f64>() - value).abs()
        };
        residual[c] =
            radii.iter().zip(&target.values).map(apart).sum::<f64>() + beyond(&dipoles[c], farthest) / target.total;
    }
    Gaussians { variances, weights, residual }
}

impl Gaussians {
    /// Device records: a weight per channel, and the standard deviation that each Gaussian adds to the one before.
    #[must_use]
    pub fn records(&self) -> [[f32; 4]; GAUSSIANS] {
        std::array::from_fn(|k| {
            let before = if k == 0 { 0.0 } else { self.variances[k - 1] };
            let weight = self.weights.map(|weights| weights[k] as f32);
            [weight[0], weight[1], weight[2], (self.variances[k] - before).sqrt().min(WIDEST) as f32]
        })
    }

    /// One channel's light at a signed distance from a straight edge of uniform light, positive on the lit side: the
    /// result of an ideal blur.
    #[must_use]
    pub fn edge(&self, channel: usize, distance: f64) -> f64 {
        let term = |(weight, v): (&f64, &f64)| weight * normal(distance / v.sqrt());
        self.weights[channel].iter().zip(&self.variances).map(term).sum()
    }
}

/// The standard normal distribution function, by Simpson's rule; within 1e-9.
fn normal(x: f64) -> f64 {
    let (end, panels) = (x.clamp(-9.0, 9.0), 400);
    let step = (end + 9.0) / f64::from(panels);
    let at = |k: i32| {
        let t = -9.0 + step * f64::from(k);
        let weight = if k == 0 || k == panels { 1.0 } else { f64::from(2 + 2 * (k % 2)) };
        weight * (-0.5 * t * t).exp()
    };
    (0..=panels).map(at).sum::<f64>() * step / 3.0 / (2.0 * PI).sqrt()
}

#[cfg(test)]
mod tests {
    use crate::shading::gaussians::*;

    #[test]
    fn the_fit_keeps_the_total_and_is_near_the_profile() {
        // Marble, and a material that hardly absorbs.
        let marble = [(2.19, 0.0021), (2.62, 0.0041), (3.0, 0.0071)].map(|(s, a)| Dipole::new(s, a, 3.96));
        let milk = [Dipole::new(2.55, 0.0011, 2.8), Dipole::new(0.0, 0.4, 2.8), Dipole::new(3.77, 0.014, 2.8)];
        for (dipoles, bound) in [(marble, 0.03), (milk, 0.03)] {
            let found = fit(&dipoles);
            assert!(found.variances.windows(2).all(|pair| pair[1] > pair[0]));
            for (c, dipole) in dipoles.iter().enumerate() {
                let sum: f64 = found.weights[c].iter().sum();
                assert!((sum - dipole.total()).abs() < 1e-12 + 1e-9 * sum, "{c}: {sum} {}", dipole.total());
                assert!(found.residual[c] < bound, "{c}: {:?}", found.residual);
            }
        }
    }

    #[test]
    fn what_is_a_sum_of_gaussians_has_its_edge() {
        let found = fit(&[Dipole::new(2.0, 0.05, 3.0); 3]);
        let whole = Dipole::new(2.0, 0.05, 3.0).total();
        assert!((found.edge(1, 0.0) - 0.5 * whole).abs() < 1e-9);
        assert!((found.edge(1, 50.0) - whole).abs() < 1e-9 && found.edge(1, -50.0) < 1e-9);
        assert!((normal(1.0) - 0.841_344_746).abs() < 1e-8);
    }
}
