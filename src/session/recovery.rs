//! Recovery: longer lists after an overflow, lists per frame where they are too long to keep, and a restart after a
//! failed frame.

use super::capacity::{Growth, Lists};
use super::run::Session;
use crate::error::{Error, Input, KeepLimit, Result};
use crate::pipeline::plan::{Change, Mode, Options};

impl Session {
    /// Why lists are rebuilt in each frame although the mode asks to keep them.
    #[must_use]
    pub fn not_kept(&self) -> Option<&str> {
        self.not_kept.as_deref()
    }

    /// Grows the lists and their buffers; stops keeping lists that become too long. Returns what the frame has to
    /// repeat: only the lists, if nothing else depends on their length.
    pub(crate) fn grow(&mut self) -> Result<Change> {
        let grown = self.lists.grow(&mut self.prepared);
        let longer = matches!(grown, Ok(Growth::Longer)) && !self.state().method.incremental;
        let done = grown.and_then(|_| if longer { self.lengthen() } else { self.resize() });
        let kept = self.unless_too_much(done)?;
        Ok(if longer && kept { Change::RELINK } else { Change::EVERYTHING })
    }

    /// Switches to lists per frame if `done` is [`Error::TooMuchToKeep`], and returns false then. The links layer of a
    /// picture, the views of links (`Mode::Keep`) and diffusion need kept lists: for them it stays an error.
    pub(crate) fn unless_too_much(&mut self, done: Result<()>) -> Result<bool> {
        let (what, limited_by) = match done {
            Err(Error::TooMuchToKeep { what, limited_by }) => (what, limited_by),
            done => return done.map(|()| true),
        };
        let options = self.plan.options();
        let solves = self.state().method.solves();
        if options.mode == Mode::Keep || solves {
            let advice = if solves { "--transport hierarchy" } else { "do without --aov or --view" };
            let what = format!("{what}; use fewer triangles, or {advice}");
            let error = Error::TooMuchToKeep { what, limited_by };
            return Err(match limited_by {
                KeepLimit::MemoryOption => Input::new(error.to_string()).key("--limit-memory").into(),
                KeepLimit::Device => error,
            });
        }
        let state = &mut self.prepared.state;
        state.keep = false;
        (state.method.any_light, state.method.incremental) = (false, false);
        state.data.object_params.iter_mut().for_each(|params| params.budget = u32::MAX);
        let why = format!("{what}: links are made for each frame, as in mode on-the-fly");
        let options = Options { mode: Mode::OnTheFly, ..options };
        self.plan = self.plan_of(options).without(("kept links", why.clone()));
        self.not_kept = Some(why);
        self.lists = Lists::new(self.fixed.hints, self.limits());
        self.lists.cut(&mut self.prepared);
        self.pending = Change::EVERYTHING.into();
        self.resize().map(|()| false)
    }

    /// After a frame that failed, restores buffers and capacities so that the next frame can run in full.
    pub(crate) fn recover(&mut self) -> Result<()> {
        if self.failed {
            self.lists = Lists::new(self.fixed.hints, self.limits());
            self.lists.cut(&mut self.prepared);
            self.pending = Change::EVERYTHING.into();
            self.resize()?;
            self.failed = false;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use crate::scene::Scene;
    use crate::session::capacity::CapacityHints;
    use crate::session::recovery::*;

    #[test]
    #[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
    fn after_an_overflow_only_the_lists_are_rebuilt() {
        for (scheme, mode) in ["blocks", "links"]
            .into_iter()
            .flat_map(|scheme| [Mode::OnTheFly, Mode::Keep, Mode::Render].map(|mode| (scheme, mode)))
        {
            let sets = ["object.0.detail=2".to_string(), format!("transport.scheme={scheme}")];
            let scene = Scene::load_with("sphere", &sets).unwrap();
            let open =
                |room| Session::with_capacity(&scene, None, Options { mode, ..Options::default() }, room).unwrap();
            let mut short = open(CapacityHints { links: 1, ..CapacityHints::default() });
            let steps = short.plan.steps(short.state(), Change::EVERYTHING);
            short.run(&steps).unwrap();
            assert_eq!(short.state().data.counters[0].overflow, 1, "{scheme} {mode:?}");
            let before = short.state().data.irradiance.clone();
            assert_eq!(short.grow().unwrap(), Change::RELINK, "{scheme} {mode:?}");
            assert!(before == short.state().data.irradiance, "{scheme} {mode:?}");
            let again = short.plan.steps(short.state(), Change::RELINK);
            assert!(again.len() < steps.len());
            let lists = |name: &str| {
                ["refit", "shadow", "irradiance", "pull", "coarse_solve"].iter().all(|known| *known != name)
            };
            assert!(again.iter().all(|step| lists(step.stage.name)), "{scheme} {mode:?}");

            // The result equals that of lists with enough capacity.
            short.frame(Change::EVERYTHING).unwrap();
            let mut once = open(CapacityHints { links: 1, ..CapacityHints::default() });
            once.frame(Change::EVERYTHING).unwrap();
            let mut long = open(CapacityHints { links: 5000, ..CapacityHints::default() });
            long.frame(Change::EVERYTHING).unwrap();
            assert!(once.retries > 0, "{scheme} {mode:?}");
            assert!(once.state().data.radiosity == long.state().data.radiosity, "{scheme} {mode:?}");
            assert!(short.state().data.radiosity == long.state().data.radiosity, "{scheme} {mode:?}");

            // Smaller parts change the layout, so everything reruns.
            let binding = if scheme == "blocks" { 1 << 13 } else { 1 << 16 };
            let mut cut = open(CapacityHints { links: 1, binding, ..CapacityHints::default() });
            let steps = cut.plan.steps(cut.state(), Change::EVERYTHING);
            cut.run(&steps).unwrap();
            assert_eq!(cut.grow().unwrap(), Change::EVERYTHING, "{scheme} {mode:?}");
        }
    }
}
