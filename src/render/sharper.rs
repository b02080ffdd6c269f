//! An error estimate that knows where errors cancel: the light is carried once more, more exactly.

use super::plan::{Goal, Mode, Options};
use super::run::{Room, Session};
use crate::error::Result;
use crate::layout::Slot;

/// How many times more exact the other radiosity is asked to be.
const SHARPER: f64 = 8.0;
/// The least tolerance that `f32` sums can tell from none.
const LEAST: f64 = 1e-6;

impl Session {
    /// Replaces the estimate that the last frame carried along by a sharper one, |B - B'| + e', per channel: B' is the
    /// radiosity at 1/8 of the tolerance, at least at 1e-6, and e' the estimate carried along with it. A bound where e' is
    /// one. Costs a frame of a new session, and its memory for the time; where the device fails in that, for want of room
    /// mostly, or the tolerance is next to 1e-6 already, the estimate stays as it is: see [`Session::blunt`]. Does nothing
    /// where no estimate is carried.
    pub fn sharpen(&mut self) -> Result<()> {
        if self.sharp.is_some() {
            return Ok(());
        }
        let solve = || -> Result<Option<Session>> {
            let Some(mut other) = self.sharper()? else { return Ok(None) };
            if let Some(camera) = self.state().data.camera.first() {
                other.shift([camera.shift_x, camera.shift_y].map(|x| f64::from(x) / 2.0))?;
            }
            let change = other.pending;
            other.frame(change)?;
            other.fetch(&[Slot::radiosity, Slot::estimate])?;
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
        self.fetch(&[Slot::radiosity, Slot::estimate])?;
        let data = &mut self.prepared.state.data;
        let sharper = &other.state().data;
        let radiosity = data.radiosity.iter().zip(&sharper.radiosity);
        for ((own, (b, better)), missed) in data.estimate.iter_mut().zip(radiosity).zip(&sharper.estimate) {
            *own = [0, 1, 2].map(|c| ((b[c] - better[c]).abs() + missed[c]).min(f32::MAX));
        }
        self.sharp = Some(Ok(()));
        Ok(())
    }

    /// The session that carries the light once more for the estimate, before its frame; none where nothing is estimated, or
    /// where it would not be more exact.
    pub fn sharper(&self) -> Result<Option<Self>> {
        let tolerance = (self.scene.transport.tolerance / SHARPER).max(LEAST);
        if !self.state().method.estimate || 2.0 * tolerance > self.scene.transport.tolerance {
            return Ok(None);
        }
        let mut scene = self.scene.clone();
        (scene.transport.tolerance, scene.transport.subdivide) = (tolerance, 0);
        let mut options = Options { mode: Mode::OnTheFly, ..self.plan.options() };
        // No picture is needed, as long as receivers are faces, and what is opaque is lit by face, without one, too.
        if self.state().objects.iter().all(|object| !object.by_pixel && !object.opaque) {
            options.goal = Goal::Radiosity;
        }
        Self::new(&scene, self.device(), options, Room::default()).map(Some)
    }

    /// Whether the estimate is the sharper one, which the host alone knows.
    pub(super) fn sharpened(&self) -> bool {
        matches!(self.sharp, Some(Ok(())))
    }

    /// Why the last estimate is the one carried along, where a sharper one was tried.
    #[must_use]
    pub fn blunt(&self) -> Option<&str> {
        self.sharp.as_ref()?.as_ref().err().map(String::as_str)
    }
}
