//! Comparisons in processes of their own, one a fixture and device: a hang or a crash ends one of them.

use std::collections::BTreeMap;

use super::arguments::{Arguments, failure, repeating};
use super::child::{command, compares};
use super::choose::Choice;
use super::sink::Sink;
use super::unfinished::write;
use crate::cli::watch::watched;
use milkglass::error::Result;
use milkglass::internals::gpu::Adapter;
use milkglass::measure::probe::{FIXTURE, REPEAT};
use milkglass::measure::results::{DeviceFacts, Line, Outcome, Verdict};

/// Compares everything that was chosen on all devices.
pub(super) fn run(
    arguments: &Arguments,
    choices: &[Choice],
    devices: &[(usize, &Adapter)],
    sink: &mut Sink,
) -> Result<()> {
    for choice in choices {
        for (index, adapter) in devices {
            compare(arguments, choice, (*index, adapter), sink)?;
        }
    }
    Ok(())
}

/// Probes a device in a process of its own; returns the failure of a process that did not end well.
pub(super) fn probed(
    arguments: &Arguments,
    (index, adapter): (usize, &Adapter),
    facts: &mut DeviceFacts,
) -> Result<Option<Outcome>> {
    let mut child = command(arguments, index)?;
    child.arg("--probe-only");
    let ended = watched(child, arguments.timeout, &mut |line: Line| {
        if let Line::Run(run) = line {
            facts.probes = run.devices.into_iter().next().map(|device| device.probes).unwrap_or_default();
        }
        Ok(())
    })?;
    let outcome = |(verdict, why): (Verdict, String)| Outcome {
        repeat: REPEAT.into(),
        ..failure(arguments, adapter, (FIXTURE, ""), verdict, &why)
    };
    Ok(ended.map(outcome))
}

fn compare(arguments: &Arguments, choice: &Choice, (index, adapter): (usize, &Adapter), sink: &mut Sink) -> Result<()> {
    let mut child = command(arguments, index)?;
    compares(&mut child, arguments, choice, (&arguments.stage, arguments.dump.as_deref()));
    let (mut stage, mut steps) = (String::new(), BTreeMap::<String, usize>::new());
    let ended = watched(child, arguments.timeout, &mut |line| match line {
        Line::Begins(_, begun) => {
            stage.clone_from(&begun);
            *steps.entry(begun.clone()).or_default() += 1;
            sink.begins(choice.name(), &begun)
        }
        // The exit code tells of a failed device, below.
        Line::Result(outcome) if outcome.verdict == Verdict::DeviceFailed => Ok(()),
        Line::Result(mut outcome) => {
            if !arguments.scenes.is_empty() {
                outcome.repeat = repeating(arguments, &outcome);
            }
            stage.clear();
            sink.add(*outcome)
        }
        Line::Run(_) => Ok(()),
    })?;
    let Some((verdict, why)) = ended else { return Ok(()) };
    sink.add(failure(arguments, adapter, (choice.name(), &stage), verdict, &why))?;
    match (&arguments.dump, steps.get(&stage)) {
        (Some(folder), Some(step)) => write(arguments, folder, choice, (index, adapter), (&stage, step - 1)),
        _ => Ok(()),
    }
}
