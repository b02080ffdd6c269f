//! Drafts: fast pictures, in sessions of their own.

use std::time::{Duration, Instant};

use milkglass::error::Result;
use milkglass::internals::gpu::{Device, Timing};
use milkglass::internals::pipeline::plan::{Change, Options, ShadingMethod};
use milkglass::internals::session::run::Session;
use milkglass::scene::Scene;

use super::{Frames, Progress};
use crate::cli::view::drafts::LEVELS;

impl Frames {
    /// Renders a draft; the next one is chosen by how long it took. `before` is the time of the change itself.
    pub(super) fn draft(&mut self, scene: &Scene, before: Duration) -> Result<Vec<Timing>> {
        let start = Instant::now();
        self.policy.choose(scene, self.all, before.as_secs_f64() * 1e3);
        if !LEVELS[self.policy.level].transport && self.lacks_coarsest() {
            self.open_coarsest(scene)?;
            return self.draft(scene, before);
        }
        let (coarse, own) = self.coarse(scene, self.policy.level)?;
        let draft = &mut self.drafts[own];
        let known = draft.as_ref().is_some_and(|session| session.scene().camera.size == coarse.camera.size);
        let session = open(draft, &coarse, &self.device, self.options)?;
        let mut steps = session.frame(Change::default())?;
        // The first draft of a size may have to compile kernels.
        if known {
            self.policy.learn(scene, &steps, start.elapsed().as_secs_f64() * 1e3);
        } else if !self.policy.knows() {
            // The very first draft: another frame tells how long drafts take.
            let start = Instant::now();
            steps = session.frame(Change::EVERYTHING)?;
            self.policy.learn(scene, &steps, start.elapsed().as_secs_f64() * 1e3);
        }
        (self.all, self.progress) = (false, Progress::Draft(Instant::now()));
        Ok(steps)
    }

    /// Whether the session of the coarsest drafts is yet to be opened.
    pub(super) fn lacks_coarsest(&self) -> bool {
        self.drafts[1].is_none() && self.policy.coarsest == LEVELS.len() - 1
    }

    /// Opens the session of the coarsest drafts, so that the first of them does not wait for it while something moves.
    pub(super) fn open_coarsest(&mut self, scene: &Scene) -> Result<()> {
        let (coarse, own) = self.coarse(scene, LEVELS.len() - 1)?;
        let options = Options { transport: ShadingMethod::Lambert, ..self.options };
        let opened = open(&mut self.drafts[own], &coarse, &self.device, options);
        match opened.and_then(|session| session.frame(Change::default())) {
            Err(error) if error.is_device_fault() => Err(error),
            Err(_) => {
                // These drafts cannot show the scene: the next finer ones are the coarsest.
                self.policy.coarsest -= 1;
                Ok(())
            }
            Ok(_) => Ok(()),
        }
    }

    /// The scene as a draft of this level shows it, and the index of the draft's session.
    fn coarse(&self, scene: &Scene, level: usize) -> Result<(Scene, usize)> {
        let mut coarse = LEVELS[level].of(scene);
        coarse.camera = coarse.camera.sized(self.draft_size(scene))?;
        Ok((coarse, usize::from(!LEVELS[level].transport)))
    }
}

/// The session of a draft, opened if there is none, with this scene.
fn open<'s>(
    draft: &'s mut Option<Session>,
    coarse: &Scene,
    device: &Device,
    options: Options,
) -> Result<&'s mut Session> {
    match draft {
        Some(session) => {
            session.show(coarse).map_err(|error| coarse.placed(error))?;
            Ok(session)
        }
        none => {
            let transport = match options.transport {
                ShadingMethod::Octree
                | ShadingMethod::Brute
                | ShadingMethod::Walk
                | ShadingMethod::Diffusion
                | ShadingMethod::Auto => ShadingMethod::Hierarchy,
                other => other,
            };
            Ok(none.insert(Session::new(coarse, Some(device), Options { transport, ..options })?))
        }
    }
}
