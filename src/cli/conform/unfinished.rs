//! `--dump` where a process has not ended well: another process runs the step again, and writes the case of each
//! dispatch before it runs; the last one is at fault.

use std::path::{Path, PathBuf};
use std::time::Instant;

use super::arguments::Arguments;
use super::child::{command, compares};
use super::choose::Choice;
use super::dumps::{made, name};
use crate::cli::repro::{amount, describe, played};
use crate::cli::watch::watched;
use milkglass::error::Result;
use milkglass::internals::gpu::{Adapter, Device};
use milkglass::internals::view::atomic_file::Part;
use milkglass::measure::fixtures::Fixture;
use milkglass::measure::repro::Case;
use milkglass::measure::repro::unfinished::{least, run_told};
use milkglass::measure::results::{Line, Verdict};

/// The most that all tries of fewer groups may take, seconds.
const TRIES: f64 = 120.0;

/// In that other process: runs a step of the stage, and writes cases 0, 1, ... to this folder.
pub(super) fn steps(
    arguments: &Arguments,
    folder: &Path,
    (device, fixture): (&Device, &Fixture),
    step: usize,
) -> Result<()> {
    let own = |index: &usize| arguments.stage.iter().any(|stage| stage == fixture.steps[*index].stage.name);
    let Some(index) = (0..fixture.steps.len()).filter(own).nth(step) else { return Ok(()) };
    let mut count = 0;
    run_told(device, fixture, index, &mut |case| {
        case.write(&folder.join(count.to_string()), "--dump")?;
        count += 1;
        Ok(())
    })
}

/// Writes the case of the step that did not end, counted from 0 among those of the stage, and says what it holds.
pub(super) fn write(
    arguments: &Arguments,
    folder: &Path,
    choice: &Choice,
    (index, adapter): (usize, &Adapter),
    (stage, step): (&str, usize),
) -> Result<()> {
    let own = folder.join(name(stage, choice.name(), &adapter.name));
    made(folder)?;
    let beside = Part::new(folder.join(format!(".unfinished.{}.part", std::process::id())));
    made(beside.path())?;
    let mut child = command(arguments, index)?;
    compares(&mut child, arguments, choice, (&[stage.to_string()], Some(beside.path())));
    child.args(["--unfinished", &step.to_string()]);
    let ended = watched(child, arguments.timeout, &mut |_: Line| Ok(()))?;
    // A folder appears whole, so the last one is that of the dispatch that ran last.
    let at = |count: usize| beside.path().join(count.to_string());
    let Some(last) = (0..).map(at).take_while(|folder| folder.is_dir()).last() else {
        let why = ended.map_or("it dispatches nothing".into(), |(_, why)| format!("before its first dispatch {why}"));
        tell!("{}: no case of {stage}: {why}", own.display());
        return Ok(());
    };
    let mut case = Case::read(&last)?;
    let Some((verdict, why)) = ended else {
        case.write(&own, "--dump")?;
        tell!("{}, {}", describe(&own, &case), amount(&case));
        tell!("{}: it ends well now, and may fail in one of many runs: replay --times 1000", own.display());
        return Ok(());
    };
    case.about.dispatches += &format!(": {why}");
    (case.about.fails, case.about.seconds) = (true, Some(arguments.timeout));
    let mut amounts = amount(&case);
    if arguments.minimize {
        let less = fewer(arguments, (&case, verdict), (index, beside.path()))?;
        amounts = format!("{amounts} -> {}", amount(&less));
        case = less;
    }
    case.write(&own, "--dump")?;
    tell!("{}, {amounts}", describe(&own, &case));
    Ok(())
}

/// The case with the groups that do not end, each try in a process of its own.
fn fewer(arguments: &Arguments, (case, verdict): (&Case, Verdict), (device, beside): (usize, &Path)) -> Result<Case> {
    let mut words = vec!["--device".to_string(), device.to_string()];
    words.extend(arguments.no_validation.then(|| "--no-validation".to_string()));
    let (begun, mut tries) = (Instant::now(), 0);
    least(case, &mut |less| {
        let rest = TRIES - begun.elapsed().as_secs_f64();
        // A hang shows only after the whole timeout.
        if rest < arguments.timeout && (verdict == Verdict::Hung || rest < 1.0) {
            return Ok(false);
        }
        let folder: PathBuf = beside.join(format!("try{tries}"));
        tries += 1;
        less.write(&folder, "--dump")?;
        let found = played(&folder, &words, (2, arguments.timeout.min(rest)))?;
        Ok(found.is_err_and(|(own, _)| own == verdict))
    })
}
