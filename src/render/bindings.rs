//! Checks that buffers fit the device's bindings, and kept ones its memory.

use super::plan::Mode;
use super::run::Session;
use crate::error::{Error, KeepLimit, Result};
use crate::layout::{SLOTS, Slot};

impl Session {
    /// Buffers that grow with the scene's settings have to fit one binding. Where links are kept, all buffers together
    /// have to fit the device's memory.
    pub(super) fn check_bindings(&self) -> Result<()> {
        let Some(limits) = self.limits() else { return Ok(()) };
        let data = &self.state().data;
        let most = limits.binding_bytes;
        let (faces, samples) = (self.state().sum(|object| object.count.faces), 32 * data.frame[0].shadow_words);
        let bits = |of: String| format!("a bit for each of {of} and {samples} samples of lights");
        let fewer = "use fewer samples, or shadows = false";
        for (slot, what, advice) in [
            (Slot::lit, bits(format!("{faces} faces")), fewer),
            (Slot::reached, bits(format!("{} pixels", data.hits.len())), fewer),
            (
                Slot::sheets,
                format!("the light of {} texels", data.charts.len()),
                "use a smaller transport.blur_texture",
            ),
        ] {
            let bytes = data.bytes(slot).len() as u64;
            if bytes > most {
                let what = format!("{what} takes {bytes} bytes, a binding of the device takes {most}; {advice}");
                return Err(Error::device(format!("making room for buffer {}", slot.spec().name), what));
            }
        }
        // Without kept links every buffer is necessary; the driver reports whether they fit.
        let all: u64 = SLOTS.iter().map(|slot| data.bytes(*slot).len() as u64).sum();
        if self.plan.options().mode != Mode::OnTheFly && all > limits.heap_bytes {
            let what = format!("all buffers take {all} bytes, the device's memory holds {}", limits.heap_bytes);
            return Err(Error::TooMuchToKeep { what, limited_by: KeepLimit::Device });
        }
        Ok(())
    }
}
