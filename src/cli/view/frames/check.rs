//! The estimated error of the picture, once the picture is whole and rests: from a session of its own, so that pictures
//! do not pay for it, and in parts, so that input is read between them.

use std::time::{Duration, Instant};

use milkglass::error::Result;
use milkglass::internals::gpu::Device;
use milkglass::internals::pipeline::plan::{Change, Goal, Options, ShadingMethod};
use milkglass::internals::session::frame_parts::FrameParts;
use milkglass::internals::session::run::Session;
use milkglass::scene::{Scene, Scheme};

use super::parts::{PART, open};

/// For how long everything must rest before the picture is made, and before its error is estimated.
pub(super) const REST: Duration = Duration::from_millis(250);

/// The estimate of the error, and the work for it.
#[derive(Default)]
pub(super) struct Check {
    session: Option<Session>,
    under_way: Option<FrameParts>,
    /// Whether the error is estimated, or known to have no estimate.
    known: bool,
    /// Whether a second solution is to sharpen the estimate.
    sharpens: bool,
    error: Option<[f64; 3]>,
    /// When the picture was whole.
    since: Option<Instant>,
}

impl Check {
    /// The estimated error of radiosity, L2, r g b.
    pub(super) fn error(&self) -> Option<[f64; 3]> {
        self.error
    }

    /// Says that the picture is whole now.
    pub(super) fn whole(&mut self) {
        self.since = Some(Instant::now());
    }

    /// Says that the picture changes: `all` of it, or the camera alone, which leaves radiosity as it is.
    pub(super) fn change(&mut self, all: bool) {
        if let (Some(session), Some(frame)) = (&mut self.session, self.under_way.take()) {
            session.leave(frame);
        }
        self.sharpens = false;
        if all {
            (self.known, self.error) = (false, None);
        }
    }

    /// Forgets everything, since the options have changed.
    pub(super) fn forget(&mut self) {
        *self = Self::default();
    }

    /// Has a second solution sharpen the error.
    pub(super) fn sharpen(&mut self) {
        self.sharpens = true;
    }

    /// When the next step of the estimate is due, while the picture is whole.
    pub(super) fn due(&self) -> Option<Instant> {
        match self.known {
            true => self.sharpens.then(Instant::now),
            false if self.under_way.is_some() => Some(Instant::now()),
            false => self.since.map(|since| since + REST),
        }
    }

    /// Works on the estimate for [`PART`]; a dispatch is not cut into parts, nor is the second solution. If it fails,
    /// there is no estimate: a device that is lost shows in the next picture.
    pub(super) fn advance(&mut self, scene: &Scene, device: &Device, options: Options) {
        if self.part(scene, device, options).is_err() {
            *self = Self { known: true, ..Self::default() };
        }
    }

    fn part(&mut self, scene: &Scene, device: &Device, options: Options) -> Result<()> {
        let start = Instant::now();
        if self.known {
            self.sharpens = false;
            if let Some(session) = &mut self.session {
                session.sharpen()?;
                self.error = session.estimated_error()?;
            }
            return Ok(());
        }
        let estimates = match options.transport {
            ShadingMethod::Hierarchy => scene.transport.scheme == Scheme::Blocks,
            ShadingMethod::Diffusion | ShadingMethod::Auto => true,
            _ => false,
        };
        // Subdivision for lights would look for more to estimate.
        if !estimates || scene.transport.subdivide > 0 {
            self.known = true;
            return Ok(());
        }
        let session = match &mut self.session {
            Some(session) => session,
            none => {
                let options = Options { goal: Goal::Radiosity, estimate: true, ..options };
                none.insert(open(scene, device, options)?)
            }
        };
        let frame = match &mut self.under_way {
            Some(frame) => frame,
            none => {
                session.show(scene)?;
                none.insert(session.begin(Change::default())?)
            }
        };
        if session.go_on(frame, Some(start + PART))?.is_some() {
            (self.under_way, self.known) = (None, true);
            self.error = session.estimated_error()?;
        }
        Ok(())
    }
}
