//! Limits beyond which a comparison of times or of work fails.

use clap::{Args, ValueEnum};

use milkglass::error::{Error, Result};
use milkglass::measure::profile::Work;
use milkglass::measure::rounds::Ratio;

use crate::cli::timing::share;

/// What is allowed.
#[derive(Args, Clone, Copy, Default)]
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
}

#[derive(Clone, Copy, Default, PartialEq, ValueEnum)]
enum Undecided {
    #[default]
    Pass,
    Fail,
}

impl Gate {
    /// The limit that asks for a comparison which is not made, if there is one.
    pub(super) fn idle(&self, compares: bool, replaces: bool) -> Option<&'static str> {
        let slower = self.fail_slower.filter(|_| !compares).map(|_| "--fail-slower");
        slower.or(self.fail_work.filter(|_| !replaces).map(|_| "--fail-work"))
    }

    /// The rows of a comparison that are beyond the limit; `edited` are the stages of replaced kernels.
    pub(super) fn times(&self, name: &str, rows: &[Ratio], edited: &[String]) -> Vec<String> {
        let Some(limit) = self.fail_slower else { return Vec::new() };
        let counts = |row: &&Ratio| edited.is_empty() || row.what == "stages" || edited.contains(&row.what);
        let fault = |row: &Ratio| {
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
        rows.iter().filter(counts).filter_map(fault).collect()
    }

    /// What is beyond the limit of work where nothing was counted.
    pub(super) fn uncounted(&self) -> Vec<String> {
        self.fail_work.map(|_| "--fail-work: what kernels do was not counted".into()).into_iter().collect()
    }

    /// The exact counts of a stage that are beyond the limit.
    pub(super) fn work(&self, stage: &str, [before, after]: [Work; 2]) -> Vec<String> {
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
        let grown = both.filter(|((_, old), (_, new))| *new as f64 > (1.0 + limit) * *old as f64);
        let allowed = percent(limit);
        grown
            .map(|((count, old), (_, new))| {
                format!("{stage}: {count} {old} -> {new}; --fail-work allows {allowed} % more")
            })
            .collect()
    }
}

/// A share in percent, to a hundredth.
fn percent(share: f64) -> f64 {
    (1e4 * share).round() / 100.0
}

/// Fails if a limit was exceeded.
pub(super) fn end(failures: &[String]) -> Result<()> {
    match failures {
        [] => Ok(()),
        some => Err(Error::Check(some.join("\n"))),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use milkglass::measure::statistics::Interval;

    fn row(what: &str, low: f64, high: f64) -> Ratio {
        let ratio = Interval { value: 0.5 * (low + high), low, high };
        let missing_rounds = if high.is_finite() { 0 } else { 8 };
        Ratio { what: what.into(), ms: [Interval::default(); 2], ratio, missing_rounds }
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
        let told = gate.times("B", &rows, &edited);
        assert_eq!(told, ["B: gather is at least 3.0 % slower; --fail-slower allows 2 %"]);
        assert_eq!(gate.times("B", &rows, &[]).len(), 2);
        let strict = Gate { undecided: Undecided::Fail, ..gate };
        let told = strict.times("B", &rows, &edited);
        assert!(told.len() == 3 && told[1].contains("push may be more than 2 % slower: 0.990..1.030"), "{told:?}");
        assert!(Gate::default().times("B", &rows, &[]).is_empty());
    }

    #[test]
    fn work_that_grows_fails() {
        let before = Work { flops: 1000, loaded: 0, ..Work::default() };
        let gate = Gate { fail_work: Some(0.01), ..Gate::default() };
        assert!(gate.work("push", [before, Work { flops: 1010, ..before }]).is_empty());
        let after = Work { flops: 1011, loaded: 4, ..before };
        let told = gate.work("push", [before, after]);
        assert!(told.len() == 2 && told[0] == "push: flop 1000 -> 1011; --fail-work allows 1 % more", "{told:?}");
    }
}
