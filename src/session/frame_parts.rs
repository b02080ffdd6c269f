//! A frame under way: its steps, in one submission or in several, and again with longer lists after an overflow.

use std::time::Instant;

use super::run::{Session, unfinished};
use crate::error::Result;
use crate::gpu::Timing;
use crate::layout::{BufferId, ListCounters};
use crate::pipeline::plan::{Change, Changes};
use crate::state::{Stage, Step};
use crate::transport::blocks::irradiance_ratio;
use crate::transport::links::{refine, update_links};
use crate::transport::octree::HOST;

/// A frame that has begun.
pub struct FrameParts {
    begin: Instant,
    /// The changes that it brings up to date.
    changes: Changes,
    /// Its steps, and how far it is; none before they are known.
    steps: Option<Steps>,
    /// The times of the steps that are done, and of those that ran before lists were made longer.
    last: Vec<Timing>,
    times: Vec<Timing>,
    /// Which of the camera's several samples it is, if it is one.
    pub(super) sample: Option<u32>,
}

/// The steps of a frame, how many are done, and how many dispatches of the next one.
struct Steps {
    all: Vec<Step>,
    done: usize,
    dispatched: usize,
}

impl Session {
    /// Begins a frame as [`Session::frame`] runs it; [`Session::go_on`] runs its steps.
    pub fn begin(&mut self, change: Change) -> Result<FrameParts> {
        if self.shifted {
            self.shift([0.0; 2], [0.0; 2], 0)?;
        }
        self.begin_as_it_is(change)
    }

    /// The same with the rays where they are.
    pub(crate) fn begin_as_it_is(&mut self, changes: impl Into<Changes>) -> Result<FrameParts> {
        self.samples_done = 0;
        self.recover()?;
        self.failed = true;
        self.pending = self.pending.clone().and(&changes.into());
        self.sharp = None;
        self.open_budget()?;
        let changes = self.pending.clone().and(&self.waiting_change().into());
        let (last, times) = (Vec::new(), Vec::new());
        Ok(FrameParts { begin: Instant::now(), changes, steps: None, last, times, sample: None })
    }

    /// Runs the rest of the frame or, where its steps can run one by one, goes on with it up to the first dispatch that
    /// is done after `until`. Returns the times of all steps once the frame is done.
    pub fn go_on(&mut self, frame: &mut FrameParts, until: Option<Instant>) -> Result<Option<Vec<Timing>>> {
        let mut steps = match frame.steps.take() {
            Some(known) => known,
            None => {
                frame.changes = self.links_anew(&frame.changes);
                let all = self.plan.steps(&self.prepared.state, frame.changes.clone());
                Steps { all, done: 0, dispatched: 0 }
            }
        };
        let octree = self.plan.runs_on_host(&HOST, &self.prepared.state, frame.changes.clone());
        let solves = self.prepared.state.method.solves();
        if octree || solves || self.walks() || (until.is_none() && steps.done + steps.dispatched == 0) {
            frame.last.append(&mut match () {
                () if octree => self.run_octree(&steps.all, frame.changes.any())?,
                () if self.walks() => self.run_walk(&steps.all)?,
                () if solves => self.run_diffusion(&steps.all)?,
                () => self.run(&steps.all)?,
            });
            steps.done = steps.all.len();
        }
        while steps.done < steps.all.len() {
            self.next_part(frame, &mut steps)?;
            if until.is_some_and(|until| until <= Instant::now()) && steps.done < steps.all.len() {
                frame.steps = Some(steps);
                return Ok(None);
            }
        }
        let steps = steps.all;
        // A stage that runs again counts with its latest run only.
        frame.times.retain(|before| frame.last.iter().all(|now| now.name != before.name));
        frame.times.append(&mut frame.last);
        match self.left(&steps)? {
            Some(changes) => {
                frame.changes = changes;
                Ok(None)
            }
            None => {
                self.pending = Changes::default();
                self.failed = false;
                self.cover()?;
                if let Some(sample) = frame.sample {
                    (self.samples_done, self.shifted) = (sample + 1, true);
                }
                Ok(Some(std::mem::take(&mut frame.times)))
            }
        }
    }

