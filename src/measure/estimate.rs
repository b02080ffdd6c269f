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
    /// Of these estimates for these errors, one of each a receiver, three channels each. A receiver is covered if it is in
    /// every channel; sizes and ranks are those of the three together, the root of their squares.
    #[must_use]
    pub fn of(estimates: &[[f64; 3]], errors: &[[f64; 3]]) -> Self {
        let within = |(estimate, error): &(&[f64; 3], &[f64; 3])| (0..3).all(|c| error[c] <= estimate[c]);
        let covered = estimates.iter().zip(errors).filter(within).count();
        let whole = |list: &[[f64; 3]]| -> Vec<f64> {
            list.iter().map(|v| v.iter().map(|x| x * x).sum::<f64>().sqrt()).collect()
        };
        let (estimate, error) = (whole(estimates), whole(errors));
        Self {
            covered: covered as f64 / errors.len().max(1) as f64,
            ratio: p99(&estimate) / p99(&error),
            rank: correlation(&ranks(&estimate), &ranks(&error)),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_constant_knows_nothing_and_twice_the_error_all() {
        let errors: Vec<[f64; 3]> = (0..1000).map(|k| [0.0, f64::from(k * 7919 % 1000), 0.0]).collect();
        let of =
            |f: &dyn Fn(f64) -> f64| -> Vec<[f64; 3]> { errors.iter().map(|[_, x, _]| [0.0, f(*x), 0.0]).collect() };
        let twice = Quality::of(&of(&|x| 2.0 * x), &errors);
        assert!((twice.covered, twice.ratio) == (1.0, 2.0) && (twice.rank - 1.0).abs() < 1e-12, "{twice:?}");
        let constant = Quality::of(&of(&|_| 899.0), &errors);
        assert_eq!((constant.covered, constant.rank), (0.9, 0.0));
        assert!((Quality::of(&of(&|x| 1.0 / (x + 1.0)), &errors).rank + 1.0).abs() < 1e-12);
        // One channel too low is enough to be uncovered.
        assert_eq!(Quality::of(&[[9.0, 1.0, 9.0], [9.0; 3]], &[[1.0, 2.0, 1.0]; 2]).covered, 0.5);
        assert_eq!(ranks(&[2.0, 1.0, 2.0, 2.0]), [2.0, 0.0, 2.0, 2.0]);
    }
}
