//! The times of the last frames, for the panel's strip and for traces.

use std::collections::VecDeque;
use std::time::Instant;

use milkglass::internals::gpu::Timing;
use milkglass::measure::rounds::Frame;

/// How many frames are kept.
pub(super) const KEPT: usize = 120;

/// The last frames, the latest one last.
pub(super) struct History {
    begin: Instant,
    pub(super) frames: VecDeque<Frame>,
    /// Every stage so far, in the order in which they first ran.
    pub(super) stages: Vec<String>,
}

impl History {
    pub(super) fn new() -> Self {
        Self { begin: Instant::now(), frames: VecDeque::new(), stages: Vec::new() }
    }

    /// Adds a frame that began at `start` and has just ended.
    pub(super) fn add(&mut self, start: Instant, steps: Vec<Timing>) {
        let frame = Frame::since(start, steps);
        for name in frame.steps.iter().map(stage_of) {
            if !self.stages.iter().any(|known| known == name) {
                self.stages.push(name.to_owned());
            }
        }
        if self.frames.len() == KEPT {
            self.frames.pop_front();
        }
        self.frames.push_back(Frame { start: start.duration_since(self.begin).as_secs_f64() * 1e3, ..frame });
    }

    /// How long each stage ran in a frame, ms on the device: in the order of `stages`, 0 where it is not known.
    pub(super) fn by_stage(&self, frame: &Frame) -> Vec<f64> {
        let mut sums = vec![0.0; self.stages.len()];
        for step in frame.steps.iter().filter(|step| step.milliseconds.is_finite()) {
            if let Some(index) = self.stages.iter().position(|known| known == stage_of(step)) {
                sums[index] += step.milliseconds;
            }
        }
        sums
    }
}

/// The name of a step's stage.
pub(super) fn stage_of(step: &Timing) -> &str {
    step.name.split(' ').next().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_frames_are_kept_and_summed_by_stage() {
        let step = |name: &str, milliseconds| Timing { name: name.into(), milliseconds, ..Timing::default() };
        let mut history = History::new();
        for frame in 0..KEPT + 5 {
            let steps = vec![step("a 0", frame as f64), step("b", f64::NAN), step("a 1", 0.5)];
            history.add(Instant::now(), steps);
        }
        assert_eq!((history.frames.len(), history.stages.as_slice()), (KEPT, &["a".to_string(), "b".into()][..]));
        assert_eq!(history.by_stage(&history.frames[0]), [5.5, 0.0]);
    }
}
