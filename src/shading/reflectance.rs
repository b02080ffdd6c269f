//! The curvature-dependent reflectance function (CDRF), equation 1 of Kubo et al. 2010, in `f64`: the reference that
//! the kernels are tested against.
//!
//! `f(theta, sigma)` is max(cos, 0) on the circle, convolved with a Gaussian of standard deviation `sigma = sigma_0
//! kappa` in the angle: light that arrives at one point of a circle of curvature kappa leaves around it. The cosine
//! is periodic: a Gaussian wider than the circle wraps around, so that no light is lost, and f tends to 1 / pi.

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::sync::OnceLock;

use crate::dipole::form_factor::gauss::{Node, legendre};

/// From this sigma on, the cosine series needs few terms; below it, quadrature over the Gaussian needs few nodes.
const WIDE: f64 = 0.5;
/// Where the Gaussian is truncated, in standard deviations: 3e-12 of it lies beyond.
const FAR: f64 = 7.0;
/// Terms of the series: from [`WIDE`] on, the rest is below 1e-17.
const TERMS: i32 = 9;
/// Nodes of the quadrature.
const NODES: usize = 40;

/// f at a cosine from -1 to 1 and a standard deviation of at least 0, radian; from 0 to 1. The error is below 1e-9.
#[must_use]
pub fn cdrf(cosine: f64, sigma: f64) -> f64 {
    let cosine = cosine.clamp(-1.0, 1.0);
    if sigma == 0.0 {
        return cosine.max(0.0);
    }
    let theta = cosine.acos();
    if sigma >= WIDE {
        let sum: f64 = (1..=TERMS).map(|n| term(n, sigma) * (f64::from(2 * n) * theta).cos()).sum();
        return (1.0 / PI + 0.5 * (-0.5 * sigma * sigma).exp() * cosine + 2.0 / PI * sum).max(0.0);
    }
    // The lit half of the circle, and of its neighbouring periods.
    [-TAU, 0.0, TAU].into_iter().map(|turn| lobe(theta - turn, sigma)).sum()
}

/// (-1)^(n+1) / (4 n^2 - 1) e^(-2 n^2 sigma^2): coefficient of the even cosines in the blurred max(cos, 0).
fn term(n: i32, sigma: f64) -> f64 {
    let square = f64::from(n * n);
    let sign = if n % 2 == 0 { -1.0 } else { 1.0 };
    sign / (4.0 * square - 1.0) * (-2.0 * square * sigma * sigma).exp()
}

/// The integral of cos t times the Gaussian about `theta` over the part of -pi/2 to pi/2 that it reaches.
fn lobe(theta: f64, sigma: f64) -> f64 {
    static RULE: OnceLock<Vec<Node>> = OnceLock::new();
    let rule = RULE.get_or_init(|| legendre(NODES));
    // Limits in standard deviations from theta: they stay distinct however small sigma is.
    let (low, high) = (((-FRAC_PI_2 - theta) / sigma).max(-FAR), ((FRAC_PI_2 - theta) / sigma).min(FAR));
    if low >= high {
        return 0.0;
    }
    let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
    let at = |node: &Node| {
        let t = middle + half * node.x;
        node.weight * (theta + sigma * t).cos() * (-0.5 * t * t).exp()
    };
    half * rule.iter().map(at).sum::<f64>() / TAU.sqrt()
}

/// Factors by which the CDRF multiplies degrees 0, 1 and 2 of the environment's spherical harmonics: 2 pi times the
/// integrals of f(mu) P_l(mu) over mu from -1 to 1. At sigma 0 they are Lambert's: pi, 2 pi / 3 and pi / 4.
#[must_use]
pub fn zonal(sigma: f64) -> [f64; 3] {
    // The integral of cos(2 n t) sin t over t from 0 to pi, and that of the same times P_2 = (1 + 3 cos 2 t) / 4.
    let plain = |n: i32| -2.0 / (4.0 * f64::from(n * n) - 1.0);
    let second = |n: i32| 0.25 * (plain(n) + 1.5 * (plain(n + 1) + plain(n - 1)));
    // At sigma 0 the terms fall as n^-4 with alternating signs.
    let sum = |integral: &dyn Fn(i32) -> f64| 4.0 * (1..=96).map(|n| term(n, sigma) * integral(n)).sum::<f64>();
    [4.0 + sum(&plain), TAU / 3.0 * (-0.5 * sigma * sigma).exp(), sum(&second)]
}

