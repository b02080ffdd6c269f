//! An error estimate that knows where errors cancel: the light is carried once more, more exactly.

use super::plan::{Mode, Options};
use super::run::{Backend, Room, Session};
use crate::error::{Error, Result};
use crate::layout::Slot;

/// How many times more exact the other radiosity is asked to be.
const SHARPER: f64 = 8.0;
/// The least tolerance that `f32` sums can tell from none.
const LEAST: f64 = 1e-6;

impl Session {
    /// Replaces the estimate that the last frame carried along by a sharper one, |B - B'| + e', per channel: B' is the
    /// radiosity at 1/8 of the tolerance, at least at 1e-6, and e' the estimate carried along with it. A bound where e' is
    /// one. Costs a frame of a new session, and its memory for the time; where the device has no room for that, or the
    /// tolerance is next to 1e-6 already, the estimate stays as it is. Does nothing where no estimate is carried.
    pub fn sharpen(&mut self) -> Result<()> {
        let tolerance = (self.scene.transport.tolerance / SHARPER).max(LEAST);
        if self.sharp || !self.state().method.estimate || 2.0 * tolerance > self.scene.transport.tolerance {
            return Ok(());
        }
        let mut scene = self.scene.clone();
        (scene.transport.tolerance, scene.transport.subdivide) = (tolerance, 0);
        let options = Options { mode: Mode::OnTheFly, ..self.plan.options() };
        let device = match &self.backend {
            Backend::Gpu(twin) => Some(twin.device()),
            Backend::Cpu => None,
        };
        let solve = || -> Result<Session> {
            let mut other = Session::new(&scene, device, options, Room::default())?;
            if let Some(camera) = self.state().data.camera.first() {
                other.shift([camera.shift_x, camera.shift_y].map(|x| f64::from(x) / 2.0))?;
            }
            let change = other.pending;
            other.frame(change)?;
            other.fetch(&[Slot::radiosity, Slot::estimate])?;
            Ok(other)
        };
        let other = match solve() {
            Err(Error::Device { .. }) => return Ok(()),
            other => other?,
        };
        self.fetch(&[Slot::radiosity, Slot::estimate])?;
        let data = &mut self.prepared.state.data;
        let sharper = &other.state().data;
        let radiosity = data.radiosity.iter().zip(&sharper.radiosity);
        for ((own, (b, better)), missed) in data.estimate.iter_mut().zip(radiosity).zip(&sharper.estimate) {
            *own = [0, 1, 2].map(|c| ((b[c] - better[c]).abs() + missed[c]).min(f32::MAX));
        }
        self.sharp = true;
        Ok(())
    }
}
