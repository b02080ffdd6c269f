//! `cargo bench --bench local`: cost and error of local shading on the default device: table 1 of Kubo et al. 2010, and
//! the curvature stages against a solve of the hierarchy.
//!
//! `cargo bench --bench local -- bunny.obj` measures other scenes than the ball of 163,842 vertices. Techniques
//! alternate, and medians are compared.

use milkglass::error::Result;
use milkglass::internals::gpu::Device;
use milkglass::measure::local::{PAPER, bending, table_1};
use milkglass::scene::Scene;

/// Frames of each technique, and of each solve.
const FRAMES: (usize, usize) = (81, 5);

fn run() -> Result<()> {
    let Some(device) = Device::best()? else {
        println!("no usable Vulkan device");
        return Ok(());
    };
    println!("{}, {}", device.name(), device.driver());
    let named: Vec<String> = std::env::args().skip(1).filter(|argument| !argument.starts_with("--")).collect();
    let fine = if named.is_empty() { vec!["object.0.detail=7".to_string()] } else { Vec::new() };
    let names = if named.is_empty() { vec!["sphere".to_string()] } else { named };
    println!(
        "{:<20} {:<20} {:>9} {:>10} {:>9} {:>6}",
        "scene, 1024 x 1024", "technique", "ms", "/ Lambert", "frame ms", "L2"
    );
    for name in &names {
        let own = ["camera.size=[1024, 1024]".into(), "transport.unwrap=true".into()];
        let scene = Scene::load_with(name, &[&own[..], &fine].concat())?;
        for row in table_1(&scene, Some(&device), FRAMES.0)? {
            let (technique, shading, ratio) = (row.technique, row.shading, row.ratio);
            let (frame, error) = (row.frame, row.error);
            println!("{name:<20} {technique:<20} {shading:>9.3} {ratio:>10.3} {frame:>9.1} {error:>6.3}");
        }
    }
    println!("\ntable 1 of the paper, frames a second on a GeForce 9300M GS: head, bunny");
    for (technique, head, bunny) in PAPER {
        println!("{technique:<20} {head:>6} {bunny:>6}");
    }
    println!();
    for name in &names {
        let bend = bending(&Scene::load_with(name, &fine)?, Some(&device), FRAMES.1)?;
        let (vertices, curvature, solve) = (bend.vertices, bend.curvature, bend.solve);
        println!(
            "{name:<20} curvature of {vertices} vertices {curvature:.2} ms, the hierarchy {solve:.1} ms: {:.4}",
            curvature / solve
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
