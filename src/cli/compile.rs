//! `milkglass compile`: what compilers of GPUs that are not here make of a scene's kernels.
//!
//! A process for each compiler opens its device, creates the plan's pipelines and ends without destroying anything,
//! since drivers of null hardware crash there. It names each kernel in a line of JSON before it compiles it, so that
//! the kernel is known at which a process was killed.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Write;
use std::path::{Path, PathBuf};

use clap::Args;
use serde::{Deserialize, Serialize};

use super::replace::{ReplaceArgument, replaced};
use super::watch::{itself, seconds, watched};
use super::{RunArguments, SceneArguments, print, table, write};
use milkglass::error::{Error, Input, Result};
use milkglass::internals::gpu::{Device, Instance, Kernels};
use milkglass::internals::pipeline::plan::Change;
use milkglass::internals::session::run::Session;
use milkglass::internals::view::atomic_file::ready;

/// Arguments of `compile`.
#[derive(Args)]
#[command(after_help = "Example: milkglass compile lotus --for navi21,gfx1100 --csv lotus.csv\n         \
                        milkglass compile lotus --for navi21,gfx1100 --baseline lotus.csv")]
pub struct Arguments {
    #[command(flatten)]
    scene: SceneArguments,
    #[command(flatten)]
    run: RunArguments,
    #[command(flatten)]
    replace: ReplaceArgument,
    /// Compilers: families of AMD GPUs for Mesa's RADV, such as polaris10, vega10, navi10, navi21 or gfx1100; `here` is
    /// the device's own compiler.
    #[arg(long = "for", value_name = "FAMILY,...", value_delimiter = ',', default_value = "navi21,gfx1100")]
    families: Vec<String>,
    /// Also write everything that the compilers report except hashes, a row for each value.
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Compare with a file that --csv wrote; fail where a kernel spills more, needs more scratch memory, has fewer
    /// waves, or takes over 10 % more cycles.
    #[arg(long, value_name = "FILE")]
    baseline: Option<PathBuf>,
    /// How long a compiler may take, seconds.
    #[arg(long, value_name = "SECONDS", default_value = "600", value_parser = seconds)]
    timeout: f64,
    /// Compile in this process.
    #[arg(long, hide = true)]
    child: bool,
}

/// A pipeline as a compiler made it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Pipeline {
    kernel: String,
    /// Specialization constants: `CHANNELS = 7, ORDER = 2`.
    constants: String,
    milliseconds: f64,
    /// What the driver reports, by its names.
    statistics: Vec<(String, f64)>,
}

/// A line that a child writes.
#[derive(Serialize, Deserialize)]
enum Line {
    Device(String),
    Begins(String),
    Pipeline(Pipeline),
}

/// The columns of a table, each shown if a driver reports it: the heading, and its names in RADV and NVK.
const SHOWN: [(&str, &[&str]); 9] = [
    ("registers", &["VGPRs", "Number of GPRs", "Register Count"]),
    ("scalar", &["SGPRs"]),
    ("spilled", &["Spilled VGPRs", "Spills to memory", "Number of spills to memory"]),
    ("scratch", &["Scratch size", "Scratch size per thread", "SLM size"]),
    ("shared", &["LDS size", "LDS Size", "Shared memory size"]),
    ("waves", &["Subgroups per SIMD"]),
    ("code, B", &["Code size", "Code Size"]),
    ("latency", &["Latency"]),
    ("cycles", &["Inverse Throughput"]),
];
/// Columns in which a value is worse than the baseline's if it is more than this factor larger; fewer waves are worse.
const WORSE: [(&str, f64); 3] = [("spilled", 1.0), ("scratch", 1.0), ("cycles", 1.1)];

