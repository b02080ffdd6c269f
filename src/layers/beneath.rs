//! Single scattering beneath a surface: phase functions, and attenuation along a ray's two legs.

use std::f64::consts::PI;

use glam::DVec3;

use crate::scene::Phase;

/// Phase function: share of light scattered per steradian. `cosine` is between the directions *towards* the light and
/// *towards* the eye, so that light which continues straight on has -1. A `g` above 0 scatters forward.
///
/// `g` is Schlick's k (equation of section 3), or the mean cosine of Henyey and Greenstein. The integral over all
/// directions is 1.
#[must_use]
pub fn phase(henyey: bool, g: f64, cosine: f64) -> f64 {
    let base = if henyey { 1.0 + g * g + 2.0 * g * cosine } else { 1.0 + g * cosine };
    let power = if henyey { base * base.sqrt() } else { base * base };
    (1.0 - g * g) / (4.0 * PI * power)
}

/// The mean cosine of Schlick's phase function: (2 k - (1 - k^2) ln((1 + k) / (1 - k))) / (2 k^2).
#[must_use]
pub fn schlick_mean(k: f64) -> f64 {
    if k.abs() < 1e-2 {
        return k * (2.0 / 3.0 + k * k * (2.0 / 15.0));
    }
    (2.0 * k - (1.0 - k * k) * ((1.0 + k) / (1.0 - k)).ln()) / (2.0 * k * k)
}

/// The parameter of the phase function: for [`Phase::SchlickMean`] the k whose mean cosine is `g`, by bisection.
#[must_use]
pub fn parameter(kind: Phase, g: f64) -> f64 {
    if kind != Phase::SchlickMean {
        return g;
    }
    let (mut low, mut high) = (0.0, 1.0 - 1e-12);
    for _ in 0..60 {
        let middle = f64::midpoint(low, high);
        if schlick_mean(middle) < g.abs() { low = middle } else { high = middle }
    }
    low.copysign(g)
}

/// The integral over s from 0 to 1 of (a + (b - a) s) exp(-(from + (to - from) s)): light that varies linearly from
/// `a` to `b`, attenuated by optical depths that vary linearly.
#[must_use]
pub fn segment(a: f64, b: f64, from: f64, to: f64) -> f64 {
    let d = to - from;
    if d.abs() < 1e-2 {
        // Power series in d, up to the sixth power.
        let (e0, e1) = (0..7).rev().fold((0.0, 0.0), |(e0, e1), k| {
            let k = f64::from(k);
            (1.0 - d / (k + 2.0) * e0, 1.0 / (k + 2.0) - d / (k + 1.0) * e1)
        });
        return (-from).exp() * (a * e0 + (b - a) * e1);
    }
    let (start, end) = ((-from).exp(), (-to).exp());
    a * (start - end) / d + (b - a) * (start - (1.0 + d) * end) / (d * d)
}

/// Optical depth from the surface down to `depth`, divided by the cosine of the crossing. `depths` are those of the
/// layers' interfaces; the last layer continues below its interface (equations 11 and 12, clamped).
#[must_use]
pub fn optical_depth(sigma_t: &[DVec3], depths: impl Fn(usize) -> f64, depth: f64, cosine: f64) -> DVec3 {
    let (mut sum, mut before) = (DVec3::ZERO, 0.0);
    for (layer, &sigma) in sigma_t.iter().enumerate() {
        let bottom = if layer + 1 == sigma_t.len() { depth } else { depths(layer).min(depth) };
        sum += sigma * (bottom - before);
        before = bottom;
    }
    sum / cosine
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn phase_functions_scatter_all_light() {
        for (henyey, g) in [(false, 0.25), (false, 0.8), (true, -0.7), (true, 0.4), (true, 0.0)] {
            let steps = 400_000;
            let at = |i: u32| 2.0 * (f64::from(i) + 0.5) / f64::from(steps) - 1.0;
            let over = |f: &dyn Fn(f64) -> f64| {
                (0..steps).map(|i| f(at(i)) * phase(henyey, g, at(i))).sum::<f64>() * 4.0 * PI / f64::from(steps)
            };
            assert!((over(&|_| 1.0) - 1.0).abs() < 1e-6, "{g}");
            // Unscattered light continues along minus the direction it comes from.
            let mean = over(&|c| -c);
            assert!((mean - if henyey { g } else { schlick_mean(g) }).abs() < 1e-6, "{g}: {mean}");
        }
    }

    #[test]
    fn schlicks_parameter_gives_the_mean_cosine() {
        // Published pairs of k and mean cosine.
        for (k, mean) in [(0.25, 0.169), (0.4, 0.276), (0.8, 0.632)] {
            assert!((schlick_mean(k) - mean).abs() < 1e-3, "{k}");
        }
        assert!((schlick_mean(0.009_999) - schlick_mean(0.010_001)).abs() < 2e-6);
        for g in [-0.6, 0.25, 0.4, 0.8] {
            assert!((schlick_mean(parameter(Phase::SchlickMean, g)) - g).abs() < 1e-9);
            assert_eq!(parameter(Phase::HenyeyGreenstein, g), g);
        }
        let printed = [0.25, 0.4, 0.8].map(|g| (parameter(Phase::SchlickMean, g) * 1e3).round() / 1e3);
        assert_eq!(printed, [0.365, 0.559, 0.921]);
    }

    #[test]
    fn a_segment_is_its_integral() {
        for (a, b, from, to) in
            [(1.0, 1.0, 0.0, 3.0), (2.0, 0.5, 0.3, 0.304), (0.0, 1.0, 1.0, 0.2), (1.0, 3.0, 0.0, 1e3)]
        {
            let steps = 2_000_000;
            let sum: f64 = (0..steps)
                .map(|i| {
                    let s = (f64::from(i) + 0.5) / f64::from(steps);
                    (a + (b - a) * s) * (-(from + (to - from) * s)).exp()
                })
                .sum();
            let (found, expected) = (segment(a, b, from, to), sum / f64::from(steps));
            assert!((found / expected - 1.0).abs() < 1e-6, "{found} {expected}");
        }
        // The series and the closed form agree where they meet.
        let gap = segment(1.0, 0.5, 0.7, 0.709_999_9) - segment(1.0, 0.5, 0.7, 0.710_000_1);
        assert!(gap.abs() < 1e-6, "{gap}");
    }

    #[test]
    fn what_is_above_an_interface_counts_in_full() {
        let sigma = [DVec3::ONE, DVec3::splat(10.0), DVec3::splat(100.0)];
        let depths = [0.5, 0.5, 2.0];
        let at = |depth: f64| optical_depth(&sigma, |j| depths[j], depth, 0.5).x;
        assert_eq!([at(0.25), at(0.5), at(1.0), at(3.0)], [0.5, 1.0, 101.0, 501.0]);
    }
}
