//! `milkglass vary`: what choices of the Vulkan API cost, each proved to compute the same before it is timed.

mod text;

use std::path::PathBuf;

use clap::Args;
use serde_json::{Value, json};

use self::text::{list, stages, summary};
use super::device::DeviceArgument;
use super::profile::unmet;
use super::run_args::OptionArguments;
use super::timing::{MOST, TimingArguments};
use super::{SceneArguments, check_messages, print, validation, write};
use milkglass::error::{Error, Input, Result};
use milkglass::internals::gpu::{AXES, Device};
use milkglass::internals::view::atomic_file::ready;
use milkglass::measure::profile::Settings;
use milkglass::measure::rounds::{ROUNDS, Ratio};
use milkglass::measure::vary::{Outcome, Subject, Tried, Variant, asked, strips};

/// Seconds for which an axis is timed by default.
const BUDGET: f64 = 60.0;

/// Arguments of `vary`.
#[derive(Args)]
#[command(after_help = "Example: milkglass vary lotus --axis barriers --axis descriptors=push,dispatch\n         \
                        milkglass vary bunny.obj --axis group.gather=32,128 --change light --until 1%\n         \
                        milkglass vary --list",
          mut_arg("scene", |scene| scene.required(false).default_value("").hide_default_value(true)))]
pub struct Arguments {
    #[command(flatten)]
    scene: SceneArguments,
    /// An axis, and its values if not all of them: `barriers`, `descriptors=push,dispatch`, `group.gather=128`; each
    /// value is compared with the default [default: all axes].
    #[arg(long, value_name = "NAME[=VALUE,...]")]
    axis: Vec<String>,
    /// List the axes and their values, and what the device lacks for them.
    #[arg(long)]
    list: bool,
    #[command(flatten)]
    device: DeviceArgument,
    #[command(flatten)]
    option_args: OptionArguments,
    #[command(flatten)]
    timing: TimingArguments,
    /// Also write what was proved, all samples and ratios to this JSON file.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
    /// Also draw the ratios and their intervals, a strip for each stage, as this SVG file.
    #[arg(long, value_name = "FILE")]
    svg: Option<PathBuf>,
}

/// Proves, times, prints, and writes the requested files.
pub fn run(arguments: &Arguments) -> Result<()> {
    ready([("--json", arguments.json.as_ref()), ("--svg", arguments.svg.as_ref())])?;
    let axes = match arguments.axis.as_slice() {
        [] => AXES.iter().map(|axis| asked(axis.name)).collect::<Result<Vec<_>>>()?,
        given => given.iter().map(|text| asked(text)).collect::<Result<Vec<_>>>()?,
    };
    let device = arguments.device.open(validation())?.ok_or_else(|| {
        let fault = Input::new("only a Vulkan device has choices of the API").key("--device").found("the CPU");
        Error::from(fault.expected("a device that `milkglass devices` lists"))
    });
    if arguments.list {
        return print(&list(&axes, device.ok().as_ref()));
    }
    let device = device?;
    if arguments.scene.scene.is_empty() {
        return Err(Input::new("no scene is given").key("SCENE").expected("a scene to run, or --list").into());
    }
    let sets = arguments.option_args.of(&arguments.scene.sets);
    let scene = SceneArguments { sets, ..arguments.scene.clone() }.load()?;
    let settings = arguments.settings();
    print(&format!("{}: {}, {}\n", scene.name, device.name(), device.driver()))?;
    let subject = Subject::new(&scene, &device, &settings)?;
    check_messages(Some(&device))?;
    let mut outcomes = Vec::new();
    for asked in axes {
        print(&format!("\n{}: {}\n", asked.name, asked.axis.about))?;
        let outcome = subject.vary(asked, &mut |variant, tried| {
            print(&match tried {
                Tried::Lacks(lack) => format!("  {}: not run: {lack}\n", variant.name),
                Tried::Proved(proof) => format!("  {}: {proof}\n", variant.name),
            })
        })?;
        check_messages(Some(&device))?;
        print(&format!("{}{}", stages(&outcome), unmet(&outcome.samples, &settings)))?;
        outcomes.push(outcome);
    }
    print(&summary(&outcomes))?;
    if let Some(path) = &arguments.svg {
        write(path, strips(&scene.name, &outcomes)?)?;
    }
    let Some(path) = &arguments.json else { return Ok(()) };
    write(path, format!("{:#}\n", arguments.result(&device, &outcomes)))
}

impl Arguments {
    fn settings(&self) -> Settings {
        let TimingArguments { frames, until, budget, .. } = self.timing;
        Settings {
            options: self.option_args.options(),
            change: self.timing.change(),
            frames: frames.unwrap_or(if until.is_some() { MOST } else { ROUNDS as u32 }) as usize,
            enough: budget.unwrap_or(BUDGET),
            until,
            seed: self.timing.seed(),
            traces: false,
        }
    }

    /// What `--json` holds.
    fn result(&self, device: &Device, outcomes: &[Outcome]) -> Value {
        let axis = |outcome: &Outcome| {
            let tried = |(variant, tried): (&Variant, &Tried)| match tried {
                Tried::Lacks(lack) => json!({"variant": variant.name, "lacks": lack}),
                Tried::Proved(proof) => json!({"variant": variant.name, "proof": proof.to_string()}),
            };
            let tried: Vec<Value> = outcome.asked.variants.iter().zip(&outcome.tried).map(tried).collect();
            let rows = |(variant, rows): (&Variant, &[Ratio])| json!({"variant": variant.name, "rows": rows});
            json!({
                "axis": outcome.asked.name,
                "default": outcome.asked.default,
                "variants": tried,
                "samples": outcome.samples,
                "comparison": outcome.timed().map(rows).collect::<Vec<_>>(),
            })
        };
        json!({
            "schema": "milkglass-vary-1",
            "version": env!("CARGO_PKG_VERSION"),
            "commit": option_env!("MILKGLASS_COMMIT"),
            "scene": self.scene.scene,
            "sets": self.option_args.of(&self.scene.sets),
            "frame": self.scene.frame,
            "seed": self.timing.seed(),
            "change": self.timing.change_name(),
            "device": device.name(),
            "driver": device.driver(),
            "axes": outcomes.iter().map(axis).collect::<Vec<_>>(),
        })
    }
}
