//! A refined error estimate, from a second solution at a smaller tolerance. It accounts for errors that cancel.

use super::antialiasing::{lens, place};
use super::run::Session;
use crate::error::Result;
use crate::layout::BufferId;
use crate::pipeline::plan::{Goal, Mode, Options};

/// Factor between the two solutions' tolerances.
const SHARPER: f64 = 8.0;
/// The smallest tolerance that `f32` sums can distinguish from 0.
const LEAST: f64 = 1e-6;
/// The smallest tolerance at which the solver of diffusion ends in `f32`.
const LEAST_SOLVED: f64 = 1e-5;

impl Session {
    /// Replaces the last frame's estimate by |B - B'| + e' per channel, where B' is the radiosity at 1/8 of the
    /// tolerance (at least 1e-6, for diffusion 1e-5) and e' its own estimate. It is a bound where e' is one. Costs a
    /// frame of a new session, and that session's memory meanwhile. The estimate stays as it is where the device fails,
    /// mostly for lack of memory (see [`Session::blunt`]), or where the tolerance is close to the least already. Does
    /// nothing without an estimate.
    pub fn sharpen(&mut self) -> Result<()> {
        if self.sharp.is_some() {
            return Ok(());
        }
        let solve = || -> Result<Option<Session>> {
            let Some(mut other) = self.sharper()? else { return Ok(None) };
            if let Some(k) =
                self.state().data.camera.first().map(|camera| camera.sample_number).filter(|_| self.shifted)
            {
                let samples = self.scene.camera.samples;
                other.shift(place(k, samples), lens(k, samples), 0)?;
            }
            let pending = other.pending.clone();
            other.frame_as_it_is(pending)?;
            other.fetch(&[BufferId::radiosity, BufferId::estimate])?;
            Ok(Some(other))
        };
        let other = match solve() {
            Ok(Some(other)) => other,
            Ok(None) => return Ok(()),
            Err(error) if error.is_device_fault() => {
                self.sharp = Some(Err(error.to_string()));
                return Ok(());
            }
            Err(error) => return Err(error),
        };
        self.fetch(&[BufferId::radiosity, BufferId::estimate])?;
        let data = &mut self.prepared.state.data;
        let sharper = &other.state().data;
        let radiosity = data.radiosity.iter().zip(&sharper.radiosity);
        for ((estimate, (b, better)), missed) in data.estimate.iter_mut().zip(radiosity).zip(&sharper.estimate) {
            *estimate = [0, 1, 2].map(|c| ((b[c] - better[c]).abs() + missed[c]).min(f32::MAX));
        }
        self.sharp = Some(Ok(()));
        Ok(())
    }

    /// The session of the second solution, before its frame; none if no error is estimated, or if it would not be
    /// more accurate.
    pub fn sharper(&self) -> Result<Option<Self>> {
        let least = if self.state().method.solves() { LEAST_SOLVED } else { LEAST };
        let tolerance = (self.scene.transport.tolerance / SHARPER).max(least);
        if !self.state().method.estimate || 2.0 * tolerance > self.scene.transport.tolerance {
            return Ok(None);
        }
        let mut scene = self.scene.clone();
        (scene.transport.tolerance, scene.transport.subdivide) = (tolerance, 0);
        let mut options = Options { mode: Mode::OnTheFly, ..self.plan.options() };
        // Receivers at faces need no picture; opaque objects may be lit per pixel, which does.
        if self.state().objects.iter().all(|object| !object.by_pixel && !object.opaque) {
            options.goal = Goal::Radiosity;
        }
        Self::new(&scene, self.device(), options).map(Some)
    }

    /// Whether the estimate is the refined one, which exists on the host only.
    pub(crate) fn sharpened(&self) -> bool {
        matches!(self.sharp, Some(Ok(())))
    }

    /// Why the last refinement failed and left the frame's own estimate.
    #[must_use]
    pub fn blunt(&self) -> Option<&str> {
        self.sharp.as_ref()?.as_ref().err().map(String::as_str)
    }
}
