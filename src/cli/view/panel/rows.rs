//! The rows of the panel: what can be changed.

use egui::{ComboBox, Grid, RichText, Slider, Ui};

use milkglass::scene::Preset;

use super::Facts;
use crate::cli::view::inspect::LAYERS;
use crate::cli::view::keys::Action;

/// Lays out the rows; what the user asks for goes to `actions`.
pub(super) fn lay_out(ui: &mut Ui, facts: &Facts<'_>, actions: &mut Vec<Action>) {
    Grid::new("changes").num_columns(2).show(ui, |ui| {
        object(ui, facts, actions);
        transport(ui, facts, actions);
        view(ui, facts, actions);
    });
}

/// The object: its material, size and deformations.
fn object(ui: &mut Ui, facts: &Facts<'_>, actions: &mut Vec<Action>) {
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
}

/// How light is carried, and the error.
fn transport(ui: &mut Ui, facts: &Facts<'_>, actions: &mut Vec<Action>) {
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
}

/// The light that is moved, and the layer that is shown.
fn view(ui: &mut Ui, facts: &Facts<'_>, actions: &mut Vec<Action>) {
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
