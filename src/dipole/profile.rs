//! The dipole profile `R_d` of one colour channel: Table 1 of Mertens et al. 2003.
//!
//! `R_d(r) = alpha'/(4 pi) [ z_r p(s_r) + z_v p(s_v) ]`, `p(s) = (1 + sigma s) e^(-sigma s) / s^3`,
//! `s_j^2 = r^2 + z_j^2`: a real source below the surface and a virtual one above it. The factor in front of `p` is
//! the depth `z_j`, not the height of the source over some other plane.

use std::f64::consts::PI;

use crate::layout::ObjectParams;

/// The dipole of one colour channel. Lengths share one unit, chosen by the caller.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dipole {
    /// Reduced albedo over 4 pi: `alpha' / (4 pi)`, no unit, in [0, 1/(4 pi)].
    pub strength: f64,
    /// Effective extinction `sigma_tr = sqrt(3 sigma_a sigma_t')`, 1/length, at least 0.
    pub sigma: f64,
    /// Depth of the real source, one mean free path `1 / sigma_t'`, length, positive.
    pub z_real: f64,
    /// Height of the virtual source, `z_real (1 + 4 A / 3)`, length, positive.
    pub z_virtual: f64,
}

impl Dipole {
    /// One channel of an object's material, in internal units.
    #[must_use]
    #[inline]
    pub fn of(params: &ObjectParams, channel: usize) -> Self {
        Self {
            strength: params.strength[channel].into(),
            sigma: params.sigma[channel].into(),
            z_real: params.z_real[channel].into(),
            z_virtual: params.z_virtual[channel].into(),
        }
    }

    /// The dipole of a homogeneous medium.
    ///
    /// `sigma_s_prime`, `sigma_a`: reduced scattering and absorption, 1/length, at least 0 and not
    /// both 0. `a_boundary`: the `A` of [`crate::lighting::fresnel::boundary`], at least 1.
    #[must_use]
    pub fn new(sigma_s_prime: f64, sigma_a: f64, a_boundary: f64) -> Self {
        let sigma_t_prime = sigma_s_prime + sigma_a;
        let z_real = 1.0 / sigma_t_prime;
        Self {
            strength: sigma_s_prime / sigma_t_prime / (4.0 * PI),
            sigma: (3.0 * sigma_a * sigma_t_prime).sqrt(),
            z_real,
            z_virtual: z_real * (1.0 + 4.0 / 3.0 * a_boundary),
        }
    }

    /// The depths of the two sources, real and virtual.
    #[must_use]
    #[inline]
    pub fn depths(&self) -> [f64; 2] {
        [self.z_real, self.z_virtual]
    }

    /// `R_d` at the distance `r` between entry and exit, per area: 1/length^2.
    #[must_use]
    pub fn reflectance(&self, r: f64) -> f64 {
        self.radial(r * r)
    }

    /// `R_d` from the squared distance `d2` between entry and exit, per area: 1/length^2.
    #[must_use]
    #[inline]
    pub fn radial(&self, d2: f64) -> f64 {
        self.depths().into_iter().map(|z| self.strength * z * kernel(self.sigma, (d2 + z * z).sqrt())).sum()
    }

    /// Total diffuse reflectance `2 pi int R_d r dr`, no unit, in [0, 1].
    ///
    /// Closed form: `alpha'/2 (e^(-sigma z_r) + e^(-sigma z_v))`. It is also the form factor of the
    /// whole plane through the receiving point.
    #[must_use]
    #[inline]
    pub fn total(&self) -> f64 {
        self.depths().into_iter().map(|z| 2.0 * PI * self.strength * (-self.sigma * z).exp()).sum()
    }
}

/// `p(s) = (1 + sigma s) e^(-sigma s) / s^3`, 1/length^3, at a distance `s` > 0 from a source.
#[must_use]
#[inline]
pub fn kernel(sigma: f64, s: f64) -> f64 {
    let a = sigma * s;
    (1.0 + a) * (-a).exp() / (s * s * s)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn without_absorption_all_light_returns() {
        let dipole = Dipole::new(2.0, 0.0, 2.6);
        assert_eq!(dipole.sigma, 0.0);
        assert!((dipole.total() - 1.0).abs() < 1e-15);
    }

    #[test]
    fn marble_green_has_the_published_lengths() {
        let dipole = Dipole::new(2.62, 0.0041, 3.9594974);
        assert!((dipole.sigma - 0.17965642).abs() < 1e-8);
        assert!((dipole.z_real - 0.38108304).abs() < 1e-8);
        assert!((dipole.z_virtual - 2.3929461).abs() < 1e-6);
    }
}
