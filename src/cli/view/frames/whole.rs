//! The frames of a whole picture: in parts, so that input is read between them.

use std::time::{Duration, Instant};

use milkglass::error::Result;
use milkglass::internals::gpu::Timing;
use milkglass::internals::pipeline::plan::Change;
use milkglass::scene::Scene;

use super::parts::PART;
use super::{Frames, Progress};

/// A picture whose first frame takes less than this is made without drafts.
const QUICK: Duration = Duration::from_millis(50);

impl Frames {
    /// Goes on with the next frame of the whole picture, for [`PART`] while another picture is shown; once the frame is
    /// done, returns the times of its steps and its own.
    pub(super) fn part(&mut self, scene: &Scene, start: Instant) -> Result<Option<(Vec<Timing>, Duration)>> {
        let (mut frame, before) = match (self.under_way.take(), self.progress) {
            (Some(under_way), _) => under_way,
            (None, Progress::Sample(done)) => (self.full.begin_sample(done)?, Duration::ZERO),
            (None, _) => {
                self.full.show(scene).map_err(|error| scene.placed(error))?;
                (self.full.begin(Change::default())?, Duration::ZERO)
            }
        };
        let until = (self.progress != Progress::Changed).then(|| start + PART);
        // Lists that turn out too short begin another round.
        let steps = loop {
            let steps = self.full.go_on(&mut frame, until)?;
            if steps.is_some() || until.is_some_and(|until| until <= Instant::now()) {
                break steps;
            }
        };
        let took = before + start.elapsed();
        let Some(steps) = steps else {
            self.under_way = Some((frame, took));
            return Ok(None);
        };
        let done = match self.progress {
            Progress::Sample(done) => done + 1,
            _ => {
                self.full.finished_rays()?;
                self.quick[usize::from(std::mem::take(&mut self.heavy))] = took < QUICK;
                self.policy.relearn(scene, &steps, took.as_secs_f64() * 1e3);
                u32::from(scene.camera.samples == 1)
            }
        };
        self.progress = if done == scene.camera.samples { Progress::Whole } else { Progress::Sample(done) };
        Ok(Some((steps, took)))
    }
}
