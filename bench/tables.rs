//! `cargo bench --bench tables`: tables 3, 4, 5 and figures 3, 4, 5 of Mertens et al. 2003, published values beside
//! ours.
//!
//! `cargo bench --bench tables -- horse.obj curve.csv` also measures meshes, and compares the curves of figures 3 and 4
//! with those of a file. `--only TEXT` selects tables by name, `--cpu` runs on the CPU, `--most-faces N` skips larger
//! models, `--samples N` sets the number of faces at which errors are measured (200).

use std::path::Path;

use milkglass::error::{Error, Input, Result};
use milkglass::internals::gpu::Device;
use milkglass::measure::tables::{Bench, TABLES, Told, figure_3, figure_4, given};

/// The parsed command line.
struct Asked {
    meshes: Vec<String>,
    curves: Vec<String>,
    only: String,
    cpu: bool,
    most_faces: usize,
    samples: usize,
}

fn asked() -> Result<Asked> {
    let mut asked =
        Asked { meshes: vec![], curves: vec![], only: String::new(), cpu: false, most_faces: usize::MAX, samples: 200 };
    let mut arguments = std::env::args().skip(1);
    while let Some(argument) = arguments.next() {
        let wrong = |found: &str| Error::from(Input::new("not an argument").found(found).expected("a number after it"));
        let mut value = || arguments.next().ok_or_else(|| wrong(&argument));
        match argument.as_str() {
            "--only" => asked.only = value()?,
            "--cpu" => asked.cpu = true,
            "--most-faces" => asked.most_faces = value()?.parse().map_err(|_| wrong(&argument))?,
            "--samples" => asked.samples = value()?.parse().map_err(|_| wrong(&argument))?,
            // Passed by cargo itself.
            "--bench" => {}
            name if name.ends_with(".obj") => asked.meshes.push(argument),
            name if name.ends_with(".csv") => asked.curves.push(argument),
            other => {
                let expected = "MESH.obj, CURVE.csv, --only TEXT, --cpu, --most-faces N, --samples N";
                return Err(Input::new("not an argument").found(other).expected(expected).into());
            }
        }
    }
    Ok(asked)
}

fn run() -> Result<()> {
    let asked = asked()?;
    let wanted = |name: &str| name.contains(&asked.only);
    let mut tell = |told: Told<'_>| println!("{told}");
    if wanted("figure 3") {
        figure_3(&mut tell);
        tell(Told::Words(""));
    }
    if wanted("figure 4") {
        figure_4(&mut tell);
        tell(Told::Words(""));
    }
    for path in &asked.curves {
        given(Path::new(path), &mut tell)?;
    }
    if !TABLES.iter().any(|(name, _)| wanted(name)) {
        return Ok(());
    }

    let device = if asked.cpu { None } else { Device::best()? };
    match &device {
        Some(device) => {
            tell(Told::Words(&format!("On {}, {}; the device's own clock.", device.name(), device.driver())));
        }
        None => tell(Told::Words("On the CPU reference, in f64: its ratios are not a device's.")),
    }
    let (device, meshes) = (device.as_ref(), asked.meshes.as_slice());
    let bench = Bench { device, meshes, samples: asked.samples, most_faces: asked.most_faces };
    for (_, table) in TABLES.iter().filter(|(name, _)| wanted(name)) {
        table(&bench, &mut tell)?;
        tell(Told::Words(""));
    }
    Ok(())
}

fn main() {
    if let Err(error) = run() {
        eprintln!("{error}");
        std::process::exit(error.exit_code().into());
    }
}