    /// Runs the next dispatch of these steps, or the next step where that is one piece.
    fn next_part(&mut self, frame: &mut FrameParts, steps: &mut Steps) -> Result<()> {
        let (step, start) = (steps.all[steps.done], Instant::now());
        let (time, more) = match &self.gpu {
            Some(gpu) => gpu.run_part(&self.prepared.state, step, steps.dispatched)?,
            None => (self.run(&[step])?.pop(), false),
        };
        if let Some(mut time) = time {
            // Devices may time the first part of a submission too short: here it is the only one.
            time.milliseconds = time.milliseconds.max(start.elapsed().as_secs_f64() * 1e3);
            time.start = start.duration_since(frame.begin).as_secs_f64() * 1e3;
            match frame.last.last_mut().filter(|_| steps.dispatched > 0) {
                Some(before) => {
                    before.milliseconds += time.milliseconds;
                    before.dispatches += time.dispatches;
                    before.barriers += time.barriers;
                }
                None => frame.last.push(time),
            }
        }
        (steps.done, steps.dispatched) = if more { (steps.done, steps.dispatched + 1) } else { (steps.done + 1, 0) };
        Ok(())
    }

    /// Runs all that is left of a frame, again from where lists overflow.
    pub(crate) fn complete(&mut self, mut frame: FrameParts) -> Result<Vec<Timing>> {
        loop {
            if let Some(times) = self.go_on(&mut frame, None)? {
                return Ok(times);
            }
        }
    }

    /// Leaves a frame that is not done; the next one does its work again, and what was found to be needed on the way:
    /// longer lists, and links made anew.
    pub fn leave(&mut self, frame: FrameParts) {
        self.pending = std::mem::take(&mut self.pending).and(&frame.changes);
        if self.state().method.incremental {
            // Links may have been updated in part.
            self.pending.add(Change::EVERYTHING);
        }
        (self.failed, self.linked) = (false, false);
    }

