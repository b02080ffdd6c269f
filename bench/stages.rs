//! `cargo bench`: time and error of the hierarchy against brute force on the default device, then each stage on the
//! device and on the CPU.
//!
//! `cargo bench -- bunny.obj lotus` measures other scenes. Times are device times, medians of several frames; ratios
//! are against brute force on the same scene. Stages are compared with the reference before they are timed.

use milkglass::error::{Error, Result};
use milkglass::internals::gpu::Device;
use milkglass::internals::pipeline::plan::{Change, Goal, Mode, Options, ShadingMethod};
use milkglass::internals::session::run::Session;
use milkglass::measure::conform::conform;
use milkglass::measure::fixtures::Fixture;
use milkglass::measure::norms::worst;
use milkglass::measure::profile::{Settings, profile};
use milkglass::measure::reference::verify;
use milkglass::measure::statistics::median;
use milkglass::scene::Scene;

/// Times each stage of a picture on the device and on the CPU, after checking that they agree.
fn stages(scene: &Scene, device: &Device) -> Result<()> {
    let rows = conform(device, &Fixture::of_scene(&scene.name, scene)?, &[])?;
    if let Some(row) = rows.iter().find(|row| !row.faults.is_empty()) {
        return Err(Error::Check(format!("{}: {}", scene.name, row.faults[0])));
    }
    let gpu = profile(scene, Some(device), &Settings { frames: 7, ..Settings::default() })?;
    let cpu = profile(scene, None, &Settings { frames: 1, ..Settings::default() })?;
    println!("\n{:<20} {:<16} {:>10} {:>10} {:>9}", "scene", "stage, conforms", "device ms", "cpu ms", "faster");
    for (one, other) in gpu.rows.iter().zip(&cpu.rows) {
        let (ms, host) = (one.device.unwrap_or(one.wall).median, other.wall.median);
        println!("{:<20} {:<16} {ms:>10.3} {host:>10.3} {:>8.1}x", scene.name, one.stage, host / ms);
    }
    println!();
    Ok(())
}

/// Median time of a frame after this change, in milliseconds.
fn time(session: &mut Session, change: Change, frames: usize) -> Result<f64> {
    let mut times = Vec::new();
    for _ in 0..frames {
        times.push(session.frame(change)?.iter().map(|part| part.milliseconds).sum::<f64>());
    }
    Ok(median(times))
}

fn run() -> Result<()> {
    let Some(device) = Device::best()? else {
        println!("no usable Vulkan device");
        return Ok(());
    };
    println!("{}, {}", device.name(), device.driver());
    println!("{:<20} {:<30} {:>10} {:>9} {:>9} {:>9}", "scene", "method", "ms", "faster", "L2", "p99");
    let named: Vec<String> = std::env::args().skip(1).filter(|argument| !argument.starts_with("--")).collect();
    let mut scenes = Vec::new();
    for name in &named {
        scenes.push(Scene::load_with(name, &[])?);
    }
    if scenes.is_empty() {
        for (name, set) in [("sphere", "object.0.detail=5"), ("slab", "object.0.detail=64")] {
            scenes.push(Scene::load_with(name, &[set.to_string()])?);
        }
    }
    for scene in scenes {
        let mut baseline = 0.0;
        for (method, transport, mode, change) in [
            ("brute force", ShadingMethod::Brute, Mode::OnTheFly, Change::EVERYTHING),
            ("hierarchy, from scratch", ShadingMethod::Hierarchy, Mode::OnTheFly, Change::EVERYTHING),
            ("hierarchy, render, new light", ShadingMethod::Hierarchy, Mode::Render, Change::LIGHT),
        ] {
            let options = Options { transport, mode, goal: Goal::Radiosity, ..Options::default() };
            let mut session = Session::new(&scene, Some(&device), options)?;
            session.frame(Change::EVERYTHING)?;
            let error = worst(&verify(&mut session, 2000, 1)?);
            if !error.l2.is_finite() {
                return Err(Error::Check(format!("{}, {method}: the error is {}", scene.name, error.l2)));
            }
            let ms = time(&mut session, change, if transport == ShadingMethod::Brute { 1 } else { 5 })?;
            if transport == ShadingMethod::Brute {
                baseline = ms;
            }
            let (l2, p99) = (error.l2, error.p99);
            let faster = baseline / ms;
            let name = &scene.name;
            println!("{name:<20} {method:<30} {ms:>10.2} {faster:>8.1}x {l2:>9.2e} {p99:>9.2e}");
        }
        stages(&scene, &device)?;
    }
    Ok(())
}

fn main() {
    if let Err(error) = run() {
        eprintln!("{error}");
        std::process::exit(error.exit_code().into());
    }
}
