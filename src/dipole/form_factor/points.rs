//! The form factor by a few samples on the triangle's area.
//!
//! One sample at the centroid is the paper's far field (equation 7). Its leading error is known: the
//! second moment of the triangle times the second derivatives of the kernel. [`midpoint_moment`] adds
//! that term without a further exponential; [`sampled`] takes a symmetric rule of Dunavant 1985 instead.

use super::{Distance, vector_area};
use crate::dipole::profile::{Dipole, kernel};
use glam::DVec3;

/// One sample of an area rule: three barycentric coordinates and a weight; weights sum to 1.
pub type Sample = [f64; 4];

/// The rule of 3 points, exact to degree 2.
pub const THREE: [Sample; 3] = orbit3(1.0 / 6.0, 1.0 / 3.0);

/// The rule of 6 points, exact to degree 4.
pub const SIX: [Sample; 6] = {
    let [a, b, c] = orbit3(0.445_948_490_915_964_9, 0.223_381_589_678_011_46);
    let [d, e, f] = orbit3(0.091_576_213_509_770_74, 0.109_951_743_655_321_87);
    [a, b, c, d, e, f]
};

/// The rule of 12 points, exact to degree 6.
pub const TWELVE: [Sample; 12] = {
    let [a, b, c] = orbit3(0.249_286_745_170_910_42, 0.116_786_275_726_379_37);
    let [d, e, f] = orbit3(0.063_089_014_491_502_23, 0.050_844_906_370_206_82);
    let (u, v) = (0.053_145_049_844_816_95, 0.310_352_451_033_784_4);
    let (w, weight) = (1.0 - u - v, 0.082_851_075_618_373_58);
    [
        a,
        b,
        c,
        d,
        e,
        f,
        [u, v, w, weight],
        [v, w, u, weight],
        [w, u, v, weight],
        [v, u, w, weight],
        [u, w, v, weight],
        [w, v, u, weight],
    ]
};

/// The three samples with two equal coordinates.
const fn orbit3(equal: f64, weight: f64) -> [Sample; 3] {
    let other = 1.0 - 2.0 * equal;
    [[other, equal, equal, weight], [equal, other, equal, weight], [equal, equal, other, weight]]
}

/// The form factor by an area rule, no unit: area times the weighted mean of `R_d`.
///
/// `triangle`: corners, counter-clockwise. `x_o`: the receiving point. `rule`: [`THREE`], [`SIX`],
/// [`TWELVE`], or any other.
#[must_use]
pub fn sampled(triangle: &[DVec3; 3], x_o: DVec3, dipole: &Dipole, distance: Distance, rule: &[Sample]) -> f64 {
    let (area, delta) = plane(triangle, x_o);
    let mut mean = 0.0;
    for [a, b, c, weight] in rule {
        let d = *a * (triangle[0] - x_o) + *b * (triangle[1] - x_o) + *c * (triangle[2] - x_o);
        let squared = distance.squared(d.length_squared(), delta, dipole);
        for (z, s2) in dipole.depths().into_iter().zip(squared) {
            mean += weight * z * kernel(dipole.sigma, s2.sqrt());
        }
    }
    area * dipole.strength * mean
}

/// The form factor by one sample at the centroid and the second moment, no unit.
///
/// `A z [p0 + (p1 tr M + p2 d.M.d) / 2]`, `M = sum of e e^T / 36` over the edges, `d` from the
/// centroid to the point, `p1 = p'/s`, `p2 = (p'/s)'/s`. Below 0 where the triangle is far too near.
#[must_use]
pub fn midpoint_moment(triangle: &[DVec3; 3], x_o: DVec3, dipole: &Dipole, distance: Distance) -> f64 {
    let (area, delta) = plane(triangle, x_o);
    let centroid = triangle.iter().map(|corner| corner - x_o).sum::<DVec3>() / 3.0;
    // Trace and quadratic form of the second moment.
    let edges = edges(triangle);
    let trace = trace(triangle);
    let form = edges.iter().map(|e| e.dot(centroid) * e.dot(centroid)).sum::<f64>() / 36.0;
    // The kernel and its two radial derivatives share one exponential.
    let squared = distance.squared(centroid.length_squared(), delta, dipole);
    let mut sum = 0.0;
    for (z, s2) in dipole.depths().into_iter().zip(squared) {
        let s = s2.sqrt();
        let a = dipole.sigma * s;
        let p0 = kernel(dipole.sigma, s);
        let p1 = -(3.0 + 3.0 * a + a * a) / (1.0 + a) / s2;
        let p2 = (15.0 + a * (15.0 + a * (6.0 + a))) / (1.0 + a) / (s2 * s2);
        sum += z * p0 * (1.0 + 0.5 * (p1 * trace + p2 * form));
    }
    area * dipole.strength * sum
}

/// Trace of a triangle's second moment about its centroid, length^2: squared edges over 36.
#[must_use]
pub fn trace(triangle: &[DVec3; 3]) -> f64 {
    edges(triangle).iter().map(|e| e.length_squared()).sum::<f64>() / 36.0
}

fn edges(triangle: &[DVec3; 3]) -> [DVec3; 3] {
    [triangle[1] - triangle[0], triangle[2] - triangle[1], triangle[0] - triangle[2]]
}

/// Area of the triangle, and signed height of the point over its plane (0 if there is no plane).
fn plane(triangle: &[DVec3; 3], x_o: DVec3) -> (f64, f64) {
    let area = vector_area(triangle);
    let normal = area.try_normalize().unwrap_or(DVec3::ZERO);
    (area.length(), (x_o - triangle[0]).dot(normal))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The rule's mean of `x^i y^j` on the unit right triangle, against `2 i! j! / (i+j+2)!`.
    fn worst(rule: &[Sample], degree: i32) -> f64 {
        let factorial = |n: i32| (1..=n).map(f64::from).product::<f64>();
        let mut worst: f64 = 0.0;
        for i in 0..=degree {
            for j in 0..=degree - i {
                let exact = 2.0 * factorial(i) * factorial(j) / factorial(i + j + 2);
                let sum: f64 = rule.iter().map(|p| p[3] * p[0].powi(i) * p[1].powi(j)).sum();
                worst = worst.max((sum - exact).abs());
            }
        }
        worst
    }

    #[test]
    fn rules_have_their_degree_and_no_more() {
        for (rule, degree) in [(&THREE[..], 2), (&SIX[..], 4), (&TWELVE[..], 6)] {
            assert!(worst(rule, degree) < 1e-15, "{degree}: {}", worst(rule, degree));
            assert!(worst(rule, degree + 1) > 1e-6);
        }
    }
}
