//! Cost of each mode after each kind of change, compared with a frame from scratch by the same scheme: time, links,
//! form factors, error.

use std::time::Instant;

use glam::{DQuat, DVec3};

use crate::error::Result;
use crate::gpu::Device;
use crate::layout::BufferId;
use crate::measure::norms::worst;
use crate::measure::reference::verify;
use crate::measure::table::Table;
use crate::pipeline::plan::{Change, Goal, Mode, Options};
use crate::scene::{Deform, Scene, Scheme};
use crate::session::run::Session;
use crate::transport::blocks::gather;
use crate::transport::links::form_factor;

/// What changes between frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum What {
    /// Every vertex moves.
    Shape,
    /// A bump on 1 % of the triangles rises.
    Bump,
    /// The coefficients of the first object's material change.
    Material,
    /// The first object turns by a degree.
    Motion,
    /// The light changes.
    Light,
    /// Nothing changes.
    Nothing,
}

/// All changes, in the order of the table.
pub const CHANGES: [What; 6] = [What::Shape, What::Bump, What::Motion, What::Material, What::Light, What::Nothing];
/// The share of triangles that the bump moves.
pub const LOCAL: f64 = 0.01;
/// The modes and their names in `--mode`.
pub const MODES: [(&str, Mode); 3] =
    [("on-the-fly", Mode::OnTheFly), ("render", Mode::Render), ("incremental", Mode::Incremental)];

/// One row of the table.
#[derive(Clone, Debug)]
pub struct Row {
    /// The scene's name and its number of triangles.
    pub scene: (String, usize),
    /// The scheme: `blocks` or `links`.
    pub scheme: &'static str,
    /// The mode, as `--mode` names it.
    pub mode: &'static str,
    /// The change.
    pub change: &'static str,
    /// Median time of the stages of a frame after the change, milliseconds.
    pub milliseconds: f64,
    /// Median time of the change and the frame by the host's clock, milliseconds.
    pub wall: f64,
    /// `milliseconds` over that of the scheme's first measured row: on-the-fly after a change of shape, unless filtered
    /// out.
    pub ratio: f64,
    /// `wall` over that of the same row.
    pub wall_ratio: f64,
    /// Entries of all lists.
    pub links: u64,
    /// Form factors computed by the last of these frames; blocks evaluate every entry on each gather.
    pub factors: u64,
    /// L2 error of the last frame's radiosity against the area integral, worst channel.
    pub error: f64,
}

impl Row {
    /// A table with a line for each row.
    #[must_use]
    pub fn table(rows: &[Self]) -> Table {
        // An empty sum of floats is -0.
        let ms = |ms: f64| format!("{:.1} ms", ms + 0.0);
        Table::of(
            rows,
            &[
                ("scene", "", &|row| format!("{}, {} triangles", row.scene.0, row.scene.1)),
                ("scheme", "how clusters are linked: ours (blocks), or as published (links)", &|row| row.scheme.into()),
                ("mode", "what is kept from frame to frame", &|row| row.mode.into()),
                ("change", "what changes before each frame", &|row| row.change.into()),
                ("time", "median time of a frame's stages", &|row| ms(row.milliseconds)),
                (
                    "of scratch",
                    "that time over the one of a frame on the fly in which every vertex has moved",
                    &|row| format!("{:.2}", row.ratio),
                ),
                ("wall", "median time of the edit and the frame by the host's clock", &|row| ms(row.wall)),
                ("wall of scratch", "the same ratio of wall times", &|row| format!("{:.2}", row.wall_ratio)),
                ("links", "entries of all lists", &|row| row.links.to_string()),
                ("form factors", "form factors that the last frame computed", &|row| row.factors.to_string()),
                ("L2", "relative L2 error of the radiosity, worst channel", &|row| format!("{:.1e}", row.error)),
            ],
        )
    }
}

impl What {
    /// The name in the table.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Shape => "shape",
            Self::Bump => "bump",
            Self::Material => "material",
            Self::Motion => "motion",
            Self::Light => "light",
            Self::Nothing => "nothing",
        }
    }
}

