//! The panel beside the picture, the keys over it, and messages.

mod handles;
mod message;
mod rows;
mod strip;

use egui::{Align2, Color32, Frame, Grid, Margin, Panel, Rect, RichText, ScrollArea, Slider, Ui};

use super::amounts::Amount;
use super::frames::Progress;
use super::history::History;
use super::inspect::Layer;
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
    rows::lay_out(ui, facts, actions);
    timeline(ui, facts, actions);
    buttons(ui, actions);
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

/// What else can be done.
fn buttons(ui: &mut Ui, actions: &mut Vec<Action>) {
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
