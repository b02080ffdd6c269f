//! `cargo bench --bench modes`: what each mode costs after each change, against a frame from scratch of the same scheme, with
//! the links and form factors that it made and the error beside the time, in one run on the default device.
//!
//! `cargo bench --bench modes -- bunny.obj lotus` takes other scenes, `--set KEY=VALUE` changes them.

use milkglass::error::Result;
use milkglass::gpu::Device;
use milkglass::measure::modes::{Row, rows};
use milkglass::scene::Scene;

/// Frames that a time is the median of.
const FRAMES: usize = 5;

fn run() -> Result<()> {
    let Some(device) = Device::first()? else {
        println!("no usable Vulkan device");
        return Ok(());
    };
    println!("{}, {}", device.name(), device.driver());
    let (mut names, mut sets) = (Vec::new(), Vec::new());
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--set" => sets.extend(arguments.next()),
            _ if argument.starts_with("--") => {}
            _ => names.push(argument),
        }
    }
    if names.is_empty() {
        names = vec!["sphere".into(), "lotus".into()];
    }
    println!("| {} |", Row::HEADS.join(" | "));
    println!("|---|---|---|---|---:|---:|---:|---:|---:|");
    for name in &names {
        for row in rows(Some(&device), &Scene::load(name, &sets)?, FRAMES)? {
            println!("| {} |", row.cells().join(" | "));
        }
    }
    Ok(())
}

fn main() {
    if let Err(error) = run() {
        eprintln!("{error}");
        std::process::exit(error.exit_code().into());
    }
}
