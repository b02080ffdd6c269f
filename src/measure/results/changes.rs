//! What differs between two results: of drivers, devices or commits.

use super::{Outcome, Results};
use crate::error::{Error, Input, Result};
use crate::measure::bias::Bias;

/// Shifts within tolerance are reported if they are larger than these.
#[derive(Clone, Copy, Debug)]
pub struct Thresholds {
    /// Change of a field's mean signed relative difference, beyond five standard errors of it.
    pub mean: f64,
    /// Change of the share of the tolerance that a stage uses.
    pub used: f64,
    /// Change of the share of floats that are more than 3 units in the last place off.
    pub beyond: f64,
}

impl Default for Thresholds {
    fn default() -> Self {
        Self { mean: 2e-7, used: 0.1, beyond: 0.01 }
    }
}

/// How a comparison has changed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Kind {
    /// It fails, and did not fail before or is not in the first results.
    Failure,
    /// It failed, and conforms now.
    Mended,
    /// It fails in another way.
    OtherFailure,
    /// It is in the second results only, and conforms.
    Added,
    /// It is in the first results only.
    Missing,
    /// It is within tolerance, but farther or less far off than before.
    Shift,
    /// Buffers have other bits.
    Bits,
}

impl Kind {
    /// All kinds, in the order of a report.
    pub const ALL: [Self; 7] =
        [Self::Failure, Self::Mended, Self::OtherFailure, Self::Added, Self::Missing, Self::Shift, Self::Bits];

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Failure => "new failure",
            Self::Mended => "mended",
            Self::OtherFailure => "other failure",
            Self::Added => "only in the second",
            Self::Missing => "only in the first",
            Self::Shift => "shift",
            Self::Bits => "other bits",
        }
    }
}

/// A change.
#[derive(Clone, Debug, PartialEq)]
pub struct Change {
    /// How the comparison has changed.
    pub kind: Kind,
    /// The device of the second results, or of the first if the comparison is in those only.
    pub device: String,
    /// The fixture.
    pub fixture: String,
    /// The stage.
    pub stage: String,
    /// What has changed, in words.
    pub what: String,
}

/// All changes from `a` to `b`, by kind. Devices are told apart by their names; the names do not matter if both results
/// are of one device each.
pub fn changes(a: &Results, b: &Results, thresholds: &Thresholds) -> Result<Vec<Change>> {
    let names = |results: &Results| {
        let mut names: Vec<String> = results.results.iter().map(|outcome| outcome.device.clone()).collect();
        names.sort();
        names.dedup();
        names
    };
    let (of_a, of_b) = (names(a), names(b));
    let alone = of_a.len() <= 1 && of_b.len() <= 1;
    if !alone && !of_b.iter().any(|name| of_a.contains(name)) {
        let fault = Input::new("no device is in both results, and there are several").found(of_b.join(", "));
        return Err(Error::from(fault.expected(of_a.join(", "))));
    }
    let same =
        |x: &Outcome, y: &Outcome| (alone || x.device == y.device) && x.fixture == y.fixture && x.stage == y.stage;
    let mut found = Vec::new();
    let mut add = |kind, outcome: &Outcome, what: String| {
        let Outcome { device, fixture, stage, .. } = outcome.clone();
        found.push(Change { kind, device, fixture, stage, what });
    };
    for new in &b.results {
        match a.results.iter().find(|old| same(old, new)) {
            Some(old) => pair(old, new, thresholds, &mut add),
            None if new.verdict.passes() => add(Kind::Added, new, new.verdict.name().into()),
            None => add(Kind::Failure, new, why(new)),
        }
    }
    for old in a.results.iter().filter(|old| !b.results.iter().any(|new| same(old, new))) {
        add(Kind::Missing, old, old.verdict.name().into());
    }
    found.sort_by_key(|change: &Change| change.kind);
    Ok(found)
}

fn why(outcome: &Outcome) -> String {
    let first = outcome.faults.first().map_or("", String::as_str);
    format!("{}: {first}", outcome.verdict.name())
}

