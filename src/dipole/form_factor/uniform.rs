//! The form factor by uniform point samples: the method that Mertens et al. 2003 compare theirs with (section 4.2,
//! table 5, figure 5).
//!
//! As many samples as Jensen and Buhler 2002 spread over a surface, one per disc whose radius is a mean free path:
//! `n = A / (pi l^2)`. They are uniformly random and belong to the triangle, not to the receiver, like a cloud of
//! points on the surface; a single sample is at the centroid. The positions come from integer arithmetic, and their
//! number from one product and a comparison in `f32`, so that every device takes the same samples.

use std::f64::consts::PI;

use super::points::Sample;
use crate::layout::{MOST_SAMPLES, ObjectParams, SAMPLE_BITS};

/// Samples per squared internal length, from the shortest mean free path of the channels.
#[must_use]
pub fn density(params: &ObjectParams) -> f32 {
    let shortest = params.z_real.iter().copied().map(f64::from).fold(f64::INFINITY, f64::min);
    (1.0 / (PI * shortest * shortest)) as f32
}

/// The number of samples of a triangle of this area, 1 to [`MOST_SAMPLES`].
#[must_use]
pub fn count(area: f32, density: f32) -> u32 {
    let wanted = area * density;
    if wanted < MOST_SAMPLES as f32 { (wanted.ceil() as u32).max(1) } else { MOST_SAMPLES }
}

/// A hash, each of whose bits depends on every bit of `x`: the finalizer `lowbias32`.
fn mixed(mut x: u32) -> u32 {
    x ^= x >> 16;
    x = x.wrapping_mul(0x7feb_352d);
    x ^= x >> 15;
    x = x.wrapping_mul(0x846c_a68b);
    x ^ x >> 16
}

/// The `count` samples of triangle number `face`, as an area rule.
pub fn samples(face: u32, count: u32) -> Vec<Sample> {
    let weight = 1.0 / f64::from(count);
    if count == 1 {
        return vec![[1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0, weight]];
    }
    let one = 1u32 << SAMPLE_BITS;
    let place = |k: u32| {
        let first = mixed(mixed(face) ^ k);
        let (mut a, mut b) = (first >> (32 - SAMPLE_BITS), mixed(first ^ 0x9e37_79b9) >> (32 - SAMPLE_BITS));
        if a + b > one {
            (a, b) = (one - a, one - b);
        }
        let part = |x: u32| f64::from(x) / f64::from(one);
        [part(a), part(b), part(one - a - b), weight]
    };
    (0..count).map(place).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_are_uniform_and_lie_in_the_triangle() {
        // Moments of the uniform distribution: E a = 1/3, E a^2 = 1/6, E ab = 1/12; n = 4096 draws, four deviations.
        for face in [0, 1, 2, 77, 1 << 20] {
            let rule = samples(face, MOST_SAMPLES);
            assert!(rule.iter().all(|s| s[..3].iter().all(|&x| (0.0..=1.0).contains(&x))));
            assert!(rule.iter().all(|s| s[0] + s[1] + s[2] == 1.0));
            let mean = |f: &dyn Fn(&Sample) -> f64| rule.iter().map(|s| s[3] * f(s)).sum::<f64>();
            for k in 0..3 {
                assert!((mean(&|s| s[k]) - 1.0 / 3.0).abs() < 0.015, "{face}");
                assert!((mean(&|s| s[k] * s[k]) - 1.0 / 6.0).abs() < 0.015, "{face}");
                assert!((mean(&|s| s[k] * s[(k + 1) % 3]) - 1.0 / 12.0).abs() < 0.005, "{face}");
            }
        }
        assert_ne!(samples(3, 2), samples(4, 2));
    }

    #[test]
    fn one_for_each_disc_of_a_mean_free_path() {
        let params = ObjectParams { z_real: [0.5, 0.1, 0.3], ..ObjectParams::default() };
        let disc = PI * 0.01;
        for (area, expected) in [(0.0, 1), (0.5, 1), (1.5, 2), (99.5, 100), (1e9, MOST_SAMPLES)] {
            assert_eq!(count((area * disc) as f32, density(&params)), expected);
        }
    }
}
