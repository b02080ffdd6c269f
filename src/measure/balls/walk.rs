//! Random walks in a ball: light from +z, uniform over the disc that the ball shows it, or constant light.

use std::f64::consts::PI;

use glam::DVec3;

use crate::measure::flat::{Lighting, enter};
use crate::measure::walk::{BATCHES, Body, Estimate, Medium, Random, batches, refracted, travel};
use crate::shading::balls::{ANGLES, Curve};

/// Light that leaves a ball of this radius, relative to `flat`, the light that leaves a plane under normal incidence;
/// `photons` enter.
#[must_use]
pub fn curve(medium: Medium, radius: f64, flat: f64, photons: u64, seed: u64) -> Curve {
    let each = photons.div_ceil(BATCHES).max(1);
    let found = batches(seed, |mut random| {
        let mut bins = [0.0; ANGLES];
        for _ in 0..each {
            if let Some((cosine, weight)) = photon(medium, radius, &mut random) {
                let bin = (cosine.clamp(-1.0, 1.0).acos() / PI * ANGLES as f64) as usize;
                bins[bin.min(ANGLES - 1)] += weight;
            }
        }
        bins
    });
    let edge = |k: usize| (PI * k as f64 / ANGLES as f64).cos();
    // `each` photons enter through a disc of area pi r^2; a bin covers 2 pi r^2 times its range of cosines.
    let scale = |k: usize| 1.0 / (each as f64 * 2.0 * (edge(k) - edge(k + 1)) * flat);
    let all: Vec<_> = (0..ANGLES).map(|k| Estimate::of(found.iter().map(|bins| bins[k] * scale(k)))).collect();
    Curve { radius, values: all.iter().map(|e| e.mean).collect(), errors: all.iter().map(|e| e.error).collect() }
}

/// Share of the entering light that leaves a ball of this radius, under the same radiance from every direction.
#[must_use]
pub fn constant(medium: Medium, radius: f64, photons: u64, seed: u64) -> Estimate {
    let each = photons.div_ceil(BATCHES).max(1);
    // By symmetry every photon enters at the top, with a direction sampled as for a slab.
    let found = batches(seed, |mut random| {
        let photon = |_| {
            let direction = enter(medium.eta, Lighting::Constant, &mut random);
            travel(medium, Body::Ball(radius), radius * DVec3::Z, direction, &mut random)
                .map_or(0.0, |(.., weight)| weight)
        };
        (0..each).map(photon).sum::<f64>() / each as f64
    });
    Estimate::of(found.into_iter())
}

/// Follows one photon; returns the cosine of the angle from the light at which it leaves, and its weight, or `None`.
fn photon(medium: Medium, radius: f64, random: &mut Random) -> Option<(f64, f64)> {
    let cosine = random.next().sqrt();
    let normal = DVec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine);
    let direction = refracted(medium.eta, DVec3::Z, normal);
    let (_, normal, weight) = travel(medium, Body::Ball(radius), radius * normal, direction, random)?;
    Some((normal.z, weight))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_absorption_all_light_leaves() {
        let medium = Medium { scattering: 2.0, absorption: 0.0, eta: 1.4 };
        assert!((constant(medium, 1.5, 3200, 7).mean - 1.0).abs() < 1e-12);
        let ball = curve(medium, 1.5, 1.0, 20_000, 7);
        let edge = |k: usize| (PI * k as f64 / ANGLES as f64).cos();
        let sum: f64 = (0..ANGLES).map(|k| ball.values[k] * 2.0 * (edge(k) - edge(k + 1))).sum();
        assert!((sum - 1.0).abs() < 1e-9, "{sum}");
        assert_eq!(ball, curve(medium, 1.5, 1.0, 20_000, 7));
        assert_ne!(ball, curve(medium, 1.5, 1.0, 20_000, 8));
    }

    #[test]
    fn a_ball_that_only_absorbs_follows_beer() {
        // Index 1: straight through along the light, over a path of 2 r cos theta; light that enters at theta leaves
        // at pi - theta.
        let (sigma, radius) = (0.8, 1.0);
        let ball = curve(Medium { scattering: 0.0, absorption: sigma, eta: 1.0 }, radius, 1.0, 4_000, 3);
        // With an albedo of 0 every scattering event absorbs: photons that leave keep their full weight.
        let edge = |k: usize| (PI * k as f64 / ANGLES as f64).cos();
        let sum: f64 = (0..ANGLES).map(|k| ball.values[k] * 2.0 * (edge(k) - edge(k + 1))).sum();
        let x = 2.0 * sigma * radius;
        let expected = 2.0 * (1.0 - (1.0 + x) * f64::exp(-x)) / (x * x);
        assert!((sum - expected).abs() < 0.03, "{sum} {expected}");
        assert!(ball.values[..ANGLES / 2].iter().all(|&value| value == 0.0));
    }
}
