//! How good an error estimate is: how often it lies above the error, by how much, and whether it knows where the errors are.

use super::norms::percentile;

/// An estimate against true errors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quality {
    /// Share of the faces, as the receivers stand for them, whose error is at most the estimate.
    pub covered: f64,
    /// 99th percentile of the estimate over that of the error.
    pub ratio: f64,
    /// Spearman's rank correlation of estimate and error over the faces; 0 where either has no ranks.
    pub rank: f64,
    /// The same if errors were normal and the estimate in proportion to their standard deviations: what may be asked of one
    /// that varies no more than this one does and cannot know where errors happen to cancel.
    pub best: f64,
}

/// The 99th percentile over the faces that the receivers stand for.
fn p99(values: &[f64], counts: &[f64]) -> f64 {
    let mut sorted: Vec<[f64; 2]> = values.iter().zip(counts).map(|(&value, &count)| [value, count]).collect();
    sorted.sort_by(|a, b| a[0].total_cmp(&b[0]));
    percentile(&sorted, 0.99)
}

/// Ranks among the faces that the receivers stand for, equal values sharing theirs.
fn ranks(values: &[f64], counts: &[f64]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&a, &b| values[a].total_cmp(&values[b]));
    let mut ranks = vec![0.0; values.len()];
    let mut before = 0.0;
    for run in order.chunk_by(|&a, &b| values[a] == values[b]) {
        let here: f64 = run.iter().map(|&k| counts[k]).sum();
        run.iter().for_each(|&k| ranks[k] = before + 0.5 * here);
        before += here;
    }
    ranks
}

/// The correlation of two lists over faces, 0 where one of them is constant.
fn correlation(a: &[f64], b: &[f64], counts: &[f64]) -> f64 {
    let whole: f64 = counts.iter().sum();
    let mean = |list: &[f64]| list.iter().zip(counts).map(|(x, count)| x * count).sum::<f64>() / whole;
    let (mean_a, mean_b) = (mean(a), mean(b));
    let sum = |f: &dyn Fn(f64, f64) -> f64| -> f64 {
        a.iter().zip(b).zip(counts).map(|((x, y), count)| count * f(x - mean_a, y - mean_b)).sum()
    };
    let both = (sum(&|x, _| x * x) * sum(&|_, y| y * y)).sqrt();
    if both > 0.0 { sum(&|x, y| x * y) / both } else { 0.0 }
}

/// Number `k` of a fixed list of normal deviates (Box and Muller 1958, by the R2 sequence).
fn deviate(k: usize) -> f64 {
    let at = |step: f64| ((k as f64 + 0.5) * step).fract();
    let (u, turn) = (at(0.754_877_666_246_692_8), at(0.569_840_290_998_053_2));
    (-2.0 * u.max(1e-12).ln()).sqrt() * (std::f64::consts::TAU * turn).cos().abs()
}

impl Quality {
    /// Of these estimates for these errors, one of each a receiver, three channels each; a receiver stands for a count of
    /// faces. A receiver is covered if it is in every channel; sizes and ranks are those of the three together, the root of
    /// their squares.
    #[must_use]
    pub fn of(counts: &[f64], estimates: &[[f64; 3]], errors: &[[f64; 3]]) -> Self {
        let within = |(estimate, error): &(&[f64; 3], &[f64; 3])| (0..3).all(|c| error[c] <= estimate[c]);
        let pairs = || estimates.iter().zip(errors).zip(counts);
        let covered: f64 = pairs().filter(|(pair, _)| within(pair)).map(|(_, count)| count).sum();
        let whole = |list: &[[f64; 3]]| -> Vec<f64> {
            list.iter().map(|v| v.iter().map(|x| x * x).sum::<f64>().sqrt()).collect()
        };
        let (estimate, error) = (whole(estimates), whole(errors));
        let drawn: Vec<f64> = estimate.iter().enumerate().map(|(k, size)| size * deviate(k)).collect();
        let ranked = ranks(&estimate, counts);
        Self {
            covered: covered / counts.iter().sum::<f64>(),
            ratio: p99(&estimate, counts) / p99(&error, counts),
            rank: correlation(&ranked, &ranks(&error, counts), counts),
            best: correlation(&ranked, &ranks(&drawn, counts), counts),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_varies_little_cannot_rank_well() {
        // Errors that are normal, with standard deviations over a range of this width: no estimate knows more than those.
        let of = |width: f64| {
            let size = |k: u32| (width * f64::from(k * 7919 % 1000) / 1000.0).exp();
            let sizes: Vec<[f64; 3]> = (0..1000).map(|k| [size(k), 0.0, 0.0]).collect();
            let normal = |k: u32| {
                let sum: f64 =
                    (1..=12).map(|j| (f64::from(k * 13 + j) * 0.618_033_988_75 * f64::from(j)).fract()).sum();
                sum - 6.0
            };
            let errors: Vec<[f64; 3]> = (0..1000).map(|k| [size(k) * normal(k), 0.0, 0.0]).collect();
            Quality::of(&[1.0; 1000], &sizes, &errors)
        };
        let [narrow, wide] = [of(1.3), of(6.0)];
        assert!((narrow.rank - narrow.best).abs() < 0.08 && narrow.best < 0.4, "{narrow:?}");
        assert!((wide.rank - wide.best).abs() < 0.08 && wide.best > 0.75, "{wide:?}");
        // Deviates are normal.
        let mean = (0..10_000).map(|k| deviate(k).powi(2)).sum::<f64>() / 1e4;
        let within = (0..10_000).filter(|&k| deviate(k) < 1.0).count();
        assert!((mean - 1.0).abs() < 0.02 && (6777..6877).contains(&within), "{mean}, {within}");
    }

    #[test]
    fn a_constant_knows_nothing_and_twice_the_error_all() {
        let errors: Vec<[f64; 3]> = (0..1000).map(|k| [0.0, f64::from(k * 7919 % 1000), 0.0]).collect();
        let of =
            |f: &dyn Fn(f64) -> f64| -> Vec<[f64; 3]> { errors.iter().map(|[_, x, _]| [0.0, f(*x), 0.0]).collect() };
        let twice = Quality::of(&[1.0; 1000], &of(&|x| 2.0 * x), &errors);
        assert!((twice.covered, twice.ratio) == (1.0, 2.0) && (twice.rank - 1.0).abs() < 1e-12, "{twice:?}");
        let constant = Quality::of(&[1.0; 1000], &of(&|_| 899.0), &errors);
        assert_eq!((constant.covered, constant.rank), (0.9, 0.0));
        assert!((Quality::of(&[1.0; 1000], &of(&|x| 1.0 / (x + 1.0)), &errors).rank + 1.0).abs() < 1e-12);
        // One channel too low is enough to be uncovered.
        assert_eq!(Quality::of(&[1.0, 1.0], &[[9.0, 1.0, 9.0], [9.0; 3]], &[[1.0, 2.0, 1.0]; 2]).covered, 0.5);
        assert_eq!(ranks(&[2.0, 1.0, 2.0, 2.0], &[1.0, 1.0, 1.0, 2.0]), [3.0, 0.5, 3.0, 3.0]);
    }
}
