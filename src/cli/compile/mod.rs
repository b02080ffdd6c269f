//! `milkglass compile`: what compilers of GPUs that are not here make of kernels.
//!
//! A process for each compiler opens its device, creates the pipelines and ends without destroying anything, since
//! drivers of null hardware crash there. It writes lines of JSON; one that is killed names the kernel it was at.

mod child;
mod file;
mod pipelines;
mod sheet;

use std::collections::BTreeMap;
use std::path::PathBuf;

use clap::Args;
use serde::{Deserialize, Serialize};

use super::replace::ReplaceArgument;
use super::watch::{itself, seconds, watched};
use super::{RunArguments, SceneArguments, print, write};
use child::Line;
use milkglass::error::{Error, Input, Result};
use milkglass::internals::view::atomic_file::ready;
use pipelines::{Wanted, wanted};

/// Families of RADV that `--for all` stands for: one or more of each generation since 2016. The last two are names of
/// the same GPU in older and newer versions of Mesa.
const FAMILIES: [&str; 11] = [
    "polaris10",
    "vega10",
    "vega20",
    "raven",
    "navi10",
    "navi14",
    "navi21",
    "navi24",
    "rembrandt",
    "gfx1100",
    "navi31",
];

/// Arguments of `compile`.
#[derive(Args)]
#[command(after_help = "Example: milkglass compile lotus --for navi21,gfx1100 --csv lotus.csv\n         \
                        milkglass compile lotus --for navi21,gfx1100 --baseline lotus.csv\n         \
                        milkglass compile --all --for all --isa code",
          mut_arg("scene", |scene| scene.required(false).default_value("").hide_default_value(true)))]
pub struct Arguments {
    #[command(flatten)]
    scene: SceneArguments,
    /// Compile for all built-in scenes, and for a sphere by every other transport.
    #[arg(long, conflicts_with = "scene")]
    all: bool,
    #[command(flatten)]
    run: RunArguments,
    #[command(flatten)]
    replace: ReplaceArgument,
    /// Compilers: families of AMD GPUs for Mesa's RADV, such as polaris10, vega10, navi10, navi21 or gfx1100; `all` for
    /// ten of them; `here` for the compiler of the device itself.
    #[arg(long = "for", value_name = "FAMILY,...", value_delimiter = ',', default_value = "navi21,gfx1100")]
    families: Vec<String>,
    /// Also write what the compilers report except hashes, a row for each value.
    #[arg(long, value_name = "FILE")]
    csv: Option<PathBuf>,
    /// Also write the same as JSON, with the milliseconds that each pipeline took.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Also write the compilers' code, down to the GPU's instructions: FOLDER/FAMILY/KERNEL.txt.
    #[arg(long, value_name = "FOLDER")]
    isa: Option<PathBuf>,
    /// Compare with a file of --csv, and fail where a kernel spills more, uses more scratch memory, has fewer waves, or
    /// takes 10 % more cycles.
    #[arg(long, value_name = "FILE")]
    baseline: Option<PathBuf>,
    /// How long a compiler may take, seconds.
    #[arg(long, value_name = "SECONDS", default_value = "600", value_parser = seconds)]
    timeout: f64,
    /// Compile in this process.
    #[arg(long, hide = true)]
    child: bool,
    /// The pipelines to compile, for a child.
    #[arg(long, hide = true, value_name = "JSON", default_value = "[]", hide_default_value = true)]
    pipelines: String,
    /// Where a child puts the module that it is about to compile.
    #[arg(long, hide = true, value_name = "FILE")]
    module: Option<PathBuf>,
}

/// A pipeline as a compiler made it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
struct Pipeline {
    kernel: String,
    /// Specialization constants: `CHANNELS = 7, ORDER = 2`.
    constants: String,
    milliseconds: f64,
    /// What the driver reports, by its names, in its order.
    statistics: Vec<(String, f64)>,
}

/// What a compiler made.
#[derive(Clone, Debug, Default, PartialEq)]
struct Compiled {
    /// The device's name, and the driver's.
    device: String,
    pipelines: Vec<Pipeline>,
    /// The built-in kernels that others replace, as the compiler made them.
    built_in: Vec<Pipeline>,
}

