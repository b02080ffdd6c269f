//! Arguments of `profile`.

use std::path::PathBuf;

use clap::{Args, Command, FromArgMatches, ValueEnum};

use super::gate::Gate;
use crate::cli::SceneArguments;
use crate::cli::device::DeviceArgument;
use crate::cli::replace::ReplaceArgument;
use crate::cli::run_args::OptionArguments;
use crate::cli::timing::{MOST, TimingArguments};
use crate::cli::validation;
use milkglass::error::{Input, Result};
use milkglass::internals::gpu::{Choices, Device, Timed};
use milkglass::internals::view::atomic_file::Written;
use milkglass::measure::profile::Settings;
use milkglass::measure::profile::file::{SCHEMA, Saved, Subject};
use milkglass::measure::rounds::{IN_TURN, ROUNDS, Samples};

/// Frames of a profile by default.
const FRAMES: u32 = 11;
/// Frames of a profile that is timed again.
const AGAIN: &str = "7";

/// Arguments of `profile`.
#[derive(Args)]
#[command(after_help = "Example: milkglass profile lotus --frames 21 --csv lotus.csv --trace lotus.json\n         \
                        milkglass profile bunny.obj --change light --mode render --until 1%\n         \
                        milkglass profile lotus --against ../other/target/release/milkglass",
          mut_arg("scene", |scene| scene.required(false).default_value("").hide_default_value(true)))]
pub struct Arguments {
    #[command(flatten)]
    scene: SceneArguments,
    /// `cpu`, a device's number in `milkglass devices`, or part of its name [default: the best Vulkan device]; several
    /// are timed in turn and compared. `interpreter` needs no device: it counts what kernels do, and times nothing.
    #[arg(long, value_name = "DEVICE")]
    pub(super) device: Vec<String>,
    #[command(flatten)]
    option_args: OptionArguments,
    #[command(flatten)]
    pub(super) replace: ReplaceArgument,
    /// Time only this stage, whose kernel is replaced: by both kernels in turn within a submission, where noise is
    /// least.
    #[arg(long, value_name = "STAGE", requires = "replace", conflicts_with_all = ["compare", "against", "model", "serve"])]
    pub(super) alternate: Option<String>,
    #[command(flatten)]
    timing: TimingArguments,
    /// Compare with an earlier run, or two of them with each other: files that `--save` wrote.
    #[arg(long, value_name = "FILE", num_args = 1..=2, conflicts_with_all = ["against", "replace"])]
    pub(super) compare: Vec<PathBuf>,
    /// Compare with another build of this program, frame by frame in random order.
    #[arg(long, value_name = "PROGRAM", conflicts_with = "replace")]
    pub(super) against: Option<PathBuf>,
    /// Also write this CSV file, one row per stage.
    #[arg(long, value_name = "FILE", conflicts_with = "against")]
    pub(super) csv: Option<PathBuf>,
    /// Also write the whole profile with all samples to this JSON file, for `--compare` and for programs.
    #[arg(long, value_name = "FILE", visible_alias = "json")]
    pub(super) save: Option<PathBuf>,
    /// Also draw each row by its intensity and rate, under what the device can do, in this SVG file.
    #[arg(long, value_name = "FILE", conflicts_with = "against")]
    pub(super) roofline: Option<PathBuf>,
    /// Also append a line with the median of each stage to this file, which `report --history` draws.
    #[arg(long, value_name = "FILE", conflicts_with = "serve")]
    pub(super) history: Option<PathBuf>,
    /// Also write the timed frames for chrome://tracing or ui.perfetto.dev.
    #[arg(long, value_name = "FILE", conflicts_with = "against")]
    pub(super) trace: Option<PathBuf>,
    /// Print a page on why a frame takes as long as it does, in place of the table: what bounds each stage, what
    /// dispatches, barriers and submissions cost, how long pipelines took to compile.
    #[arg(long, conflicts_with_all = ["against", "compare"])]
    pub(super) why: bool,
    /// Time stages, each kernel, or each of its dispatches.
    #[arg(long, value_enum, default_value_t = By::Stage, conflicts_with_all = ["against", "why"])]
    by: By,
    /// Predict how long a frame takes on another device: `h100`, `navi21`, or a TOML file with its figures. Nothing is
    /// timed; the device at hand counts the work and the longest chains.
    #[arg(long = "as", value_name = "MODEL",
          conflicts_with_all = ["compare", "against", "why", "save", "trace", "roofline", "history", "frames",
                                "until", "budget", "seed", "serve", "fail_slower", "fail_work", "junit"])]
    pub(super) model: Option<String>,
    #[command(flatten)]
    pub(super) gate: Gate,
    /// Run frames as standard input asks for them.
    #[arg(long, hide = true)]
    pub(super) serve: bool,
}