/// The changes of one comparison.
fn pair(old: &Outcome, new: &Outcome, thresholds: &Thresholds, add: &mut impl FnMut(Kind, &Outcome, String)) {
    match (old.verdict.passes(), new.verdict.passes()) {
        (true, false) => return add(Kind::Failure, new, why(new)),
        (false, true) => return add(Kind::Mended, new, format!("was {}", why(old))),
        (false, false) if old.verdict != new.verdict => {
            return add(Kind::OtherFailure, new, format!("{}, was {}", why(new), old.verdict.name()));
        }
        _ => {}
    }
    let mut shifts = Vec::new();
    if let (Some(x), Some(y)) = (old.of_tolerance, new.of_tolerance)
        && (x - y).abs() > thresholds.used
    {
        shifts.push(format!("uses {:.0} % of the tolerance, was {:.0} %", 100.0 * y, 100.0 * x));
    }
    let beyond = |outcome: &Outcome| {
        let all: u64 = outcome.histogram.iter().sum();
        outcome.histogram[3..].iter().sum::<u64>() as f64 / all.max(1) as f64
    };
    let (x, y) = (beyond(old), beyond(new));
    if (x - y).abs() > thresholds.beyond {
        shifts.push(format!("{:.1} % of floats are more than 3 ulp off, was {:.1} %", 100.0 * y, 100.0 * x));
    }
    for mean in &new.means {
        let was = old.means.iter().find(|known| known.buffer == mean.buffer && known.field == mean.field);
        let (x, y) = (was.map_or(0.0, Bias::mean), mean.mean());
        if (x - y).abs() > thresholds.mean + 5.0 * was.map_or(0.0, Bias::error).hypot(mean.error()) {
            shifts.push(format!("the mean error of {} is {y:+.1e}, was {x:+.1e}", mean.place()));
        }
    }
    if !shifts.is_empty() {
        add(Kind::Shift, new, shifts.join("; "));
    }
    let other: Vec<&str> = new
        .hashes
        .iter()
        .filter(|(name, hash)| old.hashes.get(*name).is_some_and(|known| known != *hash))
        .map(|(name, _)| name.as_str())
        .collect();
    if !other.is_empty() {
        add(Kind::Bits, new, other.join(", "));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::results::Verdict;

    fn results(device: &str, change: impl Fn(&mut Outcome)) -> Results {
        let mean = Bias { buffer: "radiosity".into(), count: 1000, sum: 1e-6, squares: 1e-15, ..Bias::default() };
        let mut outcome = Outcome {
            device: device.into(),
            fixture: "f".into(),
            stage: "s".into(),
            of_tolerance: Some(0.2),
            histogram: [90, 5, 5, 0, 0, 0, 0, 0],
            means: vec![mean],
            hashes: [("radiosity".to_string(), "1".to_string())].into(),
            ..Outcome::default()
        };
        change(&mut outcome);
        Results { results: vec![outcome], ..Results::default() }
    }

    fn kinds(a: &Results, b: &Results) -> Vec<Kind> {
        changes(a, b, &Thresholds::default()).unwrap().into_iter().map(|change| change.kind).collect()
    }

    #[test]
    fn each_change_has_its_kind() {
        let old = results("a", |_| {});
        let wrong = results("b", |outcome| outcome.verdict = Verdict::Differs);
        assert_eq!(kinds(&old, &results("b", |_| {})), []);
        assert_eq!(kinds(&old, &wrong), [Kind::Failure]);
        assert_eq!(kinds(&wrong, &old), [Kind::Mended]);
        assert_eq!(kinds(&wrong, &results("b", |outcome| outcome.verdict = Verdict::Hung)), [Kind::OtherFailure]);
        assert_eq!(
            kinds(&old, &results("a", |outcome| outcome.hashes = [("radiosity".into(), "2".into())].into())),
            [Kind::Bits]
        );
        assert_eq!(kinds(&old, &results("a", |outcome| outcome.of_tolerance = Some(0.31))), [Kind::Shift]);
        assert_eq!(kinds(&old, &results("a", |outcome| outcome.of_tolerance = Some(0.29))), []);
        assert_eq!(kinds(&old, &results("a", |outcome| outcome.histogram[4] = 5)), [Kind::Shift]);
        assert_eq!(kinds(&old, &results("a", |outcome| outcome.means[0].sum = 3e-4)), [Kind::Shift]);
        assert_eq!(kinds(&old, &results("a", |outcome| outcome.means[0].sum = 1e-4)), []);
        let other = results("a", |outcome| outcome.stage = "t".into());
        assert_eq!(kinds(&old, &other), [Kind::Added, Kind::Missing]);
    }

    #[test]
    fn devices_are_told_apart_where_there_are_several() {
        let (a, b) = (results("a", |_| {}), results("b", |outcome| outcome.verdict = Verdict::Differs));
        let both = Results { results: [a.results.clone(), b.results.clone()].concat(), ..Results::default() };
        assert_eq!(kinds(&both, &b), [Kind::Missing]);
        assert!(changes(&both, &results("c", |_| {}), &Thresholds::default()).is_err());
    }
}
