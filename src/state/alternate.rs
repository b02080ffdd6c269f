//! One step run again and again on the same state, by two sets of kernels in turn.

use super::{DeviceState, Pass, Role, State, Step};
use crate::error::Result;
use crate::gpu::{Buffer, BufferRange, Kernels, Recorder, Timing};
use crate::layout::BufferId;

/// What a step updates, as it was before the step.
struct Kept {
    id: BufferId,
    first: u64,
    copy: Buffer,
}

impl DeviceState {
    /// Runs a step twice in each of these rounds: by its own kernels or, where that is true, by `others`, which are of
    /// the same device. What the step updates is put back before each run, so that all find the same state. Returns the
    /// time of each run, in order.
    ///
    /// The first round is a submission of its own; the others share one, or where the device may drive a display, as
    /// few as its time limit allows.
    pub fn alternate(
        &mut self,
        state: &State,
        step: Step,
        others: &mut Kernels,
        rounds: &[[bool; 2]],
    ) -> Result<Vec<Timing>> {
        let kept = self.keep(state, step)?;
        let (first, rest) = rounds.split_at(rounds.len().min(1));
        let mut times = self.in_turn(state, step, others, (first, &kept))?;
        let round = times.iter().map(|time| time.milliseconds).sum::<f64>() * 1e-3;
        let most = self.device().shows().map(|limit| ((limit.as_secs_f64() / round) as usize).clamp(1, 10_000));
        for part in rest.chunks(most.unwrap_or(usize::MAX)) {
            times.extend(self.in_turn(state, step, others, (part, &kept))?);
        }
        Ok(times)
    }

    /// Copies of what a step updates; what it overwrites needs none.
    fn keep(&self, state: &State, step: Step) -> Result<Vec<Kept>> {
        let (mut recorder, mut kept) = (Recorder::new(self.device(), 0)?, Vec::new());
        for (id, ..) in step.stage.writes.iter().filter(|(_, role, _)| *role == Role::Update) {
            let id = state.data.bound(*id);
            let (first, count) = state.part(id, step.at);
            let [first, size] = [first, count].map(|elements| (elements * id.spec().stride) as u64);
            if let Some(buffer) = self.buffer(id).filter(|_| size > 0) {
                let copy = Buffer::new(self.device(), &format!("{} before", id.spec().name), size)?;
                recorder.copy(BufferRange { buffer, offset: first, size }, &copy, false);
                kept.push(Kept { id, first, copy });
            }
        }
        recorder.submit()?;
        Ok(kept)
    }

    /// Runs the step in these rounds, in one submission.
    fn in_turn(
        &mut self,
        state: &State,
        step: Step,
        others: &mut Kernels,
        (rounds, kept): (&[[bool; 2]], &[Kept]),
    ) -> Result<Vec<Timing>> {
        let mut recorder = Recorder::new(self.device(), 2 * rounds.len())?;
        for other in rounds.iter().flatten() {
            for Kept { id, first, copy } in kept {
                let back = self.buffer(*id).map(|buffer| BufferRange { buffer, offset: *first, size: copy.size() });
                back.into_iter().for_each(|back| recorder.copy(back, copy, true));
            }
            if *other {
                std::mem::swap(&mut self.kernels, others);
            }
            let list = |recorder: &mut Recorder| (step.stage.gpu)(&mut Pass::record(state, step, self, recorder));
            let listed = recorder.part_of(step.stage.name, step.place(), list);
            if *other {
                std::mem::swap(&mut self.kernels, others);
            }
            listed?;
        }
        self.execution().list(&mut recorder)?;
        let times = recorder.submit()?;
        self.execution().verify("running a stage in turn")?;
        Ok(times)
    }
}
