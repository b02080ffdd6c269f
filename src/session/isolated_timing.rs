//! Runs a frame whose steps are submitted one by one and timed by the host's clock, and lists the dispatches of a
//! frame.

use std::time::Instant;

use super::run::Session;
use crate::error::Result;
use crate::gpu::{Kernels, Timing};
use crate::layout::BUFFER_IDS;
use crate::pipeline::frame::precedes_transport;
use crate::pipeline::plan::{Change, Changes};
use crate::state::{Dispatch, Width, dispatches};

impl Session {
    /// Runs the stages before transport on the CPU reference, whatever the session's back end.
    pub fn prepare_light(&mut self) {
        let steps = self.plan.steps(&self.prepared.state, Change::EVERYTHING);
        let early = steps.iter().filter(|step| precedes_transport(step.stage));
        early.for_each(|step| step.reference(&mut self.prepared.state));
    }

    /// Runs the steps of a frame after this change, waiting for each, so that the host's clock times it. Requires a
    /// whole frame before, which gives the lists their capacity. Leaves out the octree.
    pub fn apart(&mut self, changes: impl Into<Changes>) -> Result<Vec<Timing>> {
        let (begin, mut times) = (Instant::now(), Vec::new());
        for step in self.steps_taken(changes) {
            let start = begin.elapsed().as_secs_f64() * 1e3;
            self.run(&[step])?;
            let milliseconds = begin.elapsed().as_secs_f64() * 1e3 - start;
            times.push(Timing { name: step.stage.name.to_string(), milliseconds, start, ..Timing::default() });
        }
        Ok(times)
    }

    /// Runs the steps of a frame after this change as [`Self::apart`] does, those of one stage in these rounds, by the
    /// session's kernels and `others` in turn: see [`DeviceState::alternate`]. Returns the times of each run, one for
    /// each step; none where the stage does not run, or runs on the host.
    ///
    /// [`DeviceState::alternate`]: crate::state::DeviceState::alternate
    pub fn alternate(
        &mut self,
        changes: impl Into<Changes>,
        stage: &str,
        others: &mut Kernels,
        rounds: &[[bool; 2]],
    ) -> Result<Vec<Vec<Timing>>> {
        let mut runs = vec![Vec::new(); 2 * rounds.len()];
        let steps = self.steps_taken(changes);
        for part in steps.chunk_by(|one, next| (one.stage.name == stage) == (next.stage.name == stage)) {
            let Some(gpu) = self.gpu.as_mut().filter(|_| part[0].stage.name == stage) else {
                self.run(part)?;
                continue;
            };
            for step in part {
                let times = gpu.alternate(&self.prepared.state, *step, others, rounds)?;
                runs.iter_mut().zip(times).for_each(|(run, time)| run.push(time));
            }
        }
        Ok(runs)
    }

    /// The dispatches of a frame after this change; on the CPU, those of a GPU.
    pub fn dispatches(&self, changes: impl Into<Changes>) -> Result<Vec<Dispatch>> {
        let width = self.gpu.as_ref().map_or(Width::GPU, |gpu| Width::of(gpu.device()));
        dispatches(self.state(), &self.steps_taken(changes), width)
    }

    /// Bytes of all buffers of the state.
    pub fn bytes(&self) -> u64 {
        BUFFER_IDS.iter().map(|&id| self.state().data.bytes(id).len() as u64).sum()
    }
}
