//! A message over the picture.

use egui::{Align2, Area, Color32, Frame, RichText, Ui};

use crate::cli::view::viewer::outcome::Message;

/// The background of a message: of something that is wrong, and of something that is done.
const WRONG: Color32 = Color32::from_rgb(90, 20, 20);
const DONE: Color32 = Color32::from_rgb(20, 60, 30);

/// Draws the message.
pub(super) fn draw(ui: &Ui, message: &Message) {
    Area::new("message".into()).anchor(Align2::LEFT_TOP, [8.0, 8.0]).show(ui.ctx(), |ui| {
        let fill = if message.wrong { WRONG } else { DONE };
        Frame::popup(ui.style()).fill(fill).show(ui, |ui| {
            ui.set_max_width(420.0);
            ui.label(RichText::new(&message.text).color(Color32::WHITE));
        });
    });
}
