//! Limits beyond which a comparison of times or of work fails.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use milkglass::error::{Error, Result};
use milkglass::measure::profile::Work;
use milkglass::measure::rounds::Ratio;

use crate::cli::timing::share;

/// What is allowed.
#[derive(Args, Clone, Default)]
pub(super) struct Gate {
    /// Fail if something got slower by more than this, such as 2%: if the whole interval of its ratio is above 1 +
    /// SHARE. Of kernels that are replaced: their stages, and the sum of all; else every row.
    #[arg(long, value_name = "SHARE", value_parser = share)]
    fail_slower: Option<f64>,
    /// Fail if a replaced kernel does more work: if an exact count of its stage grows by more than this.
    #[arg(long, value_name = "SHARE", value_parser = share)]
    fail_work: Option<f64>,
    /// Whether --fail-slower lets pass what it cannot decide: where the interval holds 1 + SHARE, or is none yet.
    #[arg(long, value_enum, default_value_t, requires = "fail_slower")]
    undecided: Undecided,
    /// Also write what the limits were held to as JUnit XML, for build servers: a suite for each comparison, a case for
    /// each row.
    #[arg(long, value_name = "FILE")]
    pub(super) junit: Option<PathBuf>,
}

/// What was held to a limit: a row of a comparison, or a count of a stage's work.
#[derive(Clone, Debug)]
pub(super) struct Held {
    /// The comparison.
    pub(super) suite: String,
    /// The row, or the stage and what is counted.
    pub(super) name: String,
    /// What was found.
    pub(super) found: String,
    /// What is beyond the limit, if it is.
    pub(super) failure: Option<String>,
}

#[derive(Clone, Copy, Default, PartialEq, ValueEnum)]
enum Undecided {
    #[default]
    Pass,
    Fail,
}

impl Gate {
    /// The option that asks for a comparison which is not made, or for a limit that is not given, if there is one.
    pub(super) fn idle(&self, compares: bool, replaces: bool) -> Option<&'static str> {
        if self.junit.is_some() && self.fail_slower.is_none() && self.fail_work.is_none() {
            return Some("--junit");
        }
        let slower = self.fail_slower.filter(|_| !compares).map(|_| "--fail-slower");
        slower.or(self.fail_work.filter(|_| !replaces).map(|_| "--fail-work"))
    }

    /// The rows of a comparison that are held to the limit; `edited` are the stages of replaced kernels.
    pub(super) fn times(&self, name: &str, rows: &[Ratio], edited: &[String]) -> Vec<Held> {
        let Some(limit) = self.fail_slower else { return Vec::new() };
        let counts = |row: &&Ratio| edited.is_empty() || row.what == "stages" || edited.contains(&row.what);
        let failure = |row: &Ratio| {
            let (what, value) = (&row.what, &row.ratio);
            let least = 100.0 * (value.low - 1.0);
            let allowed = percent(limit);
            if row.missing_rounds == 0 && value.low > 1.0 + limit {
                return Some(format!(
                    "{name}: {what} is at least {least:.1} % slower; --fail-slower allows {allowed} %"
                ));
            }
            let decided = row.missing_rounds == 0 && value.high <= 1.0 + limit;
            (!decided && self.undecided == Undecided::Fail).then(|| {
                let interval = format!("{:.3}..{:.3}", value.low, value.high);
                format!("{name}: {what} may be more than {allowed} % slower: {interval}; more --frames decide it")
            })
        };
        let held = |row: &Ratio| Held {
            suite: name.into(),
            name: row.what.clone(),
            found: format!("{:.3}, {:.3}..{:.3}", row.ratio.value, row.ratio.low, row.ratio.high),
            failure: failure(row),
        };
        match rows.iter().filter(counts).map(held).collect::<Vec<_>>() {
            // As on a device without timestamps, whose stages have no times.
            none if none.is_empty() => {
                let failure = Some(format!("--fail-slower: {name}: no stage has a time to compare"));
                vec![Held { suite: name.into(), name: "all".into(), found: String::new(), failure }]
            }
            held => held,
        }
    }

    /// What is beyond the limit of work where nothing was counted.
    pub(super) fn uncounted(&self) -> Vec<Held> {
        let failure = "--fail-work: what kernels do was not counted".to_string();
        let held = |_| Held { suite: WORK.into(), name: "all".into(), found: String::new(), failure: Some(failure) };
        self.fail_work.map(held).into_iter().collect()
    }

    /// The exact counts of a stage, held to the limit.
    pub(super) fn work(&self, stage: &str, [before, after]: [Work; 2]) -> Vec<Held> {
        let Some(limit) = self.fail_work else { return Vec::new() };
        let counts = |work: Work| {
            [
                ("flop", work.flops),
                ("div", work.roots),
                ("exp", work.exps),
                ("loads", work.loaded),
                ("stores", work.stored),
            ]
        };
        let both = counts(before).into_iter().zip(counts(after));
        let allowed = percent(limit);
        let held = |((count, old), (_, new)): ((&str, u64), (&str, u64))| {
            let (name, found) = (format!("{stage}: {count}"), format!("{old} -> {new}"));
            let failure = (new as f64 > (1.0 + limit) * old as f64)
                .then(|| format!("{name} {found}; --fail-work allows {allowed} % more"));
            Held { suite: WORK.into(), name, found, failure }
        };
        both.map(held).collect()
    }
}

/// The suite of exact counts.
const WORK: &str = "work";

