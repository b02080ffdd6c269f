//! `milkglass profile`: time, work and memory traffic of each stage of a scene, compared with what the device can do;
//! and times of two variants, builds, devices or runs compared with each other.

mod arguments;
mod comparison;
mod counted;
mod gate;
mod junit;
mod pipe;
mod predicted;
mod text;
mod why;

use std::collections::BTreeSet;
use std::path::Path;

use serde_json::{Value, json};

pub use self::arguments::Arguments;
use self::comparison::{files, forecast, told};
pub(super) use self::comparison::{half, rounds, unmet};
use self::gate::Held;
use self::pipe::{Other, serve};
use self::text::{text, work_told};
use super::replace::replaced;
use super::{check_messages, now, print, write};
use milkglass::error::{Error, Input, Result};
use milkglass::internals::gpu::Device;
use milkglass::internals::pipeline::plan::{Change, Mode};
use milkglass::internals::view::atomic_file::ready_for;
use milkglass::measure::interpreted::is_asked;
use milkglass::measure::profile::file::{Saved, Subject, read};
use milkglass::measure::profile::history::{self, Entry};
use milkglass::measure::profile::roofline;
use milkglass::measure::profile::why::why;
use milkglass::measure::profile::{
    Model, Open, Profile, Settings, against, agreement, alternate, profile, result, variant, work,
};
use milkglass::measure::replace::stages;
use milkglass::measure::results::system;
use milkglass::measure::rounds::{Forecast, Measured, Samples, Starter, compare};
use milkglass::scene::Scene;

/// Measures, prints, and writes the requested files.
pub fn run(arguments: &Arguments) -> Result<()> {
    if arguments.device.iter().any(|name| is_asked(Some(name))) {
        return counted::run(arguments);
    }
    arguments.check()?;
    ready_for(arguments.files())?;
    let model = arguments.model.as_deref().map(Model::read).transpose()?;
    arguments.history.iter().try_for_each(|path| history::ready(path))?;
    if let [first, second] = arguments.compare.as_slice() {
        let (one, two) = (read(first)?, read(second)?);
        let held = arguments.gate.times("B against A", &files((&one, first), (&two, second))?, &[]);
        return judge(arguments, &held, &[("A", one.origin()), ("B", two.origin())]);
    }
    let settings = arguments.settings();
    if settings.options.mode == Mode::Incremental && settings.change == Change::EVERYTHING && !arguments.serve {
        tell!("mode incremental: nothing moves, so each frame only checks its links and makes no new ones");
    }
    let earlier = arguments.compare.first().map(|path| read(path).map(|saved| (saved, path))).transpose()?;
    if let Some(program) = &arguments.against {
        return builds(arguments, program, &settings);
    }
    let scene = arguments.scene()?.load()?;
    if arguments.device.len() > 1 {
        return devices(arguments, &scene, &settings);
    }
    let device = arguments.open(arguments.device.first())?;
    if arguments.serve {
        return serve(&scene, device.as_ref(), &settings);
    }
    arguments.suits(device.as_ref())?;
    let own = arguments.replace.on(device.as_ref(), &[(&scene, settings.options)], false)?.map(|(device, _)| device);
    if let (Some(model), Some(device)) = (&model, &device) {
        return predicted::run(arguments, model, &scene, (device, own.as_ref()), &settings);
    }
    let mut comparison = match &own {
        Some(after) => replacement(arguments, &scene, (device.as_ref(), after), &settings)?,
        None => Comparison::default(),
    };
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
        let rows = files((earlier, path), (&saved, Path::new("this run")))?;
        comparison.held = arguments.gate.times("B against A", &rows, &[]);
    }
    let mut json = write_files(arguments, &found)?;
    if let Some(why) = &reasons {
        json["why"] = json!(why);
    }
    save(arguments, &saved, json, &comparison)?;
    arguments.roofline.iter().try_for_each(|path| draw(path, &found))?;
    end(arguments, &saved, &comparison.held)
}

/// Samples of a few frames of what another run timed, on this device; the CPU if there is none.
pub(super) fn timed_again(subject: &Subject, device: Option<&Device>) -> Result<Samples> {
    let arguments = Arguments::again(subject)?;
    let scene = arguments.scene()?.load()?;
    // The caller's own device goes on compiling ahead.
    let again = device.map(|device| device.opened_as(device.choices())).transpose()?;
    let device = arguments.timing(again)?;
    Ok(profile(&scene, device.as_ref(), &arguments.settings())?.samples)
}

