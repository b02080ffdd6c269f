//! The methods that are compared: a table, and one function for each that opens it at a setting.

use std::time::Instant;

use super::{Leaves, Lighting};
use crate::error::{Error, Result};
use crate::gpu::Device;
use crate::layout::Slot;
use crate::render::plan::{Change, Goal, Mode, Options, Transport};
use crate::render::room::KEEPING;
use crate::render::run::{Backend, Room, Session};
use crate::scene::Scene;

/// What is solved, and where.
#[derive(Clone, Copy)]
pub struct Bench<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The device; none is the CPU.
    pub device: Option<&'a Device>,
}

/// A way to get from light that enters to light that leaves, and the setting that trades its error for time.
#[derive(Debug)]
pub struct Method {
    /// Its name, as `--methods` takes it.
    pub name: &'static str,
    /// What it does, in one sentence.
    pub about: &'static str,
    /// The name of its setting; empty where it has none.
    pub parameter: &'static str,
    /// The setting's values, from coarse to fine; one value of no meaning where it has none.
    pub values: &'static [f64],
    /// What it sums over single triangles.
    pub leaves: Leaves,
    /// Opens it at a setting.
    pub open: fn(&Bench<'_>, Lighting, f64) -> Result<Opened>,
    /// Foretells the seconds of a frame, where even the first may take too long to be tried.
    pub foretell: Option<fn(&Bench<'_>, Lighting) -> Result<f64>>,
}

/// A method at a setting, after its first frame, which warms everything up; or why there is none.
pub enum Opened {
    /// Ready to be timed.
    Ready(Box<dyn Solver>),
    /// This lighting is not for it.
    NotOffered(String),
}

/// A method at work.
pub trait Solver {
    /// Runs what one frame of its lighting has to run; returns the milliseconds by the device's own clock, if any.
    fn frame(&mut self) -> Result<Option<f64>>;
    /// The last frame's radiosity of every triangle of the mesh, in the scene's units.
    fn radiosity(&mut self) -> Result<Vec<[f64; 3]>>;
    /// Links that the last frame summed, per face, if it has links.
    fn links_per_face(&mut self) -> Result<Option<f64>>;
}

/// Every method, the one that ratios are taken to first.
pub static METHODS: &[Method] = &[
    Method {
        name: "links",
        about: "Mertens et al. 2003; a new light builds everything anew, a resting one keeps links and form factors",
        parameter: "angle",
        values: ANGLES,
        leaves: Leaves::Exact,
        open: links,
        foretell: None,
    },
    Method {
        name: "links-kept",
        about: "the same, links and form factors kept under a new light, too: for a shape at rest",
        parameter: "angle",
        values: ANGLES,
        leaves: Leaves::Exact,
        open: links_kept,
        foretell: None,
    },
    Method {
        name: "brute",
        about: "every face to every face, one sample or the edge form",
        parameter: "",
        values: &[0.0],
        leaves: Leaves::Exact,
        open: brute,
        foretell: Some(brute_seconds),
    },
];

/// epsilon_1 and epsilon_2 of section 5.2, both at once, steradian.
const ANGLES: &[f64] = &[0.2, 0.1, 0.05, 0.03, 0.02];

fn at_angle(scene: &Scene, angle: f64) -> Scene {
    let mut scene = scene.clone();
    (scene.transport.receiver_angle, scene.transport.emitter_angle) = (angle, angle);
    scene
}

fn links(bench: &Bench<'_>, lighting: Lighting, angle: f64) -> Result<Opened> {
    let (mode, change) = match lighting {
        Lighting::Moves => (Mode::OnTheFly, Change::LIGHT),
        Lighting::Rests => (Mode::Render, Change::RESUM),
    };
    let options = Options { transport: Transport::Hierarchy, mode, goal: Goal::Radiosity, estimate: false };
    Frames::open(&at_angle(bench.scene, angle), bench.device, options, change)
}

fn links_kept(bench: &Bench<'_>, lighting: Lighting, angle: f64) -> Result<Opened> {
    if lighting == Lighting::Rests {
        return Ok(Opened::NotOffered("the same as links".into()));
    }
    let options =
        Options { transport: Transport::Hierarchy, mode: Mode::Render, goal: Goal::Radiosity, estimate: false };
    Frames::open(&at_angle(bench.scene, angle), bench.device, options, Change::LIGHT)
}

/// Every face to every face.
pub(super) fn brute(bench: &Bench<'_>, lighting: Lighting, _: f64) -> Result<Opened> {
    let change = match lighting {
        Lighting::Moves => Change::LIGHT,
        Lighting::Rests => Change::RESUM,
    };
    let options = Options { transport: Transport::Brute, mode: Mode::OnTheFly, goal: Goal::Radiosity, estimate: false };
    Frames::open(bench.scene, bench.device, options, change)
}

/// Faces of the thinned mesh that tells how fast pairs of faces go.
const THINNED: usize = 2048;

/// Every so-and-so-many-th face of the mesh by brute force, and from there by the number of pairs.
fn brute_seconds(bench: &Bench<'_>, lighting: Lighting) -> Result<f64> {
    let mut scene = bench.scene.clone();
    let mesh = &mut scene.object.mesh;
    let all = mesh.triangles.len();
    let step = all.div_ceil(THINNED);
    if step <= 2 {
        return Ok(0.0);
    }
    mesh.triangles = mesh.triangles.iter().copied().step_by(step).collect();
    mesh.input_face = mesh.input_face.iter().copied().step_by(step).collect();
    let pairs = (all as f64 / mesh.triangles.len() as f64).powi(2);
    let Opened::Ready(mut solver) = brute(&Bench { scene: &scene, ..*bench }, lighting, 0.0)? else {
        return Ok(0.0);
    };
    let start = Instant::now();
    solver.frame()?;
    Ok(start.elapsed().as_secs_f64() * pairs)
}

/// A session, and what changes before each frame.
struct Frames {
    session: Session,
    change: Change,
}

impl Frames {
    fn open(scene: &Scene, device: Option<&Device>, options: Options, change: Change) -> Result<Opened> {
        let mut session = Session::new(scene, device, options, Room::default())?;
        match session.frame(Change::EVERYTHING) {
            Ok(_) => Ok(Opened::Ready(Box::new(Self { session, change }))),
            Err(Error::Device { doing, what }) if doing == KEEPING => {
                Ok(Opened::NotOffered(format!("too many links to keep: {what}")))
            }
            Err(error) => Err(error),
        }
    }
}

impl Solver for Frames {
    fn frame(&mut self) -> Result<Option<f64>> {
        let milliseconds = self.session.frame(self.change)?.iter().map(|part| part.milliseconds).sum::<f64>();
        let timed = matches!(self.session.backend, Backend::Gpu(_)) && milliseconds.is_finite();
        Ok(timed.then_some(milliseconds))
    }

    fn radiosity(&mut self) -> Result<Vec<[f64; 3]>> {
        self.session.fetch(&[Slot::radiosity])?;
        let light = self.session.units().light;
        let mut values = vec![[0.0; 3]; self.session.prepared.faces.len()];
        for (&face, &value) in self.session.prepared.faces.iter().zip(&self.session.state().data.radiosity) {
            values[face as usize] = value.map(|x| f64::from(x) * light);
        }
        Ok(values)
    }

    fn links_per_face(&mut self) -> Result<Option<f64>> {
        if self.session.plan.options().transport != Transport::Hierarchy {
            return Ok(None);
        }
        self.session.fetch(&[Slot::spans])?;
        let data = &self.session.state().data;
        let links: u64 = data.spans.iter().map(|span| u64::from(span.links)).sum();
        Ok(Some(links as f64 / data.triangles.len() as f64))
    }
}
