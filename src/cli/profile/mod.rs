//! `milkglass profile`: time, work and memory traffic of each stage of a scene, compared with what the device can do;
//! and times of two variants, builds, devices or runs compared with each other.

mod arguments;
mod comparison;
mod pipe;
mod text;
mod why;

use std::path::Path;

use serde_json::{Value, json};

pub use self::arguments::Arguments;
use self::comparison::{files, told};
pub(super) use self::comparison::{half, rounds, unmet};
use self::pipe::{Other, serve};
use self::text::text;
use super::replace::replaced;
use super::{check_messages, print};
use milkglass::error::{Error, Input, Result};
use milkglass::internals::gpu::Device;
use milkglass::internals::pipeline::plan::{Change, Mode};
use milkglass::internals::view::atomic_file::{ready, write_atomically};
use milkglass::measure::profile::file::{Saved, read};
use milkglass::measure::profile::why::why;
use milkglass::measure::profile::{Open, Settings, against, agreement, profile, result, variant};
use milkglass::measure::replace::stages;
use milkglass::measure::rounds::{Measured, Samples, Starter, compare};
use milkglass::scene::Scene;

/// Measures, prints, and writes the requested files.
pub fn run(arguments: &Arguments) -> Result<()> {
    arguments.check()?;
    ready([
        ("--csv", arguments.csv.as_ref()),
        ("--json", arguments.save.as_ref()),
        ("--trace", arguments.trace.as_ref()),
    ])?;
    if let [first, second] = arguments.compare.as_slice() {
        return files((&read(first)?, first), (&read(second)?, second));
    }
    let settings = arguments.settings();
    if settings.options.mode == Mode::Incremental && settings.change == Change::EVERYTHING && !arguments.serve {
        tell!("mode incremental: nothing moves, so each frame only checks its links and makes no new ones");
    }
    let earlier = match arguments.compare.first() {
        Some(path) => Some((read(path)?, path)),
        None => None,
    };
    if let Some(program) = &arguments.against {
        return builds(arguments, program, &settings);
    }
    let scene = arguments.scene()?.load()?;
    match arguments.device.as_slice() {
        [] | [_] => {}
        several => return devices(arguments, several, &scene, &settings),
    }
    let device = arguments.open(arguments.device.first())?;
    if arguments.serve {
        return serve(&scene, device.as_ref(), &settings);
    }
    if arguments.why && device.is_none() {
        let fault = Input::new("measures a Vulkan device").key("--why").found("the CPU");
        return Err(fault.expected("a device that `milkglass devices` lists").into());
    }
    let own = arguments.replace.on(device.as_ref(), &[(&scene, settings.options)])?;
    let mut comparison = Value::Null;
    if let Some(after) = &own {
        let kernels = arguments.replace.load()?;
        let built_in = || arguments.open(arguments.device.first());
        let with_own = || built_in()?.map(|device| replaced(&device, &kernels)).transpose();
        let found = against(&scene, &[("built-in", &built_in), ("replaced", &with_own)], &settings)?;
        comparison = compared(&found.samples, &stages(after), &settings)?;
    }
    let device = own.or(device);
    let found = profile(&scene, device.as_ref(), &arguments.alone(&settings))?;
    let reasons = match &device {
        Some(device) if arguments.why => Some(why(&scene, device, &arguments.alone(&settings), &found)?),
        _ => None,
    };
    check_messages(device.as_ref())?;
    let page = reasons.as_ref().map_or_else(|| text(&found), |why| why::text(&found, why));
    print(&format!("{page}{}", unmet(&found.samples, &arguments.alone(&settings))))?;
    let saved = arguments.saved(&found.device, &found.driver, found.samples.clone());
    if let Some((earlier, path)) = &earlier {
        earlier.same_subject(&saved, path)?;
        print("\n")?;
        files((earlier, path), (&saved, Path::new("this run")))?;
    }
    if let Some(path) = &arguments.csv {
        write(path, found.csv()?)?;
    }
    if let Some(path) = &arguments.trace {
        write(path, format!("{}\n", found.trace()))?;
    }
    let mut json = found.json();
    if let Some(why) = &reasons {
        json["why"] = json!(why);
    }
    save(arguments, &saved, json, comparison)
}

