//! Random walks in slabs and half-spaces, under collimated and under constant light, and the dipole's prediction for
//! them.

use std::f64::consts::PI;

use super::bodies::{Estimate, Lighting, Walks, box_of};
use crate::dipole::profile::Dipole;
use crate::error::Result;

/// Shares of the light that entered; light that passes straight through is in neither.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Flat {
    /// Light that leaves through the upper side, where it entered.
    pub back: Estimate,
    /// Light that leaves through the lower side.
    pub through: Estimate,
}

/// Width of the boxes that stand for slabs, mean free paths: about a thousandth of the light leaves by their sides.
const WIDTH: f64 = 4000.0;
/// Depth of a box that stands for a half-space, in lengths over which diffuse light fades by e; then its least and its
/// largest value, mean free paths. Light that leaves below counts as if it left above.
const DEPTH: (f64, f64, f64) = (6.0, 20.0, 150.0);

/// The light that leaves a slab which is `paths` mean free paths of each channel thick; infinity is a half-space.
pub fn slab(walks: &Walks<'_>, paths: f64, lighting: Lighting) -> Result<[Flat; 3]> {
    let media = walks.media.map(|medium| medium.in_paths());
    let fades = media.map(|medium| (3.0 * (1.0 - medium.albedo()).max(1e-9)).sqrt().recip());
    let whole = (DEPTH.0 * fades.into_iter().fold(0.0, f64::max)).clamp(DEPTH.1, DEPTH.2);
    let mesh = box_of(WIDTH, if paths.is_finite() { paths } else { whole });
    let left = Walks { media, ..*walks }.leave(&mesh, lighting, |face| if face < 2 { 1.0 } else { 0.0 })?;
    Ok([0, 1, 2].map(|c| match paths.is_finite() {
        true => {
            Flat { back: left.through(c, |face| face < 2), through: left.through(c, |face| (2..4).contains(&face)) }
        }
        false => Flat { back: left.through(c, |_| true), through: Estimate::default() },
    }))
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
    use crate::measure::bodies::Medium;

    fn walks(albedos: [f64; 3], eta: f64, photons: u64) -> Walks<'static> {
        // Coefficients of any size: what counts is the free path.
        let medium = |albedo: f64| Medium { scattering: 3.0 * albedo, absorption: 3.0 * (1.0 - albedo), eta };
        Walks { device: None, media: albedos.map(medium), photons, seed: 2 }
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
    #[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
    fn a_half_space_of_index_1_is_chandrasekhars() {
        let albedos = [0.3, 0.9, 0.99];
        let walks = walks(albedos, 1.0, 40_000);
        for lighting in [Lighting::Collimated, Lighting::Constant] {
            let found = slab(&walks, f64::INFINITY, lighting).unwrap();
            for (albedo, Flat { back, through }) in albedos.into_iter().zip(found) {
                let (h, moment) = chandrasekhar(albedo);
                let root = f64::sqrt(1.0 - albedo);
                let expected = 1.0 - root * if lighting == Lighting::Collimated { h } else { 2.0 * moment };
                assert!((back.mean - expected).abs() < 4.0 * back.error, "{albedo} {lighting:?} {back:?} {expected}");
                assert!(back.error < 3e-3 && through == Estimate::default(), "{back:?} {through:?}");
            }
        }
        // Van de Hulst's formula for the spherical albedo, accurate to about 2e-3.
        for albedo in albedos {
            let root = f64::sqrt(1.0 - albedo);
            let known = (1.0 - root) * (1.0 - 0.139 * root) / (1.0 + 1.17 * root);
            let found = 1.0 - 2.0 * root * chandrasekhar(albedo).1;
            assert!((found - known).abs() < 3e-3, "{albedo}: {found} {known}");
        }
    }

    #[test]
    #[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
    fn slabs_keep_what_is_not_absorbed() {
        let walks = walks([1.0, 1.0, 0.0], 1.4, 8000);
        let found = slab(&walks, 30.0, Lighting::Constant).unwrap();
        let both = found.map(|flat| flat.back.mean + flat.through.mean);
        // A thousandth or so leaves through the sides; what only absorbs scatters nothing.
        assert!((0.99..=1.0).contains(&both[0]) && both[2] < 1e-9, "{found:?}");
        assert!(found[0].through.mean < found[0].back.mean && found[0].through.mean > 0.01, "{found:?}");
        assert_eq!(found, slab(&walks, 30.0, Lighting::Constant).unwrap());
        assert_ne!(found, slab(&Walks { seed: 3, ..walks }, 30.0, Lighting::Constant).unwrap());
    }

    #[test]
    fn the_dipoles_tail_is_its_profiles() {
        let dipole = Dipole::new(2.19, 0.0021, 3.96);
        assert!((beyond(&dipole, 0.0) / dipole.total() - 1.0).abs() < 1e-12);
        let ring = |k: i32| 0.5 + 1e-3 * (f64::from(k) + 0.5);
        let sum: f64 = (0..500).map(|k| 2.0 * PI * ring(k) * dipole.reflectance(ring(k)) * 1e-3).sum();
        assert!((beyond(&dipole, 0.5) - beyond(&dipole, 1.0) - sum).abs() < 1e-6);
    }
}
