//! A measurement repeated: the median, and from where to where four of five values lie.

/// The median of some values, and their 10th and 90th percentile.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Quantiles {
    /// The middle one, the lower of two.
    pub median: f64,
    /// A tenth lies below.
    pub low: f64,
    /// A tenth lies above.
    pub high: f64,
}

impl Quantiles {
    /// Of these values; not a number where there are none, or one is none.
    pub fn of(mut values: Vec<f64>) -> Self {
        values.sort_by(f64::total_cmp);
        if values.last().is_none_or(|last| last.is_nan()) {
            return Self { median: f64::NAN, low: f64::NAN, high: f64::NAN };
        }
        let at = |share: f64| values[((values.len() - 1) as f64 * share).round() as usize];
        Self { median: values[(values.len() - 1) / 2], low: at(0.1), high: at(0.9) }
    }
}

#[cfg(test)]
mod tests {
    use super::Quantiles;

    #[test]
    fn a_tenth_lies_on_either_side() {
        let spread = Quantiles::of((0..=10).rev().map(f64::from).collect());
        assert_eq!(spread, Quantiles { median: 5.0, low: 1.0, high: 9.0 });
        assert_eq!(Quantiles::of(vec![2.0, 1.0]).median, 1.0);
        assert!(Quantiles::of(vec![1.0, f64::NAN]).median.is_nan() && Quantiles::of(Vec::new()).low.is_nan());
    }
}
