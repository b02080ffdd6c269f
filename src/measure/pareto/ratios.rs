//! Times at equal error: each method's curve evaluated at round errors, and the ratio to one method of the same run.
//!
//! Curves are interpolated between their points, linearly on logarithmic axes, and never extrapolated.

use super::{Against, Lighting, Method, Sweep, front};
use crate::measure::table::Table;

/// The norm of the error at which times are compared.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Norm {
    /// The L2 norm.
    L2,
    /// The 99th percentile.
    P99,
}

/// The errors at which times are compared.
pub const TARGETS: [f64; 3] = [1e-2, 1e-3, 1e-4];

/// The time at which a curve reaches an error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Reach {
    /// This time, interpolated or at a point.
    At(f64),
    /// At most this time: even the coarsest setting has a smaller error.
    Within(f64),
    /// Even the finest measured setting has a larger error.
    NotReached,
    /// Nothing was measured.
    NotMeasured,
}

/// One method at one error under one lighting.
#[derive(Clone, Debug)]
pub struct Ratio {
    /// The method.
    pub method: &'static Method,
    /// The lighting.
    pub lighting: Lighting,
    /// The reference of the error.
    pub against: Against,
    /// The norm of the error.
    pub norm: Norm,
    /// Wall-clock time at each of the targets 1e-2, 1e-3 and 1e-4, milliseconds.
    pub times: [Reach; 3],
    /// The times of the method that ratios refer to.
    pub base: [Reach; 3],
}

/// The time at which a curve of (error, time) points reaches an error.
pub fn time_at(curve: &[(f64, f64)], target: f64) -> Reach {
    // Keep only the curve's own Pareto front, from the largest error down: time increases along it.
    let pairs: Vec<(f64, f64)> = curve.iter().map(|&(error, time)| (time, error)).collect();
    let kept = front(&pairs).into_iter().zip(curve).filter(|(on, _)| *on);
    let mut line: Vec<(f64, f64)> = kept.map(|(_, &point)| point).collect();
    line.sort_by(|a, b| b.0.total_cmp(&a.0));
    let Some(after) = line.iter().position(|&(error, _)| error <= target) else {
        return if line.is_empty() { Reach::NotMeasured } else { Reach::NotReached };
    };
    let (error, time) = line[after];
    if error == target {
        return Reach::At(time);
    }
    match after.checked_sub(1).map(|before| line[before]) {
        Some((larger, sooner)) if error > 0.0 && sooner > 0.0 => {
            let share = (larger / target).ln() / (larger / error).ln();
            Reach::At(sooner * (time / sooner).powf(share))
        }
        _ => Reach::Within(time),
    }
}

/// Times of every measured method at round errors, and those of the method `base`.
pub fn ratios(sweep: &Sweep, base: &Method) -> Vec<Ratio> {
    let mut list = Vec::new();
    for lighting in Lighting::ALL {
        for &against in sweep.yardsticks() {
            for norm in [Norm::L2, Norm::P99] {
                let read = |method: &Method| {
                    let own = sweep.measured(lighting).filter(|(point, _)| point.method.name == method.name);
                    let error = |norms: crate::measure::norms::Norms| match norm {
                        Norm::L2 => norms.l2,
                        Norm::P99 => norms.p99,
                    };
                    let curve: Vec<_> = own.map(|(_, run)| (error(against.of(run)), run.wall_ms)).collect();
                    TARGETS.map(|target| time_at(&curve, target))
                };
                let base = read(base);
                let methods = sweep.methods();
                let ratio = |method| Ratio { method, lighting, against, norm, times: read(method), base };
                list.extend(methods.into_iter().map(ratio).filter(|ratio| ratio.times != [Reach::NotMeasured; 3]));
            }
        }
    }
    list
}

