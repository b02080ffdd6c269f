//! Checks that buffers fit the device's bindings, and kept lists its memory.

use super::run::Session;
use crate::error::{Error, KeepLimit, Result};
use crate::layout::{BUFFER_IDS, BufferId};
use crate::pipeline::plan::Mode;

impl Session {
    /// An error unless buffers that grow with the scene's settings fit one binding and, where links are kept, all
    /// buffers together fit the device's memory.
    pub(crate) fn check_bindings(&self) -> Result<()> {
        let Some(limits) = self.limits() else { return Ok(()) };
        let data = &self.state().data;
        let most = limits.binding_bytes;
        let faces = self.state().sum(|object| object.count.faces);
        let bits = |items: String, words: u32| format!("a bit for each of {items} and {} light samples", 32 * words);
        let at_pixels = data.camera.first().map_or(0, |camera| camera.shadow_words);
        let fewer = "use fewer samples, or shadows = false";
        for (id, what, advice) in [
            (BufferId::lit, bits(format!("{faces} faces"), data.object_params[0].shadow_words), fewer),
            (BufferId::pixel_lit, bits(format!("{} pixels", data.hits.len()), at_pixels), fewer),
            (
                BufferId::irradiance_maps,
                format!("the light of {} texels", data.texel_hits.len()),
                "use a smaller transport.blur_texture",
            ),
        ] {
            let bytes = data.bytes(id).len() as u64;
            if bytes > most {
                let what = format!("{what} takes {bytes} bytes, a binding of the device takes {most}; {advice}");
                return Err(Error::device(format!("making room for buffer {}", id.spec().name), what));
            }
        }
        // Without kept links every buffer is necessary; the driver reports whether they fit.
        let all: u64 = BUFFER_IDS.iter().map(|id| data.bytes(*id).len() as u64).sum();
        if self.plan.options().mode != Mode::OnTheFly && all > limits.heap_bytes {
            let what = format!("all buffers take {all} bytes, the device's memory holds {}", limits.heap_bytes);
            return Err(Error::TooMuchToKeep { what, limited_by: KeepLimit::Device });
        }
        Ok(())
    }
}
