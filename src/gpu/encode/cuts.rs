//! Where a frame's commands are cut into several submissions. The driver of a display resets a device that works on one
//! for more than two seconds or so; and while it works, the desktop stands still.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::time::Duration;

use crate::gpu::list::{Entry, Place, Timing};

/// How long a step of each name, for each part of the work, took at most when it ran last, milliseconds.
#[derive(Default)]
pub(in super::super) struct Paces(RefCell<BTreeMap<(String, Place), f64>>);

impl Paces {
    /// Notes the times of a frame's parts, which are in the order of their beginnings.
    pub(in super::super) fn note(&self, list: &[Entry], times: &[Timing]) {
        let mut latest: BTreeMap<(String, Place), f64> = BTreeMap::new();
        let parts = list.iter().filter_map(|entry| match entry {
            Entry::Begin(name, place) => Some((name.clone(), *place)),
            Entry::Dispatch(_) | Entry::Copy(_) | Entry::End => None,
        });
        for (part, time) in parts.zip(times).filter(|(_, time)| time.milliseconds.is_finite()) {
            let longest = latest.entry(part).or_default();
            *longest = longest.max(time.milliseconds);
        }
        self.0.borrow_mut().extend(latest);
    }

    /// The entries of a list before which another submission begins, so that none takes longer than `limit`. A step
    /// that has not been timed is a submission of its own, so that on a device without timestamps every step is; of a
    /// step that takes longer each dispatch is.
    pub(in super::super) fn cuts(&self, list: &[Entry], limit: Duration) -> Vec<usize> {
        let (paces, limit) = (self.0.borrow(), limit.as_secs_f64() * 1e3);
        let (mut cuts, mut used, mut apart, mut dispatches) = (Vec::new(), 0.0, false, 0);
        for (at, entry) in list.iter().enumerate() {
            match entry {
                Entry::Begin(name, place) => {
                    let pace = paces.get(&(name.clone(), *place)).copied();
                    if used + pace.unwrap_or(f64::INFINITY) > limit && used > 0.0 {
                        cuts.push(at);
                        used = 0.0;
                    }
                    used += pace.unwrap_or(f64::INFINITY);
                    (apart, dispatches) = (pace.is_some_and(|pace| pace > limit), 0);
                }
                Entry::Dispatch(_) => {
                    if apart && dispatches > 0 {
                        cuts.push(at);
                    }
                    dispatches += 1;
                }
                Entry::Copy(_) => {}
                // The device's own last dispatch belongs to no step.
                Entry::End => apart = false,
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
        let times = [time("a", 4.0), time("b", 1.0), time("b", 5.0), time("c", 1.0), time("d", f64::NAN)];
        paces.note(&steps, &times);
        assert_eq!(paces.cuts(&steps, limit), [4, 8]);
        paces.note(&list(&["b", "d"]), &[time("b", 1.0), time("d", 0.0)]);
        assert_eq!(paces.cuts(&steps, limit), [0usize; 0]);
        assert_eq!(paces.cuts(&steps, Duration::from_nanos(1)), [2, 4, 6, 8]);
    }

    #[test]
    fn parts_of_the_work_have_times_of_their_own() {
        let (paces, limit) = (Paces::default(), Duration::from_millis(10));
        let step = |object: usize| {
            [
                Entry::Begin("a".into(), Place([Some(("object", object)), None, None])),
                Entry::End,
                list(&["b"])[0].clone(),
            ]
        };
        let time = |milliseconds| Timing { milliseconds, ..Timing::default() };
        paces.note(&step(0), &[time(9.0), time(2.0)]);
        paces.note(&step(1), &[time(1.0), time(2.0)]);
        assert_eq!(paces.cuts(&step(0), limit), [2]);
        assert_eq!(paces.cuts(&step(1), limit), [0usize; 0]);
    }
}
