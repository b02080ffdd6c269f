//! The profile and its first two derivatives by half the squared distance, per channel of a group: links are sums of
//! these.
//!
//! With a = sigma s: `p0 = (1+a) e^-a / s^3`, `p1 = p0'/s = -(3+3a+a^2) e^-a / s^5`,
//! `p2 = p1'/s = (15+15a+6a^2+a^3) e^-a / s^7`, each summed over both sources times their depths and the strength.

use glam::{DMat3, DVec3};

use super::profile::Dipole;
use crate::layout::{Moment, ObjectParams, SecondMoments};

/// Value and two derivatives at one distance.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ProfileDerivatives {
    /// `R_d`, 1/length^2.
    pub value: f64,
    /// Its derivative with respect to half the squared distance, 1/length^4.
    pub first: f64,
    /// The derivative of `first`, 1/length^6.
    pub second: f64,
}

impl ProfileDerivatives {
    /// The derivatives of a dipole's profile at a squared distance.
    #[must_use]
    #[inline]
    pub fn of(dipole: &Dipole, d2: f64) -> Self {
        let mut jet = Self::default();
        for z in dipole.depths() {
            let s2 = d2 + z * z;
            let a = dipole.sigma * s2.sqrt();
            let e = dipole.strength * z * (-a).exp() / (s2 * s2.sqrt());
            jet.value += (1.0 + a) * e;
            jet.first -= (3.0 + a * (3.0 + a)) * e / s2;
            jet.second += (15.0 + a * (15.0 + a * (6.0 + a))) * e / (s2 * s2);
        }
        jet
    }
}

/// The dipoles of a group of channels, each multiplied by the channel's tint.
pub struct GroupProfile {
    dipoles: [Dipole; 3],
    mask: u32,
}

/// A cluster's light: its sum, centroid and second moments.
#[derive(Clone, Copy, Debug)]
pub struct ClusterMoments {
    /// W: the sum of area times irradiance.
    pub weight: f64,
    /// The light's centroid.
    pub center: DVec3,
    /// Second moments about the centre per weight: xx, yy, zz; then yz, zx, xy.
    pub moments: [DVec3; 2],
}

impl ClusterMoments {
    /// From the records that store it.
    #[must_use]
    #[inline]
    pub fn new(m: &Moment, s: &SecondMoments) -> Self {
        Self { weight: m.weight.into(), center: point(m.center), moments: [point(s.diagonal), point(s.mixed)] }
    }

    /// tau: the trace of the second moments.
    #[must_use]
    #[inline]
    pub fn trace(&self) -> f64 {
        self.moments[0].element_sum()
    }

    /// The symmetric matrix of second moments.
    #[inline]
    fn tensor(&self) -> DMat3 {
        let ([xx, yy, zz], [yz, zx, xy]) = (self.moments[0].to_array(), self.moments[1].to_array());
        DMat3::from_cols_array(&[xx, xy, zx, xy, yy, yz, zx, yz, zz])
    }
}

#[inline]
fn point([x, y, z]: [f32; 3]) -> DVec3 {
    DVec3::new(x.into(), y.into(), z.into())
}

impl GroupProfile {
    /// The profile of the channels whose bits are set in `mask`.
    #[must_use]
    pub fn new(params: &ObjectParams, mask: u32) -> Self {
        let tinted = |c: usize| {
            let dipole = Dipole::of(params, c);
            Dipole { strength: dipole.strength * f64::from(params.tint[c]), ..dipole }
        };
        Self { dipoles: [0, 1, 2].map(tinted), mask }
    }

    /// The channels of the group.
    pub fn channels(&self) -> impl Iterator<Item = usize> + use<> {
        let mask = self.mask;
        (0..3).filter(move |c| mask >> c & 1 == 1)
    }

    /// Form factor of a whole plane through the receiver, times the channel's tint, no unit.
    #[must_use]
    #[inline]
    pub fn plane(&self, channel: usize) -> f64 {
        self.dipoles[channel].total()
    }

    /// The dipole of a channel, tinted.
    #[must_use]
    #[inline]
    pub fn dipole(&self, channel: usize) -> &Dipole {
        &self.dipoles[channel]
    }

    /// The derivatives of a channel at a squared distance.
    #[must_use]
    #[inline]
    pub fn at(&self, channel: usize, d2: f64) -> ProfileDerivatives {
        ProfileDerivatives::of(&self.dipoles[channel], d2)
    }

    /// Radiosity at `x` from a cluster: `W [p0 + (p1 tr Q + p2 d.Q.d) / 2]`; without Q below order 2.
    #[must_use]
    #[inline]
    pub fn link(&self, channel: usize, m: &ClusterMoments, x: DVec3, order: u32) -> f64 {
        let d = x - m.center;
        let jet = self.at(channel, d.length_squared());
        let mut value = jet.value;
        if order == 2 {
            value += 0.5 * (jet.first * m.trace() + jet.second * d.dot(m.tensor() * d));
        }
        m.weight * value
    }

    /// `chi = tau q2 / (2 s^2)` of a channel for tau = 1, as the kernels compute it: from the derivatives themselves,
    /// with the distance to the real source.
    #[must_use]
    #[inline]
    pub fn unit_chi(&self, channel: usize, d2: f64) -> f64 {
        let jet = self.at(channel, d2);
        let z = self.dipoles[channel].z_real;
        if jet.value > 0.0 { 0.5 * jet.second * (d2 + z * z) / jet.value } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use crate::dipole::derivatives::*;

    #[test]
    fn derivatives_are_those_of_the_profile() {
        let dipole = Dipole::new(2.62, 0.0041, 3.96);
        let (d2, h) = (0.7, 1e-4);
        let at = |half: f64| ProfileDerivatives::of(&dipole, 2.0 * half);
        let (low, high) = (at(0.5 * d2 - h), at(0.5 * d2 + h));
        let jet = ProfileDerivatives::of(&dipole, d2);
        assert!((jet.value - dipole.radial(d2)).abs() < 1e-15);
        assert!(((high.value - low.value) / (2.0 * h) / jet.first - 1.0).abs() < 1e-6);
        assert!(((high.first - low.first) / (2.0 * h) / jet.second - 1.0).abs() < 1e-6);
    }
}
