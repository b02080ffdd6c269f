//! Runs a plan on the CPU or a device: the steps of a frame, and those again whose lists overflowed, with longer ones.

use std::time::Instant;

pub use super::capacity::CapacityHints;
use super::capacity::Lists;
use super::choice::Choice;
use super::diffusion::SolveReport;
use super::octree::OctreeTransport;
use super::subdivide::Parts;
use super::walk::WalkTransport;
use crate::error::{Error, Result};
use crate::gpu::Timing;
use crate::layout::BufferId;
use crate::pipeline::plan::{Change, Changes, Options, Plan};
use crate::prepare::scene::Prepared;
use crate::scene::Scene;
use crate::state::{DeviceState, Step};

/// Renders a scene frame after frame, on a device or on the CPU.
///
/// ```
/// use milkglass::{Options, Scene, Session};
///
/// let mut scene = Scene::load("slab")?;
/// scene.camera.size = [32, 32];
/// let mut session = Session::new(&scene, None, Options::default())?; // none: on the CPU
/// let before = session.render()?;
///
/// // Another frame with other lights; what does not depend on them is kept.
/// session.set_lights(&[])?;
/// let dark = session.render()?;
/// assert!(before.pixels != dark.pixels);
/// # Ok::<(), milkglass::Error>(())
/// ```
pub struct Session {
    /// The state, its units and the order of its faces.
    pub(crate) prepared: Prepared,
    /// The stages that run.
    pub(crate) plan: Plan,
    /// The device where they run; none where the CPU references run.
    pub(crate) gpu: Option<DeviceState>,
    /// How often a frame was repeated because a list overflowed.
    pub(crate) retries: usize,
    /// How often a frame was repeated because the kept lists did not suit the irradiance ratio of its light.
    pub(crate) relinks: usize,
    /// Whether the shape has changed since the host has deformed the vertices.
    pub(crate) moved: bool,
    /// Whether there are links that a change of shape can update.
    pub(crate) linked: bool,
    /// Form factors computed in this frame by runs whose lists overflowed.
    pub(crate) spent: u64,
    /// Whether the host has refined the last frame's error estimate, or why that failed; none before an attempt.
    pub(crate) sharp: Option<std::result::Result<(), String>>,
    /// How each object's triangles were subdivided; empty if no object's were.
    pub(crate) parts: Vec<Parts>,
    /// Why lists are rebuilt in each frame, if the mode asks to keep them.
    pub(crate) not_kept: Option<String>,
    /// How many of the camera's several samples the mean has; 0 after any other frame.
    pub(crate) samples_done: u32,
    /// How many of the samples so far show an object, for each pixel of a picture with a transparent background.
    pub(crate) coverage: Vec<u8>,
    /// The exposure that metered pictures keep, if one was held.
    pub(crate) held: Option<f64>,
    /// Whether rays do not run through the pixels' centres.
    pub(crate) shifted: bool,
    /// Whether the last frame, or a change before it, failed halfway.
    pub(crate) failed: bool,
    /// The scene, after subdivision.
    pub(crate) scene: Scene,
    /// The lists' partition and capacities.
    pub(crate) lists: Lists,
    /// What has changed since the last frame.
    pub(crate) pending: Changes,
    /// The octree, if it is the transport.
    pub(crate) octree: Option<OctreeTransport>,
    /// The random walk, if it is the transport.
    pub(crate) walk: WalkTransport,
    /// How the systems of diffusion were solved.
    pub(crate) solves: Vec<SolveReport>,
    /// Which objects diffusion serves.
    pub(crate) choice: Choice,
    pub(crate) fixed: Fixed,
}

/// What a session is built from, and rebuilt from when its layout changes.
pub(crate) struct Fixed {
    /// The scene before subdivision, if it was subdivided.
    pub asked: Option<Scene>,
    /// The options, before any that do not fit were changed.
    pub options: Options,
    /// Initial capacities of the lists.
    pub hints: CapacityHints,
    /// The kind of receivers that the plan leaves out, and why.
    pub receivers: (&'static str, String),
}

impl Session {
    /// Runs one frame: the stages that depend on what has changed since the last one, or on `change`. Returns each
    /// step's time: the device's, or the host's for the CPU and the octree.
    ///
    /// Its rays run through the pixels' centres.
    pub fn frame(&mut self, change: Change) -> Result<Vec<Timing>> {
        let frame = self.begin(change)?;
        self.complete(frame)
    }

    /// The same with the rays where they are.
    pub(crate) fn frame_as_it_is(&mut self, changes: impl Into<Changes>) -> Result<Vec<Timing>> {
        let frame = self.begin_as_it_is(changes)?;
        self.complete(frame)
    }

    /// Runs these steps on the session's back end.
    pub(crate) fn run(&mut self, steps: &[Step]) -> Result<Vec<Timing>> {
        let (state, begin) = (&mut self.prepared.state, Instant::now());
        if let Some(gpu) = &mut self.gpu {
            return if steps.is_empty() { Ok(Vec::new()) } else { gpu.run(state, steps) };
        }
        let time = |step: &Step| {
            let start = begin.elapsed().as_secs_f64() * 1e3;
            step.reference(state);
            let milliseconds = begin.elapsed().as_secs_f64() * 1e3 - start;
            Timing { name: step.stage.name.to_string(), milliseconds, start, ..Timing::default() }
        };
        Ok(steps.iter().map(time).collect())
    }

    /// Downloads these buffers to the host, except what the host itself computes: deformed positions, the octree's
    /// radiosity where no object is opaque, and a refined estimate.
    pub fn fetch(&mut self, ids: &[BufferId]) -> Result<()> {
        if ids.contains(&BufferId::positions) {
            self.deform();
        }
        let octree = self.octree.is_some() && !self.state().objects.iter().any(|object| object.opaque);
        let there = |id: &BufferId| match *id {
            BufferId::positions => true,
            BufferId::radiosity => octree,
            BufferId::estimate => self.sharpened(),
            _ => false,
        };
        let ids: Vec<BufferId> = ids.iter().copied().filter(|id| !there(id)).collect();
        self.gpu.as_ref().map_or(Ok(()), |gpu| gpu.download(&mut self.prepared.state, &ids))
    }

    /// Uploads these buffers from the host.
    pub(crate) fn send(&mut self, ids: &[BufferId]) -> Result<()> {
        let sent = self.gpu.as_mut().map_or(Ok(()), |gpu| gpu.upload(&self.prepared.state, ids));
        sent.inspect_err(|_| self.failed = true)
    }
}

/// The error where a driver may have ended a loop early.
pub(super) fn unfinished(doing: &str, advice: &str) -> Error {
    Error::device(doing, format!("it takes more than 65,000 steps, where some drivers end a loop; {advice}"))
}
