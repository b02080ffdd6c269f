//! The strip of the last frames: each a column, the device's milliseconds of each stage stacked, the host's above them.

use egui::ecolor::Hsva;
use egui::{Color32, Rect, Sense, Ui, pos2, vec2};

use crate::cli::view::history::{History, KEPT};

/// Height of the strip in points.
const HEIGHT: f32 = 70.0;
/// How many stages have a line: those that took longest in the last frame.
const LINES: usize = 8;

/// The colour of a stage: neighbours differ.
fn color(stage: usize) -> Color32 {
    Hsva::new((0.12 + 0.618_034 * stage as f32).fract(), 0.65, 0.9, 1.0).into()
}

/// Draws the strip, and the last frame in numbers.
pub(super) fn draw(ui: &mut Ui, history: &History) {
    let Some(last) = history.frames.back() else { return };
    // Columns of nine in ten frames fit into the strip.
    let mut walls: Vec<f64> = history.frames.iter().map(|frame| frame.wall).collect();
    walls.sort_by(f64::total_cmp);
    let most = walls[walls.len() * 9 / 10].max(1.0);
    let (strip, _) = ui.allocate_exact_size(vec2(ui.available_width(), HEIGHT), Sense::hover());
    let painter = ui.painter_at(strip);
    painter.rect_filled(strip, 0.0, Color32::from_gray(16));
    let width = strip.width() / KEPT as f32;
    let left = strip.right() - width * history.frames.len() as f32;
    for (number, frame) in history.frames.iter().enumerate() {
        let x = left + width * number as f32;
        let mut below = 0.0;
        let mut column = |ms: f64, color: Color32| {
            let y = |ms: f64| strip.bottom() - (ms / most).min(1.0) as f32 * HEIGHT;
            painter.rect_filled(Rect::from_min_max(pos2(x, y(below + ms)), pos2(x + width, y(below))), 0.0, color);
            below += ms;
        };
        let stages = history.by_stage(frame);
        let device: f64 = stages.iter().sum();
        stages.iter().enumerate().for_each(|(stage, ms)| column(*ms, color(stage)));
        column((frame.wall - device).max(0.0), Color32::from_gray(90));
    }

    let stages = history.by_stage(last);
    let device: f64 = stages.iter().sum();
    ui.label(format!("{device:.1} ms on the device, {:.1} ms in all; height of the strip: {most:.0} ms", last.wall));
    let mut order: Vec<usize> = (0..stages.len()).filter(|stage| stages[*stage] > 0.0).collect();
    order.sort_by(|a, b| stages[*b].total_cmp(&stages[*a]));
    for stage in order.into_iter().take(LINES) {
        ui.horizontal(|ui| {
            let (square, _) = ui.allocate_exact_size(vec2(10.0, 10.0), Sense::hover());
            ui.painter().rect_filled(square, 0.0, color(stage));
            ui.label(format!("{} {:.1}", history.stages[stage], stages[stage]));
        });
    }
}
