//! Statistics of repeated measurements: medians and ratios with their confidence intervals, where warming up ends, and
//! drift. Pure functions of samples; nothing here runs or times anything.
//!
//! - [`median_interval`]: a median, with the percentile interval of a bootstrap over blocks of neighbouring samples.
//! - [`paired_ratio`]: the ratio of two variants measured in the same rounds in random order. Its interval holds at
//!   least as often as it says, whatever the noise is.
//! - [`fewest_pairs`]: the fewest pairs for which that interval has two ends.
//! - [`ratio_of_medians`]: the ratio of two runs that were not measured together, such as those of two files.
//! - [`each_of`]: the confidence that each of several intervals needs so that all hold at once.
//! - [`warm_up`] and [`drift`]: how many of the first samples to drop, and whether the rest has a trend.

mod bootstrap;
mod paired;
mod random;
mod series;
#[cfg(test)]
mod tests;

use serde::Serialize;

pub use bootstrap::{FEWEST, median_interval, ratio_of_medians};
pub use paired::{fewest_pairs, paired_ratio};
pub use random::Random;
pub use series::{drift, warm_up};

/// A measured value and its confidence interval.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Interval {
    /// The value that the samples give.
    pub value: f64,
    /// The lower end of the interval.
    pub low: f64,
    /// The upper end of the interval.
    pub high: f64,
}

impl Interval {
    /// Half its width as a share of the value; infinite or not a number where there are too few samples.
    #[must_use]
    pub fn half_width(&self) -> f64 {
        (self.high - self.low) / (2.0 * self.value)
    }

    /// Whether this value lies outside the interval.
    #[must_use]
    pub fn excludes(&self, value: f64) -> bool {
        self.high < value || self.low > value
    }
}

/// The confidence of each of `count` intervals with which all of them hold at least with `together` (Bonferroni).
#[must_use]
pub fn each_of(together: f64, count: usize) -> f64 {
    1.0 - (1.0 - together) / count.max(1) as f64
}

/// The median: the mean of the middle two for an even number of values; not a number for an empty list, or if a value
/// is not a number.
#[must_use]
pub fn median(mut values: Vec<f64>) -> f64 {
    let count = values.len();
    if count == 0 || values.iter().any(|value| value.is_nan()) {
        return f64::NAN;
    }
    let (below, &mut upper, _) = values.select_nth_unstable_by(count / 2, f64::total_cmp);
    if count % 2 == 1 {
        return upper;
    }
    let lower = below.iter().copied().fold(f64::NEG_INFINITY, f64::max);
    0.5 * (lower + upper)
}
