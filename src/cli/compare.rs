//! `milkglass compare`: what differs between two results of `conform`.

use std::collections::BTreeSet;
use std::path::PathBuf;

use clap::Args;

use super::{print, table};
use milkglass::error::{Error, Result};
use milkglass::measure::results::changes::{Change, Kind, Thresholds, changes};
use milkglass::measure::results::read;

/// Arguments of `compare`.
#[derive(Args)]
#[command(after_help = "Example: milkglass conform --only sliver --json a.json && milkglass compare a.json a.json")]
pub struct Arguments {
    /// Results that `conform --json` or `--jsonl` wrote.
    first: PathBuf,
    /// Results of another driver, device or commit.
    second: PathBuf,
    /// Report a change of a field's mean relative difference beyond this, and beyond five standard errors of it.
    #[arg(long, value_name = "SHARE", default_value_t = Thresholds::default().mean, value_parser = share)]
    mean: f64,
    /// Report a change of the share of its tolerance that a stage uses beyond this.
    #[arg(long, value_name = "SHARE", default_value_t = Thresholds::default().used, value_parser = share)]
    used: f64,
    /// Report a change of the share of floats that are more than 3 ulp off beyond this.
    #[arg(long, value_name = "SHARE", default_value_t = Thresholds::default().beyond, value_parser = share)]
    beyond: f64,
}

fn share(text: &str) -> std::result::Result<f64, String> {
    let found = text.parse().ok().filter(|share: &f64| share.is_finite() && *share >= 0.0);
    found.ok_or_else(|| "expected a number from 0 on".into())
}

/// Prints the changes; fails if there is a new failure.
pub fn run(arguments: &Arguments) -> Result<()> {
    let (first, second) = (read(&arguments.first)?, read(&arguments.second)?);
    let thresholds = Thresholds { mean: arguments.mean, used: arguments.used, beyond: arguments.beyond };
    let found = changes(&first, &second, &thresholds)?;
    print(&described(&found))?;
    match found.iter().filter(|change| change.kind == Kind::Failure).count() {
        0 => Ok(()),
        1 => Err(Error::Check("1 new failure".into())),
        more => Err(Error::Check(format!("{more} new failures"))),
    }
}

/// A table of the changes of comparisons that both results have, and the number of changes of each kind. Comparisons
/// that only one result has are counted, not listed: it may hold a part of the fixtures.
pub(super) fn described(changes: &[Change]) -> String {
    if changes.is_empty() {
        return "nothing has changed\n".into();
    }
    let row = |change: &Change| {
        let Change { kind, device, fixture, stage, what } = change.clone();
        vec![kind.name().to_string(), device, fixture, stage, what]
    };
    let in_one_only = |change: &&Change| matches!(change.kind, Kind::Added | Kind::Missing);
    let rows: Vec<_> = changes.iter().filter(|change| !in_one_only(change)).map(row).collect();
    let count = |kind: Kind| changes.iter().filter(|change| change.kind == kind).count();
    let counts: Vec<String> = Kind::ALL
        .into_iter()
        .filter(|kind| count(*kind) > 0)
        .map(|kind| format!("{}: {}{}", kind.name(), count(kind), fixtures(changes, kind)))
        .collect();
    let rows = match rows.is_empty() {
        true => "no comparison that both have has changed\n".into(),
        false => table(["change", "device", "fixture", "stage", "what"], rows),
    };
    format!("{rows}{}\n", counts.join(", "))
}

/// For comparisons that only one result has: the number of their fixtures, or the name if there is one.
fn fixtures(changes: &[Change], kind: Kind) -> String {
    if !matches!(kind, Kind::Added | Kind::Missing) {
        return String::new();
    }
    let names: BTreeSet<&str> =
        changes.iter().filter(|change| change.kind == kind).map(|change| change.fixture.as_str()).collect();
    match names.first() {
        Some(name) if names.len() == 1 => format!(" (of {name})"),
        _ => format!(" (of {} fixtures)", names.len()),
    }
}
