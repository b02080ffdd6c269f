//! Median and 10th and 90th percentile of repeated measurements.

use crate::measure::statistics::median;

/// The median of some values, and their 10th and 90th percentile.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Quantiles {
    /// The median.
    pub median: f64,
    /// The 10th percentile.
    pub low: f64,
    /// The 90th percentile.
    pub high: f64,
}

impl Quantiles {
    /// The quantiles of these values; NaN for an empty list, or if a value is NaN.
    pub fn of(mut values: Vec<f64>) -> Self {
        values.sort_by(f64::total_cmp);
        if values.last().is_none_or(|last| last.is_nan()) {
            return Self { median: f64::NAN, low: f64::NAN, high: f64::NAN };
        }
        let at = |share: f64| values[((values.len() - 1) as f64 * share).round() as usize];
        Self { low: at(0.1), high: at(0.9), median: median(values) }
    }
}

#[cfg(test)]
mod tests {
    use super::Quantiles;

    #[test]
    fn a_tenth_lies_on_either_side() {
        let spread = Quantiles::of((0..=10).rev().map(f64::from).collect());
        assert_eq!(spread, Quantiles { median: 5.0, low: 1.0, high: 9.0 });
        assert_eq!(Quantiles::of(vec![2.0, 1.0]).median, 1.5);
        assert!(Quantiles::of(vec![1.0, f64::NAN]).median.is_nan() && Quantiles::of(Vec::new()).low.is_nan());
    }
}
