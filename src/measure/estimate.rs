//! How good an error estimate is: how often it lies above the error, by how much, and whether it knows where the errors are.

/// An estimate against true errors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quality {
    /// Share of receivers whose error is at most the estimate.
    pub covered: f64,
    /// 99th percentile of the estimate over that of the error.
    pub ratio: f64,
    /// Spearman's rank correlation of estimate and error; 0 where either has no ranks.
    pub rank: f64,
}

/// The 99th percentile, as [`super::norms`] takes it.
fn p99(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted.get((sorted.len() * 99).div_ceil(100).saturating_sub(1)).copied().unwrap_or(0.0)
}

/// Ranks, equal values sharing theirs.
fn ranks(values: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
    let mut ranks = vec![0.0; values.len()];
    let mut before = 0;
    for run in order.chunk_by(|&a, &b| values[a] == values[b]) {
        run.iter().for_each(|&k| ranks[k] = before as f64 + 0.5 * (run.len() as f64 - 1.0));
        before += run.len();
    }
    ranks
}

/// The correlation of two lists, 0 where one of them is constant.
fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let n = a.len().max(1) as f64;
    let (mean_a, mean_b) = (a.iter().sum::<f64>() / n, b.iter().sum::<f64>() / n);
    let sum = |f: &dyn Fn(f64, f64) -> f64| a.iter().zip(b).map(|(x, y)| f(x - mean_a, y - mean_b)).sum::<f64>();
    let both = (sum(&|x, _| x * x) * sum(&|_, y| y * y)).sqrt();
    if both > 0.0 { sum(&|x, y| x * y) / both } else { 0.0 }
}

impl Quality {
    /// Of these estimates for these errors, one of each a receiver.
    #[must_use]
    pub fn of(estimates: &[f64], errors: &[f64]) -> Self {
        let covered = estimates.iter().zip(errors).filter(|(estimate, error)| error <= estimate).count();
        Self {
            covered: covered as f64 / errors.len().max(1) as f64,
            ratio: p99(estimates) / p99(errors),
            rank: correlation(&ranks(estimates), &ranks(errors)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_constant_knows_nothing_and_twice_the_error_all() {
        let errors: Vec<f64> = (0..1000).map(|k| f64::from(k * 7919 % 1000)).collect();
        let twice: Vec<f64> = errors.iter().map(|x| 2.0 * x).collect();
        let quality = Quality::of(&twice, &errors);
        assert!((quality.covered, quality.ratio) == (1.0, 2.0) && (quality.rank - 1.0).abs() < 1e-12, "{quality:?}");
        let quality = Quality::of(&[899.0; 1000], &errors);
        assert_eq!((quality.covered, quality.rank), (0.9, 0.0));
        let falling: Vec<f64> = errors.iter().map(|x| -x.powi(3)).collect();
        assert!((Quality::of(&falling, &errors).rank + 1.0).abs() < 1e-12);
        assert_eq!(ranks(&[2.0, 1.0, 2.0, 2.0]), [2.0, 0.0, 2.0, 2.0]);
    }
}