/// Writes the files of `--csv` and `--trace`, if they were requested; returns what that of `--save` has of the profile.
fn write_files(arguments: &Arguments, found: &Profile) -> Result<Value> {
    if let Some(path) = &arguments.csv {
        write(path, found.csv()?)?;
    }
    if let Some(path) = &arguments.trace {
        write(path, format!("{}\n", found.trace()))?;
    }
    Ok(found.json())
}

/// Writes the file of `--roofline`.
fn draw(path: &Path, found: &Profile) -> Result<()> {
    match roofline(found)? {
        Some(drawing) => write(path, drawing),
        None => Err(Input::new("no row has counts of floats and bytes").key("--roofline").found(&found.scene).into()),
    }
}

/// Times the user's own kernels against the built-in ones.
fn replacement(
    arguments: &Arguments,
    scene: &Scene,
    (before, after): (Option<&Device>, &Device),
    settings: &Settings,
) -> Result<Comparison> {
    let kernels = arguments.replace.load()?;
    let built_in = || arguments.open(arguments.device.first());
    let with_own = || built_in()?.map(|device| replaced(&device, &kernels)).transpose();
    let devices: [(&str, Open<'_>); 2] = [("built-in", &built_in), ("replaced", &with_own)];
    let edited = stages(after);
    let found = match &arguments.alternate {
        Some(stage) if edited.contains(stage) => {
            let both = || {
                let with_own = with_own()?.ok_or_else(|| Error::device("opening it once more", "it is gone"))?;
                Ok([with_own.built_in(), with_own])
            };
            alternate(scene, &both, stage, settings, &mut foretold(settings))?
        }
        Some(stage) => {
            let fault = Input::new("no kernel of this stage is replaced").key("--alternate").found(stage);
            return Err(fault.expected(edited.join(", ")).into());
        }
        None => against(scene, &devices, settings, &edited, &mut foretold(settings))?,
    };
    let mut comparison = compared(arguments, &found.samples, settings)?;
    if let (Some(before), Some(rows)) = (before, comparison.json.get_mut(0)) {
        let (counts, held) = works(arguments, scene, [before, after], &edited)?;
        rows["work"] = counts;
        comparison.held.extend(held);
    }
    comparison.rounds = Some(found.samples);
    Ok(comparison)
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
    let Measured { samples, .. } = compare(&mut starters, &settings.schedule(), &[], &mut foretold(settings))?;
    let comparison = compared(arguments, &samples, settings)?;
    let saved = arguments.saved(&device, &driver, samples);
    save(arguments, &saved, json!({}), &comparison)?;
    end(arguments, &saved, &comparison.held)
}

/// Times several devices side by side.
fn devices(arguments: &Arguments, scene: &Scene, settings: &Settings) -> Result<()> {
    let names = &arguments.device;
    let opened = names.iter().map(|name| arguments.open(Some(name))).collect::<Result<Vec<_>>>()?;
    let mut results = Vec::new();
    let numbers: Vec<_> = opened.iter().map(|device| device.as_ref().map(|own| own.adapter().number)).collect();
    let called = called(&numbers);
    for (device, called) in opened.iter().zip(&called) {
        let of = device.as_ref().map_or_else(String::new, |device| format!("{}, ", device.name()));
        print(&format!("{called}: {of}{}\n", described(device.as_ref())[1]))?;
        results.push(result(&mut variant(scene, device.as_ref(), settings)?.session)?);
        check_messages(device.as_ref())?;
    }
    for (k, other) in results.iter().enumerate().skip(1) {
        let found = agreement([&called[0], &called[k]], [&results[0], other], scene.transport.tolerance)?;
        print(&format!("{} and {} compute {found}\n", called[0], called[k]))?;
    }
    print("\n")?;
    let opens: Vec<_> = names.iter().map(|name| move || arguments.open(Some(name))).collect();
    let devices: Vec<(&str, Open<'_>)> =
        called.iter().zip(&opens).map(|(name, open)| (name.as_str(), open as Open<'_>)).collect();
    let Measured { samples, .. } = against(scene, &devices, settings, &[], &mut foretold(settings))?;
    let comparison = compared(arguments, &samples, settings)?;
    let [name, driver] = described(opened[0].as_ref());
    let saved = arguments.saved(name, driver, samples);
    save(arguments, &saved, json!({}), &comparison)?;
    end(arguments, &saved, &comparison.held)
}

/// What devices of these numbers in `milkglass devices` are called; the CPU has none.
fn called(numbers: &[Option<usize>]) -> Vec<String> {
    let name = |(k, number): (usize, &Option<usize>)| {
        let name = number.map_or_else(|| "cpu".into(), |number| format!("device {number}"));
        match numbers[..k].iter().filter(|known| *known == number).count() {
            0 => name,
            earlier => format!("{name}, run {}", earlier + 1),
        }
    };
    numbers.iter().enumerate().map(name).collect()
}

/// Tells how long a comparison is going to take.
fn foretold(settings: &Settings) -> impl FnMut(&Forecast) {
    |found| tell!("{}", forecast(found, settings))
}

/// Counts what the built-in and the replaced kernels do, prints it for the edited stages and for others whose counts
/// changed; returns it, and what is beyond a limit.
fn works(arguments: &Arguments, scene: &Scene, devices: [&Device; 2], edited: &[String]) -> Result<(Value, Vec<Held>)> {
    let mut counted = Vec::new();
    for device in devices {
        match work(scene, device, &arguments.settings()) {
            Ok(stages) => counted.push(stages),
            Err(error) if error.is_device_fault() => {
                print(&format!("what kernels do was not counted: {error}\n\n"))?;
                return Ok((Value::Null, arguments.gate.uncounted()));
            }
            Err(error) => return Err(error),
        }
    }
    let (mut text, mut all, mut held) = (String::new(), Vec::new(), Vec::new());
    let names: BTreeSet<&str> = counted.iter().flat_map(|stages| stages.keys().map(String::as_str)).collect();
    for stage in names {
        let [before, after] = [0, 1].map(|k| counted[k].get(stage).copied().unwrap_or_default());
        if edited.iter().any(|name| name == stage) || before.counts() != after.counts() {
            text += &work_told(stage, [before, after]);
            held.extend(arguments.gate.work(stage, [before, after]));
            all.push(json!({"stage": stage, "before": before, "after": after}));
        }
    }
    print(&format!("counted exactly, in one more frame of each:\n{text}\n"))?;
    Ok((all.into(), held))
}

/// A comparison: as JSON, its rounds where the file's samples are others, and what was held to a limit.
#[derive(Default)]
struct Comparison {
    json: Value,
    rounds: Option<Samples>,
    held: Vec<Held>,
}

/// Prints the ratios of samples of several variants; returns them.
fn compared(arguments: &Arguments, samples: &Samples, settings: &Settings) -> Result<Comparison> {
    let ratios = samples.ratios();
    print(&format!("{}{}\n", told(samples, &ratios), unmet(samples, settings)))?;
    let names = samples.variants.iter().skip(1).map(|variant| &variant.name);
    let rows = names.zip(&ratios);
    let held = rows.clone().flat_map(|(name, rows)| arguments.gate.times(name, rows, &samples.edited)).collect();
    Ok(Comparison {
        json: rows.map(|(name, rows)| json!({"variant": name, "rows": rows})).collect(),
        held,
        rounds: None,
    })
}

/// Writes the files of `--save` and `--history`, if they were requested.
fn save(arguments: &Arguments, saved: &Saved, mut value: Value, comparison: &Comparison) -> Result<()> {
    if let Some(path) = &arguments.save {
        let fault = |error: serde_json::Error| Error::from(Input::new(error.to_string()).file(path));
        if let (Value::Object(all), Value::Object(own)) = (&mut value, serde_json::to_value(saved).map_err(fault)?) {
            all.extend(own);
            all.insert("comparison".into(), comparison.json.clone());
            if let Some(rounds) = &comparison.rounds {
                all.insert("rounds".into(), serde_json::to_value(rounds).map_err(fault)?);
            }
        }
        write(path, format!("{value:#}\n"))?;
    }
    arguments.history.iter().try_for_each(|path| Entry::of(saved, now()).append(path))
}

/// Ends a run that was saved.
fn end(arguments: &Arguments, saved: &Saved, held: &[Held]) -> Result<()> {
    judge(arguments, held, &[("run", saved.origin()), ("scene", saved.subject.scene.clone()), ("system", system())])
}

/// Writes the file of `--junit`, if it was requested; fails if something is beyond a limit.
fn judge(arguments: &Arguments, held: &[Held], properties: &[(&str, String)]) -> Result<()> {
    if let Some(path) = &arguments.gate.junit {
        junit::put(path, held, properties)?;
    }
    gate::end(held)
}

/// Name and driver of a device, or of the CPU's reference.
fn described(device: Option<&Device>) -> [&str; 2] {
    device.map_or(["cpu", "the f64 reference"], |device| [device.name(), device.driver()])
}

#[cfg(test)]
mod tests {
    #[test]
    fn devices_have_the_numbers_that_are_typed() {
        let names = super::called(&[Some(0), None, Some(3), None, Some(0), None]);
        assert_eq!(names, ["device 0", "cpu", "device 3", "cpu, run 2", "device 0, run 2", "cpu, run 3"]);
    }
}