    /// What is left to do after a frame's steps, because lists overflowed or do not serve.
    fn left(&mut self, steps: &[Step]) -> Result<Option<Changes>> {
        if steps.iter().any(|step| step.stage.writes(BufferId::cut_short)) {
            self.fetch(&[BufferId::cut_short])?;
            if self.prepared.state.data.cut_short != [0] {
                let doing = "following a shadow ray, or fitting a plane to a vertex";
                return Err(unfinished(doing, "use a mesh with fewer overlapping parts"));
            }
        }
        let ran = |stage: &Stage| steps.iter().any(|step| step.stage.is(stage));
        let filled = steps.iter().any(|step| step.stage.fills_lists());
        if ran(&irradiance_ratio::STAGE) && !filled {
            self.fetch(&[BufferId::counters])?;
            if !self.prepared.state.data.counters.iter().all(ListCounters::serves) {
                self.relinks += 1;
                return Ok(Some(Change::RELINK.into()));
            }
        }
        if !filled {
            return Ok(None);
        }
        self.fetch(&[BufferId::counters])?;
        let counters = &self.prepared.state.data.counters;
        if counters.iter().any(|counters| counters.unfinished != 0) {
            self.linked = false;
            let advice =
                "use transport.receivers = \"faces\", or raise receiver_angle and emitter_angle of scheme links";
            return Err(unfinished("linking", advice));
        }
        if counters.iter().all(|counters| counters.overflow == 0) {
            self.linked = self.linked || ran(&refine::STAGE);
            return Ok(None);
        }
        self.retries += 1;
        // An update cannot start from links made anew that did not fit.
        let remade = |step: &Step| step.stage.is(&refine::STAGE) && counters[step.at.object].overflow != 0;
        if ran(&update_links::STAGE) && !steps.iter().any(remade) {
            self.make_room()?;
            // Sum all links: the light of the previous frame has been overwritten.
            return Ok(Some(Change::EVERYTHING.and(Change::LIGHT).into()));
        }
        self.grow().map(|change| Some(change.into()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::pipeline::plan::{Mode, Options};
    use crate::scene::Scene;

    #[test]
    #[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
    fn a_frame_that_is_left_leaves_no_trace() {
        for (scheme, mode) in [
            ("blocks", Mode::OnTheFly),
            ("blocks", Mode::Keep),
            ("blocks", Mode::Render),
            ("links", Mode::Keep),
            ("links", Mode::Incremental),
        ] {
            let with = |light: &str| {
                let sets = ["object.0.detail=2", &format!("transport.scheme={scheme}"), light].map(str::to_string);
                Scene::load_with("sphere", &sets).unwrap()
            };
            let [scene, moved] = ["light.0.direction=[0, 0, 1]", "light.0.direction=[1, 0, 0]"].map(with);
            let options = Options { mode, ..Options::default() };
            let mut fresh = Session::new(&moved, None, options).unwrap();
            fresh.frame(Change::EVERYTHING).unwrap();
            // A first frame, one that follows a whole one, and one that is done.
            for done in [1, 5, usize::MAX] {
                let mut session = Session::new(&scene, None, options).unwrap();
                if done > 1 {
                    session.frame(Change::EVERYTHING).unwrap();
                }
                let mut frame = session.begin(Change::EVERYTHING).unwrap();
                let mut left = false;
                for _ in 0..done.min(64) {
                    left = session.go_on(&mut frame, Some(Instant::now())).unwrap().is_none();
                    if !left {
                        break;
                    }
                }
                if left {
                    session.leave(frame);
                }
                assert!(left || done == usize::MAX, "{scheme} {mode:?}: nothing was left");
                session.show(&moved).unwrap();
                session.frame(Change::default()).unwrap();
                let (own, wanted) = (&session.state().data, &fresh.state().data);
                assert!(own.radiosity == wanted.radiosity, "{scheme} {mode:?} after {done} steps");
                assert!(own.radiance == wanted.radiance, "{scheme} {mode:?} after {done} steps: the picture");
            }
        }
    }

    #[test]
    fn lists_that_a_left_frame_made_anew_are_made_again() {
        let with = |light: &str| {
            let sets = ["object.0.detail=3".to_string(), format!("light=[{light}]")];
            Scene::load_with("sphere", &sets).unwrap()
        };
        let even = with("{ type = 'directional', direction = [0, 0, 1], irradiance = 3 }");
        let sharp = with("{ type = 'point', position = [0, 0, 5.3], intensity = 3 }");
        let options = Options { mode: Mode::Render, ..Options::default() };
        let mut fresh = Session::new(&sharp, None, options).unwrap();
        fresh.frame(Change::EVERYTHING).unwrap();
        let mut session = Session::new(&even, None, options).unwrap();
        session.frame(Change::EVERYTHING).unwrap();
        // The light asks for other lists, and these are left too short.
        session.show(&sharp).unwrap();
        session.prepared.state.data.object_params[0].entry_capacity = 8;
        let mut frame = session.begin(Change::default()).unwrap();
        let before = session.relinks();
        while session.relinks() == before {
            assert!(
                session.go_on(&mut frame, Some(Instant::now())).unwrap().is_none(),
                "the lists serve this light, too"
            );
        }
        while session.state().data.counters[0].overflow == 0 {
            assert!(session.go_on(&mut frame, Some(Instant::now())).unwrap().is_none(), "the lists are long enough");
        }
        session.leave(frame);
        session.frame(Change::VIEW).unwrap();
        assert!(session.state().data.radiosity == fresh.state().data.radiosity);
    }

    #[test]
    fn steps_one_by_one_are_the_same_frame() {
        let scene = Scene::load_with("sphere", &["object.0.detail=2".to_string()]).unwrap();
        let mut whole = Session::new(&scene, None, Options::default()).unwrap();
        let at_once = whole.frame(Change::EVERYTHING).unwrap();
        let mut parts = Session::new(&scene, None, Options::default()).unwrap();
        let mut frame = parts.begin(Change::EVERYTHING).unwrap();
        let mut turns = 1;
        let times = loop {
            match parts.go_on(&mut frame, Some(Instant::now())).unwrap() {
                Some(times) => break times,
                None => turns += 1,
            }
        };
        let names = |times: &[Timing]| -> Vec<String> { times.iter().map(|time| time.name.clone()).collect() };
        assert_eq!(names(&times), names(&at_once));
        assert!(turns >= times.len() && times.windows(2).all(|pair| pair[0].start <= pair[1].start), "{times:?}");
        assert!(whole.state().data.radiance == parts.state().data.radiance);
    }
}
