//! Comparisons in this process.

use std::collections::BTreeSet;
use std::path::Path;

use super::arguments::{Arguments, again, failure};
use super::choose::Choice;
use super::sink::Sink;
use super::{dumps, unfinished};
use crate::cli::{print, write};
use milkglass::error::Result;
use milkglass::internals::gpu::Device;
use milkglass::measure::conform::{Event, conform_told};
use milkglass::measure::coverage::{Coverage, table};
use milkglass::measure::fixtures::Fixture;
use milkglass::measure::leaning::blame;
use milkglass::measure::results::{Outcome, Verdict};
use milkglass::measure::{probe, replace};

/// Compares everything that was chosen on all devices.
pub(super) fn run(arguments: &Arguments, choices: &[Choice], open: &[Device], sink: &mut Sink) -> Result<()> {
    // Kernels that some fixture runs: those that are replaced must be among them.
    let mut run = BTreeSet::from([probe::NAME.to_string()]);
    for choice in choices {
        let fixture = choice.make(arguments)?;
        if !arguments.replace.pairs().is_empty() {
            run.extend(replace::kernels_of(&fixture, &open[0])?);
        }
        for device in open {
            match (arguments.unfinished, &arguments.dump) {
                (Some(step), Some(folder)) => unfinished::steps(arguments, folder, (device, &fixture), step)?,
                _ => compare(arguments, device, &fixture, sink)?,
            }
        }
    }
    // A child runs one fixture, and a shard some of them: neither need run every kernel.
    let whose = match choices {
        [one] => one.name(),
        _ => "what was chosen",
    };
    match arguments.replace.unused(&run, whose) {
        Some(fault) if !arguments.child && arguments.shard.is_none() => Err(fault.into()),
        _ => arguments.coverage.iter().try_for_each(|path| cover(arguments, choices, open, path)),
    }
}

/// Says in a file what was executed, once everything is compared: kernels that count may be too much for a device.
fn cover(arguments: &Arguments, choices: &[Choice], open: &[Device], path: &Path) -> Result<()> {
    let mut covered: Vec<Coverage> = open.iter().map(Coverage::new).collect();
    for choice in choices {
        let fixture = choice.make(arguments)?;
        covered.iter_mut().try_for_each(|coverage| coverage.add(&fixture))?;
    }
    covered.iter().try_for_each(|coverage| print(&coverage.text()))?;
    write(path, table(&covered).csv()?)
}

/// Compares all stages of a fixture on a device, or only those of replaced kernels and those that were asked for.
fn compare(arguments: &Arguments, device: &Device, fixture: &Fixture, sink: &mut Sink) -> Result<()> {
    let mut stages = replace::stages(device);
    stages.extend(arguments.stage.iter().cloned());
    let (adapter, mut now) = (device.adapter(), "");
    let mut failed = None;
    let done = conform_told(device, fixture, &stages, &mut |event| {
        let told = match event {
            Event::Begins(stage) => {
                now = stage;
                sink.begins(&fixture.name, stage)
            }
            Event::Ends(row) => {
                blame(std::slice::from_mut(row));
                let outcome = Outcome::new(adapter, row, again(arguments, device.name(), &row.fixture, row.stage));
                // At once: a later stage may hang.
                sink.add(outcome).and_then(|()| match &arguments.dump {
                    Some(folder) if !row.faults.is_empty() => {
                        dumps::write((folder, arguments.minimize), fixture, device, row)
                    }
                    _ => Ok(()),
                })
            }
        };
        failed = failed.take().or(told.err());
    });
    if let Some(error) = failed {
        return Err(error);
    }
    if let Err(error) = done {
        if error.is_device_fault() {
            sink.add(failure(arguments, adapter, (&fixture.name, now), Verdict::DeviceFailed, &error))?;
        }
        return Err(error);
    }
    Ok(())
}
