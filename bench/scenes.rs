//! Measurements of scenes of your own.

use std::path::Path;

use milkglass::error::{Error, Result};
use milkglass::internals::pipeline::plan::Change;
use milkglass::measure::conform::conform;
use milkglass::measure::fixtures::Fixture;
use milkglass::measure::local::{bending, table_1};
use milkglass::measure::modes::{Row, rows};
use milkglass::measure::profile::{Settings, profile};
use milkglass::measure::report::{Bench, Page};
use milkglass::measure::statistics::median;
use milkglass::measure::table::Table;
use milkglass::measure::tables::curves::{figure_3, figure_4};
use milkglass::measure::tables::{Bench as Models, Beside, TABLES, figures};
use milkglass::{Goal, Options, Scene, Session, ShadingMethod};

use super::Asked;

#[path = "../tests/native_walk/mod.rs"]
mod native_walk;

use native_walk::Body;

/// Each stage of a picture on the device and on the CPU, after both agree.
pub fn stages(asked: &Asked, bench: &Bench<'_>, page: &mut Page) -> Result<()> {
    let Some(device) = bench.device else {
        page.say("There is no device to compare with the CPU.");
        return Ok(());
    };
    for name in asked.scenes(&["sphere", "slab"]) {
        let scene = Scene::load_with(&name, &asked.sets)?;
        let compared = conform(device, &Fixture::of_scene(&scene.name, &scene)?, &[])?;
        if let Some(fault) = compared.iter().flat_map(|row| &row.faults).next() {
            return Err(Error::Check(format!("{name}: {fault}")));
        }
        let gpu = profile(&scene, Some(device), &Settings { frames: 7, ..Settings::default() })?;
        let cpu = profile(&scene, None, &Settings { frames: 1, ..Settings::default() })?;
        let times = gpu.rows.iter().zip(&cpu.rows);
        let rows: Vec<(&str, f64, f64)> =
            times.map(|(gpu, cpu)| (&*gpu.stage, gpu.device.unwrap_or(gpu.wall).median, cpu.wall.median)).collect();
        page.head(&name);
        page.small_table(&Table::of(
            &rows,
            &[
                ("stage, conforms", "", &|row| row.0.into()),
                ("device ms", "", &|row| format!("{:.3}", row.1)),
                ("cpu ms", "", &|row| format!("{:.3}", row.2)),
                ("faster", "", &|row| format!("{:.1}x", row.2 / row.1)),
            ],
        ));
    }
    Ok(())
}

/// Table 1 of Kubo et al. 2010, and curvature against a solve of the hierarchy.
pub fn local(asked: &Asked, bench: &Bench<'_>, page: &mut Page) -> Result<()> {
    for name in asked.scenes(&["sphere"]) {
        let sets = ["camera.size=[1024, 1024]".to_string(), "transport.unwrap=true".into()];
        let scene = Scene::load_with(&name, &[&sets[..], &asked.sets].concat())?;
        page.head(&name);
        page.small_table(&Table::of(
            &table_1(&scene, bench.device, if bench.quick { 25 } else { 81 })?,
            &[
                ("technique", "", &|row| row.technique.into()),
                ("shading, ms", "", &|row| format!("{:.3}", row.shading)),
                ("/ Lambert", "", &|row| format!("{:.3}", row.ratio)),
                ("frame, ms", "", &|row| format!("{:.1}", row.frame)),
                ("L2", "", &|row| format!("{:.3}", row.error)),
            ],
        ));
        let bend = bending(&Scene::load_with(&name, &asked.sets)?, bench.device, 5)?;
        let (vertices, curvature, solve) = (bend.vertices, bend.curvature, bend.solve);
        let share = curvature / solve;
        page.say(&format!("curvature of {vertices} vertices {curvature:.2} ms, a solve {solve:.1} ms: {share:.4}"));
    }
    Ok(())
}

/// Each mode after each change. `--only 'links bump'` selects the rows that match every word as scheme, mode or change;
/// `--frames N` takes the median of N frames.
pub fn modes(asked: &Asked, bench: &Bench<'_>, page: &mut Page) -> Result<()> {
    for name in asked.scenes(&["sphere", "lotus"]) {
        let (scene, frames) = (Scene::load_with(&name, &asked.sets)?, asked.number("--frames", 5.0)?);
        page.small_table(&Row::table(&rows(
            bench.device,
            &scene,
            (frames as usize).max(1),
            asked.words("--only", ""),
        )?));
    }
    Ok(())
}

