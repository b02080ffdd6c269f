//! `cargo bench --bench hierarchies`: the four hierarchies on one deforming object, on the default device: time, links
//! and error in one run.
//!
//! The object is a ball of 20,480 triangles, displaced by noise and twisted by up to 240 degrees. Face clusters, median
//! and butterfly share one mesh (an icosphere of 320 faces, subdivided three times); shrink-wrap remeshes the same
//! ball. Every frame is one of `render --frames`: all stages from scratch, with the tree rebuilt where the deformation
//! has degraded it.

use std::time::Instant;

use milkglass::error::Result;
use milkglass::internals::gpu::Device;
use milkglass::internals::layout::BufferId;
use milkglass::internals::pipeline::plan::{Change, Goal, Mode, Options};
use milkglass::internals::session::aov::links;
use milkglass::internals::session::run::Session;
use milkglass::measure::norms::worst;
use milkglass::measure::reference::verify;
use milkglass::scene::{Hierarchy, Scene};

/// The ball and its motion.
const BALL: [&str; 3] = [
    "object.0.deform=[{ type = 'noise', amplitude = 3, scale = 6, offset = { keyframes = [[0, [0, 0, 0]], [59, [0, 12, 0]]] } }, \
     { type = 'twist', angle = { keyframes = [[0, 0], [40, 240], [59, 0]], curve = 'smooth' } }]",
    "object.0.size=20",
    "camera.size=[64, 64]",
];

/// The measured frames, in order.
const FRAMES: [f64; 7] = [0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 59.0];

/// Receivers per frame that are compared with brute force in `f64`.
const SAMPLES: usize = 500;

const COARSE: [&str; 3] = ["object.0.detail=2", "transport.hierarchy=butterfly", "transport.levels=3"];
const FINE: [&str; 3] = ["object.0.detail=5", "transport.hierarchy=shrink-wrap", "transport.levels=3"];

/// Name, hierarchy, and settings of the mesh.
const ROWS: [(&str, Hierarchy, &[&str]); 4] = [
    ("face-clusters", Hierarchy::FaceClusters, &COARSE),
    ("median", Hierarchy::Median, &COARSE),
    ("butterfly", Hierarchy::Butterfly, &COARSE),
    ("shrink-wrap", Hierarchy::ShrinkWrap, &FINE),
];

/// The ball at one frame.
fn scene(hierarchy: Hierarchy, mesh: &[&str], tolerance: f64, frame: f64) -> Result<Scene> {
    let mut sets: Vec<String> = BALL.iter().chain(mesh).map(ToString::to_string).collect();
    sets.push(format!("transport.tolerance={tolerance}"));
    let mut scene = Scene::load_at("sphere", &sets, frame)?;
    scene.transport.hierarchy = hierarchy;
    Ok(scene)
}

/// One line of the table: means over the frames, except the error, which is the maximum.
fn row(device: &Device, name: &str, hierarchy: Hierarchy, mesh: &[&str], tolerance: f64) -> Result<String> {
    let options = Options { mode: Mode::Keep, goal: Goal::Radiosity, ..Options::default() };
    let start = Instant::now();
    let mut session = Session::new(&scene(hierarchy, mesh, tolerance, FRAMES[0])?, Some(device), options)?;
    let build = start.elapsed().as_secs_f64() * 1e3;
    session.frame(Change::EVERYTHING)?;
    let (mut ms, mut host, mut count, mut error, mut built) = (0.0, 0.0, 0.0, 0f64, 0);
    for frame in FRAMES {
        let next = scene(hierarchy, mesh, tolerance, frame)?;
        let start = Instant::now();
        session.show(&next)?;
        host += start.elapsed().as_secs_f64() * 1e3;
        built += usize::from(session.prepared().spoilt[0].is_some());
        session.frame(Change::EVERYTHING)?;
        let mut times = Vec::new();
        for _ in 0..5 {
            times.push(session.frame(Change::EVERYTHING)?.iter().map(|part| part.milliseconds).sum::<f64>());
        }
        times.sort_by(f64::total_cmp);
        ms += times[2];
        session.fetch(&[BufferId::runs, BufferId::spans])?;
        let lists = links(session.state());
        count += lists.iter().map(|&links| f64::from(links)).sum::<f64>() / lists.len() as f64;
        error = error.max(worst(&verify(&mut session, SAMPLES, 1)?).l2);
    }
    let all = FRAMES.len() as f64;
    let (faces, depth) = (session.state().data.triangles.len(), session.prepared().trees[0].depth());
    let (ms, host, count) = (ms / all, host / all, count / all);
    Ok(format!(
        "{name:<14} {faces:>9} {depth:>6} {tolerance:>9.0e} {ms:>9.1} {host:>9.1} {count:>9.0} {error:>9.1e} {built:>9} {build:>9.0}"
    ))
}

fn run() -> Result<()> {
    let Some(device) = Device::best()? else {
        println!("no usable Vulkan device");
        return Ok(());
    };
    println!("{}, {}", device.name(), device.driver());
    println!(
        "{:<14} {:>9} {:>6} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9} {:>9}",
        "hierarchy", "triangles", "levels", "asked", "frame ms", "host ms", "links/rec", "L2", "rebuilt", "start ms"
    );
    for tolerance in [1e-2, 1e-3] {
        for (name, hierarchy, mesh) in ROWS {
            println!("{}", row(&device, name, hierarchy, mesh, tolerance)?);
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
