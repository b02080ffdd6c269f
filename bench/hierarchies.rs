//! The four hierarchies on one deforming object: time, links and error in one run.
//!
//! The object is a ball of 20,480 triangles, displaced by noise and twisted by up to 240 degrees. Face clusters, median
//! and butterfly share one mesh (an icosphere of 320 faces, subdivided three times); shrink-wrap remeshes the same
//! ball. Every frame is one of `render --frames`: all stages from scratch, with the tree rebuilt where the deformation
//! has degraded it.

use std::time::Instant;

use milkglass::error::Result;
use milkglass::internals::layout::BufferId;
use milkglass::internals::pipeline::plan::Change;
use milkglass::internals::session::aov::links;
use milkglass::measure::norms::worst;
use milkglass::measure::reference::verify;
use milkglass::measure::report::{Bench, Page};
use milkglass::measure::statistics::median;
use milkglass::measure::table::Table;
use milkglass::{Goal, Mode, Options, Scene, Session};

use super::Asked;

/// The ball and its motion.
const BALL: [&str; 3] = [
    "object.0.deform=[{ type = 'noise', amplitude = 3, scale = 6, offset = { keyframes = [[0, [0, 0, 0]], [59, [0, 12, 0]]] } }, \
     { type = 'twist', angle = { keyframes = [[0, 0], [40, 240], [59, 0]], curve = 'smooth' } }]",
    "object.0.size=20",
    "camera.size=[64, 64]",
];
/// The measured frames, in order.
const FRAMES: [f64; 7] = [0.0, 10.0, 20.0, 30.0, 40.0, 50.0, 59.0];
/// Each hierarchy, and the detail of the mesh it starts from.
const HIERARCHIES: [(&str, u32); 4] = [("face-clusters", 2), ("median", 2), ("butterfly", 2), ("shrink-wrap", 5)];

/// Means over the frames, except of the error, which is the largest.
#[derive(Default)]
struct Row {
    name: &'static str,
    faces: usize,
    levels: u32,
    tolerance: f64,
    frame_ms: f64,
    host_ms: f64,
    links: f64,
    l2: f64,
    rebuilt: usize,
    start_ms: f64,
}

fn measured((name, detail): (&'static str, u32), tolerance: f64, bench: &Bench<'_>) -> Result<Row> {
    let scene = |frame: f64| {
        let sets = [
            format!("object.0.detail={detail}"),
            format!("transport.hierarchy={name}"),
            "transport.levels=3".into(),
            format!("transport.tolerance={tolerance}"),
        ];
        Scene::load_at("sphere", &[&BALL.map(String::from)[..], &sets].concat(), frame)
    };
    let options = Options { mode: Mode::Keep, goal: Goal::Radiosity, ..Options::default() };
    let start = Instant::now();
    let mut session = Session::new(&scene(FRAMES[0])?, bench.device, options)?;
    let mut row = Row { name, tolerance, start_ms: start.elapsed().as_secs_f64() * 1e3, ..Row::default() };
    session.frame(Change::EVERYTHING)?;
    let count = FRAMES.len() as f64;
    for frame in FRAMES {
        let (next, start) = (scene(frame)?, Instant::now());
        session.show(&next)?;
        row.host_ms += start.elapsed().as_secs_f64() * 1e3 / count;
        row.rebuilt += usize::from(session.prepared().spoilt[0].is_some());
        session.frame(Change::EVERYTHING)?;
        let mut times = Vec::new();
        for _ in 0..5 {
            times.push(session.frame(Change::EVERYTHING)?.iter().map(|part| part.milliseconds).sum());
        }
        row.frame_ms += median(times) / count;
        session.fetch(&[BufferId::runs, BufferId::spans])?;
        let lists = links(session.state());
        row.links += lists.iter().map(|&links| f64::from(links)).sum::<f64>() / (lists.len() as f64 * count);
        row.l2 = row.l2.max(worst(&verify(&mut session, 500, 1)?).l2);
    }
    (row.faces, row.levels) = (session.state().data.triangles.len(), session.prepared().trees[0].depth());
    Ok(row)
}

/// Each hierarchy at two tolerances.
pub fn hierarchies(_: &Asked, bench: &Bench<'_>, page: &mut Page) -> Result<()> {
    let mut rows = Vec::new();
    for tolerance in [1e-2, 1e-3] {
        for hierarchy in HIERARCHIES {
            rows.push(measured(hierarchy, tolerance, bench)?);
        }
    }
    page.small_table(&Table::of(
        &rows,
        &[
            ("hierarchy", "", &|row| row.name.into()),
            ("triangles", "", &|row| row.faces.to_string()),
            ("levels", "", &|row| row.levels.to_string()),
            ("asked", "", &|row| format!("{:.0e}", row.tolerance)),
            ("frame ms", "", &|row| format!("{:.1}", row.frame_ms)),
            ("host ms", "", &|row| format!("{:.1}", row.host_ms)),
            ("links/rec", "", &|row| format!("{:.0}", row.links)),
            ("L2", "", &|row| format!("{:.1e}", row.l2)),
            ("rebuilt", "", &|row| row.rebuilt.to_string()),
            ("start ms", "", &|row| format!("{:.0}", row.start_ms)),
        ],
    ));
    Ok(())
}
