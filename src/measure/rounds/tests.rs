//! Rounds of variants whose times are made up.

use super::*;
use crate::measure::statistics::Random;

/// A stage of about 10 ms, up to 1 % more for as long as it runs, and one of about 0.1 ms.
struct Made {
    random: Random,
    factor: f64,
    noise: f64,
    frames: usize,
}

impl Made {
    fn new(seed: u64, factor: f64, noise: f64) -> Self {
        let mut random = Random::of(seed);
        let lies = 1.0 + 0.01 * random.uniform();
        Self { random, factor: lies * factor, noise, frames: 0 }
    }
}

impl Variant for Made {
    fn frame(&mut self) -> Result<Frame> {
        self.frames += 1;
        let cold = if self.frames <= 4 { 2.0 } else { 1.0 };
        let mut step = |name: &str, ms: f64| Timing {
            name: name.into(),
            milliseconds: ms * cold * (1.0 + self.noise * self.random.uniform()),
            ..Timing::default()
        };
        let steps = vec![step("large", 5.0 * self.factor), step("small", 0.1), step("large", 5.0 * self.factor)];
        let wall = steps.iter().map(|step| step.milliseconds).sum();
        Ok(Frame { wall, steps, ..Frame::default() })
    }
}

fn schedule(rounds: usize) -> Schedule {
    Schedule { rounds, until: None, budget: f64::INFINITY, seed: 3 }
}

/// Two variants, the second of which takes `factor` times as long.
fn two(factor: f64, noise: f64, schedule: &Schedule) -> Measured {
    edited(factor, noise, schedule, &[]).0
}

/// Two such variants with these edited stages, and what was told after the first start.
fn edited(factor: f64, noise: f64, schedule: &Schedule, stages: &[&str]) -> (Measured, Forecast) {
    let starter = |name: &str, seed: u64, factor: f64| {
        let mut seeds = Random::of(seed);
        let start = move || Ok(Box::new(Made::new((seeds.uniform() * 1e9) as u64, factor, noise)) as _);
        Starter { name: name.into(), start: Box::new(start) }
    };
    let seed = 1000 * schedule.seed;
    let mut both = [starter("a", seed + 1, 1.0), starter("b", seed + 2, factor)];
    let (stages, mut forecast) = (stages.iter().map(|name| name.to_string()).collect::<Vec<_>>(), None);
    let found = compare(&mut both, schedule, &stages, &mut |found| forecast = Some(*found)).unwrap();
    (found, forecast.unwrap())
}

#[test]
fn a_slower_stage_is_found_and_nothing_else() {
    let found = two(1.02, 0.04, &schedule(160));
    let rows = found.samples.ratios().remove(0);
    let names: Vec<&str> = rows.iter().map(|row| row.what.as_str()).collect();
    assert_eq!(names, ["large", "small", "stages", "frame"]);
    let shown: Vec<_> = rows.iter().map(|row| row.finding()).collect();
    assert_eq!(shown, [Some("slower"), None, Some("slower"), Some("slower")]);
    assert!((rows[0].ratio.value - 1.02).abs() < 0.01 && (rows[0].ms[0].value - 10.25).abs() < 0.1, "{rows:?}");
    // The first four rounds of each start were twice as long.
    let samples = &found.samples;
    assert_eq!((samples.each, samples.warm_up, samples.rounds(), found.frames[0].len()), (8, 4, 80, 160));
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
    assert!(quiet.rounds() <= noisy.rounds() && noisy.rounds() < 5000, "{} {}", quiet.rounds(), noisy.rounds());
    for samples in [&quiet, &noisy] {
        let (what, width) = samples.widest().unwrap();
        assert!(width <= 0.01 && ["large", "stages"].contains(&what.as_str()), "{what} {width}");
    }
    let spent = two(1.0, 0.2, &Schedule { budget: 0.0, ..until });
    assert_eq!(spent.frames[1].len(), 8);
    // A single variant has medians.
    let only = run(&mut Made::new(1, 1.0, 0.1), &until).unwrap().samples;
    assert!(only.widest().unwrap().1 <= 0.01 && only.ratios().is_empty());
}

#[test]
fn intervals_hold_although_their_width_ends_the_run() {
    let until = Schedule { until: Some(0.02), ..schedule(10_000) };
    let held = (0..100).filter(|seed| {
        let found = two(1.1, 0.3, &Schedule { seed: *seed, ..until }).samples.ratios().remove(0);
        !found[0].ratio.excludes(1.1)
    });
    let held = held.count();
    assert!(held >= 95, "{held}");
}

