//! What each action does.

use clap::ValueEnum;

use milkglass::error::Result;
use milkglass::scene::Preset;

use super::Viewer;
use crate::cli::run_args::{OptionArguments, TransportArgument};
use crate::cli::view::keys::Action;
use crate::cli::view::turn::{orbit, pan, zoom};

/// What an action has changed.
pub(super) enum Changed {
    /// Nothing that is rendered.
    Nothing,
    /// Camera or lights.
    View,
    /// The scene was read again.
    Scene,
}

impl Viewer {
    /// Does what the user asks for.
    pub(super) fn change(&mut self, action: Action) -> Result<Changed> {
        let camera = &self.edits.scene.camera;
        let view = match &action {
            Action::Orbit(right, up) => Some(orbit(camera, *right, *up)),
            Action::Pan(right, up) => Some(pan(camera, *right, *up)),
            Action::Zoom(factor) => Some(zoom(camera, *factor)),
            Action::Fit => {
                let (low, high) = self.edits.scene.bounds();
                Some(camera.fitted(low, high))
            }
            _ => None,
        };
        if let Some(camera) = view {
            self.edits.look(camera);
            return Ok(Changed::View);
        }
        let material = |key: &str| format!("object.{}.material.{key}", self.object);
        match action {
            Action::Light(right, up) => self.edits.turn_light(right, up).map(|()| Changed::View),
            Action::NextLight => {
                self.edits.next_light();
                Ok(Changed::Nothing)
            }
            Action::NextObject => {
                self.object = (self.object + 1) % self.edits.scene.objects.len();
                self.measure();
                Ok(Changed::Nothing)
            }
            Action::Material(step) => {
                let names = Preset::names();
                let own = &self.edits.scene.objects[self.object].material.name;
                let now = names.iter().position(|name| name == own);
                let next = now.map_or(0, |now| (now as isize + step).rem_euclid(names.len() as isize) as usize);
                self.set(&material("preset"), names[next].to_owned())
            }
            Action::Preset(name) => self.set(&material("preset"), name),
            Action::Size(factor) => self.set(&material("scale"), format!("{:?}", self.scale * factor)),
            Action::Scale(scale) => self.set(&material("scale"), format!("{scale:?}")),
            Action::Tolerance(factor) => {
                let tolerance = (self.edits.scene.transport.tolerance * factor).clamp(1e-6, 0.5);
                self.set("transport.tolerance", format!("{tolerance:?}"))
            }
            Action::ToleranceTo(tolerance) => self.set("transport.tolerance", format!("{tolerance:?}")),
            Action::Method(step) => self.method(step),
            Action::Save => {
                self.saves = true;
                Ok(Changed::Nothing)
            }
            Action::Tell => {
                crate::cli::print(&format!("{}\n", self.command()))?;
                Ok(Changed::Nothing)
            }
            Action::Undo => self.edits.undo().map(|done| if done { Changed::Scene } else { Changed::Nothing }),
            Action::Redo => self.edits.redo().map(|done| if done { Changed::Scene } else { Changed::Nothing }),
            Action::Reset => self.edits.reset().map(|()| Changed::Scene),
            Action::Panel => {
                self.panel = !self.panel;
                Ok(Changed::Nothing)
            }
            Action::Keys => {
                self.keys = !self.keys;
                Ok(Changed::Nothing)
            }
            Action::Quit => {
                self.quits = true;
                Ok(Changed::Nothing)
            }
            Action::Orbit(..) | Action::Pan(..) | Action::Zoom(_) | Action::Fit => Ok(Changed::Nothing),
        }
    }

    /// Makes a setting.
    fn set(&mut self, key: &str, value: String) -> Result<Changed> {
        self.edits.set(key, value).map(|()| Changed::Scene)
    }

    /// Goes over to another method of the list; those that can't serve the scene are told.
    fn method(&mut self, step: isize) -> Result<Changed> {
        let all = TransportArgument::value_variants();
        let now = all.iter().position(|method| *method == self.options.transport).unwrap_or(0);
        let next = (now as isize + step).rem_euclid(all.len() as isize) as usize;
        let options = OptionArguments { transport: all[next], ..self.options };
        self.frames.set_options(&self.edits.scene, options.options())?;
        self.options = options;
        self.message = None;
        Ok(Changed::View)
    }
}
