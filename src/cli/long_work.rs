//! Tells what will take long before it runs, and what makes it cheaper.

use serde_json::{Value, json};

use super::table;
use milkglass::internals::session::run::Session;
use milkglass::internals::session::workload::{Rays, Workload};
use milkglass::scene::{Light, Source};

/// Boxes that rays are tested with in about ten seconds on two cores with lavapipe.
const LONG_RAYS: f64 = 5e8;
/// Pairs of a receiver and a near triangle that two cores integrate in about ten seconds with lavapipe.
const LONG_PAIRS: f64 = 2e7;
/// Boxes per ray, and near triangles per receiver, that only long, thin triangles have.
const THIN: f64 = 200.0;

/// Says on standard error what will take long in a frame.
pub fn tell_long_work(session: &Session) {
    for line in lines(session, &session.workload()) {
        tell!("{line}");
    }
}

fn lines(session: &Session, load: &Workload) -> Vec<String> {
    let mut lines = Vec::new();
    for rays in load.rays.iter().filter(|rays| rays.work(load.triangles) > LONG_RAYS) {
        let stage = rays.stage;
        let cast = format!(
            "long: {stage} casts about {} rays, from {}",
            count(rays.count() as f64 * rays.share),
            product(rays)
        );
        if rays.boxes > THIN {
            lines.push(format!(
                "{cast}, and a ray passes the boxes of {} of {} triangles, since they are long and thin: remesh to even ones",
                count(rays.boxes),
                count(load.triangles as f64)
            ));
        } else {
            let size = if rays.per == "pixels" { "a smaller camera.size" } else { "fewer triangles" };
            let keys = rays.samples.and_then(|_| largest(&session.scene().lights));
            lines.push(format!("{cast}; {} takes less", keys.unwrap_or_else(|| size.to_string())));
        }
    }
    if load.near > THIN && load.pairs() > LONG_PAIRS {
        lines.push(format!(
            "long: light is integrated over {} of {} triangles for each receiver, since they are long and thin, {} \
             times in all: remesh to even ones, or --transport cdrf",
            count(load.near),
            count(load.triangles as f64),
            count(load.pairs())
        ));
    }
    lines
}

/// A whole number, in groups of three digits.
fn count(x: f64) -> String {
    let digits = format!("{x:.0}");
    let groups: Vec<_> = digits.as_bytes().rchunks(3).rev().map(String::from_utf8_lossy).collect();
    groups.join(",")
}

/// The key of the light that casts most rays, if it has one.
fn largest(lights: &[Light]) -> Option<String> {
    let casts = |light: &Light| if light.shadows { light.samples() } else { 0 };
    let (number, light) = lights.iter().enumerate().max_by_key(|(_, light)| casts(light))?;
    let side = (light.samples() as f64).sqrt().round();
    (casts(light) > 1).then(|| match light.source {
        Source::Environment { .. } => format!("light.{number}.occlusion below {}", light.samples()),
        _ => format!("light.{number}.samples below {side}"),
    })
}

/// `262,144 pixels x 272 light samples`.
fn product(rays: &Rays) -> String {
    let places = format!("{} {}", count(rays.places as f64), rays.per);
    match rays.samples {
        None => places,
        Some(samples) => format!("{places} x {samples} light sample{}", if samples == 1 { "" } else { "s" }),
    }
}

/// Part of a plan: the rays of each stage, and the triangles near a receiver.
pub fn of_plan(load: &Workload) -> String {
    let row = |rays: &Rays| {
        let [all, boxes] = [rays.count() as f64, rays.boxes].map(count);
        vec![rays.stage.to_string(), all, product(rays), format!("{:.0} %", 100.0 * rays.share), boxes]
    };
    let rows: Vec<_> = load.rays.iter().map(row).collect();
    let mut text = String::new();
    if !rows.is_empty() {
        text += "\nrays: of a frame from scratch, at most; estimated from a sample: how many are cast, and boxes of triangles along each\n";
        text += &table(["stage", "rays", "one per", "cast", "boxes"], rows);
    }
    if load.near > 0.0 {
        let (near, pairs) = (count(load.near), count(load.pairs()));
        text += &format!("\nnear a receiver, estimated: {near} triangles, {pairs} for all\n");
    }
    text
}

/// The rays of each stage, as JSON.
pub fn json_of(load: &Workload) -> Value {
    let stage = |rays: &Rays| {
        json!({"stage": rays.stage, "rays": rays.count(), "per": rays.per, "places": rays.places,
               "light_samples": rays.samples, "cast": rays.share, "boxes": rays.boxes})
    };
    load.rays.iter().map(stage).collect()
}
