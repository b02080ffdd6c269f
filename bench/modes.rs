//! `cargo bench --bench modes`: cost of each mode after each change, against a frame from scratch of the same scheme,
//! with the links and form factors it computed and the error, on the default device.
//!
//! `cargo bench --bench modes -- bunny.obj lotus` measures other scenes, `--set KEY=VALUE` changes them.
//! `--only 'links bump'` selects the rows that match every word as scheme, mode or change; `--frames N` takes the
//! median of N frames.

use milkglass::error::Result;
use milkglass::internals::gpu::Device;
use milkglass::measure::modes::{Row, rows};
use milkglass::scene::Scene;

fn run() -> Result<()> {
    let Some(device) = Device::best()? else {
        println!("no usable Vulkan device");
        return Ok(());
    };
    println!("{}, {}", device.name(), device.driver());
    let (mut names, mut sets, mut only, mut frames) = (Vec::new(), Vec::new(), String::new(), 5);
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--set" => sets.extend(arguments.next()),
            "--only" => only = arguments.next().unwrap_or_default(),
            "--frames" => frames = arguments.next().and_then(|n| n.parse().ok()).unwrap_or(frames).max(1),
            _ if argument.starts_with("--") => {}
            _ => names.push(argument),
        }
    }
    if names.is_empty() {
        names = vec!["sphere".into(), "lotus".into()];
    }
    println!("| {} |", Row::HEADS.join(" | "));
    println!("|---|---|---|---|---:|---:|---:|---:|---:|---:|---:|");
    for name in &names {
        for row in rows(Some(&device), &Scene::load_with(name, &sets)?, frames, &only)? {
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
