//! `milkglass conform`: compares every stage on a device with the CPU reference.

mod alone;
mod arguments;
mod child;
mod choose;
mod drivers;
mod dumps;
mod end;
mod expect;
mod interpreted;
mod isolate;
mod junit;
mod sheet;
mod sink;
mod unfinished;

pub use self::arguments::Arguments;
use self::choose::chosen;
pub(super) use self::junit::known_root;
use self::sink::Sink;
use super::device::opened;
use super::print;
use super::replace::replaced;
use milkglass::error::{Error, Input, Result};
use milkglass::internals::gpu::{Adapter, Device, Instance};
use milkglass::internals::pipeline::frame::{STAGES, stage};
use milkglass::internals::view::atomic_file::ready;
use milkglass::measure::interpreted::is_asked;
use milkglass::measure::probe::probe;
use milkglass::measure::results::{DeviceFacts, Outcome, Results, read};

/// Runs the fixtures or scenes that were chosen on every requested device; fails if a stage does not conform and
/// `--expect` does not say so.
pub fn run(arguments: &Arguments) -> Result<()> {
    if let Some(name) = arguments.stage.iter().find(|name| stage(name).is_none()) {
        let names: Vec<_> = STAGES.iter().map(|stage| stage.name).collect();
        return Err(Input::new("there is no such stage").key("--stage").found(name).expected(names.join(", ")).into());
    }
    let choices = chosen(arguments)?;
    if arguments.list {
        return print(&choices.iter().map(|choice| format!("{}\n", choice.name())).collect::<String>());
    }
    if arguments.sanitize {
        return interpreted::sanitize(arguments, &choices);
    }
    ready([
        ("--json", arguments.json.as_ref()),
        ("--jsonl", arguments.jsonl.as_ref()),
        ("--junit", arguments.junit.as_ref()),
        ("--coverage", arguments.coverage.as_ref()),
    ])?;
    let before: Option<Results> = arguments.baseline.as_deref().map(read).transpose()?;
    if is_asked(arguments.device.as_deref()) {
        return interpreted::run(arguments, &choices, before.as_ref());
    }
    let known = expect::load(arguments.expect.as_deref())?;
    let kernels = arguments.replace.load()?;
    let instance = Instance::open(!arguments.no_validation)?;
    let adapters = instance.adapters()?;
    let devices = requested(arguments, &adapters)?;
    let isolated = arguments.isolated();
    let (mut open, mut facts, mut failures) = (Vec::<Device>::new(), Vec::new(), Vec::<Outcome>::new());
    for (index, adapter) in &devices {
        let mut own = DeviceFacts::new(adapter);
        if isolated {
            failures.extend(isolate::probed(arguments, (*index, adapter), &mut own)?);
        } else {
            let device = replaced(&opened(&instance, adapter)?, &kernels)?;
            if !arguments.child || arguments.probe_only {
                own.probes = probe(&device)?;
            }
            open.push(device);
        }
        failures.extend(own.probed().into_iter().filter(|outcome| !outcome.verdict.passes()));
        facts.push(own);
    }
    let mut sink = Sink::open(arguments, &choices, instance.layer(), facts, &kernels, known)?;
    if arguments.probe_only {
        return Ok(());
    }
    failures.into_iter().try_for_each(|failure| sink.add(failure))?;
    let done = match isolated {
        true => isolate::run(arguments, &choices, &devices, &mut sink),
        false => alone::run(arguments, &choices, &open, &mut sink),
    };
    if let Err(error) = done {
        // Write the results so far.
        sink.finish(arguments)?;
        return Err(error);
    }
    end::end(arguments, sink, before.as_ref(), &choices)
}

/// The devices that were requested, with their places in the list; tells what is left out, and what they lack.
fn requested<'a>(arguments: &Arguments, adapters: &'a [Adapter]) -> Result<Vec<(usize, &'a Adapter)>> {
    let devices: Vec<(usize, &Adapter)> = match arguments.device.as_deref() {
        Some(wish) if wish.eq_ignore_ascii_case("cpu") => {
            let fault = Input::new("the CPU is the reference itself").key("--device").found("cpu");
            return Err(fault.expected("a Vulkan device").into());
        }
        Some(wish) => {
            let found = Adapter::find(adapters, wish)?;
            adapters.iter().enumerate().filter(|(_, adapter)| std::ptr::eq(*adapter, found)).collect()
        }
        None => {
            for adapter in adapters.iter().filter(|_| !arguments.child) {
                if let Some(why) = &adapter.unusable {
                    tell!("{} is left out: {why}", adapter.name);
                }
            }
            adapters.iter().enumerate().filter(|(_, adapter)| adapter.unusable.is_none()).collect()
        }
    };
    if devices.is_empty() {
        return Err(Error::device("comparing devices with the CPU", "there is no usable Vulkan device"));
    }
    for (_, adapter) in devices.iter().filter(|_| !arguments.child) {
        if adapter.unusable.is_none() && !adapter.limits.round_to_nearest {
            tell!("{}: rounding to nearest can't be requested; decisions rely on its default", adapter.name);
        }
    }
    Ok(devices)
}