/// What has times of its own.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum By {
    /// Stages.
    Stage,
    /// Kernels, all dispatches of a frame together.
    Kernel,
    /// Dispatches, by their kernel and their number in a submission.
    Dispatch,
}

impl By {
    /// The option, as it is given.
    fn option(self) -> &'static str {
        match self {
            Self::Stage => "--by stage",
            Self::Kernel => "--by kernel",
            Self::Dispatch => "--by dispatch",
        }
    }
}

impl Arguments {
    /// The scene to run.
    pub(super) fn scene(&self) -> Result<SceneArguments> {
        if self.scene.scene.is_empty() {
            let fault = Input::new("no scene is given").key("SCENE");
            return Err(fault.expected("a scene to run, or two files of --compare").into());
        }
        Ok(SceneArguments { sets: self.option_args.of(&self.scene.sets), ..self.scene.clone() })
    }

    /// What to measure and for how long.
    pub(super) fn settings(&self) -> Settings {
        let usual = match self.several() {
            _ if self.alternate.is_some() => IN_TURN as u32,
            true => ROUNDS as u32,
            false => FRAMES,
        };
        let until = self.timing.until;
        let frames = self.timing.frames.unwrap_or(if until.is_some() { MOST } else { usual });
        let budget = self.timing.budget.or(until.map(|_| 60.0));
        Settings {
            options: self.option_args.options(),
            change: self.timing.change(),
            frames: frames as usize,
            enough: budget.unwrap_or(f64::INFINITY),
            until,
            seed: self.timing.seed(),
            traces: false,
        }
    }

    /// The settings of the profile itself: a short one after a comparison of kernels, which has used the time up.
    pub(super) fn alone(&self, settings: &Settings) -> Settings {
        let replaced = !self.replace.pairs().is_empty();
        let frames = if replaced { settings.frames.min(FRAMES as usize) } else { settings.frames };
        let (until, traces) = (settings.until.filter(|_| !replaced), self.trace.is_some());
        Settings { frames, until, traces, ..*settings }
    }

