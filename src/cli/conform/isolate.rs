//! Comparisons in processes of their own, one a fixture and device: a hang or a crash ends one of them.

use std::collections::BTreeMap;
use std::path::Path;
use std::process::Command;

use super::alone::failure;
use super::arguments::{Arguments, repeating};
use super::choose::Choice;
use super::sink::Sink;
use super::unfinished::write;
use crate::cli::watch::{itself, watched};
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
            one(arguments, choice, (*index, adapter), sink)?;
        }
    }
    Ok(())
}

/// The command of a child on this device.
pub(super) fn command(arguments: &Arguments, device: usize) -> Result<Command> {
    let mut command = itself("conform")?;
    command.args(["--device", &device.to_string()]);
    if arguments.no_validation {
        command.arg("--no-validation");
    }
    command.args(arguments.replace.words());
    Ok(command)
}

/// What is compared, as arguments: these stages, and where what differs goes.
pub(super) fn compares(
    command: &mut Command,
    arguments: &Arguments,
    choice: &Choice,
    (stages, dump): (&[String], Option<&Path>),
) {
    match choice {
        Choice::Fixture(name) => {
            command.args(["--fixture", name]);
        }
        Choice::Scene(name) => {
            command.arg(name).arg(format!("--frame={}", arguments.frame));
            command.args(arguments.sets.iter().flat_map(|set| ["--set", set]));
            command.args(arguments.option_args.words());
        }
    }
    if !stages.is_empty() {
        command.args(["--stage", &stages.join(",")]);
    }
    if let Some(folder) = dump {
        command.arg("--dump").arg(folder);
        if arguments.minimize {
            command.arg("--minimize");
        }
    }
    command.args(arguments.memory.words());
}

/// Probes a device in a process of its own; what came of it where it did not end.
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

fn one(arguments: &Arguments, choice: &Choice, (index, adapter): (usize, &Adapter), sink: &mut Sink) -> Result<()> {
    let mut child = command(arguments, index)?;
    compares(&mut child, arguments, choice, (&arguments.stage, arguments.dump.as_deref()));
    let (mut stage, mut steps) = (String::new(), BTreeMap::<String, usize>::new());
    let ended = watched(child, arguments.timeout, &mut |line| match line {
        Line::Begins(_, begun) => {
            stage.clone_from(&begun);
            *steps.entry(begun.clone()).or_default() += 1;
            sink.begins(choice.name(), &begun)
        }
        // What ended is over; a device that failed has said so itself.
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
