//! What each action does.

use clap::ValueEnum;

use milkglass::error::Result;
use milkglass::internals::pipeline::plan::ShadingMethod;
use milkglass::scene::{Preset, Scheme};

use super::outcome::{Changed, Message, Output};
use super::{Viewer, place};
use crate::cli::run_args::OptionArguments;
use crate::cli::view::amounts::{Amount, amounts, set_amount};
use crate::cli::view::inspect::{LAYERS, Layer};
use crate::cli::view::keys::Action;
use crate::cli::view::turn::{orbit, pan, zoom};

/// What is added to an object's deformations.
const TWIST: &str = "{ type = \"twist\", angle = 45 }";

impl Viewer {
    /// Does what the user asks for.
    pub(super) fn change(&mut self, action: Action) -> Result<Changed> {
        match action {
            Action::Orbit(..) | Action::Pan(..) | Action::Zoom(_) | Action::Fit => self.move_camera(&action),
            Action::Light(right, up) => self.edits.turn_light(right, up).map(|()| Changed::Light),
            Action::Shift(right, up) => self.edits.shift_light(right, up).map(|()| Changed::Light),
            Action::Brighten(factor) => self.edits.brighten_light(factor).map(|()| Changed::Light),
            Action::Material(step) => self.step_material(step),
            Action::Preset(name) => self.set_material("preset", name),
            Action::Size(factor) => self.set_material("scale", format!("{:?}", self.scale * factor)),
            Action::Scale(scale) => self.set_material("scale", format!("{scale:?}")),
            Action::Tolerance(factor) => {
                self.set_tolerance((self.edits.scene.transport.tolerance * factor).clamp(1e-6, 0.5))
            }
            Action::ToleranceTo(tolerance) => self.set_tolerance(tolerance),
            Action::Twist => self.twist(),
            Action::Deform(part) => self.deform_by(part),
            Action::DeformTo(index, to) => {
                self.deform = index;
                self.deform_to(index, to)
            }
            Action::Frame(step) => self.go_to(self.edits.frame() + step),
            Action::FrameTo(frame) => self.go_to(frame),
            Action::Method(step) => self.step_method(step),
            Action::Mode => {
                let mode = stepped(&self.options.mode, 1);
                self.set_options(OptionArguments { mode, ..self.options })
            }
            Action::Scheme => {
                let links = self.edits.scene.transport.scheme == Scheme::Links;
                self.set("transport.scheme", if links { "blocks" } else { "links" }.to_owned())
            }
            Action::Layer(step) => {
                let now = LAYERS.iter().position(|(_, layer)| *layer == self.frames.layer()).unwrap_or(0);
                let next = (now as isize + step).rem_euclid(LAYERS.len() as isize) as usize;
                self.show(LAYERS[next].1)
            }
            Action::Pick => self.show(Layer::Clusters),
            Action::Save => self.put_out(Output::Png),
            Action::SaveExr => self.put_out(Output::Exr),
            Action::SaveScene => self.put_out(Output::Scene),
            Action::Trace => self.put_out(Output::Trace),
            Action::Tell => {
                crate::cli::print(&format!("{}\n", self.command()))?;
                Ok(Changed::Nothing)
            }
            Action::Undo => self.edits.undo().map(|done| if done { Changed::Scene } else { Changed::Nothing }),
            Action::Redo => self.edits.redo().map(|done| if done { Changed::Scene } else { Changed::Nothing }),
            Action::Reset => self.edits.reset().map(|()| Changed::Scene),
            Action::NextLight | Action::NextObject | Action::NextDeform | Action::Sharpen | Action::Play => {
                Ok(self.turn_to(&action))
            }
            Action::Loop | Action::Handles | Action::Panel | Action::Keys | Action::Quit => Ok(self.toggle(&action)),
        }
    }

    /// Moves the camera.
    fn move_camera(&mut self, action: &Action) -> Result<Changed> {
        let camera = &self.edits.scene.camera;
        let moved = match action {
            Action::Orbit(right, up) => orbit(camera, *right, *up),
            Action::Pan(right, up) => pan(camera, *right, *up),
            Action::Zoom(factor) => zoom(camera, *factor),
            _ => {
                let (low, high) = self.edits.scene.bounds();
                camera.fitted(low, high)
            }
        };
        self.edits.look(moved);
        Ok(Changed::View)
    }

    /// Turns to the next thing of a kind, or to other work; none of it is rendered.
    fn turn_to(&mut self, action: &Action) -> Changed {
        match action {
            Action::NextLight => self.edits.next_light(),
            Action::NextObject => {
                self.object = (self.object + 1) % self.edits.scene.objects.len();
                self.measure();
            }
            Action::NextDeform => {
                self.deform += 1;
                self.measure();
            }
            Action::Sharpen => self.frames.sharpen(),
            _ => self.play(),
        }
        Changed::Nothing
    }

    /// Turns a switch of the window over.
    fn toggle(&mut self, action: &Action) -> Changed {
        match action {
            Action::Loop => self.timeline.loops = !self.timeline.loops,
            Action::Handles => self.handles = !self.handles,
            Action::Panel => self.panel = !self.panel,
            Action::Keys => self.keys = !self.keys,
            _ => self.quits = true,
        }
        Changed::Nothing
    }