/// Runs each compiler, prints what it reports, and compares that with the baseline.
pub fn run(arguments: &Arguments) -> Result<()> {
    ready([("--csv", arguments.csv.as_ref())])?;
    if arguments.child {
        return child(arguments);
    }
    let known = arguments.baseline.as_deref().map(read).transpose()?;
    let (mut rows, mut failed) = (BTreeMap::<String, Vec<Pipeline>>::new(), Vec::new());
    for family in &arguments.families {
        let mut command = itself("compile")?;
        // The words of this call; of all values of --for, the child takes the last one.
        command.args(std::env::args_os().skip(2)).arg("--for").arg(family);
        if family != "here" {
            command.env("RADV_FORCE_FAMILY", family);
        }
        let (mut device, mut at, mut found) = (String::new(), String::new(), Vec::new());
        let ended = watched(command, arguments.timeout, &mut |line: Line| {
            match line {
                Line::Device(name) => device = name,
                Line::Begins(kernel) => at = kernel,
                Line::Pipeline(pipeline) => found.push(pipeline),
            }
            Ok(())
        })?;
        print(&format!("{family}: {device}\n{}\n", sheet(&found)))?;
        failed.extend(ended.map(|(_, why)| format!("{family}: {at}: {why}")));
        rows.insert(family.clone(), found);
    }
    if let Some(path) = &arguments.csv {
        write(path, text(&rows)?)?;
    }
    let worse: Vec<String> = known.iter().flat_map(|known| worse(known, &rows)).collect();
    worse.iter().chain(&failed).for_each(|line| tell!("{line}"));
    match (failed.len(), worse.len()) {
        (0, 0) => Ok(()),
        (0, count) => Err(Error::Check(format!("{count} values are worse than those of the baseline"))),
        (count, _) => Err(Error::Check(format!("{count} compilers failed"))),
    }
}

/// Creates the pipelines on this process's device, and ends the process.
fn child(arguments: &Arguments) -> Result<()> {
    let scene = arguments.run.of(&arguments.scene).load()?;
    let instance = Instance::open(false)?;
    let adapters = instance.adapters()?;
    let adapter = match arguments.families.last() {
        Some(family) if family != "here" => adapters.iter().find(|adapter| adapter.null).ok_or_else(|| {
            let fault = Input::new("there is no RADV that compiles for this family").key("--for").found(family);
            fault.expected("Mesa's driver radeon (Debian: mesa-vulkan-drivers), and a family it knows")
        })?,
        _ => arguments.run.device.among(&adapters)?,
    };
    let device = replaced(&Device::compiler(&instance, adapter)?, &arguments.replace.load()?)?;
    let session = Session::new(&scene, None, arguments.run.options())?;
    let mut out = std::io::stdout().lock();
    let mut say = |line: &Line| -> Result<()> {
        let text = serde_json::to_string(line).unwrap_or_default();
        writeln!(out, "{text}").and_then(|()| out.flush()).map_err(|error| Error::device("writing a line", error))
    };
    say(&Line::Device(format!("{}, {}", adapter.name, adapter.driver)))?;
    let kernels = Kernels::new(&device);
    let mut done = BTreeSet::new();
    for need in session.needs(Change { relink: true, tone: true, ..Change::EVERYTHING })? {
        for own in need.kernels.iter().filter(|own| done.insert((own.name.clone(), own.constants.clone()))) {
            say(&Line::Begins(own.name.clone()))?;
            let kernel = kernels.get(&own.name, &own.constants)?;
            say(&Line::Pipeline(Pipeline {
                kernel: own.name.clone(),
                constants: own.specialized()?,
                milliseconds: 1e3 * kernel.creation.as_secs_f64(),
                statistics: kernel.statistics()?.into_iter().map(|one| (one.name, one.value)).collect(),
            }))?;
        }
    }
    // Nothing is destroyed.
    std::process::exit(0)
}

/// The value of a pipeline in a column, if its driver reports it.
fn value(pipeline: &Pipeline, heading: &str) -> Option<f64> {
    let names = SHOWN.iter().find(|(known, _)| *known == heading)?.1;
    pipeline.statistics.iter().find(|(name, _)| names.contains(&name.as_str())).map(|(_, value)| *value)
}

/// The pipelines of a compiler as a table, those that take most cycles first.
fn sheet(all: &[Pipeline]) -> String {
    let headings: Vec<&str> =
        SHOWN.iter().map(|(heading, _)| *heading).filter(|h| all.iter().any(|one| value(one, h).is_some())).collect();
    let mut order: Vec<&Pipeline> = all.iter().collect();
    let weight = |one: &Pipeline| value(one, "cycles").or(value(one, "code, B")).unwrap_or(0.0);
    order.sort_by(|a, b| weight(b).total_cmp(&weight(a)));
    let row = |one: &&Pipeline| {
        let values = headings.iter().map(|heading| value(one, heading).map_or("-".into(), |x| format!("{x}")));
        let rest = [format!("{:.0}", one.milliseconds), one.constants.clone()];
        [one.kernel.clone()].into_iter().chain(values).chain(rest).collect()
    };
    let head = [&["kernel"], headings.as_slice(), &["ms", "specialization constants"]].concat();
    table(head, order.iter().map(row).collect::<Vec<Vec<String>>>())
}

