//! The program's own transport methods as solvers: a session, frame after frame.

use super::{Opened, Solver};
use crate::error::{Error, Result};
use crate::gpu::Device;
use crate::layout::BufferId;
use crate::pipeline::plan::{Change, Options, ShadingMethod};
use crate::scene::{Light, Scene, Scheme};
use crate::session::run::Session;
use crate::state::State;

/// A session, and the change before each frame.
pub(super) struct Frames {
    session: Session,
    change: Change,
}

impl Frames {
    /// Opens a session and runs its first frame; `change` applies to every later one.
    pub(super) fn open(scene: &Scene, device: Option<&Device>, options: Options, change: Change) -> Result<Opened> {
        let mut session = Session::new(scene, device, options)?;
        match session.frame(Change::EVERYTHING) {
            Err(Error::TooMuchToKeep { what, .. }) => Ok(Opened::NotOffered(format!("too much to keep: {what}"))),
            Err(error) => Err(error),
            Ok(_) => Ok(match session.not_kept() {
                Some(why) => Opened::NotOffered(format!("too much to keep: {why}")),
                None => Opened::Ready(Box::new(Self { session, change })),
            }),
        }
    }
}

impl Solver for Frames {
    fn frame(&mut self) -> Result<Option<f64>> {
        let milliseconds = self.session.frame(self.change)?.iter().map(|part| part.milliseconds).sum::<f64>();
        let on_device =
            self.session.device().is_some() && self.session.plan().options().transport != ShadingMethod::Octree;
        let timed = on_device && milliseconds.is_finite();
        Ok(timed.then_some(milliseconds))
    }

    fn light(&mut self, lights: &[Light]) -> Result<()> {
        self.session.set_lights(lights)
    }

    fn radiosity(&mut self) -> Result<Vec<[f64; 3]>> {
        self.session.fetch(&[BufferId::radiosity])?;
        let light = self.session.units().light;
        let radiosity = &self.session.state().data.radiosity;
        let places = self.session.prepared().all_places();
        Ok(places.map(|place| radiosity[place].map(|x| f64::from(x) * light)).collect())
    }

    fn links_per_face(&mut self) -> Result<Option<f64>> {
        if !matches!(self.session.plan().options().transport, ShadingMethod::Hierarchy | ShadingMethod::Diffusion) {
            return Ok(None);
        }
        self.session.fetch(&[BufferId::spans, BufferId::runs])?;
        let state = self.session.state();
        let links: u64 = match state.method.scheme {
            Scheme::Blocks => entries(state),
            Scheme::Links => state.data.spans.iter().map(|span| u64::from(span.links)).sum(),
        };
        Ok(Some(links as f64 / state.sum(|object| object.count.faces) as f64))
    }
}

/// Entries of the kept lists of all blocks: expanded entries count once, the others once per face of the block. Each
/// group of channels has its own lists, all of which count.
fn entries(state: &State) -> u64 {
    let mut sum = 0;
    for (at, batch) in state.batches() {
        let (first, _) = state.part(BufferId::runs, at);
        let blocks = &state.data.blocks[state.object(at).first.blocks..][batch.start as usize..batch.end as usize];
        for (block, run) in blocks.iter().zip(&state.data.runs[first..]) {
            let each = [run.direct, run.area, run.edge].map(u64::from).iter().sum::<u64>();
            sum += u64::from(run.expanded) + u64::from(block.count) * each;
        }
    }
    sum
}
