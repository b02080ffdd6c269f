//! What becomes of a session whose lists are too much for its device to keep, or that failed in the middle of a frame.

use super::plan::{Change, Mode, Options, Plan};
use super::room::{Growth, Lists};
use super::run::Session;
use crate::error::{Error, Input, KeepLimit, Result};

impl Session {
    /// Why lists are made for each frame, where a mode was asked for that keeps them.
    #[must_use]
    pub fn not_kept(&self) -> Option<&str> {
        self.not_kept.as_deref()
    }

    /// Longer lists, and buffers of their size; where they are too much to keep, none are kept. Returns what a frame has to
    /// do again: no more than make the lists, where nothing else depends on their length.
    pub(super) fn grow(&mut self) -> Result<Change> {
        let grown = self.lists.grow(&mut self.prepared);
        let longer = matches!(grown, Ok(Growth::Longer)) && !self.state().method.incremental;
        let done = grown.and_then(|_| if longer { self.lengthen() } else { self.resize() });
        let kept = self.unless_too_much(done)?;
        Ok(if longer && kept { Change::RELINK } else { Change::EVERYTHING })
    }

    /// Has lists made for each frame if this is the error of too many to keep; whether it is not. A layer of a picture, or a
    /// look at the links themselves, can't do without.
    pub(super) fn unless_too_much(&mut self, done: Result<()>) -> Result<bool> {
        let (what, limited_by) = match done {
            Err(Error::TooMuchToKeep { what, limited_by }) => (what, limited_by),
            done => return done.map(|()| true),
        };
        let options = self.plan.options();
        if options.mode == Mode::Keep {
            let what = format!("{what}; use fewer triangles, or do without --aov or --view");
            let error = Error::TooMuchToKeep { what, limited_by };
            return Err(match limited_by {
                KeepLimit::MemoryOption => Input::new(error.to_string()).key("--limit-memory").into(),
                KeepLimit::Device => error,
            });
        }
        let state = &mut self.prepared.state;
        state.keep = false;
        (state.method.any_light, state.method.incremental) = (false, false);
        state.data.frame.iter_mut().for_each(|frame| frame.budget = u32::MAX);
        let why = format!("{what}: links are made for each frame, as in mode on-the-fly");
        self.plan = Plan::new(state, Options { mode: Mode::OnTheFly, ..options })
            .without(self.fixed.receivers.clone())
            .without(("kept links", why.clone()));
        self.not_kept = Some(why);
        self.lists = Lists::new(self.fixed.room, self.limits());
        self.lists.cut(&mut self.prepared);
        self.pending = Change::EVERYTHING;
        self.resize().map(|()| false)
    }

    /// Everything in place again after a frame that failed, for one that does everything.
    pub(super) fn recover(&mut self) -> Result<()> {
        if self.failed {
            self.lists = Lists::new(self.fixed.room, self.limits());
            self.lists.cut(&mut self.prepared);
            self.pending = Change::EVERYTHING;
            self.resize()?;
            self.failed = false;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::render::room::Room;
    use crate::scene::Scene;

    #[test]
    fn lists_that_were_too_short_are_all_that_is_made_anew() {
        for (scheme, mode) in ["blocks", "links"]
            .into_iter()
            .flat_map(|scheme| [Mode::OnTheFly, Mode::Keep, Mode::Render].map(|mode| (scheme, mode)))
        {
            let sets = ["object.0.detail=2".to_string(), format!("transport.scheme={scheme}")];
            let scene = Scene::load("sphere", &sets).unwrap();
            let open = |room| Session::new(&scene, None, Options { mode, ..Options::default() }, room).unwrap();
            let mut short = open(Room { links: 1, ..Room::default() });
            let steps = short.plan.steps(short.state(), Change::EVERYTHING);
            short.run(&steps).unwrap();
            assert_eq!(short.state().data.cursor[0].overflow, 1, "{scheme} {mode:?}");
            let before = short.state().data.irradiance.clone();
            assert_eq!(short.grow().unwrap(), Change::RELINK, "{scheme} {mode:?}");
            assert!(before == short.state().data.irradiance, "{scheme} {mode:?}");
            let again = short.plan.steps(short.state(), Change::RELINK);
            assert!(again.len() < steps.len());
            let lists =
                |name: &str| ["refit", "shadow", "irradiance", "pull", "level"].iter().all(|known| *known != name);
            assert!(again.iter().all(|step| lists(step.stage.name)), "{scheme} {mode:?}");

            // And comes out as if there had been room.
            short.frame(Change::EVERYTHING).unwrap();
            let mut once = open(Room { links: 1, ..Room::default() });
            once.frame(Change::EVERYTHING).unwrap();
            let mut long = open(Room { links: 5000, ..Room::default() });
            long.frame(Change::EVERYTHING).unwrap();
            assert!(once.retries > 0, "{scheme} {mode:?}");
            assert!(once.state().data.radiosity == long.state().data.radiosity, "{scheme} {mode:?}");
            assert!(short.state().data.radiosity == long.state().data.radiosity, "{scheme} {mode:?}");

            // Smaller parts change what lies where.
            let binding = if scheme == "blocks" { 1 << 13 } else { 1 << 16 };
            let mut cut = open(Room { links: 1, binding, ..Room::default() });
            let steps = cut.plan.steps(cut.state(), Change::EVERYTHING);
            cut.run(&steps).unwrap();
            assert_eq!(cut.grow().unwrap(), Change::EVERYTHING, "{scheme} {mode:?}");
        }
    }
}
