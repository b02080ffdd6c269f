//! `cargo bench --bench layers`: error and cost of the march through layers, as in table 2 and figure 14 of Francois et
//! al. 2006.
//!
//! `--quick` measures fewer pixels and frames; `--cpu` runs on the CPU; `--pictures FOLDER` writes the fish with 10, 50
//! and 100 samples under both integration rules (figure 14).

use milkglass::error::{Error, Input, Result};
use milkglass::internals::gpu::Device;
use milkglass::internals::pipeline::plan::{Change, Options};
use milkglass::internals::session::run::Session;
use milkglass::measure::layers::{Line, Looks, PAPER, SAMPLES, SWEEP, approximations, by_lights, dearer, rules};
use milkglass::scene::{Integration, Scene};

fn scene(name: &str, sets: &[&str]) -> Result<Scene> {
    Scene::load_with(name, &sets.iter().map(|set| (*set).to_string()).collect::<Vec<_>>())
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
    let device = if cpu { None } else { Device::best()? };
    println!("on {}\n", device.as_ref().map_or("cpu", Device::name));
    let (pixels, repeat) = if quick { (512, 3) } else { (2048, 7) };
    let looks = |first: [u32; 2]| Looks { sizes: [first, [240, 180]], pixels };

    println!("scene        lights  relief ms  ms a light");
    for (of, sets) in [("fish", &["camera.size=[400, 300]"][..]), ("gecko", &["camera.size=[400, 300]"])] {
        let costs = by_lights(&scene(of, sets)?, device.as_ref(), &[1, 2, 4, 8, 16], repeat)?;
        for &(lights, ms) in &costs {
            println!("{of:<12} {lights:>6}  {ms:>9.1}  {:>10.2}", ms / f64::from(lights));
        }
        println!("{of:<12} a light takes at most {:.2} of the time of one alone", dearer(&costs));
    }
    println!();

    println!(
        "scene        rule   samples  L2 of integration  L2 in all            at 240 x 180         relief ms  of 10 samples  cost a sample  ms a view"
    );
    for (of, size) in [("slab-layers", [400, 300]), ("fish", [800, 600]), ("gecko", [800, 600])] {
        let lines = rules(&scene(of, &[])?, device.as_ref(), &SAMPLES, looks(size), repeat)?;
        let of_rule = |line: &Line, samples: u32, rule: Integration| {
            let found = lines.iter().find(|l| l.samples == samples && l.rule == rule);
            line.relief / found.map_or(f64::NAN, |found| found.relief)
        };
        for line in &lines {
            println!(
                "{of:<12} {:<6} {:>7}  {:>17.1e}  {:<20} {:<20} {:>9.1}  {:>13.2}  {:>13.2}  {:>9.1}",
                name(line.rule),
                line.samples,
                line.integration,
                line.totals[0].to_string(),
                line.totals[1].to_string(),
                line.relief,
                of_rule(line, SAMPLES[0], line.rule),
                of_rule(line, line.samples, Integration::Paper),
                line.view,
            );
        }
    }
    println!("\ntable 2 of the paper, frames a second on a GeForce 7800 GTX");
    for (samples, fish, gecko) in PAPER {
        println!("{samples:>4} samples: fish {fish}, gecko {gecko}");
    }

    println!("\nfigure 14: error of integration against samples, fish\nsamples      paper      exact");
    let lines = rules(&scene("fish", &[])?, device.as_ref(), &SWEEP, looks([400, 300]), 1)?;
    let (paper, exact) = lines.split_at(SWEEP.len());
    for (paper, exact) in paper.iter().zip(exact) {
        println!("{:>7}  {:>9.1e}  {:>9.1e}", paper.samples, paper.integration, exact.integration);
    }

    println!("\nscene        approximation                             L2 at 400 x 300      L2 at 240 x 180");
    for of in ["slab-layers", "fish", "gecko"] {
        let both = approximations(&scene(of, &[])?, looks([400, 300]))?;
        for ((what, one), (_, other)) in both[0].errors.iter().zip(&both[1].errors) {
            println!("{of:<12} {what:<40}  {:<19}  {}", one.to_string(), other);
        }
        for found in &both {
            let ([pixels, front], share) = (found.pixels, 100.0 * found.behind);
            println!("{of:<12} {share:.2} % from behind; in front, {front} of {pixels} pixels: {}", found.front);
        }
    }

    // The pictures of figure 14.
    for samples in SAMPLES {
        for rule in [Integration::Paper, Integration::Exact] {
            let Some(folder) = &pictures else { continue };
            let mut scene = scene("fish", &["camera.size=[800, 600]"])?;
            for layers in scene.objects.iter_mut().filter_map(|object| object.material.layers.as_mut()) {
                (layers.samples, layers.integration) = (samples, rule);
            }
            let mut session = Session::new(&scene, device.as_ref(), Options::default())?;
            session.frame(Change::EVERYTHING)?;
            let path = std::path::Path::new(folder).join(format!("fish-{}-{samples}.png", name(rule)));
            session.picture()?.save(&path)?;
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
