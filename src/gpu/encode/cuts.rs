//! Where a frame's commands are cut into several submissions. The driver of a display resets a device that works on one
//! for more than two seconds or so; and while it works, the desktop stands still.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::time::Duration;

use crate::gpu::list::{Entry, Timing};

/// How long a step of each name took at most when it ran last, milliseconds.
#[derive(Default)]
pub(in super::super) struct Paces(RefCell<BTreeMap<String, f64>>);

impl Paces {
    /// Notes the times of a frame.
    pub(in super::super) fn note(&self, times: &[Timing]) {
        let mut latest: BTreeMap<&str, f64> = BTreeMap::new();
        for time in times.iter().filter(|time| time.milliseconds.is_finite()) {
            let longest = latest.entry(&time.name).or_default();
            *longest = longest.max(time.milliseconds);
        }
        self.0.borrow_mut().extend(latest.into_iter().map(|(name, ms)| (name.to_string(), ms)));
    }

    /// The entries of a list before which another submission begins, so that none takes longer than `limit`. A step
    /// that has not been timed is a submission of its own; each dispatch is, of a step that takes longer.
    pub(in super::super) fn cuts(&self, list: &[Entry], limit: Duration) -> Vec<usize> {
        let (paces, limit) = (self.0.borrow(), limit.as_secs_f64() * 1e3);
        let (mut cuts, mut used, mut open, mut apart, mut dispatches) = (Vec::new(), 0.0, 0, false, 0);
        for (at, entry) in list.iter().enumerate() {
            match entry {
                Entry::Begin(name, _) => {
                    let pace = paces.get(name).copied();
                    // Steps have no steps within them; what kernels of a step are timed as has.
                    if open == 0 {
                        if used + pace.unwrap_or(f64::INFINITY) > limit && used > 0.0 {
                            cuts.push(at);
                            used = 0.0;
                        }
                        used += pace.unwrap_or(f64::INFINITY);
                        (apart, dispatches) = (pace.is_some_and(|pace| pace > limit), 0);
                    }
                    open += 1;
                }
                Entry::Dispatch(_) => {
                    if apart && open > 0 && dispatches > 0 {
                        cuts.push(at);
                    }
                    dispatches += 1;
                }
                Entry::End => open -= 1,
            }
        }
        cuts
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::list::Place;

    /// Steps of these names, without dispatches.
    fn list(names: &[&str]) -> Vec<Entry> {
        names.iter().flat_map(|name| [Entry::Begin((*name).to_string(), Place::default()), Entry::End]).collect()
    }

    #[test]
    fn no_submission_takes_longer_than_it_may() {
        let (paces, limit) = (Paces::default(), Duration::from_millis(10));
        let steps = list(&["a", "b", "b", "c", "d"]);
        // Where nothing is known, each step is alone.
        assert_eq!(paces.cuts(&steps, limit), [2, 4, 6, 8]);
        let time = |name: &str, milliseconds| Timing { name: name.into(), milliseconds, ..Timing::default() };
        // The longer one of two counts; a step that is not timed stays alone.
        paces.note(&[time("a", 4.0), time("b", 1.0), time("b", 5.0), time("c", 1.0), time("d", f64::NAN)]);
        assert_eq!(paces.cuts(&steps, limit), [4, 8]);
        paces.note(&[time("b", 1.0), time("d", 0.0)]);
        assert_eq!(paces.cuts(&steps, limit), [0usize; 0]);
        assert_eq!(paces.cuts(&steps, Duration::from_nanos(1)), [2, 4, 6, 8]);
    }
}