/// A share in percent, to a hundredth.
fn percent(share: f64) -> f64 {
    (1e4 * share).round() / 100.0
}

/// Fails if a limit was exceeded.
pub(super) fn end(held: &[Held]) -> Result<()> {
    match held.iter().filter_map(|held| held.failure.clone()).collect::<Vec<_>>().as_slice() {
        [] => Ok(()),
        some => Err(Error::Check(some.join("\n"))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use milkglass::internals::gpu::Timing;
    use milkglass::measure::rounds::{Frame, ROUNDS, Schedule, Starter, Variant, compare};
    use milkglass::measure::statistics::{Interval, Random};

    fn row(what: &str, low: f64, high: f64) -> Ratio {
        let ratio = Interval { value: 0.5 * (low + high), low, high };
        let missing_rounds = if high.is_finite() { 0 } else { 8 };
        Ratio { what: what.into(), ms: [Interval::default(); 2], ratio, missing_rounds }
    }

    fn failures(held: &[Held]) -> Vec<String> {
        held.iter().filter_map(|held| held.failure.clone()).collect()
    }

    #[test]
    fn what_is_surely_slower_fails_and_what_is_open_as_asked() {
        let rows = [
            row("gather", 1.03, 1.05),
            row("push", 0.99, 1.03),
            row("link", 0.5, f64::INFINITY),
            row("stages", 0.99, 1.01),
            row("pull", 1.5, 1.6),
        ];
        let edited = ["gather", "push", "link"].map(String::from);
        let gate = Gate { fail_slower: Some(0.02), ..Gate::default() };
        let held = gate.times("B", &rows, &edited);
        assert_eq!(failures(&held), ["B: gather is at least 3.0 % slower; --fail-slower allows 2 %"]);
        assert_eq!((held.len(), held[1].found.as_str()), (4, "1.010, 0.990..1.030"));
        assert_eq!(failures(&gate.times("B", &rows, &[])).len(), 2);
        let strict = Gate { undecided: Undecided::Fail, ..gate };
        let told = failures(&strict.times("B", &rows, &edited));
        assert!(told.len() == 3 && told[1].contains("push may be more than 2 % slower: 0.990..1.030"), "{told:?}");
        assert!(Gate::default().times("B", &rows, &[]).is_empty());
        // Without timestamps only the frame has a time.
        let told = failures(&Gate { fail_slower: Some(0.02), ..Gate::default() }.times(
            "B",
            &[row("frame", 0.9, 1.0)],
            &edited,
        ));
        assert_eq!(told, ["--fail-slower: B: no stage has a time to compare"]);
    }

    #[test]
    fn work_that_grows_fails() {
        let before = Work { flops: 1000, loaded: 0, ..Work::default() };
        let gate = Gate { fail_work: Some(0.01), ..Gate::default() };
        assert!(failures(&gate.work("push", [before, Work { flops: 1010, ..before }])).is_empty());
        let after = Work { flops: 1011, loaded: 4, ..before };
        let told = failures(&gate.work("push", [before, after]));
        assert!(told.len() == 2 && told[0] == "push: flop 1000 -> 1011; --fail-work allows 1 % more", "{told:?}");
    }

    /// A stage of about 10 ms and one of about 1 ms, with skewed noise up to 5 %, and 20 % more once in 20 frames; each
    /// start lies up to 1 % off.
    struct Made {
        random: Random,
        factor: f64,
    }

    impl Variant for Made {
        fn frame(&mut self) -> Result<Frame> {
            let mut step = |name: &str, ms: f64| {
                let noise = 0.05 * self.random.uniform().powi(2);
                let outlier = if self.random.uniform() < 0.05 { 0.2 } else { 0.0 };
                let milliseconds = ms * (1.0 + noise + outlier);
                Timing { name: name.into(), milliseconds, ..Timing::default() }
            };
            let steps = vec![step("large", 10.0 * self.factor), step("small", 1.0)];
            let wall = steps.iter().map(|step| step.milliseconds).sum();
            Ok(Frame { wall, steps, ..Frame::default() })
        }
    }

    /// How many of 100 comparisons fail where the second variant takes `factor` times as long.
    fn alarms(limit: f64, factor: f64) -> usize {
        let gate = Gate { fail_slower: Some(limit), ..Gate::default() };
        let fails = |seed: u64| {
            let starter = |name: &str, own: u64, factor: f64| {
                let mut seeds = Random::of(1000 * seed + own);
                let start = move || {
                    let lies = 1.0 + 0.01 * seeds.uniform();
                    let random = Random::of((seeds.uniform() * 1e9) as u64);
                    Ok(Box::new(Made { random, factor: lies * factor }) as _)
                };
                Starter { name: name.into(), start: Box::new(start) }
            };
            let mut both = [starter("a", 1, 1.0), starter("b", 2, factor)];
            let schedule = Schedule { rounds: ROUNDS, until: None, budget: f64::INFINITY, seed };
            let samples = compare(&mut both, &schedule, &[], &mut |_| {}).unwrap().samples;
            !failures(&gate.times("b", &samples.ratios()[0], &[])).is_empty()
        };
        (0..100).filter(|seed| fails(*seed)).count()
    }

    #[test]
    fn false_alarms_are_rare_and_a_slower_stage_is_found() {
        // The same twice, with no margin at all; then 4 % where 2 % are allowed.
        let (same, slower) = (alarms(1e-9, 1.0), alarms(0.02, 1.04));
        assert!(same <= 5 && slower >= 95, "{same} {slower}");
    }
}
