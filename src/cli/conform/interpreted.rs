//! `conform` without a device: on the interpreter, or what it finds wrong in kernels.

use std::collections::BTreeSet;

use super::arguments::{Arguments, again};
use super::choose::Choice;
use super::end;
use super::sink::Sink;
use crate::cli::print;
use milkglass::error::{Error, Input, Result};
use milkglass::measure::conform::Event;
use milkglass::measure::fixtures::Fixture;
use milkglass::measure::interpret::stage::{Interpreter, LANES, SUBGROUP};
use milkglass::measure::interpreted::{DEVICE, Sanitized, adapter, conform_interpreted, replaced_stages};
use milkglass::measure::leaning::blame;
use milkglass::measure::results::{DeviceFacts, Outcome, Results};

/// The interpreter with the replaced kernels, and the stages to run on it: all if there are none.
fn interpreter(arguments: &Arguments) -> Result<(Interpreter, Vec<String>)> {
    let interpreter = Interpreter::new(arguments.replace.load()?);
    let mut stages = replaced_stages(&interpreter);
    stages.extend(arguments.stage.iter().cloned());
    Ok((interpreter, stages))
}

/// Fails where something was asked for that takes a device or a process of its own.
fn refuse(arguments: &Arguments) -> Result<()> {
    let asked = [
        ("--isolate", arguments.isolate),
        ("--junit", arguments.junit.is_some()),
        ("--dump", arguments.dump.is_some()),
        ("--coverage", arguments.coverage.is_some()),
    ];
    match asked.iter().find(|(_, given)| *given) {
        Some((key, _)) => {
            let fault = Input::new("the interpreter runs in this process, without a device").key(*key);
            Err(fault.expected("a Vulkan device").into())
        }
        None => Ok(()),
    }
}

/// Compares the interpreter with the reference.
pub(super) fn run(arguments: &Arguments, choices: &[Choice], before: Option<&Results>) -> Result<()> {
    refuse(arguments)?;
    let (interpreter, stages) = interpreter(arguments)?;
    let (adapter, known) = (adapter(), super::expect::load(arguments.expect.as_deref())?);
    let kernels = arguments.replace.load()?;
    let mut sink = Sink::open(arguments, choices, None, vec![DeviceFacts::new(&adapter)], &kernels, known)?;
    for choice in choices {
        let fixture = choice.make(arguments)?;
        let mut failed = None;
        conform_interpreted(&interpreter, &fixture, &stages, &mut |event| {
            let told = match event {
                Event::Begins(stage) => sink.begins(&fixture.name, stage),
                Event::Ends(row) => {
                    blame(std::slice::from_mut(row));
                    sink.add(Outcome::new(&adapter, row, again(arguments, DEVICE, &row.fixture, row.stage)))
                }
            };
            failed = failed.take().or(told.err());
        })?;
        failed.map_or(Ok(()), Err)?;
    }
    end::end(arguments, sink, before, choices)
}

/// Watches the stages of what was chosen; fails if something is wrong.
pub(super) fn sanitize(arguments: &Arguments, choices: &[Choice]) -> Result<()> {
    refuse(arguments)?;
    let (interpreter, stages) = interpreter(arguments)?;
    let mut all = Sanitized::default();
    for choice in choices {
        let fixture: Fixture = choice.make(arguments)?;
        let new = all.add(&interpreter, &fixture, &stages)?;
        print(&new.iter().map(|(finding, place)| format!("{finding}; first in {place}\n")).collect::<String>())?;
    }
    let kernels: BTreeSet<String> = all.kernels.clone();
    let whose = match choices {
        [one] => one.name(),
        _ => "what was chosen",
    };
    if let Some(fault) = arguments.replace.unused(&kernels, whose).filter(|_| arguments.shard.is_none()) {
        return Err(fault.into());
    }
    if all.dispatches == 0 && arguments.shard.is_none() {
        return Err(Error::Check("nothing was watched: no stage that was chosen runs".into()));
    }
    let plural = |count: usize, word: &str| format!("{count} {word}{}", if count == 1 { "" } else { "s" });
    let fixtures = plural(all.fixtures, if arguments.scenes.is_empty() { "fixture" } else { "scene" });
    let (dispatches, kernels) = (plural(all.dispatches, "dispatch").replace("dispatchs", "dispatches"), kernels.len());
    let ran = format!(
        "watched {dispatches} of {} on {fixtures}: {:.1} million instructions, subgroups of {SUBGROUP}, up to {LANES} invocations an item",
        plural(kernels, "kernel"),
        all.executed as f64 * 1e-6
    );
    match all.findings.len() {
        0 => print(&format!("{ran}; nothing is wrong\n")),
        count => {
            print(&format!("{ran}\n"))?;
            Err(Error::Check(format!("{} in kernels", plural(count, "fault"))))
        }
    }
}
