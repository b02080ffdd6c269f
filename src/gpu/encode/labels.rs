//! Labels in command buffers, by which tools such as RenderDoc and Nsight show steps and dispatches.

use std::ffi::CString;

use ash::vk;

use super::Encoded;
use crate::gpu::faults::{Told, tell};
use crate::gpu::list::Place;

impl Encoded {
    /// What is recorded from here on is within this label, where the loader offers labels.
    pub(super) fn begin_label(&self, name: &str, place: Place) {
        let Some(debug) = self.device.debug() else { return };
        let text = if place == Place::default() { name.to_string() } else { format!("{name} of {place}") };
        let Ok(label) = CString::new(text.as_str()) else { return };
        let info = vk::DebugUtilsLabelEXT::default().label_name(&label);
        // SAFETY: the command buffer is recording.
        unsafe { debug.cmd_begin_debug_utils_label(self.now, &info) };
        tell(|| Told::Begin(text));
    }

    /// The label that began last ends.
    pub(super) fn end_label(&self) {
        let Some(debug) = self.device.debug() else { return };
        // SAFETY: the command buffer is recording, and the label began in it.
        unsafe { debug.cmd_end_debug_utils_label(self.now) };
        tell(|| Told::End);
    }
}