    /// The files that are written, with their options.
    pub(super) fn files(&self) -> [(&'static str, Option<&PathBuf>, Written); 6] {
        [
            ("--csv", self.csv.as_ref(), Written::Replaced),
            ("--json", self.save.as_ref(), Written::Replaced),
            ("--trace", self.trace.as_ref(), Written::Replaced),
            ("--junit", self.gate.junit.as_ref(), Written::Replaced),
            ("--roofline", self.roofline.as_ref(), Written::Replaced),
            ("--history", self.history.as_ref(), Written::Appended),
        ]
    }

    /// Fails if options do not go together.
    pub(super) fn check(&self) -> Result<()> {
        let refused = |key: &str, what: &str| Input::new(what).key(key);
        let one = [
            ("--csv", self.csv.is_some()),
            ("--trace", self.trace.is_some()),
            ("--why", self.why),
            ("--as", self.model.is_some()),
            (self.by.option(), self.by != By::Stage),
            ("--roofline", self.roofline.is_some()),
            ("--replace", !self.replace.pairs().is_empty()),
            ("--compare", !self.compare.is_empty()),
            ("--against", self.against.is_some()),
        ];
        if let Some((key, _)) = one.iter().find(|(_, given)| *given && self.device.len() > 1) {
            let found = format!("{} of --device", self.device.len());
            return Err(refused(key, "goes with one device only").found(found).into());
        }
        if self.by != By::Stage && self.model.is_none() && !self.replace.pairs().is_empty() {
            let fault = refused("--replace", "kernels are compared by stage").found(self.by.option());
            return Err(fault.expected("--as MODEL, or stages").into());
        }
        let written = self.files().into_iter().find(|(key, file, _)| *key != "--junit" && file.is_some());
        let idle = written.map(|(key, ..)| key).or((!self.scene.scene.is_empty()).then_some("SCENE"));
        if let (Some(key), 2) = (idle, self.compare.len()) {
            let fault = refused(key, "nothing is measured").found("two files of --compare");
            return Err(fault.expected("one of them and a scene").into());
        }
        let Some(key) = self.gate.idle(self.several(), !self.replace.pairs().is_empty()) else { return Ok(()) };
        let (what, expected) = match key {
            "--fail-work" => ("only kernels that are replaced are counted", "--replace KERNEL=FILE"),
            "--junit" => ("nothing is held to a limit", "--fail-slower or --fail-work"),
            _ => ("nothing is compared", "--replace, --against, --compare, or several of --device"),
        };
        Err(refused(key, what).expected(expected).into())
    }

    /// Fails if something is asked for that has to be timed.
    pub(super) fn counts_only(&self) -> Result<()> {
        let files = self.files().into_iter().map(|(key, file, _)| (key, file.is_some() && key != "--csv"));
        let asked = [
            ("several --device", self.device.len() > 1),
            ("--frames", self.timing.frames.is_some()),
            ("--until", self.timing.until.is_some()),
            ("--budget", self.timing.budget.is_some()),
            ("--seed", self.timing.seed.is_some()),
            ("--alternate", self.alternate.is_some()),
            ("--compare", !self.compare.is_empty()),
            ("--against", self.against.is_some()),
            ("--why", self.why),
            ("--serve", self.serve),
        ];
        let gate = self.gate.idle(false, false);
        match asked.into_iter().chain(files).find(|(_, given)| *given).map(|(key, _)| key).or(gate) {
            Some(key) => {
                let fault = Input::new("the interpreter counts what kernels do, and times nothing").key(key);
                Err(fault.found("--device interpreter").expected("a device that `milkglass devices` lists").into())
            }
            None => Ok(()),
        }
    }

    /// What has a row of its own.
    pub(super) fn timed(&self) -> Timed {
        match self.by {
            By::Stage => Timed::Steps,
            By::Kernel => Timed::Kernels,
            By::Dispatch => Timed::Dispatches,
        }
    }

    /// Fails if the device has not what an option needs.
    pub(super) fn suits(&self, device: Option<&Device>) -> Result<()> {
        let needs = [
            ("--why", self.why),
            ("--as", self.model.is_some()),
            ("--roofline", self.roofline.is_some()),
            ("--alternate", self.alternate.is_some()),
        ];
        let timed = [needs[2], needs[3]].into_iter().find(|(_, given)| *given);
        match (needs.iter().find(|(_, given)| *given), device) {
            (Some((key, _)), None) => {
                let fault = Input::new("measures a Vulkan device").key(*key).found("the CPU");
                Err(fault.expected("a device that `milkglass devices` lists").into())
            }
            (_, Some(device)) if device.limits().timestamp_period <= 0.0 => timed.map_or(Ok(()), |(key, _)| {
                let fault = Input::new("goes by the device's timestamps").key(key);
                Err(fault.found(format!("none of {}", device.name())).into())
            }),
            _ => Ok(()),
        }
    }

    /// Whether several builds, runs, devices or kernels are compared.
    fn several(&self) -> bool {
        self.against.is_some() || !self.compare.is_empty() || self.device.len() > 1 || !self.replace.pairs().is_empty()
    }

    /// Arguments that time a few frames of what another run timed.
    pub(super) fn again(subject: &Subject) -> Result<Self> {
        let frame = subject.frame.to_string();
        let fixed = ["--frame", &frame, "--change", &subject.change, "--mode", &subject.mode];
        let rest = ["--transport", &subject.transport, "--by", subject.by(), "--frames", AGAIN, "--budget", "30"];
        let sets = subject.sets.iter().flat_map(|set| ["--set", set]);
        let words = ["profile", &subject.scene].into_iter().chain(fixed).chain(rest).chain(sets);
        let command = Self::augment_args(Command::new("profile"));
        let found = command.try_get_matches_from(words).and_then(|matches| Self::from_arg_matches(&matches));
        let fault = |error: clap::Error| Input::new(error.kind().to_string()).found(subject.scene.as_str());
        found.map_err(|error| fault(error).expected("what this version of `milkglass profile` times").into())
    }

    /// Opens a device; `None` is the CPU.
    pub(super) fn open(&self, name: Option<&String>) -> Result<Option<Device>> {
        self.timing(DeviceArgument::named(name.cloned()).open(validation())?)
    }

    /// The device as it times what has times of its own.
    pub(super) fn timing(&self, device: Option<Device>) -> Result<Option<Device>> {
        let timed = self.timed();
        let lanes = self.model.as_ref().map(|_| u32::MAX);
        let device = match device {
            device if timed == Timed::Steps && lanes.is_none() => device,
            Some(device) if device.limits().timestamp_period == 0.0 && lanes.is_none() => {
                let fault = Input::new("times kernels by the device's timestamps").key(self.by.option());
                return Err(fault.found(format!("none of {}", device.name())).into());
            }
            Some(device) => {
                let lanes = lanes.or(device.choices().lanes);
                Some(device.opened_as(&Choices { timed, lanes, ..device.choices().clone() })?)
            }
            None if timed == Timed::Steps => None,
            None => {
                let fault = Input::new("times kernels of a Vulkan device").key(self.by.option()).found("the CPU");
                return Err(fault.expected("a device that `milkglass devices` lists").into());
            }
        };
        // A profile tells how long a stage's first run takes, so nothing is compiled ahead.
        device.iter().for_each(|device| device.compile_ahead(false));
        Ok(device)
    }

    /// The arguments with which another build times the same.
    pub(super) fn words(&self) -> Vec<String> {
        let device = self.device.iter().flat_map(|name| ["--device".to_string(), name.clone()]);
        let change = ["--change".to_string(), self.subject().change];
        self.scene.words().into_iter().chain(device).chain(self.option_args.words()).chain(change).collect()
    }

    /// What is timed.
    fn subject(&self) -> Subject {
        let words = self.option_args.words();
        Subject {
            scene: self.scene.scene.clone(),
            frame: self.scene.frame,
            sets: self.scene.sets(),
            change: self.timing.change_name(),
            mode: words[1].clone(),
            transport: words[3].clone(),
            by_kernel: self.by != By::Stage,
            by_dispatch: self.by == By::Dispatch,
        }
    }

    /// The head of the file that `--save` writes, with these samples.
    pub(super) fn saved(&self, device: &str, driver: &str, samples: Samples) -> Saved {
        Saved {
            schema: SCHEMA,
            version: env!("CARGO_PKG_VERSION").into(),
            commit: option_env!("MILKGLASS_COMMIT").map(String::from),
            subject: self.subject(),
            device: device.into(),
            driver: driver.into(),
            replaced: self.replace.told(),
            samples,
        }
    }
}
