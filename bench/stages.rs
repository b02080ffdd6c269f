//! `cargo bench`: the hierarchy against brute force on the default device, error beside time, in one run.
//!
//! `cargo bench -- bunny.obj lotus` takes other scenes. Times are the device's own, the median of several frames;
//! each ratio is against brute force of the same scene.

use milkglass::error::Result;
use milkglass::gpu::{Device, Instance};
use milkglass::measure::norms::worst;
use milkglass::measure::reference::verify;
use milkglass::render::plan::{Change, Goal, Mode, Options, Transport};
use milkglass::render::run::{Room, Session};
use milkglass::scene::Scene;

/// Median time of a frame after this change, milliseconds.
fn time(session: &mut Session, change: Change, frames: usize) -> Result<f64> {
    let mut times = Vec::new();
    for _ in 0..frames {
        times.push(session.frame(change)?.iter().map(|part| part.milliseconds).sum::<f64>());
    }
    times.sort_by(f64::total_cmp);
    Ok(times[times.len() / 2])
}

fn run() -> Result<()> {
    let instance = Instance::open(false)?;
    let Some(adapter) = instance.adapters()?.into_iter().find(|adapter| adapter.unusable.is_none()) else {
        println!("no usable Vulkan device");
        return Ok(());
    };
    let device = Device::open(&instance, &adapter)?;
    println!("{}, {}", adapter.name, adapter.driver);
    println!("{:<20} {:<30} {:>10} {:>9} {:>9} {:>9}", "scene", "method", "ms", "faster", "L2", "p99");
    let named: Vec<String> = std::env::args().skip(1).filter(|argument| !argument.starts_with("--")).collect();
    let mut scenes = Vec::new();
    for name in &named {
        scenes.push(Scene::load(name, &[])?);
    }
    if scenes.is_empty() {
        for (name, set) in [("sphere", "object.0.detail=5"), ("slab", "object.0.detail=64")] {
            scenes.push(Scene::load(name, &[set.to_string()])?);
        }
    }
    for scene in scenes {
        let mut baseline = 0.0;
        for (method, transport, mode, change) in [
            ("brute force", Transport::Brute, Mode::OnTheFly, Change::EVERYTHING),
            ("hierarchy, from scratch", Transport::Hierarchy, Mode::OnTheFly, Change::EVERYTHING),
            ("hierarchy, render, new light", Transport::Hierarchy, Mode::Render, Change::LIGHT),
        ] {
            let options = Options { transport, mode, goal: Goal::Radiosity, ..Options::default() };
            let mut session = Session::new(&scene, Some(&device), options, Room::default())?;
            session.frame(Change::EVERYTHING)?;
            let ms = time(&mut session, change, if transport == Transport::Brute { 1 } else { 5 })?;
            if transport == Transport::Brute {
                baseline = ms;
            }
            let error = worst(&verify(&mut session, 2000, 1)?);
            let (l2, p99) = (error.l2, error.p99);
            let faster = baseline / ms;
            let name = &scene.name;
            println!("{name:<20} {method:<30} {ms:>10.2} {faster:>8.1}x {l2:>9.2e} {p99:>9.2e}");
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
