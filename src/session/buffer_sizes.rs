//! Sizes of a session's buffers: before the first frame, when lists grow, and when the picture's size changes.

use super::run::Session;
use crate::error::Result;
use crate::layout::BufferId;
use crate::pipeline::buffer_sizes::{RESULTS, adjust, grows, resize, size};
use crate::pipeline::plan::{Plan, ShadingMethod};
use crate::state::State;
use crate::transport::octree::HOST;

/// Buffers that stages may leave as they are and the host or kernels read for every object, though not every object has
/// lists.
const STANDING: [BufferId; 5] =
    [BufferId::arrivals, BufferId::cut_short, BufferId::counters, BufferId::stale, BufferId::stale_counts];

impl Session {
    /// Gives every buffer its size and uploads the inputs.
    pub(crate) fn resize(&mut self) -> Result<()> {
        self.sized(size);
        self.linked = false;
        self.size_picture();
        self.check_bindings()?;
        let inputs: Vec<BufferId> = Plan::inputs().collect();
        self.send(&inputs)?;
        self.blank()?;
        self.send(&STANDING)
    }

    /// Gives buffers their sizes. A solution whose buffer changes its size cannot start the solver.
    fn sized(&mut self, size: fn(&mut State, &Plan)) {
        let length = |session: &Self| session.state().data.bytes(BufferId::solution).len();
        let before = length(self);
        size(&mut self.prepared.state, &self.plan);
        if length(self) != before {
            self.solves.clear();
        }
    }

    /// Resizes the buffers that need it after a change of `inputs`; all others keep their contents.
    pub(crate) fn adjust(&mut self, inputs: &[BufferId]) -> Result<()> {
        let sizes = |session: &Self| STANDING.map(|id| session.state().data.bytes(id).len());
        let before = sizes(self);
        self.sized(adjust);
        self.check_bindings()?;
        self.send(inputs)?;
        // New memory may hold anything.
        let made = STANDING.into_iter().zip(before).zip(sizes(self)).filter(|((_, before), now)| before != now);
        self.send(&made.map(|((id, _), _)| id).collect::<Vec<_>>())?;
        self.blank()
    }

    /// Zeroes the buffers that neither a stage of the plan nor the host writes, where a stage or the host reads them.
    fn blank(&mut self) -> Result<()> {
        let transport = self.plan.options().transport;
        let unwritten = |id: &BufferId| match transport {
            ShadingMethod::Octree if *id == HOST.writes => !self.plan.writes(HOST.reads),
            ShadingMethod::None if *id == BufferId::radiosity => true,
            _ => !self.plan.writes(*id),
        };
        let blank = RESULTS.iter().copied().filter(|id| *id != BufferId::counters && unwritten(id));
        let blank: Vec<BufferId> = blank.collect();
        blank.iter().for_each(|id| self.prepared.state.data.bytes_mut(*id).fill(0));
        self.send(&blank)
    }

    /// Gives the lists their new size, when all earlier results of the frame are still valid.
    pub(crate) fn lengthen(&mut self) -> Result<()> {
        resize(&mut self.prepared.state, &self.plan, grows);
        self.check_bindings()?;
        self.send(&[BufferId::object_params])
    }

    pub(crate) fn size_picture(&mut self) {
        resize(&mut self.prepared.state, &self.plan, |id| id.spec().per == "pixel");
    }
}
