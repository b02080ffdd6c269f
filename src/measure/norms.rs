//! Error norms of radiosity, as all tables report them.

use super::sample::Sample;

/// Error norms of one colour channel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Norms {
    /// sqrt(sum A dB^2 / sum A B^2).
    pub l2: f64,
    /// 99th percentile of |dB| / rms(B), over the faces that the receivers stand for.
    pub p99: f64,
    /// Maximum of |dB| / rms(B) over the receivers.
    pub max: f64,
}

impl Norms {
    /// Not measured.
    pub const UNKNOWN: Self = Self { l2: f64::NAN, p99: f64::NAN, max: f64::NAN };
}

/// Error norms per channel of `values` against `reference`; each receiver of the sample stands for an area and a
/// number of faces. Where the reference is black, the norms are 0 if the values are black too, otherwise infinite.
pub fn norms(Sample { areas, counts, .. }: &Sample, values: &[[f64; 3]], reference: &[[f64; 3]]) -> [Norms; 3] {
    std::array::from_fn(|channel| {
        let weighted = |f: &dyn Fn(usize) -> f64| -> f64 { (0..areas.len()).map(|i| areas[i] * f(i)).sum() };
        let difference = |i: usize| values[i][channel] - reference[i][channel];
        let power = weighted(&|i| reference[i][channel].powi(2));
        let whole: f64 = areas.iter().sum();
        if power <= 0.0 || whole <= 0.0 {
            // Black reference: any light, and NaN, counts as an infinite error.
            let dark = (0..areas.len()).all(|i| values[i][channel] == 0.0);
            let all = if dark { 0.0 } else { f64::INFINITY };
            return Norms { l2: all, p99: all, max: all };
        }
        let rms = (power / whole).sqrt();
        let mut sizes: Vec<[f64; 2]> = (0..areas.len()).map(|i| [difference(i).abs() / rms, counts[i]]).collect();
        sizes.sort_by(|a, b| a[0].total_cmp(&b[0]));
        Norms {
            l2: (weighted(&|i| difference(i).powi(2)) / power).sqrt(),
            p99: percentile(&sizes, 0.99),
            max: sizes.last().map_or(0.0, |last| last[0]),
        }
    })
}

/// Weighted percentile of sorted `[value, weight]` pairs: the smallest value such that at least this share of the
/// weight is at or below it.
pub(super) fn percentile(sorted: &[[f64; 2]], share: f64) -> f64 {
    let whole: f64 = sorted.iter().map(|[_, weight]| weight).sum();
    let mut below = 0.0;
    for [value, weight] in sorted {
        below += weight;
        if below >= share * whole * (1.0 - 1e-12) {
            return *value;
        }
    }
    sorted.last().map_or(0.0, |last| last[0])
}

/// The largest of each norm over the channels; NaN if any is NaN.
pub fn worst(norms: &[Norms; 3]) -> Norms {
    let larger = |a: f64, b: f64| if b.is_nan() || b > a { b } else { a };
    let largest = |norm: fn(&Norms) -> f64| norms.iter().map(norm).fold(0.0, larger);
    Norms { l2: largest(|n| n.l2), p99: largest(|n| n.p99), max: largest(|n| n.max) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_percentile_goes_by_weight() {
        assert_eq!(percentile(&[[1.0, 98.0], [2.0, 1.0], [3.0, 1.0]], 0.99), 2.0);
        assert_eq!(percentile(&[[1.0, 1.0], [2.0, 1.0], [3.0, 98.0]], 0.99), 3.0);
        assert_eq!(percentile(&[], 0.99), 0.0);
    }

    #[test]
    fn a_known_difference() {
        // One of 100 receivers is off by 10 % of the value that all share.
        let sample = Sample { faces: (0..100).collect(), areas: vec![2.0; 100], counts: vec![1.0; 100] };
        let reference = vec![[1.0, 2.0, 0.0]; 100];
        let mut values = reference.clone();
        values[7][0] = 1.1;
        let n = norms(&sample, &values, &reference);
        assert!((n[0].l2 - 0.01).abs() < 1e-12 && n[0].p99 < 1e-12 && (n[0].max - 0.1).abs() < 1e-12);
        assert_eq!(n[1], Norms::default());
        assert_eq!(n[2], Norms::default());
        assert_eq!(worst(&n), n[0]);

        // NaN, and light on a black reference, must not be hidden.
        values[3][1] = f64::NAN;
        values[5][2] = 1e-9;
        let n = norms(&sample, &values, &reference);
        assert!(worst(&n).max.is_nan() && worst(&n).l2.is_nan());
        assert_eq!(n[2].l2, f64::INFINITY);
    }
}
