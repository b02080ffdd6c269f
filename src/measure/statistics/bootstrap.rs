//! Medians and their ratios by the bootstrap: percentile intervals over resampled medians.
//!
//! A median's interval is also at least the one that ranks alone give, because resampling a dozen samples finds too few
//! medians near the ends. What is resampled are blocks of neighbouring samples, as long as the cube root of their
//! number, from a circle: frames that follow one another share other load on the machine and the clock's frequency, and
//! an interval that takes each for a new piece of evidence is too narrow (Politis and Romano 1992).

use super::{Interval, Random, median};

/// Least number of resamples.
const RESAMPLES: f64 = 2000.0;
/// With more samples than this, resampling alone finds a median's interval.
const MANY: usize = 200;
/// Fewest samples on either side for an interval of a ratio of medians.
pub const FEWEST: usize = 20;
/// Resampled medians beyond either end of the interval, at least.
const BEYOND: f64 = 10.0;

/// The median of some samples in the order in which they were taken, and its interval of this confidence, up to
/// infinity where there are too few. Not a number for an empty list, or if a sample is not a number.
#[must_use]
pub fn median_interval(samples: &[f64], confidence: f64, seed: u64) -> Interval {
    let mut random = Random::of(seed);
    let found = interval(median(samples.to_vec()), confidence, || median(resampled(samples, &mut random)));
    if found.value.is_nan() || samples.len() > MANY {
        return found;
    }
    let [low, high] = ranked(samples, confidence);
    Interval { low: found.low.min(low), high: found.high.max(high), ..found }
}

/// The interval of a median from one of the sorted samples to another: how many samples are below the true median is a
/// matter of chance, by the binomial distribution.
fn ranked(samples: &[f64], confidence: f64) -> [f64; 2] {
    let mut sorted = samples.to_vec();
    sorted.sort_by(f64::total_cmp);
    let (count, tail) = (sorted.len(), 0.5 * (1.0 - confidence));
    let (mut chance, mut below, mut rank) = (0.5f64.powi(count as i32), 0.0, 0);
    while below + chance <= tail {
        below += chance;
        chance *= (count - rank) as f64 / (rank + 1) as f64;
        rank += 1;
    }
    if rank == 0 { [0.0, f64::INFINITY] } else { [sorted[rank - 1], sorted[count - rank]] }
}

/// The ratio of the medians, `after` to `before`, of samples that were not taken together, and its interval of this
/// confidence: from 0 to infinity with fewer than 20 samples on a side.
#[must_use]
pub fn ratio_of_medians(before: &[f64], after: &[f64], confidence: f64, seed: u64) -> Interval {
    let mut random = Random::of(seed);
    let value = median(after.to_vec()) / median(before.to_vec());
    if before.len().min(after.len()) < FEWEST {
        return Interval { value, low: 0.0, high: f64::INFINITY };
    }
    interval(value, confidence, || median(resampled(after, &mut random)) / median(resampled(before, &mut random)))
}

/// The percentile interval of a value that `again` computes from resampled data.
fn interval(value: f64, confidence: f64, mut again: impl FnMut() -> f64) -> Interval {
    if !value.is_finite() {
        return Interval { value: f64::NAN, low: f64::NAN, high: f64::NAN };
    }
    let tail = 0.5 * (1.0 - confidence);
    let count = f64::max(RESAMPLES, (BEYOND / tail).ceil()) as usize;
    let mut values: Vec<f64> = (0..count).map(|_| again()).collect();
    values.sort_by(f64::total_cmp);
    let beyond = (tail * count as f64) as usize;
    Interval { value, low: values[beyond], high: values[count - 1 - beyond] }
}

/// As many samples as these, drawn in blocks from random places.
fn resampled(samples: &[f64], random: &mut Random) -> Vec<f64> {
    let (count, block) = (samples.len(), (samples.len() as f64).cbrt().round() as usize);
    let mut drawn = Vec::with_capacity(count + block);
    while drawn.len() < count {
        let first = random.below(count);
        drawn.extend((first..first + block).map(|at| samples[at % count]));
    }
    drawn.truncate(count);
    drawn
}
