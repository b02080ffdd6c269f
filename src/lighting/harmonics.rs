//! Irradiance from an environment of nine spherical harmonics (Ramamoorthi and Hanrahan 2001), with the boundary's
//! Fresnel transmittance in their factors.
//!
//! Irradiance is a convolution of radiance with F_t(mu) mu, so each harmonic of degree l is multiplied by the
//! integral of 2 pi F_t(mu) mu P_l(mu) over mu from 0 to 1. For F_t = 1 the factors are pi, 2 pi / 3, pi / 4.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::fresnel::transmittance;

/// The factors of degrees 0, 1 and 2 for a relative index, inside over outside, positive.
#[must_use]
pub fn zonal(eta: f64) -> [f64; 3] {
    // Simpson's rule in s with mu = s^2, because for an index near 1 the transmittance bends near mu = 0.
    const PANELS: usize = 8192;
    let mut sums = [0.0; 3];
    for i in 0..=PANELS {
        let s = i as f64 / PANELS as f64;
        let mu = s * s;
        let weight = match i {
            0 | PANELS => 1.0,
            i if i % 2 == 1 => 4.0,
            _ => 2.0,
        };
        let value = weight * transmittance(eta, mu) * mu * 2.0 * s;
        for (sum, legendre) in sums.iter_mut().zip([1.0, mu, 1.5 * mu * mu - 0.5]) {
            *sum += value * legendre;
        }
    }
    sums.map(|sum| TAU * sum / (3.0 * PANELS as f64))
}

/// The nine real orthonormal harmonics at a unit vector: degree 0; x, y, z; yz, zx, xy, 3 y^2 - 1, x^2 - z^2.
#[must_use]
pub fn basis(n: DVec3) -> [f64; 9] {
    let one = (1.0 / (4.0 * PI)).sqrt();
    let first = (3.0 / (4.0 * PI)).sqrt();
    let second = (15.0 / (4.0 * PI)).sqrt();
    let axial = (5.0 / (16.0 * PI)).sqrt();
    [
        one,
        first * n.x,
        first * n.y,
        first * n.z,
        second * n.y * n.z,
        second * n.z * n.x,
        second * n.x * n.y,
        axial * (3.0 * n.y * n.y - 1.0),
        0.5 * second * (n.x * n.x - n.z * n.z),
    ]
}

/// Radiance from direction `n`, at least 0, given nine coefficients.
#[must_use]
pub fn radiance(coefficients: &[DVec3], n: DVec3) -> DVec3 {
    let sum: DVec3 = coefficients.iter().zip(basis(n)).map(|(&c, y)| c * y).sum();
    sum.max(DVec3::ZERO)
}

/// Irradiance that enters a face of normal `n`, at least 0; `factors` are those of each degree, per channel.
#[must_use]
pub fn irradiance(coefficients: &[DVec3], factors: [DVec3; 3], n: DVec3) -> DVec3 {
    const DEGREE: [usize; 9] = [0, 1, 1, 1, 2, 2, 2, 2, 2];
    let terms = coefficients.iter().zip(basis(n)).zip(DEGREE);
    terms.map(|((&c, y), degree)| factors[degree] * c * y).sum::<DVec3>().max(DVec3::ZERO)
}

#[cfg(test)]
mod tests {
    use crate::lighting::fresnel::diffuse_external_exact;
    use crate::lighting::harmonics::*;

    #[test]
    fn the_cosine_and_the_fresnel_weighted_cosine() {
        for (found, known) in zonal(1.0).into_iter().zip([PI, TAU / 3.0, PI / 4.0]) {
            assert!((found - known).abs() < 1e-9, "{found} {known}");
        }
        for (eta, known) in [(1.3, [2.9495, 2.0204, 0.8192]), (1.5, [2.8533, 1.9623, 0.8060])] {
            for (found, known) in zonal(eta).into_iter().zip(known) {
                assert!((found - known).abs() < 6e-5, "{eta}: {found} {known}");
            }
        }
        for eta in [1.0001, 1.01, 1.3, 2.0, 4.0] {
            let known = PI * (1.0 - diffuse_external_exact(eta));
            assert!((zonal(eta)[0] - known).abs() < 1e-7, "{eta}: {} {known}", zonal(eta)[0]);
        }
    }

    #[test]
    fn the_basis_is_orthonormal() {
        // A midpoint rule with many points is accurate enough.
        let (rows, columns) = (400, 800);
        let mut products = [[0.0; 9]; 9];
        for row in 0..rows {
            for column in 0..columns {
                let y = 1.0 - 2.0 * (f64::from(row) + 0.5) / f64::from(rows);
                let angle = TAU * (f64::from(column) + 0.5) / f64::from(columns);
                let across = (1.0 - y * y).sqrt();
                let values = basis(DVec3::new(across * angle.sin(), y, -across * angle.cos()));
                for (i, j) in (0..9).flat_map(|i| (0..9).map(move |j| (i, j))) {
                    products[i][j] += values[i] * values[j] * 4.0 * PI / f64::from(rows * columns);
                }
            }
        }
        for (i, j) in (0..9).flat_map(|i| (0..9).map(move |j| (i, j))) {
            let expected = f64::from(u8::from(i == j));
            assert!((products[i][j] - expected).abs() < 1e-4, "{i} {j}: {}", products[i][j]);
        }
    }
}
