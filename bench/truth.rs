//! Error against a random walk and against the area integral of the same model, by run time, for the built-in ball,
//! torus and slab and for meshes (20 mm across), in three materials: `truth.csv` and the chart `truth.svg`.
//!
//! `--seconds 8` is the time of each walk, `--budget 15` the most seconds of a point, `--methods blocks,octree` which
//! methods are compared.

use std::path::Path;

use milkglass::Scene;
use milkglass::error::{Input, Result};
use milkglass::internals::session::walk::WalkControl;
use milkglass::measure::pareto::{Bench as Subject, Lighting, METHODS, Settings, sweep};
use milkglass::measure::plot::{Axis, COLORS, Mark, Panel, Plot, Series};
use milkglass::measure::report::{Bench, Page};
use milkglass::measure::table::{Column, Table};
use milkglass::measure::truth::Truth;

use super::Asked;

/// The built-in shapes: the name, the scene and a setting of each.
const SHAPES: [(&str, &str, &str); 3] = [
    ("ball, 20 mm", "sphere", "object.0.size=20"),
    ("torus, 36 mm", "torus", "object.0.deform=[]"),
    ("slab, 10 x 10 x 2 mm", "slab", "object.0.size=10"),
];
const MATERIALS: [&str; 3] = ["marble", "wholemilk", "skin1"];
const LIGHT: &str = "light=[{ type = 'directional', direction = [0.6, 0.7, 0.4], irradiance = 3 }]";

/// A measured point: milliseconds, errors against the walk and the area integral, and the walk's noise.
struct Row {
    shape: String,
    material: &'static str,
    method: &'static str,
    setting: f64,
    numbers: [f64; 4],
}

/// Measures everything, and writes the files.
pub fn truth(asked: &Asked, bench: &Bench<'_>, page: &mut Page) -> Result<()> {
    let names = asked.words("--methods", "blocks,links,octree,diffusion");
    let methods = names.split(',').filter_map(|name| METHODS.iter().find(|method| method.name == name)).collect();
    let budget = asked.number("--budget", 15.0)?;
    let mut settings = Settings { methods, values: 5, repeat: 3, samples: 60, seed: 1, budget, truth: None };
    let walk = format!("walk:{}", asked.number("--seconds", 8.0)?);
    let stem = |file: &String| Path::new(file).file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let meshes = asked.files.iter().map(|file| (format!("{}, 20 mm", stem(file)), file.as_str(), "object.0.size=20"));
    let shapes = SHAPES.iter().map(|&(name, scene, set)| (name.to_string(), scene, set)).chain(meshes);
    let (mut rows, mut panels) = (Vec::new(), Vec::new());
    for (shape, scene, set) in shapes {
        for material in MATERIALS {
            let sets = [set.into(), LIGHT.into(), format!("object.0.material={{ preset = '{material}' }}")];
            let scene = Scene::load_with(scene, &sets)?;
            settings.truth = Some(Truth::find(&walk, &scene, bench.device, WalkControl::default())?);
            let found = sweep(&Subject { scene: &scene, device: bench.device }, &settings)?;
            let before = rows.len();
            for (point, run) in found.measured(Lighting::Moves) {
                let Some(truth) = run.truth else { continue };
                let numbers = [run.wall_ms, truth.norms().l2, run.total.l2, truth.noise];
                rows.push(Row {
                    shape: shape.clone(),
                    material,
                    method: point.method.name,
                    setting: point.value,
                    numbers,
                });
            }
            eprintln!("{shape}, {material}: {} points", rows.len() - before);
            panels.push(panel(&format!("{shape}, {material}"), &settings, &rows[before..]));
        }
    }
    let title = vec!["Relative L2 error of radiosity against time per frame, light moving".to_string()];
    let table = table(&rows);
    save("truth.csv", &table.csv()?)?;
    save("truth.svg", &Plot { title, panels, columns: MATERIALS.len(), shared: true }.svg()?)?;
    page.small_table(&table);
    Ok(())
}

fn save(file: &str, text: &str) -> Result<()> {
    std::fs::write(file, text)
        .map_err(|error| Input::new("could not be written").file(Path::new(file)).found(error).into())
}

fn table(rows: &[Row]) -> Table {
    let number = |x: f64| format!("{x:.4e}");
    let columns: [Column<'_, Row>; 8] = [
        ("shape", "", &|row| row.shape.clone()),
        ("material", "", &|row| row.material.into()),
        ("method", "", &|row| row.method.into()),
        ("setting", "", &|row| row.setting.to_string()),
        ("wall_ms", "", &|row| number(row.numbers[0])),
        ("truth_l2", "", &|row| number(row.numbers[1])),
        ("total_l2", "", &|row| number(row.numbers[2])),
        ("truth_noise", "", &|row| number(row.numbers[3])),
    ];
    Table::of(rows, &columns)
}

/// Each method's curves, and the walk's noise.
fn panel(title: &str, settings: &Settings, rows: &[Row]) -> Panel {
    let mut series = Vec::new();
    for (method, color) in settings.methods.iter().zip(COLORS) {
        let dots = |column: usize| {
            let points = rows.iter().filter(|row| row.method == method.name);
            points.map(|row| (row.numbers[0], row.numbers[column].max(3e-4))).collect::<Vec<_>>()
        };
        let name = format!("{}: against a random walk, noise taken off", method.name);
        series.push(Series::new(name, Mark::Curve, dots(1)).colored(color));
        series
            .push(Series::new("dashed: against the same model, summed exactly", Mark::Dashes, dots(2)).colored(color));
    }
    let noise = rows.iter().map(|row| (row.numbers[0], row.numbers[3])).collect::<Vec<_>>();
    series.push(Series::new("the walk's noise", Mark::Band, noise));
    Panel { size: [330, 300], ..Panel::new(title, [Axis::log("ms"), Axis::log("L2")], series) }
}
