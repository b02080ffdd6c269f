//! The same by a random walk, without the dipole's approximations: light scatters evenly in all directions with the reduced
//! coefficient, is absorbed, and is reflected at the surface from inside by Fresnel's formulas.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use rayon::prelude::*;

use super::{ANGLES, Curve};
use crate::light::fresnel;

/// A medium: reduced scattering and absorption, 1/length, and index, inside over outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Medium {
    /// sigma_s', at least 0.
    pub scattering: f64,
    /// sigma_a, at least 0; the sum is above 0.
    pub absorption: f64,
    /// The index.
    pub eta: f64,
}

/// Independent parts of a walk, whose spread tells the standard error.
const BATCHES: u64 = 32;
/// Steps after which a photon is given up: what is left of it would be lost anyway.
const STEPS: usize = 1_000_000;
/// The weight below which a photon goes on with one chance in two, twice as heavy.
const LIGHT: f64 = 0.1;

/// Random numbers: splitmix64.
struct Random(u64);

impl Random {
    /// Above 0, up to 1.
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (((z ^ (z >> 31)) >> 11) as f64 + 1.0) / (1u64 << 53) as f64
    }
}

/// What leaves a ball of this radius, in units of `flat`, what leaves a plane in full light; `photons` enter.
#[must_use]
pub fn curve(medium: Medium, radius: f64, flat: f64, photons: u64, seed: u64) -> Curve {
    let each = photons.div_ceil(BATCHES).max(1);
    let batch = |number: u64| {
        let mut random = Random(seed.wrapping_mul(0xd134_2543_de82_ef95) ^ (number << 32));
        random.next();
        let mut bins = [0.0; ANGLES];
        for _ in 0..each {
            if let Some((cosine, weight)) = photon(medium, radius, &mut random) {
                let bin = (cosine.clamp(-1.0, 1.0).acos() / PI * ANGLES as f64) as usize;
                bins[bin.min(ANGLES - 1)] += weight;
            }
        }
        bins
    };
    let batches: Vec<_> = (0..BATCHES).into_par_iter().map(batch).collect();
    let edge = |k: usize| (PI * k as f64 / ANGLES as f64).cos();
    // Through a disc of pi r^2 entered `each`; a bin has 2 pi r^2 times its span of cosines.
    let scale = |k: usize| 1.0 / (each as f64 * 2.0 * (edge(k) - edge(k + 1)) * flat);
    let count = BATCHES as f64;
    let mean = |k: usize| batches.iter().map(|bins| bins[k]).sum::<f64>() / count;
    let spread = |k: usize| batches.iter().map(|bins| (bins[k] - mean(k)).powi(2)).sum::<f64>() / (count - 1.0);
    Curve {
        radius,
        values: (0..ANGLES).map(|k| mean(k) * scale(k)).collect(),
        errors: (0..ANGLES).map(|k| (spread(k) / count).sqrt() * scale(k)).collect(),
    }
}

/// Where a photon leaves, as the cosine of the angle from the light, and with what weight, if it does.
fn photon(medium: Medium, radius: f64, random: &mut Random) -> Option<(f64, f64)> {
    let extinction = medium.scattering + medium.absorption;
    let albedo = medium.scattering / extinction;
    // Evenly over the disc that the light sees, refracted; light comes from +z.
    let cosine = random.next().sqrt();
    let normal = DVec3::new((1.0 - cosine * cosine).sqrt(), 0.0, cosine);
    let mut place = radius * normal;
    let sine2 = (1.0 - cosine * cosine) / (medium.eta * medium.eta);
    let inner = (1.0 - sine2).max(0.0).sqrt();
    let mut direction = (-DVec3::Z / medium.eta + (cosine / medium.eta - inner) * normal).normalize();
    let mut weight = 1.0;
    for _ in 0..STEPS {
        let along = place.dot(direction);
        let edge = -along + (along * along + radius * radius - place.length_squared()).max(0.0).sqrt();
        let step = -random.next().ln() / extinction;
        if step < edge {
            place += step * direction;
            weight *= albedo;
            if weight < LIGHT {
                if random.next() > 0.5 {
                    return None;
                }
                weight *= 2.0;
            }
            let (z, turn) = (2.0 * random.next() - 1.0, TAU * random.next());
            let across = (1.0 - z * z).sqrt();
            direction = DVec3::new(across * turn.cos(), across * turn.sin(), z);
            continue;
        }
        // At the surface: out, or back in.
        place = radius * (place + edge * direction).normalize();
        let normal = place / radius;
        let cosine = direction.dot(normal);
        let sine2 = (1.0 - cosine * cosine).max(0.0) * medium.eta * medium.eta;
        let out = (1.0 - sine2).max(0.0).sqrt();
        if random.next() < fresnel::transmittance(medium.eta, out) {
            return Some((normal.z, weight));
        }
        direction -= 2.0 * cosine * normal;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_absorption_all_light_leaves() {
        let medium = Medium { scattering: 2.0, absorption: 0.0, eta: 1.4 };
        let ball = curve(medium, 1.5, 1.0, 20_000, 7);
        let edge = |k: usize| (PI * k as f64 / ANGLES as f64).cos();
        let sum: f64 = (0..ANGLES).map(|k| ball.values[k] * 2.0 * (edge(k) - edge(k + 1))).sum();
        assert!((sum - 1.0).abs() < 1e-9, "{sum}");
        assert_eq!(ball, curve(medium, 1.5, 1.0, 20_000, 7));
        assert_ne!(ball, curve(medium, 1.5, 1.0, 20_000, 8));
    }

    #[test]
    fn a_ball_that_only_absorbs_follows_beer() {
        // Index 1: straight through along the light, 2 r cos long; what enters at theta leaves at pi - theta.
        let (sigma, radius) = (0.8, 1.0);
        let ball = curve(Medium { scattering: 0.0, absorption: sigma, eta: 1.0 }, radius, 1.0, 4_000, 3);
        // An albedo of 0 takes whatever is scattered: photons that pass have their full weight.
        let edge = |k: usize| (PI * k as f64 / ANGLES as f64).cos();
        let sum: f64 = (0..ANGLES).map(|k| ball.values[k] * 2.0 * (edge(k) - edge(k + 1))).sum();
        let x = 2.0 * sigma * radius;
        let expected = 2.0 * (1.0 - (1.0 + x) * f64::exp(-x)) / (x * x);
        assert!((sum - expected).abs() < 0.03, "{sum} {expected}");
        assert!(ball.values[..ANGLES / 2].iter().all(|&value| value == 0.0));
    }
}
