//! The panel beside the picture, the keys over it, and messages.

use egui::{Align2, Color32, ComboBox, Frame, Grid, Margin, Panel, ProgressBar, RichText, ScrollArea, Slider, Ui};

use milkglass::scene::Preset;

use super::frames::Progress;
use super::keys::{Action, ROWS};

/// Width of the panel in points.
pub(super) const WIDTH: f32 = 270.0;
/// Least time of a stage that has a line of its own, ms.
const LEAST: f64 = 0.05;

/// What the panel shows.
pub(super) struct Facts<'a> {
    pub(super) scene: &'a str,
    pub(super) device: &'a str,
    /// Width and height of the picture in pixels.
    pub(super) size: [u32; 2],
    pub(super) progress: Progress,
    pub(super) samples: u32,
    /// Width and height of what is shown, in pixels.
    pub(super) shown: [u32; 2],
    /// The object that is changed, and their number.
    pub(super) object: [usize; 2],
    pub(super) material: &'a str,
    /// The object's largest extent, mm, without the factor, and the factor on its coefficients.
    pub(super) extent: f64,
    pub(super) scale: f64,
    /// The light that is moved, and their number.
    pub(super) light: [usize; 2],
    pub(super) method: &'a str,
    pub(super) methods: &'a [String],
    pub(super) tolerance: f64,
    pub(super) times: &'a [(String, f64)],
    pub(super) wall: f64,
    /// Bytes of device memory.
    pub(super) memory: u64,
    pub(super) message: Option<&'a str>,
    pub(super) panel: bool,
    pub(super) keys: bool,
}

/// Lays everything out; what the user asks for goes to `actions`.
pub(super) fn lay_out(ui: &mut Ui, facts: &Facts<'_>, actions: &mut Vec<Action>) {
    if facts.panel {
        let frame = Frame::side_top_panel(ui.style()).inner_margin(Margin::same(10));
        let panel = Panel::right("panel").exact_size(WIDTH).resizable(false).show_separator_line(false).frame(frame);
        panel.show(ui, |ui| ScrollArea::vertical().show(ui, |ui| contents(ui, facts, actions)));
    }
    if let Some(message) = facts.message {
        egui::Area::new("message".into()).anchor(Align2::LEFT_TOP, [8.0, 8.0]).show(ui.ctx(), |ui| {
            let frame = Frame::popup(ui.style()).fill(Color32::from_rgb(90, 20, 20));
            frame.show(ui, |ui| {
                ui.set_max_width(420.0);
                ui.label(RichText::new(message).color(Color32::WHITE));
            });
        });
    }
    if facts.keys {
        let window =
            egui::Window::new("Keys").collapsible(false).resizable(false).anchor(Align2::LEFT_BOTTOM, [8.0, -8.0]);
        window.show(ui.ctx(), |ui| {
            Grid::new("keys").striped(true).show(ui, |ui| {
                for row in ROWS {
                    ui.label(RichText::new(row.shown).strong());
                    ui.label(row.does);
                    ui.end_row();
                }
            });
        });
    }
}

fn contents(ui: &mut Ui, facts: &Facts<'_>, actions: &mut Vec<Action>) {
    ui.heading(facts.scene);
    ui.label(facts.device);
    let [width, height] = facts.size;
    ui.label(format!("{width} x {height}: {}", state(facts)));
    ui.separator();

    // What can be changed.
    Grid::new("changes").num_columns(2).show(ui, |ui| {
        let [object, objects] = facts.object;
        if objects > 1 && ui.button(format!("object {object} of {objects}")).clicked() {
            actions.push(Action::NextObject);
        } else if objects == 1 {
            ui.label("material");
        }
        ComboBox::from_id_salt("material").selected_text(facts.material).width(130.0).show_ui(ui, |ui| {
            for name in Preset::names() {
                if ui.selectable_label(name == facts.material, name).clicked() {
                    actions.push(Action::Preset(name.to_owned()));
                }
            }
        });
        ui.end_row();

        ui.label("size, mm");
        let usual = facts.extent.max(1e-9);
        let mut size = usual * facts.scale;
        if ui.add(Slider::new(&mut size, usual * 0.01..=usual * 100.0).logarithmic(true)).changed() {
            actions.push(Action::Scale(size / usual));
        }
        ui.end_row();

        ui.label("method");
        ComboBox::from_id_salt("method").selected_text(facts.method).width(130.0).show_ui(ui, |ui| {
            for (index, name) in facts.methods.iter().enumerate() {
                let now = facts.methods.iter().position(|known| known == facts.method).unwrap_or(0);
                if ui.selectable_label(name == facts.method, name).clicked() {
                    actions.push(Action::Method(index as isize - now as isize));
                }
            }
        });
        ui.end_row();

        ui.label("tolerance");
        let mut tolerance = facts.tolerance;
        if ui.add(Slider::new(&mut tolerance, 1e-4..=0.5).logarithmic(true)).changed() {
            actions.push(Action::ToleranceTo(tolerance));
        }
        ui.end_row();

        let [light, lights] = facts.light;
        ui.label("light");
        if ui.button(format!("{light} of {lights}")).clicked() {
            actions.push(Action::NextLight);
        }
        ui.end_row();
    });
    ui.horizontal(|ui| {
        for (name, action) in [
            ("fit", Action::Fit),
            ("save", Action::Save),
            ("undo", Action::Undo),
            ("reset", Action::Reset),
            ("? keys", Action::Keys),
        ] {
            if ui.button(name).clicked() {
                actions.push(action);
            }
        }
    });
    ui.separator();

    // Where the time goes.
    let total: f64 = facts.times.iter().map(|(_, ms)| ms).filter(|ms| ms.is_finite()).sum();
    ui.label(format!("{total:.1} ms on the device, {:.1} ms in all", facts.wall));
    for (name, ms) in facts.times.iter().filter(|(_, ms)| ms.is_finite() && *ms >= LEAST) {
        let share = if total > 0.0 { (ms / total) as f32 } else { 0.0 };
        ui.add(ProgressBar::new(share).corner_radius(0).desired_height(16.0).text(format!("{name} {ms:.1}")));
    }
    ui.label(format!("{:.0} MiB of device memory", facts.memory as f64 / 1_048_576.0));
}

/// How far the picture is, in words.
fn state(facts: &Facts<'_>) -> String {
    match facts.progress {
        Progress::Changed | Progress::Draft(_) => format!("draft, {} x {}", facts.shown[0], facts.shown[1]),
        Progress::Sample(done) => format!("sample {done} of {}", facts.samples),
        Progress::Whole => "whole".into(),
    }
}
