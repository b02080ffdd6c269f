//! Arguments of `profile`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};

use crate::cli::SceneArguments;
use crate::cli::device::DeviceArgument;
use crate::cli::replace::ReplaceArgument;
use crate::cli::run_args::OptionArguments;
use crate::cli::validation;
use milkglass::error::{Input, Result};
use milkglass::internals::gpu::Device;
use milkglass::internals::pipeline::plan::Change;
use milkglass::measure::profile::Settings;
use milkglass::measure::profile::file::{SCHEMA, Saved, Subject};
use milkglass::measure::rounds::{ROUNDS, Samples};

/// Frames of a profile, where nothing else is asked for.
const FRAMES: u32 = 11;
/// Those that are compared with an earlier run.
const COMPARED: u32 = 41;
/// Most frames.
const MOST: u32 = 10_000;

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
    /// are timed in turn and compared.
    #[arg(long, value_name = "DEVICE")]
    pub(super) device: Vec<String>,
    #[command(flatten)]
    option_args: OptionArguments,
    #[command(flatten)]
    pub(super) replace: ReplaceArgument,
    /// Timed frames, after those that warm up [default: 11; where several are compared 128 of each, in 16 starts].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST)))]
    frames: Option<u32>,
    /// Time frames until the interval of each stage that takes 2 % or more of the frame is at most this wide on either
    /// side, such as 1%.
    #[arg(long, value_name = "SHARE", value_parser = share, conflicts_with = "frames")]
    until: Option<f64>,
    /// Time no longer than this; with `--until` 60 by default.
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    budget: Option<f64>,
    /// Seed of the order of what is compared, and of the intervals.
    #[arg(long, value_name = "N", default_value_t = 1)]
    seed: u64,
    /// What changes before each frame.
    #[arg(long, value_enum, default_value_t)]
    change: ChangeArgument,
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
    /// Also write the timed frames for chrome://tracing or ui.perfetto.dev.
    #[arg(long, value_name = "FILE", conflicts_with = "against")]
    pub(super) trace: Option<PathBuf>,
    /// Print a page on why a frame takes as long as it does, in place of the table: what bounds each stage, what
    /// dispatches, barriers and submissions cost, how long pipelines took to compile.
    #[arg(long, conflicts_with_all = ["against", "compare"])]
    pub(super) why: bool,
    /// Run frames as standard input asks for them.
    #[arg(long, hide = true)]
    pub(super) serve: bool,
}

#[derive(Clone, Copy, Default, ValueEnum)]
enum ChangeArgument {
    /// Everything: a frame from scratch.
    #[default]
    Everything,
    /// The lights.
    Light,
    /// The coefficients of all materials.
    Material,
    /// The camera.
    View,
}

/// A share of 1, also in percent.
fn share(text: &str) -> std::result::Result<f64, String> {
    let number = |text: &str, scale: f64| Some(text.trim().parse::<f64>().ok()? * scale);
    let found = text.strip_suffix('%').map_or_else(|| number(text, 1.0), |text| number(text, 0.01));
    found.filter(|share| (1e-4..=0.5).contains(share)).ok_or_else(|| "expected 0.01% to 50%, or 0.0001 to 0.5".into())
}

fn seconds(text: &str) -> std::result::Result<f64, String> {
    let found = text.parse().ok().filter(|seconds| (0.0..=1e6).contains(seconds));
    found.ok_or_else(|| "expected 0 to 1e6 seconds".into())
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
        let usual = if self.several() {
            ROUNDS as u32
        } else if self.compare.is_empty() {
            FRAMES
        } else {
            COMPARED
        };
        let frames = self.frames.unwrap_or(if self.until.is_some() { MOST } else { usual });
        let budget = self.budget.or(self.until.map(|_| 60.0));
        Settings {
            options: self.option_args.options(),
            change: match self.change {
                ChangeArgument::Everything => Change::EVERYTHING,
                ChangeArgument::Light => Change::LIGHT,
                ChangeArgument::Material => Change::MATERIAL,
                ChangeArgument::View => Change::VIEW,
            },
            frames: frames as usize,
            enough: budget.unwrap_or(f64::INFINITY),
            until: self.until,
            seed: self.seed,
        }
    }

    /// The settings of the profile that follows a comparison of kernels, which has taken the time it may.
    pub(super) fn alone(&self, settings: &Settings) -> Settings {
        let replaced = !self.replace.pairs().is_empty();
        let frames = if replaced { settings.frames.min(FRAMES as usize) } else { settings.frames };
        Settings { frames, until: settings.until.filter(|_| !replaced), ..*settings }
    }

    /// Fails if there are several devices and something that goes with one only.
    pub(super) fn check(&self) -> Result<()> {
        let given = [
            ("--csv", self.csv.is_some()),
            ("--trace", self.trace.is_some()),
            ("--why", self.why),
            ("--replace", !self.replace.pairs().is_empty()),
            ("--compare", !self.compare.is_empty()),
            ("--against", self.against.is_some()),
        ];
        match given.iter().find(|(_, given)| *given && self.device.len() > 1) {
            Some((key, _)) => {
                let fault = Input::new("goes with one device only").key(*key);
                Err(fault.found(format!("{} of --device", self.device.len())).into())
            }
            None => Ok(()),
        }
    }

    /// Whether several are compared.
    fn several(&self) -> bool {
        self.against.is_some() || !self.compare.is_empty() || self.device.len() > 1 || !self.replace.pairs().is_empty()
    }

    /// Opens a device; `None` is the CPU.
    pub(super) fn open(&self, name: Option<&String>) -> Result<Option<Device>> {
        DeviceArgument::named(name.cloned()).open(validation())
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
        let change = self.change.to_possible_value().map_or_else(String::new, |value| value.get_name().to_string());
        Subject {
            scene: self.scene.scene.clone(),
            frame: self.scene.frame,
            sets: self.scene.sets(),
            change,
            mode: words[1].clone(),
            transport: words[3].clone(),
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
            replaced: self.replace.pairs().to_vec(),
            samples,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_also_percent() {
        assert_eq!((share("1%"), share("0.02"), share("2.5 %")), (Ok(0.01), Ok(0.02), Ok(0.025)));
        for bad in ["1", "0", "-1%", "60%", "", "%", "nan", "x"] {
            assert!(share(bad).is_err(), "{bad}");
        }
        assert!(seconds("nan").is_err() && seconds("-1").is_err() && seconds("0.5") == Ok(0.5));
    }
}
