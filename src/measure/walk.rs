//! Monte Carlo random walk of light in a body, without the dipole's approximations: isotropic scattering with the
//! reduced coefficient, absorption, and Fresnel reflection at the surface from inside.

use std::f64::consts::TAU;

use glam::DVec3;
use rayon::prelude::*;

use crate::lighting::fresnel;

/// A medium: reduced scattering and absorption coefficients, 1/length, and the relative index of refraction, inside
/// over outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Medium {
    /// sigma_s', at least 0.
    pub scattering: f64,
    /// sigma_a, at least 0; the sum of both is above 0.
    pub absorption: f64,
    /// The relative index of refraction.
    pub eta: f64,
}

/// A body.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Body {
    /// A ball of this radius around the origin.
    Ball(f64),
    /// The slab between z = 0 and this depth below; infinite for a half-space.
    Slab(f64),
}

impl Body {
    /// Distance from a point inside to the surface along a ray.
    fn reach(self, place: DVec3, direction: DVec3) -> f64 {
        match self {
            Self::Ball(radius) => {
                let along = place.dot(direction);
                -along + (along * along + radius * radius - place.length_squared()).max(0.0).sqrt()
            }
            Self::Slab(_) if direction.z > 0.0 => (-place.z / direction.z).max(0.0),
            Self::Slab(depth) if direction.z < 0.0 => ((-depth - place.z) / direction.z).max(0.0),
            Self::Slab(_) => f64::INFINITY,
        }
    }

    /// Snaps a point to the surface, off which it is by rounding only, and returns it with the outward normal.
    fn surface(self, place: DVec3, direction: DVec3) -> (DVec3, DVec3) {
        match self {
            Self::Ball(radius) => {
                let place = radius * place.normalize();
                (place, place / radius)
            }
            Self::Slab(_) if direction.z > 0.0 => (DVec3::new(place.x, place.y, 0.0), DVec3::Z),
            Self::Slab(depth) => (DVec3::new(place.x, place.y, -depth), -DVec3::Z),
        }
    }
}

/// Independent batches of a walk, whose variance gives the standard error.
pub const BATCHES: u64 = 32;
/// Maximum number of steps, scattering or reflection; a photon that reaches it is dropped.
const STEPS: usize = 1_000_000;
/// Weight below which Russian roulette starts: a photon survives with probability 1/2 and double weight.
const LIGHT: f64 = 0.1;

/// Random number generator: splitmix64.
pub struct Random(u64);

impl Random {
    /// The generator for one batch of a walk.
    #[must_use]
    pub fn of(seed: u64, batch: u64) -> Self {
        let mut random = Self(seed.wrapping_mul(0xd134_2543_de82_ef95) ^ (batch << 32));
        random.next();
        random
    }

    /// Uniform in (0, 1].
    pub(super) fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (((z ^ (z >> 31)) >> 11) as f64 + 1.0) / (1u64 << 53) as f64
    }
}

/// Runs all batches in parallel and returns the result of each.
pub fn batches<T: Send>(seed: u64, batch: impl Fn(Random) -> T + Sync) -> Vec<T> {
    (0..BATCHES).into_par_iter().map(|number| batch(Random::of(seed, number))).collect()
}

/// A mean with its standard error.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimate {
    /// The mean over the batches.
    pub mean: f64,
    /// The standard error of the mean.
    pub error: f64,
}

impl Estimate {
    /// From the results of the batches, at least two.
    #[must_use]
    pub fn of(values: impl ExactSizeIterator<Item = f64> + Clone) -> Self {
        let count = values.len() as f64;
        let mean = values.clone().sum::<f64>() / count;
        let spread = values.map(|x| (x - mean).powi(2)).sum::<f64>() / (count - 1.0);
        Self { mean, error: (spread / count).sqrt() }
    }
}

/// The refracted direction inside, for light from `toward`; `toward` and `normal` point away from the body.
#[must_use]
pub fn refracted(eta: f64, toward: DVec3, normal: DVec3) -> DVec3 {
    let cosine = toward.dot(normal);
    let inner = (1.0 - (1.0 - cosine * cosine) / (eta * eta)).max(0.0).sqrt();
    (-toward / eta + (cosine / eta - inner) * normal).normalize()
}

/// Follows a photon inside the body; returns where it leaves, the normal there, and its weight, or `None` if it is
/// lost.
pub fn travel(
    medium: Medium,
    body: Body,
    mut place: DVec3,
    mut direction: DVec3,
    random: &mut Random,
) -> Option<(DVec3, DVec3, f64)> {
    let extinction = medium.scattering + medium.absorption;
    let albedo = medium.scattering / extinction;
    let mut weight = 1.0;
    for _ in 0..STEPS {
        let edge = body.reach(place, direction);
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
        // At the surface: leave, or reflect back in.
        let (at, normal) = body.surface(place + edge * direction, direction);
        place = at;
        let cosine = direction.dot(normal);
        let sine2 = (1.0 - cosine * cosine).max(0.0) * medium.eta * medium.eta;
        let out = (1.0 - sine2).max(0.0).sqrt();
        if random.next() < fresnel::transmittance(medium.eta, out) {
            return Some((place, normal, weight));
        }
        direction -= 2.0 * cosine * normal;
    }
    None
}
