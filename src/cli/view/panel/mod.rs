//! The panel beside the picture, the keys over it, and messages.

mod handles;
mod message;
mod strip;

use egui::{Align2, Color32, ComboBox, Frame, Grid, Margin, Panel, Rect, RichText, ScrollArea, Slider, Ui};

use milkglass::scene::Preset;

use super::amounts::Amount;
use super::frames::Progress;
use super::history::History;
use super::inspect::{LAYERS, Layer};
use super::keys::{Action, ROWS};
use super::viewer::outcome::Message;

/// Width of the panel in points.
pub(super) const WIDTH: f32 = 270.0;

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
    /// The number of the object that is changed, from 1 on, and the number of objects.
    pub(super) object: [usize; 2],
    pub(super) material: &'a str,
    /// The object's largest extent, mm, without the factor, and the factor on its coefficients.
    pub(super) extent: f64,
    pub(super) scale: f64,
    /// The object's deformations, and which of them keys change.
    pub(super) amounts: Vec<Amount>,
    pub(super) deform: usize,
    /// The number of the light that is changed, from 1 on, and the number of lights.
    pub(super) light: [usize; 2],
    /// Where the lights are seen, in pixels.
    pub(super) handles: Vec<Option<[f64; 2]>>,
    pub(super) method: &'a str,
    pub(super) methods: &'a [String],
    pub(super) mode: &'a str,
    pub(super) scheme: &'a str,
    pub(super) tolerance: f64,
    /// The picture's estimated error, r g b, and whether nothing is left to do.
    pub(super) error: Option<[f64; 3]>,
    pub(super) settled: bool,
    pub(super) layer: Layer,
    /// What the layer's colours mean.
    pub(super) legend: &'a [Vec<String>],
    /// The first and the last frame of an animation, the frame that is shown, whether it plays, and whether it begins
    /// again at its end.
    pub(super) frames: Option<[f64; 2]>,
    pub(super) frame: f64,
    pub(super) plays: bool,
    pub(super) loops: bool,
    pub(super) history: &'a History,
    /// Entries of the longest lists, and repeated frames.
    pub(super) counts: [u64; 2],
    /// Bytes of device memory.
    pub(super) memory: u64,
    pub(super) message: Option<&'a Message>,
    pub(super) panel: bool,
    pub(super) keys: bool,
}

/// Lays everything out; what the user asks for goes to `actions`. Returns what is left for the picture.
pub(super) fn lay_out(ui: &mut Ui, facts: &Facts<'_>, actions: &mut Vec<Action>) -> Rect {
    let mut free = ui.available_rect_before_wrap();
    if facts.panel {
        // Exactly, whatever the width of the contents.
        free.max.x = (free.max.x - WIDTH).max(free.min.x);
        let frame = Frame::side_top_panel(ui.style()).inner_margin(Margin::same(10));
        let panel = Panel::right("panel").exact_size(WIDTH).resizable(false).show_separator_line(false).frame(frame);
        panel.show(ui, |ui| ScrollArea::vertical().auto_shrink(false).show(ui, |ui| contents(ui, facts, actions)));
    }
    handles::draw(ui, facts, free);
    facts.message.iter().for_each(|message| message::draw(ui, message));
    if facts.keys {
        let window =
            egui::Window::new("Keys").collapsible(false).resizable(false).anchor(Align2::LEFT_BOTTOM, [8.0, -8.0]);
        window.show(ui.ctx(), |ui| {
            ui.style_mut().override_font_id = Some(egui::FontId::proportional(11.0));
            ScrollArea::vertical().max_height(ui.ctx().content_rect().height() - 70.0).show(ui, |ui| {
                Grid::new("keys").striped(true).spacing([10.0, 1.0]).min_row_height(12.0).show(ui, |ui| {
                    for row in ROWS {
                        ui.label(RichText::new(row.shown).strong());
                        ui.label(row.does);
                        ui.end_row();
                    }
                });
            });
        });
    }
    free
}