/// Everything that the compilers reported except hashes, as CSV.
fn text(rows: &BTreeMap<String, Vec<Pipeline>>) -> Result<Vec<u8>> {
    let mut writer = csv::Writer::from_writer(Vec::new());
    let mut add = |row: [&str; 5]| writer.write_record(row).map_err(|error| Error::device("writing CSV", error));
    add(["compiler", "kernel", "constants", "statistic", "value"])?;
    for (family, all) in rows {
        for one in all {
            let own = one.statistics.iter().filter(|(name, _)| !name.to_lowercase().contains("hash"));
            for (name, value) in own {
                add([family, &one.kernel, &one.constants, name, &value.to_string()])?;
            }
        }
    }
    writer.into_inner().map_err(|error| Error::device("writing CSV", error))
}

/// Reads a file that [`text`] made.
fn read(path: &Path) -> Result<BTreeMap<String, Vec<Pipeline>>> {
    let fault = |what: &str| Input::new(what).file(path).key("--baseline");
    let mut reader = csv::Reader::from_path(path).map_err(|error| fault("the file could not be read").found(error))?;
    let mut rows = BTreeMap::<String, Vec<Pipeline>>::new();
    for record in reader.deserialize::<(String, String, String, String, f64)>() {
        let (family, kernel, constants, name, value) = record.map_err(|error| {
            fault("not what compile writes").found(error).expected("compiler,kernel,constants,statistic,value")
        })?;
        let all = rows.entry(family).or_default();
        match all.iter_mut().find(|one| one.kernel == kernel && one.constants == constants) {
            Some(one) => one.statistics.push((name, value)),
            None => all.push(Pipeline { kernel, constants, milliseconds: 0.0, statistics: vec![(name, value)] }),
        }
    }
    Ok(rows)
}

/// The values that are worse than before, of the pipelines that are in both.
fn worse(before: &BTreeMap<String, Vec<Pipeline>>, now: &BTreeMap<String, Vec<Pipeline>>) -> Vec<String> {
    let mut found = Vec::new();
    for (family, own) in now.iter().flat_map(|(family, all)| all.iter().map(move |own| (family, own))) {
        let same = |old: &&Pipeline| old.kernel == own.kernel && old.constants == own.constants;
        let Some(old) = before.get(family).and_then(|all| all.iter().find(same)) else { continue };
        let mut add = |heading: &str, is: &dyn Fn(f64, f64) -> bool| {
            if let (Some(x), Some(y)) = (value(old, heading), value(own, heading))
                && is(x, y)
            {
                found.push(format!("{family}: {}: {heading} {x} -> {y}", own.kernel));
            }
        };
        for (heading, factor) in WORSE {
            add(heading, &|x, y| y > factor * x);
        }
        add("waves", &|x, y| y < x);
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    fn pipeline(statistics: &[(&str, f64)]) -> BTreeMap<String, Vec<Pipeline>> {
        let statistics = statistics.iter().map(|(name, value)| (name.to_string(), *value)).collect();
        let (kernel, constants) = ("a/b".to_string(), "N = 1, M = 2".to_string());
        [("navi21".to_string(), vec![Pipeline { kernel, constants, milliseconds: 0.0, statistics }])].into()
    }

    #[test]
    fn what_is_worse_is_named_and_files_hold_what_was_reported() {
        let old = pipeline(&[("Spilled VGPRs", 0.0), ("Subgroups per SIMD", 8.0), ("Inverse Throughput", 100.0)]);
        assert!(worse(&old, &pipeline(&[("Spilled VGPRs", 0.0), ("Inverse Throughput", 109.0)])).is_empty());
        let new = pipeline(&[("Spilled VGPRs", 3.0), ("Subgroups per SIMD", 7.0), ("Inverse Throughput", 111.0)]);
        assert_eq!(
            worse(&old, &new),
            ["navi21: a/b: spilled 0 -> 3", "navi21: a/b: cycles 100 -> 111", "navi21: a/b: waves 8 -> 7"]
        );
        assert!(worse(&new, &old).is_empty());
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.csv");
        std::fs::write(&path, text(&new).unwrap()).unwrap();
        assert_eq!(read(&path).unwrap(), new);
        std::fs::write(&path, "compiler,kernel\na,b\n").unwrap();
        assert!(read(&path).unwrap_err().to_string().contains("not what compile writes"));
    }
}
