//! The methods that are compared: a table, and one function per method that opens it at a setting.

use std::sync::{Mutex, PoisonError};
use std::time::Instant;

use super::frames::{Frames, diffusion, diffusion_kept};
use super::{Equation, Leaves, Lighting};
use crate::error::Result;
use crate::gpu::Device;
use crate::pipeline::plan::{Change, Goal, Mode, Options, ShadingMethod};
use crate::scene::{ClusterForm, Distance, Hierarchy, Light, Scene, Scheme};

/// The problem, and where it is solved.
#[derive(Clone, Copy)]
pub struct Bench<'a> {
    /// The scene.
    pub scene: &'a Scene,
    /// The device; `None` for the CPU.
    pub device: Option<&'a Device>,
}

/// A transport method, and the setting that trades its error for time.
#[derive(Clone, Debug)]
pub struct Method {
    /// Its name, as `--methods` takes it.
    pub name: &'static str,
    /// A description in one sentence.
    pub about: &'static str,
    /// The name of its setting; empty where it has none.
    pub parameter: &'static str,
    /// The setting's values, from coarse to fine; a single unused value if it has none.
    pub values: &'static [f64],
    /// The equation that it solves.
    pub equation: Equation,
    /// How it sums over single triangles.
    pub leaves: Leaves,
    /// Opens the method at a setting.
    pub open: fn(&Bench<'_>, Lighting, f64) -> Result<Opened>,
    /// Predicts the seconds of a frame, for methods of which even the first frame may take too long.
    pub foretell: Option<fn(&Bench<'_>, Lighting) -> Result<f64>>,
}

impl Method {
    /// The same method, run by other kernels, as its name says; methods are few, and live as long as the program.
    pub(super) fn called(&self, how: &str) -> &'static Self {
        static KNOWN: Mutex<Vec<&'static Method>> = Mutex::new(Vec::new());
        let name = format!("{}, {how}", self.name);
        let mut known = KNOWN.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(method) = known.iter().find(|method| method.name == name) {
            return method;
        }
        known.push(Box::leak(Box::new(Self { name: name.leak(), ..self.clone() })));
        known[known.len() - 1]
    }
}

/// A method at a setting, after its first frame as warm-up; or the reason why it is not offered.
pub enum Opened {
    /// Ready to be timed.
    Ready(Box<dyn Solver>),
    /// Not offered for this scene or lighting, with the reason.
    NotOffered(String),
}

/// An opened method.
pub trait Solver {
    /// Work before a frame that is not timed.
    fn before(&mut self) -> Result<()> {
        Ok(())
    }
    /// Runs the work of one frame for its lighting; returns milliseconds by the device's clock, if there are any.
    fn frame(&mut self) -> Result<Option<f64>>;
    /// The last frame's radiosity of every triangle of the mesh, in the scene's units.
    fn radiosity(&mut self) -> Result<Vec<[f64; 3]>>;
    /// Links summed by the last frame, per face, if the method has links. For blocks, the mean number of list entries
    /// per face; an entry that is expanded once for a whole block is shared among its faces.
    fn links_per_face(&mut self) -> Result<Option<f64>>;
    /// Replaces the lights, for the next frame.
    fn light(&mut self, lights: &[Light]) -> Result<()>;
}

/// All methods; ratios refer to the first.
pub static METHODS: &[Method] = &[
    Method {
        name: "blocks",
        about: "emitters with moments to blocks of receivers; a resting light keeps the lists",
        parameter: "tolerance",
        values: &[1e-1, 3e-2, 1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 1e-5],
        equation: Equation::Dipole,
        leaves: Leaves::Exact,
        open: blocks,
        foretell: None,
    },
    Method {
        name: "blocks-kept",
        about: "the same, with lists that hold for any light and are kept while it changes: for a shape at rest",
        parameter: "tolerance",
        values: &[1e-1, 3e-2, 1e-2, 3e-3, 1e-3, 3e-4, 1e-4, 1e-5],
        equation: Equation::Dipole,
        leaves: Leaves::Exact,
        open: blocks_kept,
        foretell: None,
    },
    Method {
        name: "links",
        about: "Mertens et al. 2003; a new light rebuilds everything, a resting one keeps links and form factors",
        parameter: "angle",
        values: ANGLES,
        equation: Equation::Dipole,
        leaves: Leaves::Exact,
        open: links,
        foretell: None,
    },
    Method {
        name: "links-sample",
        about: "the same, with one sample for every cluster, however near",
        parameter: "angle",
        values: ANGLES,
        equation: Equation::Dipole,
        leaves: Leaves::Exact,
        open: links_sample,
        foretell: None,
    },
    Method {
        name: "links-kept",
        about: "links, kept with their form factors under a new light, too: for a shape at rest",
        parameter: "angle",
        values: ANGLES,
        equation: Equation::Dipole,
        leaves: Leaves::Exact,
        open: links_kept,
        foretell: None,
    },
    Method {
        name: "octree",
        about: "the irradiance octree of Jensen and Buhler 2002 on the host's cores; a resting light keeps the tree",
        parameter: "angle",
        values: &[0.8, 0.4, 0.2, 0.1, 0.05, 0.02, 0.01],
        equation: Equation::Dipole,
        leaves: Leaves::Midpoint,
        open: octree,
        foretell: None,
    },
    Method {
        name: "brute",
        about: "every face to every face, one sample or the edge form",
        parameter: "",
        values: &[0.0],
        equation: Equation::Dipole,
        leaves: Leaves::Exact,
        open: brute,
        foretell: Some(brute_seconds),
    },
    Method {
        name: "diffusion",
        about: "the diffusion equation on the object's own surface; lists are kept, the solver starts from 0",
        parameter: "tolerance",
        values: DIFFUSION,
        equation: Equation::Diffusion,
        leaves: Leaves::Exact,
        open: diffusion,
        foretell: None,
    },
    Method {
        name: "diffusion-kept",
        about: "the same, from the last frame's solution while the lights turn by three degrees a frame",
        parameter: "tolerance",
        values: DIFFUSION,
        equation: Equation::Diffusion,
        leaves: Leaves::Exact,
        open: diffusion_kept,
        foretell: None,
    },
];

/// Tolerances of diffusion.
const DIFFUSION: &[f64] = &[1e-1, 3e-2, 1e-2, 3e-3, 1e-3, 1e-4];

/// Values for both epsilon_1 and epsilon_2 of section 5.2, steradian.
const ANGLES: &[f64] = &[0.2, 0.1, 0.05, 0.03, 0.02];

/// The change before each frame under this lighting.
pub(super) fn change(lighting: Lighting) -> Change {
    match lighting {
        Lighting::Moves => Change::LIGHT,
        Lighting::Rests => Change::RESUM,
    }
}

fn blocks(bench: &Bench<'_>, lighting: Lighting, tolerance: f64) -> Result<Opened> {
    blocks_in(bench, Mode::Keep, lighting, tolerance)
}

fn blocks_kept(bench: &Bench<'_>, lighting: Lighting, tolerance: f64) -> Result<Opened> {
    if lighting == Lighting::Rests {
        return Ok(Opened::NotOffered("blocks are faster where the light rests".into()));
    }
    blocks_in(bench, Mode::Render, lighting, tolerance)
}

fn blocks_in(bench: &Bench<'_>, mode: Mode, lighting: Lighting, tolerance: f64) -> Result<Opened> {
    if bench.scene.transport.distance != Distance::Radial {
        return Ok(Opened::NotOffered("moments work with radial distances only".into()));
    }
    let mut scene = bench.scene.clone();
    (scene.transport.scheme, scene.transport.hierarchy) = (Scheme::Blocks, Hierarchy::Median);
    scene.transport.tolerance = tolerance;
    let options = Options { transport: ShadingMethod::Hierarchy, mode, goal: Goal::Radiosity, estimate: false };
    Frames::open(&scene, bench.device, options, change(lighting))
}

/// The scene with the scheme as published, face clusters, and both solid angles at this value.
fn at_angle(scene: &Scene, angle: f64) -> Scene {
    let mut scene = scene.clone();
    (scene.transport.scheme, scene.transport.hierarchy) = (Scheme::Links, Hierarchy::FaceClusters);
    (scene.transport.receiver_angle, scene.transport.emitter_angle) = (angle, angle);
    scene
}

fn links(bench: &Bench<'_>, lighting: Lighting, angle: f64) -> Result<Opened> {
    links_of(&at_angle(bench.scene, angle), bench.device, lighting)
}

fn links_sample(bench: &Bench<'_>, lighting: Lighting, angle: f64) -> Result<Opened> {
    let mut scene = at_angle(bench.scene, angle);
    scene.transport.cluster = Some(ClusterForm::Sample);
    links_of(&scene, bench.device, lighting)
}

fn links_of(scene: &Scene, device: Option<&Device>, lighting: Lighting) -> Result<Opened> {
    let mode = match lighting {
        Lighting::Moves => Mode::OnTheFly,
        Lighting::Rests => Mode::Keep,
    };
    let options = Options { transport: ShadingMethod::Hierarchy, mode, goal: Goal::Radiosity, estimate: false };
    Frames::open(scene, device, options, change(lighting))
}

fn links_kept(bench: &Bench<'_>, lighting: Lighting, angle: f64) -> Result<Opened> {
    if lighting == Lighting::Rests {
        return Ok(Opened::NotOffered("the same as links".into()));
    }
    let options =
        Options { transport: ShadingMethod::Hierarchy, mode: Mode::Render, goal: Goal::Radiosity, estimate: false };
    Frames::open(&at_angle(bench.scene, angle), bench.device, options, Change::LIGHT)
}

/// Irradiance is computed on the device, if there is one; the octree runs on the host.
fn octree(bench: &Bench<'_>, lighting: Lighting, angle: f64) -> Result<Opened> {
    if bench.scene.transport.distance != Distance::Radial {
        return Ok(Opened::NotOffered("the octree works with radial distances only".into()));
    }
    let mut scene = bench.scene.clone();
    scene.transport.octree_angle = angle;
    let options =
        Options { transport: ShadingMethod::Octree, mode: Mode::Render, goal: Goal::Radiosity, estimate: false };
    Frames::open(&scene, bench.device, options, change(lighting))
}

/// Brute force: every face to every face.
pub(super) fn brute(bench: &Bench<'_>, lighting: Lighting, _: f64) -> Result<Opened> {
    let options =
        Options { transport: ShadingMethod::Brute, mode: Mode::OnTheFly, goal: Goal::Radiosity, estimate: false };
    Frames::open(bench.scene, bench.device, options, change(lighting))
}

/// Maximum number of faces of the thinned mesh from which brute force's time is extrapolated.
const THINNED: usize = 2048;

/// Times brute force on every n-th face of the mesh and scales the time by the number of pairs; 0 for small meshes.
fn brute_seconds(bench: &Bench<'_>, lighting: Lighting) -> Result<f64> {
    let mut scene = bench.scene.clone();
    let mesh = &mut scene.objects[0].mesh;
    let all = mesh.triangles.len();
    let step = all.div_ceil(THINNED);
    if step <= 2 {
        return Ok(0.0);
    }
    mesh.triangles = mesh.triangles.iter().copied().step_by(step).collect();
    mesh.input_face = mesh.input_face.iter().copied().step_by(step).collect();
    mesh.splits.clear();
    let pairs = (all as f64 / mesh.triangles.len() as f64).powi(2);
    let Opened::Ready(mut solver) = brute(&Bench { scene: &scene, ..*bench }, lighting, 0.0)? else {
        return Ok(0.0);
    };
    let start = Instant::now();
    solver.frame()?;
    Ok(start.elapsed().as_secs_f64() * pairs)
}
