//! `milkglass conform`: every stage of a device against the CPU reference.

use std::path::PathBuf;

use clap::Args;
use serde_json::json;

use super::device::pick;
use super::{print, table};
use crate::error::{Error, Input, Result};
use crate::gpu::{Adapter, Device, Instance};
use crate::measure::conform::{Row, conform};
use crate::measure::fixtures::{Fixture, fixtures};
use crate::scene::Scene;
use crate::view::picture::write_whole;

/// Arguments of `conform`.
#[derive(Args)]
#[command(after_help = "Example: milkglass conform --device llvmpipe\n         milkglass conform bunny.obj lotus")]
pub struct Arguments {
    /// Scenes to compare on; without any, the built-in fixtures.
    scenes: Vec<String>,
    /// A device's number in `milkglass devices`, or a part of its name [default: every Vulkan device].
    #[arg(long, value_name = "DEVICE")]
    device: Option<String>,
    /// Run without the validation layer.
    #[arg(long)]
    no_validation: bool,
    /// Only fixtures whose name contains this.
    #[arg(long, value_name = "TEXT", default_value = "")]
    only: String,
    /// Also write the table to this file.
    #[arg(long, value_name = "FILE")]
    json: Option<PathBuf>,
}

/// Runs the fixtures on every device asked for; fails on any difference beyond tolerance.
pub fn run(arguments: &Arguments) -> Result<()> {
    let instance = Instance::open(!arguments.no_validation)?;
    let adapters = instance.adapters()?;
    let chosen: Vec<&Adapter> = match arguments.device.as_deref() {
        Some("cpu") => {
            let fault = Input::new("the CPU is the reference itself").key("--device").found("cpu");
            return Err(fault.expected("a Vulkan device").into());
        }
        Some(wish) => vec![pick(&adapters, wish)?],
        None => adapters.iter().filter(|adapter| adapter.unusable.is_none()).collect(),
    };
    if chosen.is_empty() {
        return Err(Error::device("comparing devices with the CPU", "there is no usable Vulkan device"));
    }
    let mut list: Vec<Fixture> = Vec::new();
    if arguments.scenes.is_empty() {
        list.extend(fixtures(&arguments.only)?);
    }
    for name in &arguments.scenes {
        list.push(Fixture::of_scene(name, &Scene::load(name, &[])?)?);
    }

    let mut rows: Vec<(String, Row)> = Vec::new();
    for adapter in chosen {
        let device = Device::open(&instance, adapter)?;
        if !adapter.limits.round_to_nearest {
            eprintln!("{}: rounding to nearest can't be requested; decisions rely on its default", adapter.name);
        }
        for fixture in &list {
            for row in conform(&device, fixture, None)? {
                rows.push((adapter.name.clone(), row));
            }
        }
    }

    let cells: Vec<_> = rows
        .iter()
        .map(|(device, row)| {
            // Near zero the distance in units in the last place says nothing.
            let ulp = if row.ulp > 1_000_000 { "-".to_string() } else { row.ulp.to_string() };
            let verdict = if row.faults.is_empty() { "conforms".to_string() } else { "DIFFERS".to_string() };
            let (words, relative) = (row.words.to_string(), format!("{:.1e}", row.relative));
            vec![device.clone(), row.fixture.clone(), row.stage.to_string(), words, ulp, relative, verdict]
        })
        .collect();
    print(&table(&["device", "fixture", "stage", "words", "ulp", "relative", "verdict"], &[3, 4, 5], &cells))?;
    if let Some(path) = &arguments.json {
        let value: Vec<_> = rows
            .iter()
            .map(|(device, row)| {
                json!({"device": device, "fixture": row.fixture, "stage": row.stage, "words": row.words,
                       "ulp": row.ulp, "relative": row.relative, "faults": row.faults})
            })
            .collect();
        let text = format!("{:#}\n", serde_json::Value::from(value));
        write_whole(path, |beside| std::fs::write(beside, text).map_err(|e| e.to_string()))?;
    }
    for (device, row) in &rows {
        for fault in &row.faults {
            eprintln!("{device}: {}: {fault}", row.fixture);
        }
    }
    let faults: usize = rows.iter().map(|(_, row)| row.faults.len()).sum();
    if rows.is_empty() {
        return Err(Error::Check("nothing was compared".into()));
    }
    if faults > 0 {
        return Err(Error::Check(format!("{faults} differences beyond tolerance")));
    }
    print(&format!("{} comparisons, all conform\n", rows.len()))?;
    Ok(())
}
