//! `milkglass conform`: compares every stage on a device with the CPU reference.

mod dumps;
mod sheet;

use std::path::PathBuf;

use clap::Args;
use serde_json::json;

use super::device::opened;
use super::replace::{ReplaceArgument, replaced};
use super::run_args::{OptionArguments, quoted, repeated};
use super::{MemoryArgument, print};
use milkglass::error::{Error, Input, Result};
use milkglass::internals::gpu::{Adapter, Device, Instance};
use milkglass::internals::pipeline::frame::{STAGES, stage};
use milkglass::internals::session::run::CapacityHints;
use milkglass::internals::view::atomic_file::{ready, write_atomically};
use milkglass::measure::bias::farthest;
use milkglass::measure::conform::{BINS, Row, conform, conform_stages};
use milkglass::measure::fixtures::{Fixture, fixtures};
use milkglass::measure::leaning::blame;
use milkglass::measure::replace;
use milkglass::measure::verdict::verdict;
use milkglass::scene::Scene;
use sheet::text;

/// Arguments of `conform`.
#[derive(Args)]
#[command(
    after_help = "Example: milkglass conform --device llvmpipe\n         milkglass conform bunny.obj lotus\n         \
                        milkglass conform sphere --replace transport/blocks/push=my.comp"
)]
pub struct Arguments {
    /// Scenes to compare on; without any, the built-in fixtures.
    scenes: Vec<String>,
    /// Change a value of the scenes: `object.0.material.preset=ketchup`.
    #[arg(long = "set", value_name = "KEY=VALUE", requires = "scenes")]
    sets: Vec<String>,
    /// The frame, if values of the scenes have keyframes.
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true, requires = "scenes")]
    frame: f64,
    #[command(flatten)]
    option_args: OptionArguments,
    /// A device's number in `milkglass devices`, or part of its name [default: every Vulkan device].
    #[arg(long, value_name = "DEVICE")]
    device: Option<String>,
    /// Run without the validation layer.
    #[arg(long)]
    no_validation: bool,
    /// Only fixtures whose name contains this.
    #[arg(long, value_name = "TEXT", default_value = "", conflicts_with = "scenes")]
    only: String,
    #[command(flatten)]
    memory: MemoryArgument,
    /// Only these stages, separated by commas; the reference runs the others.
    #[arg(long, value_name = "STAGES", value_delimiter = ',')]
    stage: Vec<String>,
    #[command(flatten)]
    replace: ReplaceArgument,
    /// For each stage and fixture that differs, write the dispatch to a folder of this folder: see `milkglass replay`.
    #[arg(long, value_name = "FOLDER")]
    dump: Option<PathBuf>,
    /// In these folders leave out groups that do not fail, and the ends of buffers that nothing reaches.
    #[arg(long, requires = "dump")]
    minimize: bool,
    /// Also write the table to this file.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// Runs the fixtures on every requested device; fails on any difference beyond tolerance.
