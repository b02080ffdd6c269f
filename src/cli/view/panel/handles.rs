//! The lights' handles.

use egui::{Color32, Rect, Stroke, Ui};

use super::Facts;

/// Radius of a handle in points.
const HANDLE: f32 = 6.0;

/// Draws the lights' handles over the picture; the handle of the light that drags and keys change is filled.
pub(super) fn draw(ui: &Ui, facts: &Facts<'_>, picture: Rect) {
    let painter = ui.painter().with_clip_rect(picture);
    let points = ui.ctx().pixels_per_point();
    for (light, handle) in facts.handles.iter().enumerate() {
        let Some([x, y]) = handle else { continue };
        let at = egui::pos2(*x as f32, *y as f32) / points;
        let chosen = light + 1 == facts.light[0];
        painter.circle(
            at,
            HANDLE,
            if chosen { Color32::GOLD } else { Color32::TRANSPARENT },
            Stroke::new(1.5, Color32::GOLD),
        );
        painter.circle_stroke(at, HANDLE + 1.5, Stroke::new(1.0, Color32::BLACK));
    }
}