/// Energy reflected by a ball relative to Lambert's cosine: rho(sigma), from 1 to 4 / pi. The CDRF blurs along a
/// circle; over a ball that gains energy, which the paper does not mention.
#[must_use]
pub fn gain(sigma: f64) -> f64 {
    zonal(sigma)[0] / PI
}

#[cfg(test)]
mod tests {
    use crate::shading::reflectance::*;

    /// The convolution by Simpson's rule, over five turns.
    fn convolution(theta: f64, sigma: f64) -> f64 {
        let panels = 200_000;
        let step = 5.0 * TAU / f64::from(panels);
        let at = |i: i32| {
            let t = -2.5 * TAU + step * f64::from(i);
            let weight = if i == 0 || i == panels {
                1.0
            } else if i % 2 == 1 {
                4.0
            } else {
                2.0
            };
            weight * t.cos().max(0.0) * (-0.5 * ((t - theta) / sigma).powi(2)).exp()
        };
        (0..=panels).map(at).sum::<f64>() * step / 3.0 / (TAU.sqrt() * sigma)
    }

    #[test]
    fn it_is_the_convolution() {
        for sigma in [0.01, 0.1, 0.3, 0.49, 0.5, 0.7, 1.0, 1.6, 2.2] {
            for theta in [0.0, 0.4, 1.2, 1.5, FRAC_PI_2, 1.7, 2.5, PI] {
                let (found, expected) = (cdrf(theta.cos(), sigma), convolution(theta, sigma));
                assert!((found - expected).abs() < 2e-9, "{sigma} {theta}: {found} {expected}");
            }
        }
    }

    #[test]
    fn its_ends_are_lambert_and_a_third() {
        for cosine in [-1.0, -0.3, 0.0, 0.2, 1.0] {
            assert_eq!(cdrf(cosine, 0.0), f64::max(cosine, 0.0));
            for sigma in [1e-7, 1e-12, 1e-16, 1e-17, 3e-17, 5e-324] {
                let found = cdrf(cosine, sigma);
                assert!((found - f64::max(cosine, 0.0)).abs() < 1e-9 + sigma, "{cosine} {sigma}: {found}");
            }
            assert!((cdrf(cosine, 1e30) - 1.0 / PI).abs() < 1e-15);
        }
        // At the terminator sigma / sqrt(2 pi), to second order.
        assert!((cdrf(0.0, 1e-3) - 1e-3 / TAU.sqrt()).abs() < 1e-9);
        // No light is lost: the mean over the circle is 1 / pi.
        for sigma in [0.05, 0.4, 0.8, 3.0] {
            let mean =
                (0..4000).map(|k| cdrf((TAU * (f64::from(k) + 0.5) / 4000.0).cos(), sigma)).sum::<f64>() / 4000.0;
            assert!((mean - 1.0 / PI).abs() < 1e-6, "{sigma}: {mean}");
        }
    }

    #[test]
    fn harmonics_are_integrals_of_it() {
        for (found, expected) in zonal(0.0).into_iter().zip([PI, TAU / 3.0, PI / 4.0]) {
            assert!((found - expected).abs() < 1e-7, "{found} {expected}");
        }
        for sigma in [0.1, 0.4, 1.0, 2.5] {
            let steps = 20_000;
            let mut sums = [0.0; 3];
            for k in 0..steps {
                let mu = -1.0 + 2.0 * (f64::from(k) + 0.5) / f64::from(steps);
                let value = cdrf(mu, sigma) * TAU * 2.0 / f64::from(steps);
                for (sum, legendre) in sums.iter_mut().zip([1.0, mu, 1.5 * mu * mu - 0.5]) {
                    *sum += value * legendre;
                }
            }
            for (found, expected) in zonal(sigma).into_iter().zip(sums) {
                assert!((found - expected).abs() < 2e-6, "{sigma}: {found} {expected}");
            }
        }
        for (sigma, known) in [(0.1, 1.005), (0.3, 1.042), (0.5, 1.103), (1.0, 1.235), (1.5, 1.270)] {
            assert!((gain(sigma) - known).abs() < 6e-4, "{sigma}: {}", gain(sigma));
        }
    }
}