/// The scene at frame `step`: its first object with noise and a bump, of which this change moves one; or turned
/// by a degree a step; or with a material of 1 % more absorption a step.
#[must_use]
pub fn moved(scene: &Scene, what: What, step: usize) -> Scene {
    let mut moved = scene.clone();
    let Some(object) = moved.objects.first_mut() else { return moved };
    let mesh = &object.mesh;
    let extent = |p: &DVec3| p.abs().max_element();
    let size = mesh.positions.iter().map(extent).fold(0.0, f64::max);
    let middle = mesh.triangles.first().map_or(DVec3::ZERO, |t| mesh.positions[t[0] as usize]);
    let away = |triangle: &[u32; 3]| {
        triangle.iter().map(|&v| mesh.positions[v as usize].distance(middle)).fold(f64::INFINITY, f64::min)
    };
    let mut distances: Vec<f64> = mesh.triangles.iter().map(away).collect();
    distances.sort_by(f64::total_cmp);
    let within = (LOCAL * distances.len() as f64) as usize;
    let radius = distances.get(within).copied().unwrap_or(size).max(1e-6 * size);
    let steps = |own: What| if what == own { step as f64 } else { 0.0 };
    let height = 0.1 * radius * (1.0 + 0.1 * steps(What::Bump));
    let offset = DVec3::new(0.0, 0.01 * size * steps(What::Shape), 0.0);
    if what == What::Motion {
        object.rotation = DQuat::from_rotation_y((step as f64).to_radians()) * object.rotation;
        return moved;
    }
    object.material.sigma_a = object.material.sigma_a.map(|sigma| sigma * (1.0 + 0.01 * steps(What::Material)));
    object.deforms.push(Deform::Noise { amplitude: 0.01 * size, scale: 0.5 * size, offset });
    object.deforms.push(Deform::Bump { position: middle, radius, height, direction: None });
    moved
}

/// Once three frames are timed, timing stops after this many seconds.
const ENOUGH: f64 = 5.0;

/// Measures one scene on a device or the CPU, over `frames` frames per row, fewer if they are slow: both schemes,
/// every mode, every change. `only` keeps the rows whose scheme, mode and change include all of its words. The ratios
/// of a scheme refer to its first row.
pub fn rows(device: Option<&Device>, scene: &Scene, frames: usize, only: &str) -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    for (scheme, called) in [(Scheme::Blocks, "blocks"), (Scheme::Links, "links")] {
        let mut scene = scene.clone();
        scene.transport.scheme = scheme;
        let mut scratch = None;
        for (mode, kind) in MODES {
            for what in CHANGES {
                if !only.split_whitespace().all(|word| [called, mode, what.name()].contains(&word)) {
                    continue;
                }
                let mut row = measure(device, &scene, (kind, what), frames)?;
                let [stages, wall] = *scratch.get_or_insert([row.milliseconds, row.wall]);
                (row.scheme, row.mode) = (called, mode);
                (row.ratio, row.wall_ratio) = (row.milliseconds / stages, row.wall / wall);
                rows.push(row);
            }
        }
    }
    Ok(rows)
}

/// One row; the caller fills in scheme, mode and ratio.
fn measure(device: Option<&Device>, scene: &Scene, (mode, what): (Mode, What), frames: usize) -> Result<Row> {
    let options = Options { mode, goal: Goal::Radiosity, ..Options::default() };
    let mut session = Session::new(&moved(scene, what, 0), device, options)?;
    session.frame(Change::EVERYTHING)?;
    let (start, mut times, mut walls, mut names) = (Instant::now(), Vec::new(), Vec::new(), Vec::new());
    for step in 1..=frames {
        if step > 3 && start.elapsed().as_secs_f64() > ENOUGH {
            break;
        }
        let scene = moved(scene, what, step);
        let begin = Instant::now();
        session.show(&scene)?;
        // Lighting is evaluated again although the light is the same; a new light costs as much.
        let change = if what == What::Light { Change::LIGHT } else { Change::default() };
        let parts = session.frame(change)?;
        walls.push(begin.elapsed().as_secs_f64() * 1e3);
        times.push(parts.iter().fold(0.0, |sum, part| sum + part.milliseconds));
        names = parts.into_iter().map(|part| part.name).collect();
    }
    let links = links(&mut session, &moved(scene, what, times.len()), device)?;
    times.sort_by(f64::total_cmp);
    walls.sort_by(f64::total_cmp);
    let all = [&gather::STAGE, &form_factor::STAGE].iter().any(|stage| names.iter().any(|name| name == stage.name));
    let factors = if all { links } else { session.renewed() };
    let error = worst(&verify(&mut session, 500, 1)?).l2;
    let triangles = session.state().sum(|object| object.count.faces);
    Ok(Row {
        scene: (scene.name.clone(), triangles),
        scheme: "",
        mode: "",
        change: what.name(),
        milliseconds: times[times.len() / 2],
        wall: walls[walls.len() / 2],
        ratio: 1.0,
        wall_ratio: 1.0,
        links,
        factors,
        error,
    })
}

/// Entries of all lists after a frame. On-the-fly lists are overwritten part by part, so they are counted in a
/// session in mode `keep`, whose lists are the same.
fn links(session: &mut Session, scene: &Scene, device: Option<&Device>) -> Result<u64> {
    let options = session.plan().options();
    if options.mode == Mode::OnTheFly {
        let mut kept = Session::new(scene, device, Options { mode: Mode::Keep, ..options })?;
        kept.frame(Change::EVERYTHING)?;
        return links(&mut kept, scene, device);
    }
    session.fetch(&[BufferId::runs, BufferId::spans])?;
    let (state, data) = (session.state(), &session.state().data);
    let entries = state.runs().map(|run| u64::from(run.expanded + run.direct + run.area + run.edge));
    Ok(entries.sum::<u64>() + data.spans.iter().map(|span| u64::from(span.links)).sum::<u64>())
}
