//! `cargo bench --bench local`: what local shading costs on the default device, in one run: the kernel with Lambert's cosine,
//! the table and the closed form, visibility left out; and curvature against a frame of the hierarchy.
//!
//! `cargo bench --bench local -- bunny.obj` takes other scenes. Kernels take turns, and medians are compared.

use milkglass::error::Result;
use milkglass::gpu::Device;
use milkglass::render::plan::{Change, Options, Transport};
use milkglass::render::run::{Room, Session};
use milkglass::scene::{Cdrf, Scene};

/// Frames of each kernel.
const FRAMES: usize = 41;

/// Milliseconds of a stage, or of all.
fn time(session: &mut Session, change: Change, stage: &str) -> Result<f64> {
    let times = session.frame(change)?;
    Ok(times.iter().filter(|time| stage.is_empty() || time.name == stage).map(|time| time.milliseconds).sum())
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

fn run() -> Result<()> {
    let Some(device) = Device::first()? else {
        println!("no usable Vulkan device");
        return Ok(());
    };
    println!("{}, {}", device.name(), device.driver());
    let named: Vec<String> = std::env::args().skip(1).filter(|argument| !argument.starts_with("--")).collect();
    let names = if named.is_empty() { vec!["sphere".to_string()] } else { named };
    println!("{:<20} {:<12} {:>9} {:>9}", "scene, 1024 x 1024", "function", "ms", "/ lambert");
    for name in &names {
        let mut scene = Scene::load(name, &["camera.size=[1024, 1024]".into(), "camera.samples=1".into()])?;
        let mut sessions = Vec::new();
        for (function, transport, cdrf) in [
            ("lambert", Transport::Lambert, Cdrf::Closed),
            ("table", Transport::Cdrf, Cdrf::Table),
            ("closed form", Transport::Cdrf, Cdrf::Closed),
        ] {
            scene.transport.cdrf = cdrf;
            let options = Options { transport, ..Options::default() };
            let mut session = Session::new(&scene, Some(&device), options, Room::default())?;
            session.frame(Change::EVERYTHING)?;
            sessions.push((function, session, Vec::new()));
        }
        for _ in 0..FRAMES {
            for (function, session, times) in &mut sessions {
                let stage = if *function == "lambert" { "lambert" } else { "cdrf" };
                times.push(time(session, Change::VIEW, stage)?);
            }
        }
        let medians: Vec<f64> = sessions.iter().map(|(.., times)| median(times.clone())).collect();
        for ((function, ..), ms) in sessions.iter().zip(&medians) {
            println!("{name:<20} {function:<12} {ms:>9.3} {:>9.3}", ms / medians[0]);
        }

        // The picture is no part of it.
        scene.camera.size = [64, 64];
        // A new shape: curvature against all that the hierarchy does.
        let shape = Options { transport: Transport::Cdrf, ..Options::default() };
        let mut local = Session::new(&scene, Some(&device), shape, Room::default())?;
        let mut carried = Session::new(&scene, Some(&device), Options::default(), Room::default())?;
        local.frame(Change::EVERYTHING)?;
        carried.frame(Change::EVERYTHING)?;
        let seen = ["visibility", "shade", "reflect", "backdrop"];
        let (mut bends, mut solves) = (Vec::new(), Vec::new());
        for _ in 0..5 {
            bends.push(time(&mut local, Change::EVERYTHING, "curvature")?);
            let times = carried.frame(Change::EVERYTHING)?;
            solves.push(times.iter().filter(|t| !seen.contains(&t.name.as_str())).map(|t| t.milliseconds).sum());
        }
        let (bend, solve) = (median(bends), median(solves));
        let vertices = local.state().data.curvature.len();
        println!(
            "{name:<20} curvature of {vertices} vertices {bend:.2} ms, the hierarchy {solve:.1} ms: {:.4}",
            bend / solve
        );
    }
    Ok(())
}

fn main() {
    if let Err(error) = run() {
        eprintln!("{error}");
        std::process::exit(error.exit_code().into());
    }
}