    /// Takes the preset so many places on in the list.
    fn step_material(&mut self, step: isize) -> Result<Changed> {
        let names = Preset::names();
        let own = &self.edits.scene.objects[self.object].material.name;
        let now = names.iter().position(|name| name == own);
        let next = now.map_or(0, |now| (now as isize + step).rem_euclid(names.len() as isize) as usize);
        self.set_material("preset", names[next].to_owned())
    }

    /// Adds a twist to the object.
    fn twist(&mut self) -> Result<Changed> {
        let next = self.amounts().len();
        let twist = self.set(&format!("object.{}.deform.{next}", self.object), TWIST.to_owned())?;
        self.deform = next;
        Ok(twist)
    }

    /// Deforms the object further, by a part of what the slider offers.
    fn deform_by(&mut self, part: f64) -> Result<Changed> {
        match self.amounts().get(self.deform) {
            Some(amount) => {
                let to = amount.value + part * (amount.ends[1] - amount.ends[0]);
                self.deform_to(self.deform, to)
            }
            None => Ok(Changed::Nothing),
        }
    }

    /// Goes over to another method; a step of one goes on past those that can't serve the scene, and tells why.
    fn step_method(&mut self, step: isize) -> Result<Changed> {
        let mut refused = None;
        for further in 0..ShadingMethod::value_variants().len() as isize {
            let transport = stepped(&self.options.transport, step + further * step.signum());
            match self.set_options(OptionArguments { transport, ..self.options }) {
                Ok(changed) => {
                    self.message = refused;
                    return Ok(changed);
                }
                Err(error) if step.abs() == 1 && !error.is_device_fault() => {
                    refused.get_or_insert(Message::of(&error));
                }
                Err(error) => return Err(error),
            }
        }
        Ok(Changed::Nothing)
    }

    /// Makes a setting.
    fn set(&mut self, key: &str, value: String) -> Result<Changed> {
        self.edits.set(key, value).map(|()| Changed::Scene)
    }

    /// The amounts of the object's deformations.
    fn amounts(&self) -> Vec<Amount> {
        let scene = &self.edits.scene;
        amounts(&scene.objects[self.object], self.extent / scene.unit_mm)
    }

    /// Sets the amount of a deformation.
    fn deform_to(&mut self, index: usize, to: f64) -> Result<Changed> {
        let (object, all) = (self.object, self.amounts());
        let Some(amount) = all.get(index) else { return Ok(Changed::Nothing) };
        let key = format!("object.{object}.deform.{index}.{}", amount.key);
        // What a scene may have; one without an effect may be left out of it.
        let to = if amount.kind == "morph" { to.clamp(-10.0, 10.0) } else { to.clamp(-36_000.0, 36_000.0) };
        if to == 0.0 || amount.value == 0.0 {
            return self.set(&key, format!("{to:?}"));
        }
        self.edits.adjust(&key, format!("{to:?}"), |scene| set_amount(&mut scene.objects[object], index, to));
        Ok(Changed::Scene)
    }

    /// Changes the object's material.
    fn set_material(&mut self, key: &str, value: String) -> Result<Changed> {
        let (object, full) = (self.object, format!("object.{}.material.{key}", self.object));
        match self.edits.material(object, key, &value) {
            Some(material) => {
                self.edits.adjust(&full, value, |scene| scene.objects[object].material = material);
                Ok(Changed::Scene)
            }
            None => self.set(&full, value),
        }
    }

    /// Sets the tolerance.
    fn set_tolerance(&mut self, tolerance: f64) -> Result<Changed> {
        let value = format!("{tolerance:?}");
        self.edits.adjust("transport.tolerance", value, |scene| scene.transport.tolerance = tolerance);
        Ok(Changed::Scene)
    }

    /// Shows a layer, for the pixel at the pointer or else the middle one.
    fn show(&mut self, layer: Layer) -> Result<Changed> {
        let size = self.edits.scene.camera.size;
        let middle = size.map(|side| f64::from(side) / 2.0);
        let at = self.pointer.unwrap_or(middle);
        self.pick = [0, 1].map(|k| (at[k].max(0.0) as u32).min(size[k] - 1));
        self.frames.set_layer(layer, self.pick);
        self.message = None;
        Ok(Changed::View)
    }

    /// Asks for a file.
    fn put_out(&mut self, output: Output) -> Result<Changed> {
        self.output = Some(output);
        Ok(Changed::Nothing)
    }

    /// Goes over to other options; those that can't serve the scene are told.
    fn set_options(&mut self, options: OptionArguments) -> Result<Changed> {
        self.frames.set_options(&self.edits.scene, options.options())?;
        self.options = options;
        self.message = None;
        Ok(Changed::Light)
    }
}

/// The value so many places on in the list of its argument.
fn stepped<T: ValueEnum + Copy + PartialEq>(value: &T, step: isize) -> T {
    let all = T::value_variants();
    all[(place(value) as isize + step).rem_euclid(all.len() as isize) as usize]
}
