//! Error against run time.

use super::{Bench, Page, Tone};
use crate::error::Result;
use crate::measure::pareto::{self, Lighting, METHODS, Norm, Origin, Reach, Settings, csv, ratios, svg, sweep};
use crate::scene::Scene;

/// Every method over its settings, in one run.
pub fn pareto(bench: &Bench<'_>, page: &mut Page) -> Result<()> {
    let names: &[&str] = bench.either(&["sphere"], &["sphere", "lotus"]);
    for name in names {
        let sets: &[String] = if bench.quick { &["object.0.detail=3".into()] } else { &[] };
        one(bench, page, &Scene::load(name, sets)?)?;
    }
    Ok(())
}

fn one(bench: &Bench<'_>, page: &mut Page, scene: &Scene) -> Result<()> {
    let settings = Settings {
        methods: METHODS.iter().collect(),
        values: bench.either(3, usize::MAX),
        repeat: 5,
        samples: bench.either(100, 500),
        seed: 1,
        budget: bench.either(3.0, 30.0),
    };
    let found = sweep(&pareto::Bench { scene, device: bench.device }, &settings)?;
    let (low, high) = scene.bounds();
    let origin = Origin {
        device: super::setting::name(bench),
        driver: super::setting::driver(bench),
        scene: scene.name.clone(),
        faces: scene.objects.iter().map(|object| object.mesh.triangles.len()).sum(),
        extent_mm: ((high - low).max_element() * scene.unit_mm * 1e4).round() / 1e4,
        material: scene.objects.first().map_or_else(String::new, |object| object.material.name.clone()),
        repeat: settings.repeat,
    };
    page.head(&format!("{}, {} triangles", origin.scene, origin.faces));
    page.say(
        "Up and to the right is worse. A moving light makes everything anew that depends on light; a resting one leaves only \
         the summing. Errors are L2 of the radiosity, worst channel, against brute force in f64 over the method's own leaf \
         sums, and against the area integral. Read points side by side: they were measured in one run on one device.",
    );
    page.plot(&svg(&found, &origin)?, true);
    page.file(&format!("pareto-{}.csv", origin.scene), csv(&found, &origin)?.into_bytes());

    let all = ratios(&found, &METHODS[0]);
    let row = |ratio: &pareto::Ratio| {
        let norm = if ratio.norm == Norm::L2 { "L2" } else { "p99" };
        let error = format!("{norm} {}", ratio.against.name());
        let light = ratio.lighting.name().to_string();
        vec![light, error, ratio.method.name.to_string(), ratio.cell(0), ratio.cell(1), ratio.cell(2)]
    };
    page.say(&format!("Wall time at equal error, and its ratio to that of {} (above 1: slower):", METHODS[0].name));
    let header = ["light", "error", "method", "1e-2", "1e-3", "1e-4"];
    page.table(&format!("pareto-{}-ratios", origin.scene), &header, &all.iter().map(row).collect::<Vec<_>>())?;

    for lighting in Lighting::ALL {
        for method in found.methods().into_iter().skip(1) {
            let own = all.iter().filter(|ratio| ratio.lighting == lighting && ratio.method.name == method.name);
            if let Some((times, words)) = own.filter_map(compared).min_by(|a, b| a.0.total_cmp(&b.0)) {
                let tone = if times >= 1.0 { Tone::Win } else { Tone::Loss };
                page.find(tone, &format!("{}, {}: {words}", origin.scene, lighting.name()));
            }
        }
    }
    Ok(())
}

/// A method's time as a multiple of the base's, at the finest error where that can be told, and both in words.
fn compared(ratio: &pareto::Ratio) -> Option<(f64, String)> {
    // Where there is no setting the time is the time at any error that is met.
    let theirs = |reach: Reach| match reach {
        Reach::Within(time) if ratio.method.parameter.is_empty() => Reach::At(time),
        other => other,
    };
    (0..3).rev().find_map(|k| {
        let (a, b) = match (theirs(ratio.times[k]), ratio.base[k]) {
            (Reach::At(a), Reach::At(b)) => (a, b),
            (Reach::At(a), Reach::Within(b)) if b <= a => (a, b),
            (Reach::Within(a), Reach::At(b)) if a <= b => (a, b),
            _ => return None,
        };
        let norm = if ratio.norm == Norm::L2 { "L2" } else { "p99" };
        let (error, target) = (ratio.against.name(), ["1e-2", "1e-3", "1e-4"][k]);
        let (ours, name) = (METHODS[0].name, ratio.method.name);
        Some((a / b, format!("{norm} {target} {error}: {ours} {b:.1} ms, {name} {a:.1} ms")))
    })
}
