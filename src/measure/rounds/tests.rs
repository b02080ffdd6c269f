//! Rounds of variants whose times are made up.

use super::*;
use crate::measure::statistics::Random;

/// A stage of about 10 ms and one of about 1 ms.
struct Made {
    name: &'static str,
    random: Random,
    factor: f64,
    noise: f64,
    frames: usize,
}

impl Made {
    fn new(name: &'static str, seed: u64, factor: f64, noise: f64) -> Self {
        Self { name, random: Random::of(seed), factor, noise, frames: 0 }
    }
}

impl Variant for Made {
    fn name(&self) -> String {
        self.name.into()
    }

    fn frame(&mut self) -> Result<Frame> {
        self.frames += 1;
        let cold = if self.frames <= 4 { 2.0 } else { 1.0 };
        let mut step = |name: &str, ms: f64| Timing {
            name: name.into(),
            milliseconds: ms * cold * (1.0 + self.noise * self.random.uniform()),
            start: 0.0,
        };
        let steps = vec![step("large", 5.0 * self.factor), step("small", 0.1), step("large", 5.0 * self.factor)];
        let wall = steps.iter().map(|step| step.milliseconds).sum();
        Ok(Frame { start: 0.0, wall, steps })
    }
}

fn schedule(rounds: usize) -> Schedule {
    Schedule { rounds, until: None, budget: f64::INFINITY, seed: 3 }
}

fn two(factor: f64, noise: f64, schedule: &Schedule) -> Measured {
    run(&mut [&mut Made::new("a", 1, 1.0, noise), &mut Made::new("b", 2, factor, noise)], schedule).unwrap()
}

#[test]
fn a_slower_stage_is_found_and_nothing_else() {
    let found = two(1.02, 0.04, &schedule(60));
    let rows = found.samples.ratios().remove(0);
    let names: Vec<&str> = rows.iter().map(|row| row.what.as_str()).collect();
    assert_eq!(names, ["large", "small", "stages", "frame"]);
    let shown: Vec<_> = rows.iter().map(|row| row.finding()).collect();
    assert_eq!(shown, [Some("slower"), None, Some("slower"), Some("slower")]);
    assert!((rows[0].ratio.value - 1.02).abs() < 0.01 && (rows[0].ms[0].value - 10.2).abs() < 0.1, "{rows:?}");
    // The first four rounds were twice as long.
    assert!((4..9).contains(&found.samples.warm_up), "{}", found.samples.warm_up);
    assert_eq!((found.frames[0].len(), found.samples.rounds() + found.samples.warm_up), (60, 60));
}

#[test]
fn the_order_is_drawn_and_is_that_of_the_seed() {
    let orders = two(1.0, 0.1, &schedule(40)).samples.orders;
    let first = orders.iter().filter(|order| order[..] == [0, 1]).count();
    assert!((12..=28).contains(&first) && orders.iter().all(|order| order.len() == 2), "{orders:?}");
    assert_eq!(orders, two(1.0, 0.1, &schedule(40)).samples.orders);
    assert_ne!(orders, two(1.0, 0.1, &Schedule { seed: 4, ..schedule(40) }).samples.orders);
}

#[test]
fn rounds_end_when_intervals_are_narrow_or_the_budget_is_spent() {
    let until = Schedule { until: Some(0.01), ..schedule(10_000) };
    let (quiet, noisy) = (two(1.0, 0.02, &until).samples, two(1.0, 0.2, &until).samples);
    assert!(quiet.rounds() < noisy.rounds() && noisy.rounds() < 5000, "{} {}", quiet.rounds(), noisy.rounds());
    for samples in [&quiet, &noisy] {
        let (what, width) = samples.widest().unwrap();
        assert!(width <= 0.01 && ["large", "stages"].contains(&what.as_str()), "{what} {width}");
    }
    let spent = two(1.0, 0.2, &Schedule { budget: 0.0, ..until });
    assert_eq!(spent.frames[1].len(), 3);
    // A single variant has medians.
    let only = run(&mut [&mut Made::new("a", 1, 1.0, 0.1)], &until).unwrap().samples;
    assert!(only.widest().unwrap().1 <= 0.01 && only.ratios().is_empty());
}

#[test]
fn intervals_hold_although_their_width_ends_the_run() {
    let until = Schedule { until: Some(0.02), ..schedule(10_000) };
    let held = (0..100).filter(|seed| {
        let mut variants = [Made::new("a", 7 * seed, 1.0, 0.3), Made::new("b", 7 * seed + 1, 1.1, 0.3)];
        let [a, b] = &mut variants;
        let found = run(&mut [a, b], &Schedule { seed: *seed, ..until }).unwrap().samples.ratios().remove(0);
        !found[0].ratio.excludes(1.1)
    });
    let held = held.count();
    assert!(held >= 95, "{held}");
}

#[test]
fn samples_come_back_from_a_file_and_are_compared() {
    let (a, b) = (two(1.0, 0.04, &schedule(60)).samples, two(1.0, 0.04, &Schedule { seed: 9, ..schedule(60) }).samples);
    let text = serde_json::to_string(&a).unwrap();
    assert_eq!(serde_json::from_str::<Samples>(&text).unwrap(), a);
    assert_eq!(a.fault(), None);
    let mut slower = run(&mut [&mut Made::new("a", 5, 1.1, 0.04)], &schedule(60)).unwrap().samples;
    assert!(a.against(&b).iter().all(|row| row.finding().is_none()), "{:?}", a.against(&b));
    let rows = a.against(&slower);
    let shown: Vec<_> = rows.iter().map(Ratio::finding).collect();
    assert_eq!(shown, [Some("slower"), None, Some("slower"), Some("slower")]);
    // What only one has is told.
    slower.variants[0].stages.remove(1);
    assert_eq!(a.against(&slower).len(), 3);
    assert_eq!(Samples::unshared(&a.variants[0], &slower.variants[0]), ["small"]);
    slower.variants[0].stages[0].ms.pop();
    assert!(slower.fault().unwrap().contains("large has 59 samples, not 60"));
}

#[test]
fn a_stage_without_timestamps_has_no_samples() {
    struct Blind;
    impl Variant for Blind {
        fn name(&self) -> String {
            "blind".into()
        }
        fn frame(&mut self) -> Result<Frame> {
            let step = Timing { name: "x".into(), milliseconds: f64::NAN, start: f64::NAN };
            Ok(Frame { start: 0.0, wall: 1.0, steps: vec![step] })
        }
    }
    let found = run(&mut [&mut Blind, &mut Blind], &schedule(30)).unwrap().samples;
    assert!(found.variants[0].stages.is_empty());
    let rows = found.ratios().remove(0);
    assert_eq!((rows.len(), rows[0].what.as_str(), rows[0].finding()), (1, "frame", None));
}