pub fn run(arguments: &Arguments) -> Result<()> {
    ready([("--json", arguments.json.as_ref())])?;
    if let Some(name) = arguments.stage.iter().find(|name| stage(name).is_none()) {
        let names: Vec<_> = STAGES.iter().map(|stage| stage.name).collect();
        return Err(Input::new("there is no such stage").key("--stage").found(name).expected(names.join(", ")).into());
    }
    let kernels = arguments.replace.load()?;
    let instance = Instance::open(!arguments.no_validation)?;
    let adapters = instance.adapters()?;
    let chosen: Vec<&Adapter> = match arguments.device.as_deref() {
        Some(wish) if wish.eq_ignore_ascii_case("cpu") => {
            let fault = Input::new("the CPU is the reference itself").key("--device").found("cpu");
            return Err(fault.expected("a Vulkan device").into());
        }
        Some(wish) => vec![Adapter::find(&adapters, wish)?],
        None => {
            for adapter in &adapters {
                if let Some(why) = &adapter.unusable {
                    tell!("{} is left out: {why}", adapter.name);
                }
            }
            adapters.iter().filter(|adapter| adapter.unusable.is_none()).collect()
        }
    };
    if chosen.is_empty() {
        return Err(Error::device("comparing devices with the CPU", "there is no usable Vulkan device"));
    }
    let mut list: Vec<Fixture> = Vec::new();
    if arguments.scenes.is_empty() {
        list.extend(fixtures(&arguments.only)?);
    }
    let files = arguments.memory.files();
    for name in &arguments.scenes {
        let scene = Scene::load_from(name, &arguments.option_args.of(&arguments.sets), arguments.frame, &files)?;
        let options = arguments.option_args.options();
        list.push(Fixture::new(name, &scene, options, CapacityHints::default()).map_err(|error| scene.placed(error))?);
    }

    let mut rows: Vec<(Device, Row)> = Vec::new();
    for &adapter in &chosen {
        let device = replaced(&opened(&instance, adapter)?, &kernels);
        if !adapter.limits.round_to_nearest {
            tell!("{}: rounding to nearest can't be requested; decisions rely on its default", adapter.name);
        }
        for row in on_device(arguments, &device, &list)? {
            rows.push((device.clone(), row));
        }
    }
    print(&text(&rows))?;
    if let Some(path) = &arguments.json {
        let value: Vec<_> = rows
            .iter()
            .map(|(device, row)| {
                // Null where a value is not a number, as `relative` is then.
                let ulp = (row.ulp < u64::MAX).then_some(row.ulp);
                json!({"device": device.name(), "driver": device.driver(), "fixture": row.fixture, "stage": row.stage,
                       "words": row.words, "ulp": ulp, "histogram": row.histogram, "most_ulp_of_bins": BINS,
                       "relative": row.relative, "of_tolerance": row.used,
                       "mean": farthest(&row.biases), "faults": row.faults})
            })
            .collect();
        let text = format!("{:#}\n", serde_json::Value::from(value));
        write_atomically(path, |beside| std::fs::write(beside, text).map_err(|e| e.to_string()))?;
    }
    let wrong: Vec<_> = rows.iter().filter(|(_, row)| !row.faults.is_empty()).collect();
    for (device, row) in &wrong {
        tell!("\n{}", verdict(device, row, &again(arguments, device, row)));
    }
    if let Some(folder) = &arguments.dump {
        dumps::write((folder, arguments.minimize), &list, wrong.iter().map(|(device, row)| (device, row)))?;
    }
    let idle = |name: &&String| rows.iter().all(|(_, row)| row.stage != **name);
    if let Some(name) = arguments.stage.iter().find(idle) {
        let what = if arguments.scenes.is_empty() { "fixture that was chosen" } else { "scene" };
        let fault = Input::new(format!("no {what} runs this stage, so it was not compared")).key("--stage").found(name);
        return Err(fault.expected("a stage that `milkglass plan` lists for the scene, or other fixtures").into());
    }
    if rows.is_empty() {
        return Err(Error::Check("nothing was compared".into()));
    }
    if !wrong.is_empty() {
        let faults: usize = wrong.iter().map(|(_, row)| row.faults.len()).sum();
        let s = if faults == 1 { "" } else { "s" };
        return Err(Error::Check(format!("{faults} difference{s} beyond tolerance")));
    }
    // What a report on a driver needs.
    let mut text = String::new();
    for adapter in chosen {
        let (name, driver, size) = (&adapter.name, &adapter.driver, adapter.limits.subgroup_size);
        let count = rows.iter().filter(|(device, _)| device.name() == name).count();
        let version = env!("CARGO_PKG_VERSION");
        text += &format!("milkglass {version}, {name}, driver {driver}, subgroups of {size}: {count} comparisons\n");
    }
    print(&format!("{text}{} comparisons, all conform\n", rows.len()))
}

/// All rows of a device: of every stage, of the requested stages, or of the stages whose kernels are replaced.
fn on_device(arguments: &Arguments, device: &Device, list: &[Fixture]) -> Result<Vec<Row>> {
    let mut stages = arguments.stage.clone();
    let mut rows = Vec::new();
    if device.replaced().next().is_some() {
        rows.extend(replace::check(device, list)?);
        stages.retain(|stage| !replace::stages(device).contains(stage));
        if stages.is_empty() {
            return Ok(rows);
        }
    }
    let checked = rows.len();
    for fixture in list {
        match stages.is_empty() {
            true => rows.extend(conform(device, fixture, &[])?),
            false => rows.extend(conform_stages(device, fixture, &stages)?),
        }
    }
    blame(&mut rows[checked..]);
    Ok(rows)
}

/// The command that reproduces this row.
fn again(arguments: &Arguments, device: &Device, row: &Row) -> String {
    let (name, stage, own) = (device.name(), row.stage, arguments.replace.again());
    if !arguments.scenes.is_empty() {
        return repeated(device);
    }
    let validation = if arguments.no_validation { " --no-validation" } else { "" };
    let (fixture, name) = (quoted(&row.fixture), quoted(name));
    format!("milkglass conform --only {fixture} --device {name} --stage {stage}{own}{validation}")
}
