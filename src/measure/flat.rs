//! Random walks in slabs and half-spaces, under collimated and under constant light, and the dipole's prediction for
//! them.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::walk::{BATCHES, Body, Estimate, Medium, Random, batches, refracted, travel};
use crate::dipole::profile::Dipole;
use crate::lighting::fresnel;

/// How light falls on the upper side of a slab.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lighting {
    /// At normal incidence.
    Collimated,
    /// The same radiance from every direction of the upper hemisphere.
    Constant,
}

/// Shares of the light that entered.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flat {
    /// Light that leaves through the upper side, where it entered.
    pub back: Estimate,
    /// Light that leaves through the lower side.
    pub through: Estimate,
}

/// Samples the direction of an entering photon inside the medium; Fresnel transmittance favours steep incidence.
pub(super) fn enter(eta: f64, lighting: Lighting, random: &mut Random) -> DVec3 {
    if lighting == Lighting::Collimated {
        return -DVec3::Z;
    }
    // Cosine-weighted direction, accepted with the probability of Fresnel transmittance.
    loop {
        let cosine = random.next().sqrt();
        if random.next() <= fresnel::transmittance(eta, cosine) {
            let turn = TAU * random.next();
            let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
            return refracted(eta, DVec3::new(sine * turn.cos(), sine * turn.sin(), cosine), DVec3::Z);
        }
    }
}

/// Random walk of `photons` photons in a slab of this thickness (a length); infinity gives a half-space.
#[must_use]
pub fn walk(medium: Medium, thickness: f64, lighting: Lighting, photons: u64, seed: u64) -> Flat {
    let each = photons.div_ceil(BATCHES).max(1);
    let found = batches(seed, |mut random| {
        let mut shares = [0.0; 2];
        for _ in 0..each {
            let direction = enter(medium.eta, lighting, &mut random);
            if let Some((_, normal, weight)) =
                travel(medium, Body::Slab(thickness), DVec3::ZERO, direction, &mut random)
            {
                shares[usize::from(normal.z < 0.0)] += weight / each as f64;
            }
        }
        shares
    });
    let [back, through] = [0, 1].map(|side| Estimate::of(found.iter().map(|shares: &[f64; 2]| shares[side])));
    Flat { back, through }
}

/// The dipole's exitant light beyond this distance from the point of entry in a plane: the integral of 2 pi r R_d
/// over r from `distance` to infinity, which is 2 pi strength times the sum over both sources of z e^(-sigma d) / d
/// with d^2 = distance^2 + z^2. It predicts the transmittance of a slab of that thickness; 0 gives the total
/// reflectance.
#[must_use]
pub fn beyond(dipole: &Dipole, distance: f64) -> f64 {
    let source = |z: f64| {
        let d = distance.hypot(z);
        z * (-dipole.sigma * d).exp() / d
    };
    2.0 * PI * dipole.strength * dipole.depths().into_iter().map(source).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dipole::form_factor::gauss::legendre;

    fn medium(albedo: f64, eta: f64) -> Medium {
        Medium { scattering: albedo, absorption: 1.0 - albedo, eta }
    }

    /// Chandrasekhar's H function for isotropic scattering: its value at 1, and the integral of mu H(mu). It solves
    /// 1/H(mu) = sqrt(1 - w) + w/2 integral of m H(m) / (mu + m).
    fn chandrasekhar(albedo: f64) -> (f64, f64) {
        let nodes: Vec<_> = legendre(48).iter().map(|node| (0.5 + 0.5 * node.x, 0.5 * node.weight)).collect();
        let mut h = vec![1.0; nodes.len()];
        let at = |mu: f64, h: &[f64]| {
            let sum: f64 = nodes.iter().zip(h).map(|(&(m, weight), h)| weight * m * h / (mu + m)).sum();
            1.0 / ((1.0 - albedo).sqrt() + 0.5 * albedo * sum)
        };
        for _ in 0..2000 {
            h = nodes.iter().map(|&(mu, _)| at(mu, &h)).collect();
        }
        (at(1.0, &h), nodes.iter().zip(&h).map(|(&(mu, weight), h)| weight * mu * h).sum())
    }

    #[test]
    fn a_half_space_of_index_1_is_chandrasekhars() {
        for (k, albedo) in [0.3, 0.9, 0.99].into_iter().enumerate() {
            let (h, moment) = chandrasekhar(albedo);
            let root = f64::sqrt(1.0 - albedo);
            for (lighting, expected) in
                [(Lighting::Collimated, 1.0 - root * h), (Lighting::Constant, 1.0 - 2.0 * root * moment)]
            {
                let Flat { back, through } = walk(medium(albedo, 1.0), f64::INFINITY, lighting, 100_000, k as u64);
                assert!((back.mean - expected).abs() < 4.0 * back.error, "{albedo} {lighting:?} {back:?} {expected}");
                assert!(back.error < 2e-3 && through == Estimate::default(), "{back:?} {through:?}");
            }
        }
        // Van de Hulst's formula for the spherical albedo, accurate to about 2e-3.
        for albedo in [0.3, 0.9, 0.99] {
            let root = f64::sqrt(1.0 - albedo);
            let known = (1.0 - root) * (1.0 - 0.139 * root) / (1.0 + 1.17 * root);
            let found = 1.0 - 2.0 * root * chandrasekhar(albedo).1;
            assert!((found - known).abs() < 3e-3, "{albedo}: {found} {known}");
        }
    }

    #[test]
    fn slabs_keep_what_is_not_absorbed_and_absorb_by_beer() {
        let clear = walk(medium(1.0, 1.4), 3.0, Lighting::Constant, 20_000, 5);
        assert!((clear.back.mean + clear.through.mean - 1.0).abs() < 1e-9, "{clear:?}");
        let black = walk(medium(0.0, 1.0), 0.7, Lighting::Collimated, 100_000, 6);
        let expected = f64::exp(-0.7);
        assert!((black.through.mean - expected).abs() < 4.0 * black.through.error, "{black:?}");
        assert_eq!(black.back.mean, 0.0);
        assert_eq!(clear, walk(medium(1.0, 1.4), 3.0, Lighting::Constant, 20_000, 5));
    }

    #[test]
    fn the_dipoles_tail_is_its_profiles() {
        let dipole = Dipole::new(2.19, 0.0021, 3.96);
        assert!((beyond(&dipole, 0.0) / dipole.total() - 1.0).abs() < 1e-12);
        let ring = |k: i32| 0.5 + 1e-3 * (f64::from(k) + 0.5);
        let sum: f64 = (0..500).map(|k| TAU * ring(k) * dipole.reflectance(ring(k)) * 1e-3).sum();
        assert!((beyond(&dipole, 0.5) - beyond(&dipole, 1.0) - sum).abs() < 1e-6);
    }
}
