//! Failures that dispatches show only together.
//!
//! A trace runs the dispatches of a step one at a time, and waits for each. The effect of a barrier that is missing or
//! does nothing does not show there, but in one submission of all, and perhaps not in each.

use super::Case;
use crate::error::Result;

/// Runs of all dispatches in one submission.
const RUNS: usize = 8;

/// Runs a case, whose dispatches are right one at a time, in one submission. If a run is wrong, the case gets its
/// results. All dispatches stay.
pub(super) fn together(mut case: Case, mut run: impl FnMut(&Case) -> Result<Vec<Vec<u32>>>) -> Result<Case> {
    for number in 1..=RUNS {
        let left = run(&case)?;
        if case.compare(&left).wrong.is_empty() {
            continue;
        }
        case.about.fails = true;
        case.about.dispatches += match case.dispatches.len() {
            1 => ", right in one run and wrong in another",
            _ => ", each of them right alone: wrong only in one submission",
        };
        case.about.dispatches += &format!(", here in run {number} of {RUNS}");
        case.buffers.iter_mut().zip(left).for_each(|(part, left)| part.device = left);
        break;
    }
    Ok(case)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::repro::{BITS, Dispatch, Part};

    /// A case of this many dispatches, and the results of its runs.
    fn found(dispatches: usize, runs: &[u32]) -> (Case, usize) {
        let part = Part {
            name: "a".into(),
            before: vec![0],
            expected: vec![7],
            allowed: vec![BITS],
            device: vec![7],
            ..Part::default()
        };
        let dispatches = vec![Dispatch::default(); dispatches];
        let (case, mut done) = (Case { buffers: vec![part], dispatches, about: Default::default() }, 0);
        let run = |_: &Case| {
            done += 1;
            Ok(vec![vec![*runs.get(done - 1).unwrap_or(&7)]])
        };
        (together(case, run).unwrap(), done)
    }

    #[test]
    fn dispatches_that_fail_only_together_stay_together() {
        let (case, done) = found(3, &[7, 7, 5]);
        assert!(case.about.fails && case.dispatches.len() == 3 && done == 3, "{case:?}");
        assert_eq!(case.buffers[0].device, [5]);
        assert!(case.about.dispatches.ends_with("wrong only in one submission, here in run 3 of 8"), "{case:?}");
        let (case, _) = found(1, &[5]);
        assert!(case.about.dispatches.contains("right in one run and wrong in another"), "{case:?}");
        let (case, done) = found(3, &[]);
        assert!(!case.about.fails && case.buffers[0].device == [7] && done == RUNS, "{case:?}");
    }
}