impl Ratio {
    /// Time and ratio to the base at one target, as text.
    pub fn cell(&self, target: usize) -> String {
        let ratio = |sign: &str, time: f64, base: f64| {
            let ratio = time / base;
            let digits = (1 - ratio.log10().floor() as i32).clamp(0, 6) as usize;
            format!("{time:.2} ms, {sign}{ratio:.digits$}x")
        };
        match (self.times[target], self.base[target]) {
            (Reach::NotMeasured, _) => "-".into(),
            (Reach::NotReached, _) => "not reached".into(),
            (Reach::At(time), Reach::At(base)) => ratio("", time, base),
            (Reach::At(time), Reach::Within(base)) => ratio(">= ", time, base),
            (Reach::Within(time), Reach::At(base)) => format!("<= {}", ratio("<= ", time, base)),
            (Reach::At(time), _) => format!("{time:.2} ms"),
            (Reach::Within(time), _) => format!("<= {time:.2} ms"),
        }
    }

    /// The norm and the reference of the error.
    pub fn error(&self) -> String {
        format!("{} {}", if self.norm == Norm::L2 { "L2" } else { "p99" }, self.against.name())
    }

    /// A table with a row for each.
    pub fn table(ratios: &[Self]) -> Table {
        let time = "wall time of a frame with this error, and its ratio to that of the first method";
        Table::of(
            ratios,
            &[
                ("light", "whether it changes in every frame", &|ratio| ratio.lighting.name().into()),
                (
                    "error",
                    "norm, and what it is measured against: own leaf sums, or the area integral in total",
                    &Self::error,
                ),
                ("method", "", &|ratio| ratio.method.name.into()),
                ("1e-2", time, &|ratio| ratio.cell(0)),
                ("1e-3", time, &|ratio| ratio.cell(1)),
                ("1e-4", time, &|ratio| ratio.cell(2)),
            ],
        )
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn between_two_points_along_a_power_law() {
        // time = 1 / error is a straight line on logarithmic axes; the order of the points does not matter.
        let curve = [(1e-3, 1e3), (1e-1, 1e1), (1e-5, 1e5)];
        for target in [1e-2, 1e-4] {
            let Reach::At(time) = time_at(&curve, target) else { panic!("{target}") };
            assert!((time * target - 1.0).abs() < 1e-12, "{time}");
        }
        assert_eq!(time_at(&curve, 1e-3), Reach::At(1e3));
    }

    #[test]
    fn a_curve_is_never_continued() {
        let curve = [(5e-2, 3.0), (2e-3, 40.0)];
        assert_eq!(time_at(&curve, 1e-4), Reach::NotReached);
        assert_eq!(time_at(&curve, 0.5), Reach::Within(3.0));
        assert_eq!(time_at(&[], 1e-2), Reach::NotMeasured);
        assert_eq!(time_at(&[(f64::NAN, 1.0)], 1e-2), Reach::NotMeasured);
        assert_eq!(time_at(&[(1e-1, 1.0), (0.0, 2.0)], 1e-2), Reach::Within(2.0));
    }

    #[test]
    fn a_bound_stays_a_bound() {
        let cell = |time, base| {
            let (lighting, against, norm) = (Lighting::Moves, Against::Own, Norm::L2);
            let method = &super::super::METHODS[0];
            Ratio { method, lighting, against, norm, times: [time; 3], base: [base; 3] }.cell(1)
        };
        assert_eq!(cell(Reach::At(50.0), Reach::At(200.0)), "50.00 ms, 0.25x");
        assert_eq!(cell(Reach::Within(50.0), Reach::At(4.0)), "<= 50.00 ms, <= 12x");
        assert_eq!(cell(Reach::At(50.0), Reach::Within(500.0)), "50.00 ms, >= 0.10x");
        assert_eq!(cell(Reach::Within(5.0), Reach::Within(1.0)), "<= 5.00 ms");
        assert_eq!(cell(Reach::At(5.0), Reach::NotReached), "5.00 ms");
        assert_eq!(cell(Reach::NotReached, Reach::At(1.0)), "not reached");
    }

    #[test]
    fn a_setting_that_is_slower_and_worse_is_passed_over() {
        let curve = [(1e-1, 1.0), (8e-2, 50.0), (1e-3, 10.0)];
        let Reach::At(time) = time_at(&curve, 1e-2) else { panic!("in between") };
        assert!((time - 10f64.sqrt()).abs() < 1e-12, "{time}");
    }
}
