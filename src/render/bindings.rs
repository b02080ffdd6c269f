//! What has to fit one binding of the device.

use super::run::{Backend, Session};
use crate::error::{Error, Result};
use crate::layout::Slot;

impl Session {
    /// What grows with what the scene asks for has to fit one binding.
    pub(super) fn check_bindings(&self) -> Result<()> {
        let Backend::Gpu(twin) = &self.backend else { return Ok(()) };
        let (data, most) = (&self.prepared.state.data, twin.device().limits().binding_bytes);
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
        Ok(())
    }
}
