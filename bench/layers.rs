//! `cargo bench --bench layers`: what the march through layers errs and costs, table 2 and figure 14 of Francois et al. 2006.
//!
//! `--quick` takes fewer pixels; `--cpu` runs on the CPU; `--pictures FOLDER` writes the fish with 10, 50 and 100 samples of
//! both rules there (figure 14).

use milkglass::error::{Error, Input, Result};
use milkglass::gpu::Device;
use milkglass::measure::layers::{Line, approximations, rules};
use milkglass::render::plan::{Change, Options};
use milkglass::render::run::{Room, Session};
use milkglass::scene::{Integration, Scene};

/// Samples as in table 2.
const SAMPLES: [u32; 3] = [10, 50, 100];

fn scene(name: &str, sets: &[&str]) -> Result<Scene> {
    Scene::load(name, &sets.iter().map(|set| (*set).to_string()).collect::<Vec<_>>())
}

fn name(rule: Integration) -> &'static str {
    if rule == Integration::Paper { "paper" } else { "exact" }
}

fn run() -> Result<()> {
    let (mut quick, mut cpu, mut pictures) = (false, false, None);
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        match argument.as_str() {
            "--quick" => quick = true,
            "--cpu" => cpu = true,
            "--pictures" => pictures = arguments.next(),
            "--bench" => {}
            other => {
                let fault = Input::new("not an argument").found(other);
                return Err(fault.expected("--quick, --cpu, --pictures FOLDER").into());
            }
        }
    }
    let device = if cpu { None } else { Device::first()? };
    println!("on {}\n", device.as_ref().map_or("cpu", Device::name));
    let (pixels, repeat) = if quick { (40, 3) } else { (240, 7) };

    println!(
        "scene        rule   samples  L2 of integration  L2 in all  relief ms  of 10 samples  cost a sample  ms a view"
    );
    for (of, sets) in [
        ("slab-layers", &["camera.size=[400, 300]"][..]),
        ("fish", &["camera.size=[800, 600]"]),
        ("gecko", &["camera.size=[800, 600]"]),
    ] {
        let lines = rules(&scene(of, sets)?, device.as_ref(), &SAMPLES, pixels, repeat)?;
        let of_rule = |line: &Line, samples: u32, rule: Integration| {
            let found = lines.iter().find(|l| l.samples == samples && l.rule == rule);
            line.relief / found.map_or(f64::NAN, |found| found.relief)
        };
        for line in &lines {
            println!(
                "{of:<12} {:<6} {:>7}  {:>17.1e}  {:>9.1e}  {:>9.1}  {:>13.2}  {:>13.2}  {:>9.1}",
                name(line.rule),
                line.samples,
                line.integration,
                line.total,
                line.relief,
                of_rule(line, SAMPLES[0], line.rule),
                of_rule(line, line.samples, Integration::Paper),
                line.view,
            );
        }
    }
    println!(
        "\ntable 2: frames a second with 10, 50, 100 samples: fish 126, 51, 20; gecko 120, 33, 16 (GeForce 7800 GTX)"
    );

    println!("\nscene        approximation                             L2");
    for of in ["fish", "gecko"] {
        for (what, error) in approximations(&scene(of, &["camera.size=[400, 300]"])?, pixels / 4)? {
            println!("{of:<12} {what:<40}  {error:.1e}");
        }
    }

    // Figure 14.
    for samples in SAMPLES {
        for rule in [Integration::Paper, Integration::Exact] {
            let Some(folder) = &pictures else { continue };
            let mut scene = scene("fish", &["camera.size=[800, 600]"])?;
            for layers in scene.objects.iter_mut().filter_map(|object| object.material.layers.as_mut()) {
                (layers.samples, layers.integration) = (samples, rule);
            }
            let mut session = Session::new(&scene, device.as_ref(), Options::default(), Room::default())?;
            session.frame(Change::EVERYTHING)?;
            let path = std::path::Path::new(folder).join(format!("fish-{}-{samples}.png", name(rule)));
            session.picture()?.save(&path, &scene.camera)?;
        }
    }
    Ok(())
}

fn main() {
    if let Err(error) = run() {
        let error: Error = error;
        eprintln!("layers: {error}");
        std::process::exit(1);
    }
}
