//! Wall time by phase: what a program spends before, between and after the stages of its frames.

use std::cell::RefCell;
use std::time::{Duration, Instant};

/// When the first phase began; the phases so far, in the order in which they ended; and the time of those that ended
/// inside the one under way.
#[derive(Default)]
struct Spent {
    begin: Option<Instant>,
    phases: Vec<(&'static str, Duration)>,
    inside: Duration,
}

thread_local! {
    static SPENT: RefCell<Spent> = RefCell::default();
}

/// Does a phase's work and adds its wall time. A phase inside another counts for itself alone.
pub fn phase<T>(name: &'static str, work: impl FnOnce() -> T) -> T {
    let begin = Instant::now();
    let outer = SPENT.with_borrow_mut(|spent| {
        spent.begin.get_or_insert(begin);
        std::mem::take(&mut spent.inside)
    });
    let result = work();
    let all = begin.elapsed();
    SPENT.with_borrow_mut(|spent| {
        let alone = all.saturating_sub(spent.inside);
        match spent.phases.iter_mut().find(|(known, _)| *known == name) {
            Some((_, sum)) => *sum += alone,
            None => spent.phases.push((name, alone)),
        }
        spent.inside = outer + all;
    });
    result
}

/// Every phase of this thread so far, its name and its wall time, and all time since the first began; milliseconds.
#[must_use]
pub fn phases() -> (Vec<(&'static str, f64)>, f64) {
    let ms = |time: Duration| time.as_secs_f64() * 1e3;
    SPENT.with_borrow(|spent| {
        let phases = spent.phases.iter().map(|(name, time)| (*name, ms(*time))).collect();
        (phases, spent.begin.map_or(0.0, |begin| ms(begin.elapsed())))
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_inner_phase_counts_for_itself() {
        let wait = |ms| std::thread::sleep(Duration::from_millis(ms));
        for _ in 0..2 {
            let six = phase("outer", || {
                wait(5);
                phase("inner", || wait(20));
                6
            });
            assert_eq!(six, 6);
        }
        let (found, all) = phases();
        assert_eq!(found.iter().map(|(name, _)| *name).collect::<Vec<_>>(), ["inner", "outer"]);
        assert!(found[0].1 >= 40.0 && found[1].1 >= 10.0, "{found:?}");
        // Nothing is counted twice.
        assert!(found[0].1 + found[1].1 <= all, "{found:?} of {all}");
    }
}
