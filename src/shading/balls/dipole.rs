//! Quadrature of the dipole on a ball: B(theta) is an integral over the distance to the point of entry, and over the
//! circle of points at that distance.

use std::f64::consts::{PI, TAU};

use super::{ANGLES, Curve, angle};
use crate::dipole::form_factor::gauss::legendre;
use crate::dipole::profile::Dipole;

/// Light that leaves a ball of this radius, by angle from the light.
#[must_use]
pub fn curve(dipole: &Dipole, radius: f64) -> Curve {
    // Intervals of distance from 0 to the diameter; the first ends at a quarter of z_real (or of a smaller radius),
    // each next one at twice the distance.
    let rule = legendre(16);
    let (mut low, mut high) = (0.0, 0.25 * dipole.z_real.min(radius));
    let mut distances = Vec::new();
    while low < 2.0 * radius {
        high = f64::min(high, 2.0 * radius);
        let (middle, half) = (0.5 * (low + high), 0.5 * (high - low));
        distances.extend(rule.iter().map(|node| (middle + half * node.x, half * node.weight)));
        (low, high) = (high, 2.0 * high);
    }
    let at = |theta: f64| {
        let ring = |&(distance, weight): &(f64, f64)| {
            // A chord of this length spans the angle psi; sin psi d psi = distance d distance / radius^2.
            let cosine = 1.0 - distance * distance / (2.0 * radius * radius);
            let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
            weight * TAU * distance * dipole.reflectance(distance) * lit(theta.cos() * cosine, theta.sin() * sine)
        };
        distances.iter().map(ring).sum::<f64>() / dipole.total()
    };
    Curve { radius, values: (0..ANGLES).map(|k| at(angle(k))).collect(), errors: vec![0.0; ANGLES] }
}

/// The mean of max(a + b cos phi, 0) over a circle.
fn lit(a: f64, b: f64) -> f64 {
    if a >= b {
        return a;
    }
    if a <= -b {
        return 0.0;
    }
    let end = (-a / b).acos();
    (a * end + b * end.sin()) / PI
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_large_ball_is_lambert() {
        let dipole = Dipole::new(2.0, 0.3, 3.0);
        for (k, value) in curve(&dipole, 1e4).values.into_iter().enumerate() {
            assert!((value - angle(k).cos().max(0.0)).abs() < 1e-4, "{k}: {value}");
        }
    }

    #[test]
    fn light_that_enters_leaves_or_is_lost() {
        // Every point of a ball emits the same share of its light, the profile's integral up to the diameter.
        let (dipole, radius) = (Dipole::new(2.0, 0.01, 3.0), 2.0);
        let steps = 200_000;
        let d = |k: i32| 2.0 * radius * (f64::from(k) + 0.5) / f64::from(steps);
        let share: f64 = (0..steps).map(|k| TAU * d(k) * dipole.reflectance(d(k))).sum::<f64>() * 2.0 * radius
            / f64::from(steps)
            / dipole.total();
        let ball = curve(&dipole, radius);
        let mean: f64 = (0..ANGLES).map(|k| ball.values[k] * angle(k).sin()).sum::<f64>() * 0.5 * PI / ANGLES as f64;
        // On average over the ball, a quarter of the normal irradiance enters.
        assert!((mean / (0.25 * share) - 1.0).abs() < 2e-3, "{mean} {share}");
        assert!(ball.values.windows(2).all(|pair| pair[0] > pair[1]));
    }
}