/// Times this program's build against another one, each in a process of its own.
fn builds(arguments: &Arguments, program: &Path, settings: &Settings) -> Result<()> {
    let tolerance = arguments.scene()?.load()?.transport.tolerance;
    let own = std::env::current_exe().map_err(|error| Error::device("starting this program again", error))?;
    let first = Other::start(&own, arguments)?;
    let second = Other::start(program, arguments)?;
    print(&format!("this build:  {}\nother build: {}, {}\n", first.origin(), program.display(), second.origin()))?;
    let results = [first.result(), second.result()];
    let found = agreement(["this build", "the other"], results, tolerance)?;
    print(&format!("both compute {found}\n\n"))?;
    let (device, driver) = (first.hello.device.clone(), first.hello.driver.clone());
    drop((first, second));
    let starter = |name: &str, program: &Path| {
        let program = program.to_path_buf();
        let start = move || Ok(Box::new(Other::start(&program, arguments)?) as _);
        Starter { name: name.into(), start: Box::new(start) }
    };
    let mut starters = [starter("this build", &own), starter("other build", program)];
    let Measured { samples, .. } = compare(&mut starters, &settings.schedule())?;
    let comparison = compared(&samples, &[], settings)?;
    save(arguments, &arguments.saved(&device, &driver, samples), json!({}), comparison)
}

/// Times several devices side by side.
fn devices(arguments: &Arguments, names: &[String], scene: &Scene, settings: &Settings) -> Result<()> {
    let opened = names.iter().map(|name| arguments.open(Some(name))).collect::<Result<Vec<_>>>()?;
    let mut results = Vec::new();
    for (k, device) in opened.iter().enumerate() {
        let [name, driver] = described(device.as_ref());
        print(&format!("device {}: {name}, {driver}\n", k + 1))?;
        results.push(result(&mut variant(scene, device.as_ref(), settings)?.session)?);
        check_messages(device.as_ref())?;
    }
    for (k, other) in results.iter().enumerate().skip(1) {
        let names = ["device 1".to_string(), format!("device {}", k + 1)];
        let found = agreement([&names[0], &names[1]], [&results[0], other], scene.transport.tolerance)?;
        print(&format!("{} and {} compute {found}\n", names[0], names[1]))?;
    }
    print("\n")?;
    let opens: Vec<_> = names.iter().map(|name| move || arguments.open(Some(name))).collect();
    let called: Vec<String> = (1..=names.len()).map(|number| format!("device {number}")).collect();
    let devices: Vec<(&str, Open<'_>)> =
        called.iter().zip(&opens).map(|(name, open)| (name.as_str(), open as Open<'_>)).collect();
    let Measured { samples, .. } = against(scene, &devices, settings)?;
    let comparison = compared(&samples, &[], settings)?;
    let [name, driver] = described(opened[0].as_ref());
    save(arguments, &arguments.saved(name, driver, samples), json!({}), comparison)
}

/// Prints the ratios of samples of several variants; returns them.
fn compared(samples: &Samples, replaced: &[String], settings: &Settings) -> Result<Value> {
    let ratios = samples.ratios();
    print(&format!("{}{}\n", told(samples, &ratios, replaced), unmet(samples, settings)))?;
    let names = samples.variants.iter().skip(1).map(|variant| &variant.name);
    Ok(names.zip(&ratios).map(|(name, rows)| json!({"variant": name, "rows": rows})).collect())
}

/// Writes the file of `--save`, if it was requested.
fn save(arguments: &Arguments, saved: &Saved, mut value: Value, comparison: Value) -> Result<()> {
    let Some(path) = &arguments.save else { return Ok(()) };
    let fault = |error: serde_json::Error| Error::from(Input::new(error.to_string()).file(path));
    if let (Value::Object(all), Value::Object(own)) = (&mut value, serde_json::to_value(saved).map_err(fault)?) {
        all.extend(own);
        all.insert("comparison".into(), comparison);
    }
    write(path, format!("{value:#}\n"))
}

/// Writes a text. The file appears whole or not at all.
pub(super) fn write(path: &Path, text: String) -> Result<()> {
    write_atomically(path, |beside| std::fs::write(beside, text).map_err(|e| e.to_string()))
}

/// Name and driver of a device, or of the CPU's reference.
fn described(device: Option<&Device>) -> [&str; 2] {
    device.map_or(["cpu", "the f64 reference"], |device| [device.name(), device.driver()])
}