#[test]
fn samples_come_back_from_a_file_and_are_compared() {
    let other = Schedule { seed: 9, ..schedule(160) };
    let (a, b) = (two(1.0, 0.04, &schedule(160)).samples, two(1.0, 0.04, &other).samples);
    let text = serde_json::to_string(&a).unwrap();
    let read: Samples = serde_json::from_str(&text).unwrap();
    // Numbers of JSON may differ in their last bit.
    let rounded =
        |samples: &Samples| -> Vec<f32> { samples.variants[1].frame_ms.iter().map(|ms| *ms as f32).collect() };
    assert_eq!((&read.orders, read.each, read.warm_up), (&a.orders, 8, 4));
    assert_eq!((rounded(&read), read.fault()), (rounded(&a), None));
    assert_eq!(read.variants[1].stages.len(), 2);
    let mut slower = run(&mut Made::new(5, 1.1, 0.04), &schedule(60)).unwrap().samples;
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
        fn frame(&mut self) -> Result<Frame> {
            let step = Timing { name: "x".into(), milliseconds: f64::NAN, ..Timing::default() };
            Ok(Frame { wall: 1.0, steps: vec![step], ..Frame::default() })
        }
    }
    let blind = || Starter { name: "blind".into(), start: Box::new(|| Ok(Box::new(Blind) as _)) };
    let found = compare(&mut [blind(), blind()], &schedule(80), &[], &mut |_| {}).unwrap().samples;
    assert!(found.variants[0].stages.is_empty());
    let rows = found.ratios().remove(0);
    assert_eq!((rows.len(), rows[0].what.as_str(), rows[0].finding()), (1, "frame", None));
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn the_same_program_started_twice_is_no_finding() {
    // Each start lies up to 1 % off, for all of its rounds.
    let wrong = (0..400).filter(|seed| {
        let found = two(1.0, 0.01, &Schedule { seed: *seed, ..schedule(ROUNDS) }).samples.ratios().remove(0);
        found.iter().any(|row| row.finding().is_some())
    });
    let wrong = wrong.count();
    assert!(wrong <= 20, "{wrong} of 400");
}

#[test]
fn few_frames_are_enough_starts_for_a_verdict() {
    // Nine starts at least, of a ninth of the rounds, eight at most.
    for (rounds, expected) in [(1, [9, 1]), (11, [9, 2]), (40, [9, 5]), (72, [9, 8]), (128, [16, 8])] {
        let (found, forecast) = edited(3.0, 0.01, &schedule(rounds), &["large"]);
        let starts = found.samples.orders.len() / found.samples.each;
        assert_eq!(([starts, found.samples.each], [forecast.starts, forecast.each]), (expected, expected), "{rounds}");
        assert_eq!(forecast.fewest, [6, 7]);
        let rows = found.samples.ratios().remove(0);
        let shown: Vec<_> = rows.iter().map(Ratio::shows).collect();
        assert_eq!(shown, ["slower", "", "slower", "slower"], "{rows:?}");
        assert!(rows.iter().all(|row| row.ratio.high.is_finite() && row.missing_rounds == 0 && row.hidden() > 0.0));
    }
}

#[test]
fn without_enough_starts_even_a_large_ratio_is_undecided() {
    let spent = Schedule { budget: 0.0, ..schedule(40) };
    let rows = edited(3.0, 0.01, &spent, &["large"]).0.samples.ratios().remove(0);
    assert!(rows.iter().all(|row| row.shows() == "undecided" && row.finding().is_none()), "{rows:?}");
    // One start of five rounds is there; the edited stage takes six, the three others together seven.
    assert_eq!(rows.iter().map(|row| row.missing_rounds).collect::<Vec<_>>(), [25, 30, 30, 30]);
    // With six starts the edited stage is judged, and no other.
    let mut samples = edited(3.0, 0.01, &schedule(40), &["large"]).0.samples;
    for variant in &mut samples.variants {
        variant.frame_ms.truncate(30);
        variant.stages.iter_mut().for_each(|times| times.ms.truncate(30));
    }
    let rows = samples.ratios().remove(0);
    assert_eq!(rows.iter().map(Ratio::shows).collect::<Vec<_>>(), ["slower", "undecided", "undecided", "undecided"]);
    assert_eq!(rows[1].missing_rounds, 5);
    // Files have samples in place of starts.
    let few = run(&mut Made::new(5, 1.0, 0.04), &schedule(12)).unwrap().samples;
    let rows = few.against(&few);
    assert!(rows.iter().all(|row| row.shows() == "undecided" && row.missing_rounds == 20 - few.rounds()), "{rows:?}");
}

#[test]
fn a_stage_in_turn_is_the_only_row() {
    let mut starts = Vec::new();
    let mut start = |rounds: &[[usize; 2]]| {
        starts.push(rounds.to_vec());
        let mut both = [Made::new(starts.len() as u64, 1.0, 0.02), Made::new(starts.len() as u64 + 99, 1.05, 0.02)];
        let mut frames = [Vec::new(), Vec::new()];
        for which in rounds.iter().flatten() {
            let steps = both[*which].frame()?.steps.into_iter().filter(|step| step.name == "large").collect();
            frames[*which].push(Frame { wall: f64::NAN, steps, ..Frame::default() });
        }
        Ok(frames)
    };
    let mut forecast = None;
    let mut told = |found: &Forecast| forecast = Some(*found);
    let found = alternate(["a", "b"], &schedule(IN_TURN), "large", &mut start, &mut told).unwrap().samples;
    let forecast = forecast.unwrap();
    assert_eq!((forecast.starts, forecast.each, forecast.fewest), (STARTS, IN_TURN / STARTS, [6, 0]));
    let rows = found.ratios().remove(0);
    assert!(rows.len() == 1 && rows[0].what == "large" && rows[0].finding() == Some("slower"), "{rows:?}");
    // Each round has both, in the order that was drawn for it.
    assert_eq!(found.orders, starts.concat().iter().map(|round| round.to_vec()).collect::<Vec<_>>());
    let first = found.orders.iter().filter(|order| order[..] == [0, 1]).count();
    assert!(found.orders.len() == IN_TURN && (IN_TURN / 3..IN_TURN * 2 / 3).contains(&first), "{first}");
}