/// What each compiler made, by family.
type Sheets = BTreeMap<String, Compiled>;

/// Compiles, and prints what is reported.
pub fn run(arguments: &Arguments) -> Result<()> {
    ready([("--csv", arguments.csv.as_ref()), ("--json", arguments.json.as_ref())])?;
    if arguments.child {
        return child::compile(arguments);
    }
    let known = arguments.baseline.as_deref().map(file::read).transpose()?;
    let wanted = wanted(arguments)?;
    let every = arguments.families.iter().any(|family| family == "all");
    let mut families: Vec<&str> =
        arguments.families.iter().map(String::as_str).filter(|family| *family != "all").collect();
    families.extend(FAMILIES.iter().filter(|_| every));
    let (mut sheets, mut failed) = (Sheets::new(), Vec::new());
    for family in families {
        let (compiled, failure) = compile(arguments, family, &wanted)?;
        if every && failure.as_ref().is_some_and(|why| why.contains("Unknown family")) {
            tell!("left out: {family}, which this RADV does not know");
            continue;
        }
        print(&format!("{family}: {}\n{}\n", compiled.device, sheet::table_of(&compiled.pipelines)))?;
        print(&sheet::changes(&compiled))?;
        failed.extend(failure);
        sheets.insert(family.to_string(), compiled);
    }
    if arguments.all {
        print(&format!(
            "{} pipelines of {} of {} kernels\n",
            wanted.len(),
            pipelines::kernels(&wanted),
            pipelines::every()
        ))?;
    }
    if let Some(path) = &arguments.csv {
        write(path, file::csv(&sheets)?)?;
    }
    if let Some(path) = &arguments.json {
        write(path, file::json(&sheets)?)?;
    }
    let worse: Vec<String> = known.iter().flat_map(|known| sheet::worse(known, &sheets)).collect();
    worse.iter().chain(&failed).for_each(|line| tell!("{line}"));
    match (failed.len(), worse.len()) {
        (0, 0) => Ok(()),
        (0, count) => Err(Error::Check(format!("{count} values are worse than those of the baseline"))),
        (1, _) => Err(Error::Check("a compiler failed".into())),
        (count, _) => Err(Error::Check(format!("{count} compilers failed"))),
    }
}

/// What a family's compiler makes of the pipelines, and how it failed if it did: then the module that it was at is
/// beside.
fn compile(arguments: &Arguments, family: &str, wanted: &[Wanted]) -> Result<(Compiled, Option<String>)> {
    let mut command = itself("compile")?;
    let module = std::env::temp_dir().join(format!("milkglass-compile-{}.spv", std::process::id()));
    let list = serde_json::to_string(wanted).unwrap_or_default();
    // The subcommand's own words, but for which compilers: the last one counts.
    command.args(std::env::args_os().skip(2)).args(["--for", family, "--pipelines", &list, "--module"]).arg(&module);
    if family != "here" {
        command.env("RADV_FORCE_FAMILY", family);
    }
    let (mut compiled, mut at) = (Compiled::default(), String::new());
    let ended = watched(command, arguments.timeout, &mut |line: Line| {
        match line {
            Line::Device(name) => compiled.device = name,
            Line::Begins(kernel) => at = kernel,
            Line::Pipeline(pipeline) => compiled.pipelines.push(pipeline),
            Line::BuiltIn(pipeline) => compiled.built_in.push(pipeline),
        }
        Ok(())
    });
    let held = std::fs::read(&module);
    let _ = std::fs::remove_file(&module);
    let failure = match ended? {
        None => None,
        Some((_, why)) if at.is_empty() => Some(format!("{family}: {why}")),
        Some((_, why)) => {
            let path = PathBuf::from(format!("compile-{family}-{}.spv", at.replace('/', "-")));
            write(&path, held.map_err(|error| Error::device("reading the module", error))?)?;
            Some(format!("{family}: {at}: {why}; its module is {}", path.display()))
        }
    };
    Ok((compiled, failure))
}

/// An error where there is nothing to compile.
fn no_scene() -> Error {
    Input::new("no scene is given").key("SCENE").expected("a scene, or --all").into()
}
