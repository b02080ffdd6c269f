//! `milkglass compile`: what compilers of GPUs that are not here make of kernels.
//!
//! A process for each compiler opens its device, creates the pipelines and ends without destroying anything, since
//! drivers of null hardware crash there. It writes lines of JSON; one that is killed names the kernel it was at.

mod arguments;
mod child;
mod file;
mod pipelines;
mod record;
mod sheet;

use std::ffi::OsString;
use std::path::{Path, PathBuf};

use super::watch::{itself, watched};
use super::{print, write};
pub use arguments::Arguments;
use child::{LIST, Line, MODULE};
use milkglass::error::{Error, Input, Result};
use milkglass::internals::pipeline::plan::Options;
use milkglass::internals::view::atomic_file::{Part, ready};
use milkglass::measure::results::Verdict;
use milkglass::measure::table::Table;
use milkglass::scene::Scene;
use pipelines::{Wanted, wanted};
use record::{Compiled, Sheets};

/// Compiles, and prints what is reported.
pub fn run(arguments: &Arguments) -> Result<()> {
    if arguments.child {
        return child::compile(arguments);
    }
    ready([("--csv", arguments.csv.as_ref()), ("--json", arguments.json.as_ref())])?;
    keep_baseline(arguments)?;
    let known = arguments.baseline.as_deref().map(file::read).transpose()?;
    let families = arguments.families()?;
    if let Some(folder) = &arguments.isa {
        families.iter().try_for_each(|(family, _)| create(&folder.join(family)))?;
    }
    let wanted = wanted(arguments)?;
    // Faults of shaders are told here, once, and not by each child.
    arguments.replace.load()?;
    let run = wanted.iter().map(|wanted| wanted.kernel.clone()).collect();
    if let Some(fault) = arguments.replace.unused(&run, "the scene") {
        return Err(fault.into());
    }
    let job = Job { wanted: &wanted, words: arguments.words(), timeout: arguments.timeout };
    let (mut sheets, mut failed) = (Sheets::new(), Vec::new());
    for (family, typed) in families {
        let (compiled, failure) = compile(&job, family)?;
        if !typed && failure.as_ref().is_some_and(|why| why.contains("Unknown family")) {
            tell!("left out: {family}, which this RADV does not know");
            continue;
        }
        print(&format!("{family}: {}\n{}\n", compiled.device, sheet::table_of(&compiled.pipelines).text()))?;
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
    // A file that lacks a compiler's figures would be a baseline without them.
    if let (Some(path), true) = (&arguments.csv, failed.is_empty()) {
        write(path, file::csv(&sheets)?)?;
    }
    if let Some(path) = &arguments.json {
        write(path, file::json(&sheets)?)?;
    }
    failed.iter().for_each(|line| tell!("{line}"));
    let worse = match (&known, &arguments.baseline) {
        (Some(known), Some(path)) => {
            sheet::unknown(known, &sheets, path)?.iter().for_each(|line| tell!("{line}"));
            sheet::worse(known, &sheets)
        }
        _ => Vec::new(),
    };
    worse.iter().for_each(|line| tell!("{line}"));
    match (failed.len(), worse.len()) {
        (0, 0) => Ok(()),
        (0, count) => Err(Error::Check(format!("{count} values are worse than those of the baseline"))),
        (1, _) => Err(Error::Check("a compiler failed".into())),
        (count, _) => Err(Error::Check(format!("{count} compilers failed"))),
    }
}

/// Fails if a file to be written is the baseline, which may be write-protected.
fn keep_baseline(arguments: &Arguments) -> Result<()> {
    let place = |path: &Option<PathBuf>| path.as_ref().and_then(|path| path.canonicalize().ok());
    let Some(baseline) = place(&arguments.baseline) else { return Ok(()) };
    for (key, path) in [("--csv", &arguments.csv), ("--json", &arguments.json)] {
        if place(path).as_ref() == Some(&baseline) {
            let fault = Input::new("the same file as --baseline").key(key).found(baseline.display());
            return Err(fault.expected("another file").into());
        }
    }
    Ok(())
}

/// Makes a folder of `--isa`.
fn create(folder: &Path) -> Result<()> {
    let fault = |error| Input::new("the folder can't be made").file(folder).key("--isa").found(error);
    Ok(std::fs::create_dir_all(folder).map_err(fault)?)
}

/// What a child does.
struct Job<'a> {
    wanted: &'a [Wanted],
    /// More words of its command line.
    words: Vec<OsString>,
    /// Seconds after which it is killed.
    timeout: f64,
}

/// What these families' compilers make of a scene's kernels: a heading and a table for each.
pub fn tables(scene: &Scene, families: &[&str]) -> Result<Vec<(String, Table)>> {
    let wanted = pipelines::of_scene(scene, Options::default())?;
    let job = Job { wanted: &wanted, words: Vec::new(), timeout: 600.0 };
    let table = |family: &&str| match compile(&job, family)? {
        (compiled, None) => Ok((format!("{family}: {}", compiled.device), sheet::table_of(&compiled.pipelines))),
        (_, Some(failure)) => Err(Error::Check(failure)),
    };
    families.iter().map(table).collect()
}

/// What a family's compiler makes of the pipelines, and how it failed if it did; then the module that it was at is in
/// the current folder.
fn compile(job: &Job<'_>, family: &str) -> Result<(Compiled, Option<String>)> {
    let mut command = itself("compile")?;
    // A part is removed at the end, whatever that is.
    let exchange = Part::new(std::env::temp_dir().join(format!("milkglass-compile-{}", std::process::id())));
    let list = serde_json::to_string(job.wanted).unwrap_or_default();
    std::fs::create_dir(exchange.path())
        .and_then(|()| std::fs::write(exchange.path().join(LIST), list))
        .map_err(|error| Error::device(format!("writing {}", exchange.path().display()), error))?;
    command.args(&job.words).args(["--for", family, "--exchange"]).arg(exchange.path());
    // Else the time of a pipeline may be that of reading it from a file.
    command.env("MESA_SHADER_CACHE_DISABLE", "true").env("MESA_GLSL_CACHE_DISABLE", "true");
    if family != "here" {
        command.env("RADV_FORCE_FAMILY", family);
    }
    let (mut compiled, mut at) = (Compiled::default(), String::new());
    let ended = watched(command, job.timeout, &mut |line: Line| {
        match line {
            Line::Device(name) => compiled.device = name,
            Line::Begins(kernel) => at = kernel,
            Line::Pipeline(pipeline) => compiled.pipelines.push(pipeline),
            Line::BuiltIn(pipeline) => compiled.built_in.push(pipeline),
        }
        Ok(())
    });
    let held = std::fs::read(exchange.path().join(MODULE));
    let failure = match ended? {
        None => None,
        Some((Verdict::DeviceFailed, why)) if at.is_empty() && family == "here" => {
            return Err(Error::device("opening the device", why));
        }
        Some((_, why)) if at.is_empty() => Some(format!("{family}: {why}")),
        Some((_, why)) => {
            let path = PathBuf::from(format!("compile-{family}-{}.spv", at.replace('/', "-")));
            write(&path, held.map_err(|error| Error::device("reading the module", error))?)?;
            Some(format!("{family}: {at}: {why}; its module is {}", path.display()))
        }
    };
    Ok((compiled, failure))
}
