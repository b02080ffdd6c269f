//! The pointer over the picture: drags of the view, the lights and their handles.

use winit::event::MouseButton;

use milkglass::error::Result;

use super::App;
use crate::cli::view::drag::{Drag, handle_at};

impl App {
    /// The pointer has moved to a pixel of the window.
    pub(super) fn moved(&mut self, to: [f64; 2]) -> Result<()> {
        let [right, down] = [0, 1].map(|k| to[k] - self.pointer[k]);
        self.pointer = to;
        self.viewer.pointer = self.over_picture().then_some(to);
        let height = self.viewer.edits.scene.camera.size[1];
        match self.drag {
            Some(drag) if right != 0.0 || down != 0.0 => self.viewer.perform(drag.moved(right, down, height), false),
            _ => Ok(()),
        }
    }

    /// Whether the pointer is over the picture, and over no panel.
    pub(super) fn over_picture(&self) -> bool {
        let picture = self.viewer.edits.scene.camera.size;
        let scale = f64::from(self.egui.pixels_per_point());
        let [x, y] = self.pointer.map(|x| (x / scale) as f32);
        let layer = self.egui.layer_id_at(egui::pos2(x, y));
        let inside = [0, 1].iter().all(|&k| (0.0..f64::from(picture[k])).contains(&self.pointer[k]));
        inside && layer.is_none_or(|layer| layer.order == egui::Order::Background)
    }

    /// A button was pressed, or released.
    pub(super) fn pressed(&mut self, button: MouseButton, pressed: bool) {
        self.drag = if pressed && self.over_picture() { Drag::of(button, self.modifiers) } else { None };
        if self.drag == Some(Drag::Orbit)
            && self.viewer.handles
            && let Some(light) = handle_at(&self.viewer.edits.handles(), self.pointer)
        {
            self.viewer.edits.light = light;
            self.drag = Some(Drag::Handle);
        }
        if self.drag.is_some() {
            self.viewer.edits.begin();
        }
    }
}
