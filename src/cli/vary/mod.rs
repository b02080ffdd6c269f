//! `milkglass vary`: what choices of the Vulkan API cost, each proved to compute the same before it is timed.

mod text;

use std::path::PathBuf;

use clap::Args;
use serde_json::{Value, json};

use self::text::{list, proved, stages, summary};
use super::device::DeviceArgument;
use super::profile::{unmet, write};
use super::run_args::OptionArguments;
use super::timing::{MOST, TimingArguments};
use super::{SceneArguments, check_messages, print, validation};
use milkglass::error::{Error, Input, Result};
use milkglass::internals::gpu::{AXES, Choices, Device};
use milkglass::internals::session::run::CapacityHints;
use milkglass::internals::view::atomic_file::ready;
use milkglass::measure::fixtures::Fixture;
use milkglass::measure::profile::Settings;
use milkglass::measure::rounds::{ROUNDS, Ratio, Samples};
use milkglass::measure::vary::{Asked, Variant, asked, compare_first_frames, compare_frames, computed, lack, proof};
use milkglass::scene::Scene;

/// Seconds that an axis is timed for, where nothing else is asked for.
const BUDGET: f64 = 30.0;

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
    /// value is compared with the default. All axes where none is given.
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
}

/// What came of one axis.
pub(super) struct Outcome {
    asked: Asked,
    /// Of each variant, what it lacks or what was proved.
    proofs: Vec<Value>,
    /// The variants that were timed, in the order of `ratios`.
    timed: Vec<Variant>,
    samples: Samples,
    ratios: Vec<Vec<Ratio>>,
}

/// Proves, times, prints, and writes the requested files.
pub fn run(arguments: &Arguments) -> Result<()> {
    ready([("--json", arguments.json.as_ref())])?;
    let axes = match arguments.axis.as_slice() {
        [] => AXES.iter().map(|axis| asked(axis.name)).collect::<Result<Vec<_>>>()?,
        given => given.iter().map(|text| asked(text)).collect::<Result<Vec<_>>>()?,
    };
    let device = arguments.device.open(validation())?.ok_or_else(|| {
        let fault = Input::new("the API is a device's").key("--device").found("the CPU");
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
    let cleared = |choices: &Choices| device.opened_as(&Choices { cleared: true, ..choices.clone() });
    let default = computed(&scene, &cleared(&Choices::default())?, &settings)?;
    check_messages(Some(&device))?;
    let fixture = || Fixture::new(&scene.name, &scene, settings.options, CapacityHints::default());
    let mut outcomes = Vec::new();
    for asked in axes {
        print(&format!("\n{}: {}\n", asked.name, asked.axis.about))?;
        let (mut timed, mut proofs) = (Vec::new(), Vec::new());
        for variant in &asked.variants {
            if let Some(lack) = lack(device.adapter(), &variant.choices) {
                print(&format!("  {}: not run: {lack}\n", variant.name))?;
                proofs.push(json!({"variant": variant.name, "lacks": lack}));
                continue;
            }
            let opened = cleared(&variant.choices)?;
            let own = computed(&scene, &opened, &settings)?;
            let found = proof(&variant.name, [&default, &own], &opened, &fixture)?;
            check_messages(Some(&opened))?;
            let told = proved(&found);
            print(&format!("  {}: {told}\n", variant.name))?;
            proofs.push(json!({"variant": variant.name, "proof": told}));
            timed.push(variant.clone());
        }
        outcomes.push(arguments.time(&scene, &device, &settings, (asked, timed, proofs))?);
    }
    print(&summary(&outcomes))?;
    let Some(path) = &arguments.json else { return Ok(()) };
    write(path, format!("{:#}\n", arguments.result(&device, &outcomes)))
}

impl Arguments {
    fn settings(&self) -> Settings {
        let TimingArguments { frames, until, budget, seed, .. } = self.timing;
        Settings {
            options: self.option_args.options(),
            change: self.timing.change(),
            frames: frames.unwrap_or(if until.is_some() { MOST } else { ROUNDS as u32 }) as usize,
            enough: budget.unwrap_or(if until.is_some() { 2.0 * BUDGET } else { BUDGET }),
            until,
            seed,
        }
    }

    /// Times the variants of an axis against the default.
    fn time(
        &self,
        scene: &Scene,
        device: &Device,
        settings: &Settings,
        (asked, timed, proofs): (Asked, Vec<Variant>, Vec<Value>),
    ) -> Result<Outcome> {
        if timed.is_empty() {
            return Ok(Outcome { asked, proofs, timed, samples: Samples::default(), ratios: Vec::new() });
        }
        let open = |choices: &Choices| device.opened_as(choices);
        let found = match asked.axis.name {
            "cache" => compare_first_frames(scene, &timed, &open, settings)?,
            _ => compare_frames(scene, &timed, &open, settings)?,
        };
        check_messages(Some(device))?;
        let ratios = found.samples.ratios();
        let outcome = Outcome { asked, proofs, timed, samples: found.samples, ratios };
        print(&format!("{}{}", stages(&outcome), unmet(&outcome.samples, settings)))?;
        Ok(outcome)
    }

    /// What `--json` holds.
    fn result(&self, device: &Device, outcomes: &[Outcome]) -> Value {
        let axis = |outcome: &Outcome| {
            let ratios = outcome.timed.iter().zip(&outcome.ratios);
            json!({
                "axis": outcome.asked.name,
                "default": outcome.asked.default,
                "variants": outcome.proofs,
                "samples": outcome.samples,
                "comparison": ratios
                    .map(|(variant, rows)| json!({"variant": variant.name, "rows": rows}))
                    .collect::<Vec<_>>(),
            })
        };
        json!({
            "schema": "milkglass-vary-1",
            "version": env!("CARGO_PKG_VERSION"),
            "commit": option_env!("MILKGLASS_COMMIT"),
            "scene": self.scene.scene,
            "sets": self.option_args.of(&self.scene.sets),
            "frame": self.scene.frame,
            "change": self.timing.change_name(),
            "device": device.name(),
            "driver": device.driver(),
            "axes": outcomes.iter().map(axis).collect::<Vec<_>>(),
        })
    }
}
