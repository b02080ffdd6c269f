//! The first frame of a whole picture: in parts, so that input is read between them.

use std::time::{Duration, Instant};

use milkglass::error::Result;
use milkglass::internals::gpu::Timing;
use milkglass::internals::pipeline::plan::Change;
use milkglass::scene::Scene;

use super::check::PART;
use super::{Frames, Progress};

/// If the first frame of a picture takes less, there are no drafts.
const QUICK: Duration = Duration::from_millis(50);

impl Frames {
    /// Goes on with the first frame of the whole picture, for [`PART`] while a draft is shown; the times of its steps
    /// and what it took once it is done.
    pub(super) fn first(&mut self, scene: &Scene, start: Instant) -> Result<Option<(Vec<Timing>, Duration)>> {
        let (mut frame, before) = match self.under_way.take() {
            Some(under_way) => under_way,
            None => {
                self.full.show(scene).map_err(|error| scene.placed(error))?;
                (self.full.begin(Change::default())?, Duration::ZERO)
            }
        };
        let most = if self.progress == Progress::Changed { usize::MAX } else { 1 };
        let steps = loop {
            let steps = self.full.go_on(&mut frame, most)?;
            if steps.is_some() || (most == 1 && start.elapsed() > PART) {
                break steps;
            }
        };
        self.longest = self.longest.max(start.elapsed());
        let took = before + start.elapsed();
        let Some(steps) = steps else {
            self.under_way = Some((frame, took));
            return Ok(None);
        };
        self.full.finished_rays()?;
        self.quick[usize::from(std::mem::take(&mut self.heavy))] = took < QUICK;
        self.policy.relearn(scene, &steps, took.as_secs_f64() * 1e3);
        self.progress = if scene.camera.samples == 1 { Progress::Whole } else { Progress::Sample(0) };
        Ok(Some((steps, took)))
    }
}
