//! The arguments of `conform`, and the commands that repeat a comparison.

use std::path::PathBuf;

use clap::Args;

use crate::cli::MemoryArgument;
use crate::cli::replace::ReplaceArgument;
use crate::cli::run_args::{OptionArguments, quoted, repeated};
use milkglass::internals::gpu::Adapter;
use milkglass::measure::results::{Outcome, Verdict};

/// Arguments of `conform`.
#[derive(Args)]
#[command(
    after_help = "Example: milkglass conform --device llvmpipe\n         milkglass conform bunny.obj lotus\n         \
                        milkglass conform sphere --replace transport/blocks/push=my.comp\n         \
                        milkglass conform --junit r.xml --jsonl r.jsonl --baseline last.jsonl --dump failures"
)]
pub struct Arguments {
    /// Scenes to compare on; without any, the built-in fixtures.
    #[arg(value_parser = crate::cli::paths::any_path())]
    pub(super) scenes: Vec<String>,
    /// Change a value of the scenes: `object.0.material.preset=ketchup`.
    #[arg(long = "set", value_name = "KEY=VALUE", requires = "scenes")]
    pub(super) sets: Vec<String>,
    /// The frame, if values of the scenes have keyframes.
    #[arg(long, default_value_t = 0.0, allow_negative_numbers = true, requires = "scenes")]
    pub(super) frame: f64,
    #[command(flatten)]
    pub(super) option_args: OptionArguments,
    /// A device's number in `milkglass devices`, or part of its name; `interpreter` runs kernels by the letter of the
    /// specification, without a device [default: every Vulkan device].
    #[arg(long, value_name = "DEVICE")]
    pub(super) device: Option<String>,
    /// Run without the validation layer.
    #[arg(long)]
    pub(super) no_validation: bool,
    /// Only fixtures whose name contains this.
    #[arg(long, value_name = "TEXT", default_value = "", conflicts_with = "scenes")]
    pub(super) only: String,
    /// Only fixtures whose name matches this regular expression.
    #[arg(long, value_name = "REGEX", conflicts_with = "scenes")]
    pub(super) filter: Option<String>,
    /// Only the fixture of this name; may be repeated.
    #[arg(long, value_name = "NAME", conflicts_with = "scenes")]
    pub(super) fixture: Vec<String>,
    /// Only a part of the fixtures: 2/4 is the second of four.
    #[arg(long, value_name = "I/N")]
    pub(super) shard: Option<String>,
    /// List the chosen fixtures, and run nothing.
    #[arg(long)]
    pub(super) list: bool,
    #[command(flatten)]
    pub(super) memory: MemoryArgument,
    /// Only these stages, separated by commas; the reference runs the others.
    #[arg(long, value_name = "STAGES", value_delimiter = ',')]
    pub(super) stage: Vec<String>,
    #[command(flatten)]
    pub(super) replace: ReplaceArgument,
    /// Compare nothing: run the kernels in the interpreter, and report data races, accesses out of bounds,
    /// uninitialised values, barriers and subgroup operations in non-uniform flow, and results that are not finite.
    #[arg(long, conflicts_with_all = ["device", "json", "jsonl", "expect", "baseline", "child", "list"])]
    pub(super) sanitize: bool,
    /// For each stage and fixture that differs, and with --isolate for each that hangs or crashes, write the dispatch
    /// to a folder of this folder: see `milkglass replay`.
    #[arg(long, value_name = "FOLDER")]
    pub(super) dump: Option<PathBuf>,
    /// In the folders of --dump leave out groups that do not fail, and the ends of buffers that nothing reaches.
    #[arg(long, requires = "dump")]
    pub(super) minimize: bool,
    /// Also run what was chosen with kernels that count, and say what of SPIR-V and Vulkan was executed, by which
    /// fixtures, in a CSV file.
    #[arg(long, value_name = "FILE", conflicts_with_all = ["isolate", "junit", "child", "list"])]
    pub(super) coverage: Option<PathBuf>,
    /// Write all results to this file at the end.
    #[arg(long, value_name = "FILE")]
    pub(super) json: Option<PathBuf>,
    /// Write each result to this file as it comes, as a line of JSON.
    #[arg(long, value_name = "FILE")]
    pub(super) jsonl: Option<PathBuf>,
    /// Write the results as JUnit XML, for build servers; implies --isolate.
    #[arg(long, value_name = "FILE")]
    pub(super) junit: Option<PathBuf>,
    /// Run each fixture in a process of its own: a hang or a crash becomes a verdict, and the run goes on.
    #[arg(long)]
    pub(super) isolate: bool,
    /// How long a process of --isolate may take, seconds.
    #[arg(long, value_name = "SECONDS", default_value_t = 600.0, value_parser = crate::cli::watch::seconds)]
    pub(super) timeout: f64,
    /// Failures that are known, as TOML; they do not fail the run, and those that are gone do.
    #[arg(long, value_name = "FILE")]
    pub(super) expect: Option<PathBuf>,
    /// Also say what has changed since these results, which --json or --jsonl wrote.
    #[arg(long, value_name = "FILE")]
    pub(super) baseline: Option<PathBuf>,
    /// Write lines of JSON to standard output and nothing else: for the process that has started this one.
    #[arg(long, hide = true)]
    pub(super) child: bool,
    /// Compare nothing, only probe the device: for a process that this program starts.
    #[arg(long, hide = true, requires = "child")]
    pub(super) probe_only: bool,
    /// Compare nothing, only run this step of the stage, counted from 0, and write the case of each dispatch to a
    /// folder of --dump before it runs: for a process that this program starts.
    #[arg(long, hide = true, requires = "child")]
    pub(super) unfinished: Option<usize>,
}

impl Arguments {
    /// Whether each fixture has a process of its own.
    pub(super) fn isolated(&self) -> bool {
        self.isolate || self.junit.is_some()
    }
}

/// The command that repeats a comparison.
pub(super) fn again(arguments: &Arguments, device: &str, fixture: &str, stage: &str) -> String {
    if !arguments.scenes.is_empty() {
        return repeated(device);
    }
    let validation = if arguments.no_validation { " --no-validation" } else { "" };
    let stage = if stage.is_empty() { String::new() } else { format!(" --stage {stage}") };
    let (fixture, device, replaced) = (quoted(fixture), quoted(device), arguments.replace.again());
    format!("milkglass conform --fixture {fixture} --device {device}{stage}{replaced}{validation}")
}

/// The command that repeats the comparison of an outcome.
pub(super) fn repeating(arguments: &Arguments, outcome: &Outcome) -> String {
    again(arguments, &outcome.device, &outcome.fixture, &outcome.stage)
}

/// The outcome of a comparison that did not end.
pub(super) fn failure(
    arguments: &Arguments,
    adapter: &Adapter,
    (fixture, stage): (&str, &str),
    verdict: Verdict,
    why: &dyn std::fmt::Display,
) -> Outcome {
    let mut outcome = Outcome {
        device: adapter.name.clone(),
        driver: adapter.driver.clone(),
        fixture: fixture.into(),
        stage: stage.into(),
        verdict,
        faults: vec![why.to_string()],
        ..Outcome::default()
    };
    outcome.repeat = repeating(arguments, &outcome);
    if arguments.isolated() && arguments.scenes.is_empty() {
        outcome.repeat += &format!(" --isolate --timeout {}", arguments.timeout);
    }
    outcome
}
