//! What samples in a row say about the run itself: where warming up ends, and whether the rest drifts.

use super::median;

/// Fewest samples in which warming up or a drift is looked for.
const FEWEST: usize = 8;
/// Standard deviations of the rank correlation beyond which a trend is not due to chance: two-sided 1 %.
const TREND: f64 = 2.576;

/// How many of the first samples belong to warming up: those before the first that is on the other side of the median
/// of the second half, whether above or below. At most half; 0 for fewer than 8 samples.
///
/// Samples that are warm from the start lose two on average.
#[must_use]
pub fn warm_up(samples: &[f64]) -> usize {
    let half = samples.len() / 2;
    if samples.len() < FEWEST {
        return 0;
    }
    let warm = median(samples[half..].to_vec());
    let same = |sample: &&f64| **sample != warm && (**sample > warm) == (samples[0] > warm);
    samples[..half].iter().take_while(same).count()
}

/// The change from the first to the last third of the samples, as a share of the first, if there is a trend:
/// Spearman's correlation of rank and place is not 0 at 1 %. `None` without one, and for fewer than 8 samples.
#[must_use]
pub fn drift(samples: &[f64]) -> Option<f64> {
    let count = samples.len();
    if count < FEWEST || samples.iter().any(|sample| sample.is_nan()) {
        return None;
    }
    let mut places: Vec<usize> = (0..count).collect();
    places.sort_by(|a, b| samples[*a].total_cmp(&samples[*b]));
    let middle = 0.5 * (count as f64 - 1.0);
    let apart = |(rank, place): (usize, &usize)| (rank as f64 - middle) * (*place as f64 - middle);
    let sum: f64 = places.iter().enumerate().map(apart).sum();
    let correlation = 12.0 * sum / (count as f64 * (count as f64 * count as f64 - 1.0));
    let third = count / 3;
    let [first, last] = [&samples[..third], &samples[count - third..]].map(|part| median(part.to_vec()));
    (correlation.abs() * (count as f64 - 1.0).sqrt() > TREND && first != last).then(|| last / first - 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::statistics::Random;

    #[test]
    fn the_first_samples_are_dropped_until_they_are_like_the_rest() {
        let mut random = Random::of(1);
        let mut noisy = |base: f64| base * (1.0 + 0.02 * random.uniform());
        let cold: Vec<f64> = (0..40).map(|k| noisy(1.0 + f64::exp(-f64::from(k) / 2.0))).collect();
        assert!((7..=14).contains(&warm_up(&cold)), "{}", warm_up(&cold));
        // A clock that is fast until the device is hot.
        let hot: Vec<f64> = (0..40).map(|k| noisy(if k < 9 { 0.9 } else { 1.0 })).collect();
        assert!((9..=11).contains(&warm_up(&hot)), "{}", warm_up(&hot));
        let dropped: usize = (0..100).map(|_| warm_up(&(0..40).map(|_| noisy(1.0)).collect::<Vec<_>>())).sum();
        assert!((100..300).contains(&dropped), "{dropped}");
        assert_eq!((warm_up(&[1.0; 20]), warm_up(&[9.0, 8.0, 1.0]), warm_up(&[])), (0, 0, 0));
        // One that never ends takes half.
        assert_eq!(warm_up(&(0..20).map(f64::from).collect::<Vec<_>>()), 10);
    }

    #[test]
    fn a_trend_is_told_and_noise_is_none() {
        let mut random = Random::of(2);
        let mut run = |slope: f64| -> Vec<f64> {
            (0..41).map(|k| 1.0 + slope * f64::from(k) / 40.0 + 0.02 * random.uniform()).collect()
        };
        let found = drift(&run(0.03)).unwrap();
        assert!((found - 0.02).abs() < 0.008, "{found}");
        assert!(drift(&run(-0.03)).unwrap() < -0.01);
        let none = (0..200).filter(|_| drift(&run(0.0)).is_some()).count();
        assert!(none <= 6, "{none} of 200");
        assert!(drift(&[1.0, 2.0, 3.0]).is_none() && drift(&[1.0; 20]).is_none());
    }
}