fn contents(ui: &mut Ui, facts: &Facts<'_>, actions: &mut Vec<Action>) {
    ui.heading(facts.scene);
    ui.label(facts.device);
    let [width, height] = facts.size;
    ui.label(format!("{width} x {height}: {}", state(facts)));
    ui.separator();

    // What can be changed.
    ui.spacing_mut().slider_width = 90.0;
    Grid::new("changes").num_columns(2).show(ui, |ui| {
        let [object, objects] = facts.object;
        if objects > 1 && ui.button(format!("object {object} of {objects}")).clicked() {
            actions.push(Action::NextObject);
        } else if objects == 1 {
            ui.label("material");
        }
        let presets: Vec<&str> = Preset::names().to_vec();
        if let Some(index) = choice(ui, "material", facts.material, &presets) {
            actions.push(Action::Preset(presets[index].to_owned()));
        }
        ui.end_row();

        ui.label("size, mm");
        let usual = facts.extent.max(1e-9);
        let mut size = usual * facts.scale;
        if ui.add(Slider::new(&mut size, usual * 0.01..=usual * 100.0).logarithmic(true)).changed() {
            actions.push(Action::Scale(size / usual));
        }
        ui.end_row();

        for (index, amount) in facts.amounts.iter().enumerate() {
            let name = RichText::new(amount.kind);
            ui.label(if index == facts.deform { name.strong() } else { name });
            let mut value = amount.value;
            if ui.add(Slider::new(&mut value, amount.ends[0]..=amount.ends[1])).changed() {
                actions.push(Action::DeformTo(index, value));
            }
            ui.end_row();
        }

        ui.label("method");
        let methods: Vec<&str> = facts.methods.iter().map(String::as_str).collect();
        if let Some(index) = choice(ui, "method", facts.method, &methods) {
            let now = methods.iter().position(|known| *known == facts.method).unwrap_or(0);
            actions.push(Action::Method(index as isize - now as isize));
        }
        ui.end_row();

        ui.label("scheme, mode");
        ui.horizontal(|ui| {
            for (name, action) in [(facts.scheme, Action::Scheme), (facts.mode, Action::Mode)] {
                if ui.button(name).clicked() {
                    actions.push(action);
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

        ui.label("error, L2");
        ui.horizontal(|ui| {
            let none = if facts.settled { "not estimated" } else { "to be estimated" };
            let worst = facts.error.map(|error| error.into_iter().fold(0.0, f64::max));
            ui.label(worst.map_or(none.into(), |worst| format!("up to {worst:.1e}")));
            if worst.is_some() && ui.button("sharpen").clicked() {
                actions.push(Action::Sharpen);
            }
        });
        ui.end_row();

        let [light, lights] = facts.light;
        ui.label("light");
        ui.horizontal(|ui| {
            if ui.button(format!("{light} of {lights}")).clicked() {
                actions.push(Action::NextLight);
            }
            for (name, factor) in [("-", 1.0 / 1.1), ("+", 1.1)] {
                if lights > 0 && ui.button(name).clicked() {
                    actions.push(Action::Brighten(factor));
                }
            }
            if ui.button("handles").clicked() {
                actions.push(Action::Handles);
            }
        });
        ui.end_row();

        ui.label("layer");
        let layers = LAYERS.map(|(name, _)| name);
        let now = LAYERS.iter().position(|(_, layer)| *layer == facts.layer).unwrap_or(0);
        if let Some(index) = choice(ui, "layer", layers[now], &layers) {
            actions.push(Action::Layer(index as isize - now as isize));
        }
        ui.end_row();
    });
    timeline(ui, facts, actions);
    let rows = [
        [
            ("fit", Action::Fit),
            ("undo", Action::Undo),
            ("redo", Action::Redo),
            ("reset", Action::Reset),
            ("twist", Action::Twist),
        ],
        [
            ("png", Action::Save),
            ("exr", Action::SaveExr),
            ("scene", Action::SaveScene),
            ("trace", Action::Trace),
            ("? keys", Action::Keys),
        ],
    ];
    for row in rows {
        ui.horizontal(|ui| {
            ui.spacing_mut().item_spacing.x = 4.0;
            for (name, action) in row {
                if ui.button(name).clicked() {
                    actions.push(action);
                }
            }
        });
    }
    ui.separator();
    if facts.layer != Layer::Light && facts.progress == Progress::Whole {
        legend(ui, facts.legend);
    }
    strip::draw(ui, facts.history);
    let ([links, retries], memory) = (facts.counts, facts.memory as f64 / 1_048_576.0);
    ui.label(format!(
        "{memory:.0} MiB of device memory\n{links} links in the longest lists, {retries} frames repeated"
    ));
}

/// A list to choose from; the index of what was chosen.
fn choice(ui: &mut Ui, id: &str, now: &str, all: &[&str]) -> Option<usize> {
    let mut chosen = None;
    ComboBox::from_id_salt(id).selected_text(now).width(120.0).show_ui(ui, |ui| {
        for (index, name) in all.iter().enumerate() {
            if ui.selectable_label(*name == now, *name).clicked() {
                chosen = Some(index);
            }
        }
    });
    chosen
}

/// The frames of an animation.
fn timeline(ui: &mut Ui, facts: &Facts<'_>, actions: &mut Vec<Action>) {
    let Some([first, last]) = facts.frames else { return };
    ui.horizontal(|ui| {
        if ui.button(if facts.plays { "stop" } else { "play" }).clicked() {
            actions.push(Action::Play);
        }
        if ui.selectable_label(facts.loops, "loop").clicked() {
            actions.push(Action::Loop);
        }
        let mut frame = facts.frame;
        if ui.add(Slider::new(&mut frame, first..=last).step_by(1.0)).changed() {
            actions.push(Action::FrameTo(frame));
        }
    });
}

/// What the colours of a layer mean.
fn legend(ui: &mut Ui, rows: &[Vec<String>]) {
    Grid::new("legend").spacing([10.0, 0.0]).show(ui, |ui| {
        for row in rows {
            for cell in row {
                match Color32::from_hex(cell) {
                    Ok(color) => ui.label(RichText::new("      ").background_color(color)),
                    Err(_) => ui.label(cell),
                };
            }
            ui.end_row();
        }
    });
}

/// How far the picture is, in words.
fn state(facts: &Facts<'_>) -> String {
    match facts.progress {
        Progress::Changed | Progress::Draft(_) => format!("draft, {} x {}", facts.shown[0], facts.shown[1]),
        Progress::Sample(done) => format!("sample {done} of {}", facts.samples),
        Progress::Whole => "whole".into(),
    }
}
