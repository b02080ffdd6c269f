//! A frame whose stages are submitted one by one, each timed by the host's clock; and what a session's frame dispatches.

use std::time::Instant;

use super::plan::{Change, before_transport};
use super::run::Session;
use crate::error::Result;
use crate::gpu::Timing;
use crate::layout::SLOTS;
use crate::state::{Dispatch, dispatches};

/// Lanes in lockstep where there is no device to ask.
const SUBGROUP: usize = 32;

impl Session {
    /// Runs the reference's stages up to irradiance on the host, whatever runs the others.
    pub fn prepare_light(&mut self) {
        let steps = self.plan.steps(&self.prepared.state, Change::EVERYTHING);
        let early = steps.iter().filter(|step| before_transport(step.stage.name));
        early.for_each(|step| step.reference(&mut self.prepared.state));
    }

    /// Runs the steps of a frame after this change, each submitted and waited for by itself, so that the host's clock can
    /// tell them apart; after a whole frame only, when the lists have their room. The octree takes no part.
    pub fn apart(&mut self, change: Change) -> Result<Vec<Timing>> {
        let (begin, mut times) = (Instant::now(), Vec::new());
        for step in self.plan.steps(&self.prepared.state, change) {
            let start = begin.elapsed().as_secs_f64() * 1e3;
            self.run(&[step])?;
            let milliseconds = begin.elapsed().as_secs_f64() * 1e3 - start;
            times.push(Timing { name: step.stage.name.to_string(), milliseconds, start });
        }
        Ok(times)
    }

    /// What a frame after this change dispatches, or would on a device of 32 lanes where there is none.
    pub fn dispatches(&self, change: Change) -> Result<Vec<Dispatch>> {
        let lanes = self.limits().map_or(SUBGROUP, |limits| limits.subgroup_size.max(1) as usize);
        dispatches(self.state(), &self.plan.steps(self.state(), change), lanes)
    }

    /// Bytes of all buffers of the state.
    pub fn bytes(&self) -> u64 {
        SLOTS.iter().map(|&slot| self.state().data.bytes(slot).len() as u64).sum()
    }
}
