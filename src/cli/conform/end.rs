//! After the last comparison: what all fixtures together show, what has changed, and whether all is well.

use super::arguments::{Arguments, repeating};
use super::choose::Choice;
use super::drivers::side_by_side;
use super::sheet::histogram;
use super::sink::Sink;
use crate::cli::compare::described;
use crate::cli::print;
use milkglass::error::{Error, Input, Result};
use milkglass::measure::bias::{Bias, add};
use milkglass::measure::results::changes::{Thresholds, changes};
use milkglass::measure::results::{Outcome, Results, Verdict};
use milkglass::measure::verdict::{commit, verdict, watched};

/// The fixture's name in an outcome of all fixtures together.
const ALL: &str = "all fixtures";

/// Writes the files, says what is wrong, and fails if something is.
pub(super) fn end(arguments: &Arguments, mut sink: Sink, before: Option<&Results>, choices: &[Choice]) -> Result<()> {
    if arguments.child {
        return Ok(());
    }
    for outcome in leaning(arguments, &sink) {
        sink.add(outcome)?;
    }
    sink.finish(arguments)?;
    let outcomes = &sink.all.results;
    if outcomes.iter().any(|outcome| outcome.words > 0) {
        print(&histogram(outcomes))?;
        print(&side_by_side(&sink.all))?;
    }
    let wrong: Vec<&Outcome> =
        outcomes.iter().filter(|outcome| !outcome.verdict.passes() && outcome.known.is_none()).collect();
    for outcome in &wrong {
        let facts = sink.all.run.devices.iter().find(|facts| facts.name == outcome.device).cloned();
        let layer = sink.all.run.layer.as_deref();
        tell!("\n{}", verdict(outcome, &facts.unwrap_or_default(), layer, &sink.replaced));
    }
    let stale: Vec<String> = sink.known.iter().filter_map(|known| known.stale(&sink.all)).collect();
    stale.iter().for_each(|what| tell!("--expect: {what}"));
    if let Some(before) = before {
        print(&described(&changes(before, &sink.all, &Thresholds::default())?))?;
    }
    let idle = |name: &&String| outcomes.iter().all(|outcome| outcome.stage != **name);
    let own = arguments.replace.stages();
    let own = own.iter().filter(|stages| stages.iter().all(|stage| idle(&stage))).filter_map(|stages| stages.first());
    let asked = arguments.stage.iter().map(|stage| ("--stage", stage)).chain(own.map(|stage| ("--replace", stage)));
    // A shard need not run every stage.
    if wrong.is_empty()
        && arguments.shard.is_none()
        && let Some((key, name)) = asked.into_iter().find(|(_, name)| idle(name))
    {
        let what = if arguments.scenes.is_empty() { "fixture that was chosen" } else { "scene" };
        let fault = Input::new(format!("no {what} runs this stage, so it was not compared")).key(key).found(name);
        return Err(fault.expected("a stage that `milkglass plan` lists for the scene, or other fixtures").into());
    }
    if outcomes.is_empty() && !choices.is_empty() && arguments.shard.is_none() {
        return Err(Error::Check("nothing was compared".into()));
    }
    if !wrong.is_empty() {
        return Err(Error::Check(summary(&wrong)));
    }
    if !stale.is_empty() {
        let s = if stale.len() == 1 { "" } else { "s" };
        return Err(Error::Check(format!("{} known failure{s} of --expect conform now", stale.len())));
    }
    closing(&sink.all)
}

/// How many comparisons failed, and how.
fn summary(wrong: &[&Outcome]) -> String {
    let faults: usize = wrong.iter().map(|outcome| outcome.faults.len()).sum();
    if wrong.iter().all(|outcome| outcome.verdict == Verdict::Differs) {
        return format!("{faults} difference{} beyond tolerance", if faults == 1 { "" } else { "s" });
    }
    let count = |verdict: Verdict| wrong.iter().filter(|outcome| outcome.verdict == verdict).count();
    let kinds = [
        (Verdict::Differs, "differ"),
        (Verdict::Hung, "hung"),
        (Verdict::Crashed, "crashed"),
        (Verdict::DeviceFailed, "ended with a device failure"),
    ];
    let parts: Vec<String> = kinds
        .into_iter()
        .filter(|(verdict, _)| count(*verdict) > 0)
        .map(|(verdict, word)| format!("{} {word}", count(verdict)))
        .collect();
    format!("of the comparisons, {}", parts.join(", "))
}

/// Prints what a bug report on a driver needs: device, driver, probes and system; then the number of comparisons.
fn closing(all: &Results) -> Result<()> {
    let mut text = String::new();
    for facts in &all.run.devices {
        let count = all.results.iter().filter(|outcome| outcome.device == facts.name).count();
        let (version, name, made) = (&all.run.version, &facts.name, commit(all.run.commit.as_deref()));
        let (device, driver) = (facts.device(), facts.own_driver());
        text += &format!("milkglass {version}{made}, {device}, driver {driver}: {count} comparisons\n");
        let wrong: Vec<&str> = facts.probes.iter().filter(|fact| !fact.right).map(|fact| fact.name.as_str()).collect();
        let avoided = if wrong.is_empty() { String::new() } else { format!("; avoided: {}", wrong.join(", ")) };
        let (right, all) = (facts.probes.len() - wrong.len(), facts.probes.len());
        if all > 0 {
            text += &format!("{right} of {all} probes of {name} are right{avoided}\n");
        }
    }
    text += &format!("on {}; {}\n", all.run.system, watched(all.run.layer.as_deref()));
    let known = all.results.iter().filter(|outcome| outcome.known.is_some()).count();
    let count = all.results.len();
    match known {
        0 => print(&format!("{text}{count} comparisons, all conform\n")),
        some => print(&format!("{text}{count} comparisons, {some} known failures, all others conform\n")),
    }
}

/// Stages whose values lean to one side over all fixtures, but in no single fixture enough to be seen.
fn leaning(arguments: &Arguments, sink: &Sink) -> Vec<Outcome> {
    let mut found: Vec<Outcome> = Vec::new();
    let outcomes = &sink.all.results;
    let mut done: Vec<(&str, &str)> = Vec::new();
    for outcome in outcomes {
        let key = (outcome.device.as_str(), outcome.stage.as_str());
        if done.contains(&key) {
            continue;
        }
        done.push(key);
        let own = || outcomes.iter().filter(|o| (o.device.as_str(), o.stage.as_str()) == key);
        let mut sums = Vec::new();
        for own in own() {
            if own.means.iter().any(Bias::leans) {
                sums.clear();
                break;
            }
            add(&mut sums, &own.means);
        }
        let faults: Vec<String> =
            sums.iter().filter(|sum| sum.leans()).map(|sum| sum.fault("over all fixtures ")).collect();
        if own().count() > 1 && !faults.is_empty() {
            let mut whole = Outcome {
                device: outcome.device.clone(),
                driver: outcome.driver.clone(),
                fixture: ALL.into(),
                stage: outcome.stage.clone(),
                verdict: Verdict::Differs,
                faults,
                ..Outcome::default()
            };
            let mut command = outcome.clone();
            command.fixture = String::new();
            whole.repeat = repeating(arguments, &command).replacen(" --fixture ''", "", 1);
            found.push(whole);
        }
    }
    found
}
