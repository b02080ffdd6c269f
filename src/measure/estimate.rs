//! Quality of an error estimate: how often it lies above the true error, by how much, and whether it finds where the
//! errors are.

use super::norms::percentile;

/// An estimate compared with the true errors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Quality {
    /// Share of faces whose error is at most the estimate; each receiver stands for a number of faces.
    pub covered: f64,
    /// 99th percentile of the estimate over the 99th percentile of the error.
    pub ratio: f64,
    /// Spearman's rank correlation of estimate and error over the faces; 0 if either is constant.
    pub rank: f64,
}

/// The 99th percentile, weighted by the number of faces per receiver.
fn p99(values: &[f64], counts: &[f64]) -> f64 {
    let mut sorted: Vec<[f64; 2]> = values.iter().zip(counts).map(|(&value, &count)| [value, count]).collect();
    sorted.sort_by(|a, b| a[0].total_cmp(&b[0]));
    percentile(&sorted, 0.99)
}

/// Ranks weighted by the number of faces per receiver; equal values share one rank.
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

/// Weighted correlation of two lists, 0 if either is constant.
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

impl Quality {
    /// Compares estimates with errors, one of each per receiver, three channels each; `counts` holds the number of
    /// faces that each receiver stands for. A receiver is covered if it is covered in every channel. Percentiles and
    /// ranks use the Euclidean norm over the channels.
    #[must_use]
    pub fn of(counts: &[f64], estimates: &[[f64; 3]], errors: &[[f64; 3]]) -> Self {
        let within = |(estimate, error): &(&[f64; 3], &[f64; 3])| (0..3).all(|c| error[c] <= estimate[c]);
        let pairs = || estimates.iter().zip(errors).zip(counts);
        let covered: f64 = pairs().filter(|(pair, _)| within(pair)).map(|(_, count)| count).sum();
        let whole = |list: &[[f64; 3]]| -> Vec<f64> {
            list.iter().map(|v| v.iter().map(|x| x * x).sum::<f64>().sqrt()).collect()
        };
        let (estimate, error) = (whole(estimates), whole(errors));
        Self {
            // An empty sum is -0.
            covered: (covered + 0.0) / counts.iter().sum::<f64>(),
            ratio: p99(&estimate, counts) / p99(&error, counts),
            rank: correlation(&ranks(&estimate, counts), &ranks(&error, counts), counts),
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
        let twice = Quality::of(&[1.0; 1000], &of(&|x| 2.0 * x), &errors);
        assert!((twice.covered, twice.ratio) == (1.0, 2.0) && (twice.rank - 1.0).abs() < 1e-12, "{twice:?}");
        let constant = Quality::of(&[1.0; 1000], &of(&|_| 899.0), &errors);
        assert_eq!((constant.covered, constant.rank), (0.9, 0.0));
        assert!((Quality::of(&[1.0; 1000], &of(&|x| 1.0 / (x + 1.0)), &errors).rank + 1.0).abs() < 1e-12);
        // A receiver is not covered if a single channel is too low.
        assert_eq!(Quality::of(&[1.0, 1.0], &[[9.0, 1.0, 9.0], [9.0; 3]], &[[1.0, 2.0, 1.0]; 2]).covered, 0.5);
        assert_eq!(ranks(&[2.0, 1.0, 2.0, 2.0], &[1.0, 1.0, 1.0, 2.0]), [3.0, 0.5, 3.0, 3.0]);
    }
}
