//! The Pareto front: the points that no other point dominates in time and error.

use super::{Lighting, Run, Sweep};
use crate::measure::norms::Norms;

/// The reference of an error.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Against {
    /// Brute force over the method's own leaf sums: only the error of its clustering.
    Own,
    /// The area integral over the same faces.
    Total,
    /// A random walk, over patches: this includes the error of the model.
    Truth,
}

impl Against {
    /// The error norms of a run.
    pub fn of(self, run: &Run) -> Norms {
        match self {
            Self::Own => run.own,
            Self::Total => run.total,
            Self::Truth => run.truth.map_or(Norms::UNKNOWN, |truth| truth.norms()),
        }
    }

    /// The reference in words.
    pub fn name(self) -> &'static str {
        match self {
            Self::Own => "against its own leaf sums",
            Self::Total => "against the area integral",
            Self::Truth => "against a random walk",
        }
    }
}

/// Marks the (time, error) pairs that no other pair dominates, by being at least as good in both and better in one.
/// Equal pairs are marked alike; a pair that is not finite is never on the front and dominates none.
pub fn front(pairs: &[(f64, f64)]) -> Vec<bool> {
    let dominates = |a: (f64, f64), b: (f64, f64)| a.0 <= b.0 && a.1 <= b.1 && (a.0 < b.0 || a.1 < b.1);
    let sound = |pair: (f64, f64)| pair.0.is_finite() && pair.1.is_finite();
    pairs.iter().map(|&pair| sound(pair) && !pairs.iter().any(|&other| dominates(other, pair))).collect()
}

/// Marks the points of a sweep that are on the front of their lighting, by wall-clock time and L2.
pub fn mark(sweep: &Sweep, against: Against) -> Vec<bool> {
    let mut marks = vec![false; sweep.points.len()];
    for lighting in Lighting::ALL {
        let (places, pairs): (Vec<usize>, Vec<(f64, f64)>) = sweep
            .points
            .iter()
            .enumerate()
            .filter(|(_, point)| point.lighting == lighting)
            .filter_map(|(k, point)| point.run.as_ref().ok().map(|run| (k, (run.wall_ms, against.of(run).l2))))
            .unzip();
        for (place, on) in places.into_iter().zip(front(&pairs)) {
            marks[place] = on;
        }
    }
    marks
}

#[cfg(test)]
mod tests {
    use super::front;

    #[test]
    fn what_is_beaten_in_both_is_off_the_front() {
        assert_eq!(front(&[(1.0, 0.1), (2.0, 0.01), (3.0, 0.05), (0.5, 0.2)]), [true, true, false, true]);
        assert_eq!(front(&[]), [false; 0]);
        assert_eq!(front(&[(7.0, 7.0)]), [true]);
    }

    #[test]
    fn ties() {
        // Equal in one and worse in the other is dominated; equal pairs are marked alike.
        assert_eq!(front(&[(1.0, 0.1), (1.0, 0.2), (2.0, 0.1)]), [true, false, false]);
        assert_eq!(front(&[(1.0, 0.1), (1.0, 0.1), (2.0, 0.05)]), [true, true, true]);
        assert_eq!(front(&[(1.0, 0.1), (1.0, 0.1), (0.5, 0.1)]), [false, false, true]);
    }

    #[test]
    fn no_number_is_never_on_the_front() {
        assert_eq!(
            front(&[(f64::NAN, 0.0), (1.0, f64::NAN), (1.0, f64::INFINITY), (2.0, 0.1)]),
            [false, false, false, true]
        );
    }
}