/// Figures 3 and 4 and tables 3, 4, 5 of Mertens et al. 2003, also for meshes; a file of curves, `.csv`, is compared
/// with figures 3 and 4. `--only TEXT` selects tables by name, `--most-faces N` skips larger models, `--samples N` sets
/// the number of faces at which errors are measured.
pub fn tables(asked: &Asked, bench: &Bench<'_>, page: &mut Page) -> Result<()> {
    let (curves, meshes): (Vec<String>, _) = asked.files.iter().cloned().partition(|file| file.ends_with(".csv"));
    for file in curves {
        page.say(&figures::given(Path::new(&file))?);
    }
    for (name, place, points) in [("figure 3", "tip_mm", figure_3()), ("figure 4", "base_mm", figure_4())] {
        if name.contains(asked.words("--only", "")) {
            page.head(name);
            page.small_table(&figures::points(place, &points));
            page.small_table(&figures::worst(&points));
        }
    }
    let most_faces = asked.number("--most-faces", if bench.quick { 2_100.0 } else { f64::INFINITY })? as usize;
    let samples = asked.number("--samples", 200.0)? as usize;
    let models = Models { device: bench.device, meshes: &meshes, samples, most_faces };
    for (_, measure) in TABLES.iter().filter(|(name, _)| name.contains(asked.words("--only", ""))) {
        // Rows take minutes.
        let mut print = |so_far: &Beside| {
            so_far.table.rows.last().iter().for_each(|row| eprintln!("{}", row.join("  ")));
            Ok(())
        };
        for beside in measure(&models, &mut print)? {
            beside.before.iter().for_each(|words| page.say(words));
            page.small_table(&beside.table);
            beside.after.iter().for_each(|words| page.say(words));
        }
    }
    Ok(())
}

/// Photons of each channel in a turn.
const PHOTONS: u64 = 16_000;
/// Turns, in each of which all walks run once.
const TURNS: u64 = 5;

/// Photons a second in marble under one directional light, on the device, by the CPU's reference and by a native
/// program: medians of turns in which all alternate.
pub fn walk(asked: &Asked, bench: &Bench<'_>, page: &mut Page) -> Result<()> {
    for name in asked.scenes(&["sphere"]) {
        let sun = "light=[{ type = 'directional', direction = [0, 0, 1], irradiance = 1, shadows = false }]";
        let marble = ["object.0.material.preset=marble", "object.0.size=20", sun].map(String::from);
        let detail = (name == "sphere").then(|| "object.0.detail=3".to_string());
        let photons = [format!("transport.walks={PHOTONS}")];
        let sets: Vec<String> = marble.into_iter().chain(detail).chain(photons).chain(asked.sets.clone()).collect();
        let scene = Scene::load_with(&name, &sets)?;
        let options = Options { transport: ShadingMethod::Walk, goal: Goal::Radiosity, ..Options::default() };
        let mut sessions = Vec::new();
        for device in bench.device.map(Some).into_iter().chain([None]) {
            let mut session = Session::new(&scene, device, options)?;
            session.frame(Change::EVERYTHING)?;
            sessions.push((if device.is_some() { "device" } else { "CPU" }, session, Vec::new()));
        }
        let light = sessions[0].1.faces()?.iter().map(|face| face.area * face.irradiance[1]).collect();
        let (body, material) = (Body::new(&scene, light, glam::DVec3::Z), &scene.objects[0].material);
        let media = [0, 1, 2].map(|c| (material.sigma_s_prime[c], material.sigma_a[c], material.eta[c]));
        let (mut native, mut found) = (Vec::new(), (0.0, 0.0));
        for turn in 0..TURNS {
            let begin = std::time::Instant::now();
            found = body.walk(media, PHOTONS, turn);
            native.push(3.0 * PHOTONS as f64 / begin.elapsed().as_secs_f64());
            for (_, session, rates) in &mut sessions {
                session.frame(Change::LIGHT)?;
                rates.push(3.0 * PHOTONS as f64 / session.walk_reports()[0].seconds);
            }
        }
        let mut rows = vec![("native", median(native), found.0)];
        for (walk, session, rates) in sessions {
            rows.push((walk, median(rates), session.walk_reports()[0].left.iter().sum::<f64>() / 3.0));
        }
        page.say(&format!("{name}: {:.1} flights a photon", found.1));
        page.small_table(&Table::of(
            &rows,
            &[
                ("walk", "", &|row| row.0.into()),
                ("photons / s", "", &|row| format!("{:.3e}", row.1)),
                ("/ native", "", &|row| format!("{:.2}", row.1 / rows[0].1)),
                ("left %", "", &|row| format!("{:.2}", 100.0 * row.2)),
            ],
        ));
    }
    Ok(())
}
