//! Relative errors of a sample of pixels, each with the interval in which it lies.

pub use super::statistics::Interval;
use super::statistics::Random;

/// Resamples of the bootstrap.
const RESAMPLES: usize = 1000;

impl Interval {
    /// A relative L2 error, without unit, and its 95 % interval: root of the sum of squared differences over that of
    /// squares of the reference, all channels of all pixels together. The interval is that of a seeded bootstrap over
    /// pixels: a few pixels with most of the error make it wide.
    #[must_use]
    pub fn l2(found: &[[f64; 3]], reference: &[[f64; 3]], seed: u64) -> Self {
        let square = |x: [f64; 3]| x.iter().map(|x| x * x).sum::<f64>();
        let apart = |(a, b): (&[f64; 3], &[f64; 3])| [square([a[0] - b[0], a[1] - b[1], a[2] - b[2]]), square(*b)];
        let pixels: Vec<[f64; 2]> = found.iter().zip(reference).map(apart).collect();
        let root = |[apart, square]: [f64; 2]| (apart / square.max(1e-300)).sqrt();
        let sum = |of: &mut dyn Iterator<Item = [f64; 2]>| of.fold([0.0; 2], |s, x| [s[0] + x[0], s[1] + x[1]]);
        let value = root(sum(&mut pixels.iter().copied()));
        let (mut random, count) = (Random::of(seed), pixels.len());
        let pick = |random: &mut Random| pixels[random.below(count)];
        let mut errors: Vec<f64> =
            (0..RESAMPLES).map(|_| root(sum(&mut (0..count).map(|_| pick(&mut random))))).collect();
        errors.sort_by(f64::total_cmp);
        Self { value, low: errors[RESAMPLES / 40], high: errors[RESAMPLES - 1 - RESAMPLES / 40] }
    }
}

impl std::fmt::Display for Interval {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let short = |x: f64| {
            if x == 0.0 {
                "0".into()
            } else if x < 0.095 {
                format!("{x:.1e}")
            } else {
                format!("{x:.2}")
            }
        };
        write!(f, "{} [{}, {}]", short(self.value), short(self.low), short(self.high))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_digits_are_shown() {
        let shown = Interval { value: 0.1234, low: 0.0567, high: 1.5 }.to_string();
        assert_eq!((shown, Interval::default().to_string()), ("0.12 [5.7e-2, 1.50]".into(), "0 [0, 0]".into()));
    }

    #[test]
    #[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
    fn the_interval_holds_the_error_of_all_pixels_nineteen_times_of_twenty() {
        // Errors of 0.1 to 0.5 of each pixel; many samples of 500 of the same population.
        let mut random = Random::of(5);
        let mut pixel = || (1.0 + random.uniform(), 0.1 + 0.4 * random.uniform());
        let all: Vec<(f64, f64)> = (0..100_000).map(|_| pixel()).collect();
        let of = |pixels: &[(f64, f64)], seed| {
            let reference: Vec<[f64; 3]> = pixels.iter().map(|&(x, _)| [x, 0.0, 2.0 * x]).collect();
            let found: Vec<[f64; 3]> = pixels.iter().map(|&(x, e)| [x * (1.0 + e), 0.0, 2.0 * x * (1.0 - e)]).collect();
            Interval::l2(&found, &reference, seed)
        };
        let (sums, square) = all.iter().fold((0.0, 0.0), |(s, q), (x, e)| (s + (x * e).powi(2), q + x * x));
        let truth = f64::sqrt(sums / square);
        let parts: Vec<Interval> = all.chunks(500).enumerate().map(|(k, part)| of(part, k as u64)).collect();
        let held = parts.iter().filter(|i| i.low <= truth && truth <= i.high).count();
        assert!((180..=198).contains(&held), "{held} of {}", parts.len());
        assert!(parts.iter().all(|i| i.low < i.value && i.value < i.high && i.high - i.low < 0.1 * truth));
        assert_eq!(of(&all[..500], 3), of(&all[..500], 3));
    }
}
