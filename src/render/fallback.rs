//! What becomes of a session whose lists are too much for its device to keep, or that failed in the middle of a frame.

use super::plan::{Change, Mode, Options, Plan};
use super::room::{KEEPING, LIMITED, Lists};
use super::run::{Backend, Session};
use crate::error::{Error, Input, Result};
use crate::gpu::Limits;

impl Session {
    /// Why lists are made for each frame, where a mode was asked for that keeps them.
    #[must_use]
    pub fn not_kept(&self) -> Option<&str> {
        self.not_kept.as_deref()
    }

    /// Longer lists, and buffers of their size; where they are too much to keep, none are kept.
    pub(super) fn grow(&mut self) -> Result<()> {
        let grown = self.lists.grow(&mut self.prepared).and_then(|()| self.resize());
        self.unless_too_much(grown)
    }

    /// Has lists made for each frame if this is the error of too many to keep. A layer of a picture, or a look at the links
    /// themselves, can't do without.
    pub(super) fn unless_too_much(&mut self, done: Result<()>) -> Result<()> {
        let what = match done {
            Err(Error::Device { doing, what }) if doing == KEEPING => what,
            done => return done,
        };
        let options = self.plan.options();
        if options.mode == Mode::Keep {
            let what = format!("{what}; use fewer triangles, or do without --aov or --view");
            return Err(match what.contains(LIMITED) {
                true => Input::new(format!("{KEEPING}: {what}")).key("--limit-memory").into(),
                false => Error::device(KEEPING, what),
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
        self.lists = Lists::new(self.fixed.room, self.limits().as_ref());
        self.lists.cut(&mut self.prepared);
        self.pending = Change::EVERYTHING;
        self.resize()
    }

    /// Everything in place again after a frame that failed, for one that does everything.
    pub(super) fn recover(&mut self) -> Result<()> {
        if self.failed {
            self.lists = Lists::new(self.fixed.room, self.limits().as_ref());
            self.lists.cut(&mut self.prepared);
            self.pending = Change::EVERYTHING;
            self.resize()?;
            self.failed = false;
        }
        Ok(())
    }

    fn limits(&self) -> Option<Limits> {
        match &self.backend {
            Backend::Gpu(twin) => Some(*twin.device().limits()),
            Backend::Cpu => None,
        }
    }
}
