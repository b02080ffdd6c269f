//! The ratio of two variants that were measured in the same rounds, or started together: the Hodges-Lehmann estimate of
//! the logarithms of the pairs' ratios, with the interval that Wilcoxon's signed-rank test does not reject.
//!
//! Which variant comes first is drawn anew for each pair. So if both take the same time, swapping them in a pair is as
//! likely as not, whatever the noise is: outliers, drift, and load that lasts for many rounds change the size of a
//! pair's difference but not the chance of its sign. The test depends on nothing else, so that its interval holds at
//! least as often as it says, from the first rounds on; and for Gaussian noise it is 5 % wider than that of a t-test,
//! where one about the median would be 25 % wider.

use super::Interval;

/// Up to this many pairs the test's distribution is computed; beyond, it is Gaussian, with slightly heavier tails.
const EXACT: usize = 64;

/// The ratio of the second to the first of each pair, and its interval of this confidence: from 0 to infinity where
/// there are too few pairs for it. Pairs with a value that is not finite or not above 0 are left out; without any, the
/// ratio is not a number.
#[must_use]
pub fn paired_ratio(pairs: &[[f64; 2]], confidence: f64) -> Interval {
    let mut logs: Vec<f64> = pairs.iter().map(|[before, after]| (after / before).ln()).collect();
    logs.retain(|log| log.is_finite());
    logs.sort_by(f64::total_cmp);
    if logs.is_empty() {
        return Interval { value: f64::NAN, low: 0.0, high: f64::INFINITY };
    }
    let count = logs.len() * (logs.len() + 1) / 2;
    let value = (0.5 * (mean(&logs, (count - 1) / 2) + mean(&logs, count / 2))).exp();
    match critical(logs.len(), 0.5 * (1.0 - confidence)) {
        Some(k) => Interval { value, low: mean(&logs, k).exp(), high: mean(&logs, count - 1 - k).exp() },
        None => Interval { value, low: 0.0, high: f64::INFINITY },
    }
}

/// The fewest pairs with which the interval of this confidence has two ends.
#[must_use]
pub fn fewest_pairs(confidence: f64) -> usize {
    let tail = 0.5 * (1.0 - confidence);
    (1..EXACT).find(|count| 0.5f64.powi(*count as i32) <= tail).unwrap_or(EXACT)
}

/// The `k`-th smallest, counted from 0, of the means of all pairs of these sorted values, each with itself included.
fn mean(sorted: &[f64], k: usize) -> f64 {
    // How many means are at most this.
    let at_most = |bound: f64| {
        let (mut found, mut above) = (0, sorted.len());
        for (first, value) in sorted.iter().enumerate() {
            while above > 0 && 0.5 * (value + sorted[above - 1]) > bound {
                above -= 1;
            }
            found += above.saturating_sub(first);
        }
        found
    };
    let (mut low, mut high) = (sorted[0], sorted[sorted.len() - 1]);
    if at_most(low) > k {
        return low;
    }
    // `low` has too few, `high` has enough.
    loop {
        let middle = 0.5 * (low + high);
        if middle <= low || middle >= high {
            return high;
        }
        if at_most(middle) > k { high = middle } else { low = middle }
    }
}

/// The largest number such that the sum of ranks is at most that in no more than this share of all cases; `None` if not
/// even 0 is such a number.
fn critical(count: usize, tail: f64) -> Option<usize> {
    if count > EXACT {
        let n = count as f64;
        let deviation = (n * (n + 1.0) * (2.0 * n + 1.0) / 24.0).sqrt();
        return Some((n * (n + 1.0) / 4.0 - deviates(tail) * deviation - 0.5).max(0.0) as usize);
    }
    // The chance of each sum: each rank is in it or not.
    let mut chances = vec![0.0; count * (count + 1) / 2 + 1];
    chances[0] = 0.5f64.powi(count as i32);
    for rank in 1..=count {
        for sum in (rank..chances.len()).rev() {
            chances[sum] += chances[sum - rank];
        }
    }
    let mut below = 0.0;
    chances
        .iter()
        .take_while(|chance| {
            below += *chance;
            below <= tail
        })
        .count()
        .checked_sub(1)
}

/// How many standard deviations above the mean a share `tail`, at most one half, of a Gaussian lies: Abramowitz and
/// Stegun 26.2.23, within 4.5e-4.
fn deviates(tail: f64) -> f64 {
    let t = (-2.0 * tail.ln()).sqrt();
    t - (2.515517 + t * (0.802853 + t * 0.010328)) / (1.0 + t * (1.432788 + t * (0.189269 + t * 0.001308)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ranks_are_those_of_tables() {
        // Wilcoxon's table, two-sided 5 % and 1 %.
        for (count, five, one) in
            [(6, Some(0), None), (8, Some(3), Some(0)), (10, Some(8), Some(3)), (30, Some(137), Some(109))]
        {
            assert_eq!((critical(count, 0.025), critical(count, 0.005)), (five, one), "{count}");
        }
        assert_eq!(critical(5, 0.025), None);
        // Gauss continues it.
        let exact = critical(EXACT, 0.00125).unwrap() as f64;
        let next = critical(EXACT + 1, 0.00125).unwrap() as f64;
        assert!(next > exact && next < exact + 32.0, "{exact} {next}");
        assert!((deviates(0.025) - 1.959964).abs() < 5e-4 && (deviates(0.00125) - 3.023341).abs() < 5e-4);
    }

    #[test]
    fn means_of_pairs_are_sorted() {
        let values = [-3.0, -1.0, 0.5, 0.5, 4.0];
        let mut all: Vec<f64> = (0..5).flat_map(|i| (i..5).map(move |j| 0.5 * (values[i] + values[j]))).collect();
        all.sort_by(f64::total_cmp);
        for (k, expected) in all.iter().enumerate() {
            assert!((mean(&values, k) - expected).abs() < 1e-12, "{k}: {} {expected}", mean(&values, k));
        }
    }

    #[test]
    fn an_interval_has_ends_from_the_fewest_pairs_on() {
        for (rows, expected) in [(1, 6), (2, 7), (12, 9), (20, 10), (25, 10), (26, 11), (51, 11), (52, 12)] {
            let confidence = crate::measure::statistics::each_of(0.95, rows);
            let fewest = fewest_pairs(confidence);
            assert_eq!(fewest, expected, "{rows} rows");
            let bounded = |count: usize| paired_ratio(&vec![[1.0, 2.0]; count], confidence).high.is_finite();
            assert!(bounded(fewest) && !bounded(fewest - 1), "{rows} rows, {fewest} pairs");
        }
    }

    #[test]
    fn few_pairs_say_little() {
        let few = paired_ratio(&[[1.0, 2.0]; 5], 0.95);
        assert_eq!((few.low, few.high), (0.0, f64::INFINITY));
        assert!((few.value - 2.0).abs() < 1e-12);
        let enough = paired_ratio(&[[1.0, 2.0]; 6], 0.95);
        assert!((enough.low - 2.0).abs() < 1e-12 && (enough.high - 2.0).abs() < 1e-12);
        assert!(paired_ratio(&[[0.0, 1.0], [f64::NAN, 1.0], [0.0, 0.0]], 0.95).value.is_nan());
    }
}
