//! What the user has changed: settings on top of the scene's file, as `--set` makes them.

#[cfg(test)]
mod tests;
mod values;

use std::path::PathBuf;
use std::time::SystemTime;

use glam::DVec3;
use milkglass::error::Result;
use milkglass::scene::{Camera, Light, Scene};

use super::turn::{Keys, brighten, list, move_light, moves, place_of, project, turn_light};
use crate::cli::SceneArguments;
use crate::cli::bare::Subject;

/// Keys and values, in the order in which they were set.
pub(super) type Made = Vec<(String, String)>;

/// A scene and the settings that were made in the window.
pub(super) struct Edits {
    subject: Subject,
    /// The settings of the command line, before those of the window.
    given: Vec<String>,
    made: Made,
    /// The settings before each change, and those that were taken back.
    undo: Vec<Made>,
    redo: Vec<Made>,
    /// The scene as it is now; its camera has the size of the picture in the window.
    pub(super) scene: Scene,
    /// The light that drags and keys change.
    pub(super) light: usize,
    /// Whether [`Self::adjust`] has changed the scene since it was read.
    adjusted: bool,
    /// The scene's file, and its state when it was read last.
    file: Option<(PathBuf, FileState)>,
}

/// When a file was changed, and its size in bytes.
type FileState = (Option<SystemTime>, u64);

impl Edits {
    /// A scene without changes.
    pub(super) fn of(subject: Subject) -> Result<Self> {
        let file = PathBuf::from(&subject.scenes.scene);
        let file = state(&file).map(|state| (file, state));
        let scene = subject.load()?;
        let light = scene.lights.iter().position(moves).unwrap_or(0);
        let given = subject.scenes.sets.clone();
        Ok(Self {
            subject,
            given,
            made: Vec::new(),
            undo: Vec::new(),
            redo: Vec::new(),
            scene,
            light,
            adjusted: false,
            file,
        })
    }

    /// Begins a change that one [`Self::undo`] takes back.
    pub(super) fn begin(&mut self) {
        if self.undo.last() != Some(&self.made) {
            self.undo.push(self.made.clone());
        }
    }

    /// The scene, with the settings that made it.
    pub(super) fn state(&self) -> (Scene, Made) {
        (self.scene.clone(), self.made.clone())
    }

    /// Goes back to a scene and its settings; the picture keeps its size.
    pub(super) fn restore(&mut self, (scene, made): (Scene, Made)) -> Result<()> {
        let camera = scene.camera.clone().sized(self.scene.camera.size)?;
        (self.scene, self.made, self.adjusted) = (Scene { camera, ..scene }, made, false);
        Ok(())
    }

    /// Reads the scene with other settings; an error leaves everything as it was.
    fn replace(&mut self, made: Made) -> Result<()> {
        let before = std::mem::replace(&mut self.made, made);
        self.read().inspect_err(|_| self.made = before)
    }

    /// The scene with a setting, read anew; an error leaves everything as it was.
    pub(super) fn set(&mut self, key: &str, value: String) -> Result<()> {
        let before = self.made.clone();
        self.note(key, value);
        self.read().inspect_err(|_| self.made = before)
    }

    /// Makes a setting whose effect on the scene is known: without reading the scene, until [`Self::settle`].
    pub(super) fn adjust(&mut self, key: &str, value: String, change: impl FnOnce(&mut Scene)) {
        self.note(key, value);
        change(&mut self.scene);
        self.adjusted = true;
    }

    /// Reads the scene if it was adjusted since it was read; if that fails, takes the last change back, unless the
    /// scene fails without it, too.
    pub(super) fn settle(&mut self) -> Result<()> {
        if !self.adjusted {
            return Ok(());
        }
        let Err(error) = self.read() else { return Ok(()) };
        if let Some(before) = self.undo.last().cloned()
            && self.replace(before).is_ok()
        {
            self.undo.pop();
        }
        self.adjusted = false;
        Err(error)
    }

    /// Goes back to the settings before the last change; returns whether there was one.
    pub(super) fn undo(&mut self) -> Result<bool> {
        while let Some(before) = self.undo.pop() {
            if before != self.made {
                let now = self.made.clone();
                if let Err(error) = self.replace(before.clone()) {
                    self.undo.push(before);
                    return Err(error);
                }
                self.redo.push(now);
                return Ok(true);
            }
        }
        Ok(false)
    }

    /// Makes the settings again that the last undo took back; returns whether there were any.
    pub(super) fn redo(&mut self) -> Result<bool> {
        let Some(after) = self.redo.pop() else { return Ok(false) };
        let now = self.made.clone();
        if let Err(error) = self.replace(after.clone()) {
            self.redo.push(after);
            return Err(error);
        }
        self.undo.push(now);
        Ok(true)
    }

    /// The scene's frame.
    pub(super) fn frame(&self) -> f64 {
        self.subject.scenes.frame
    }

    /// The scene at another frame; an error leaves everything as it was.
    pub(super) fn set_frame(&mut self, frame: f64) -> Result<()> {
        let before = std::mem::replace(&mut self.subject.scenes.frame, frame);
        self.read().inspect_err(|_| self.subject.scenes.frame = before)
    }

    /// The scene's file with all settings, and the picture's size.
    pub(super) fn written(&self) -> Result<String> {
        let camera = &self.scene.camera;
        let mut sets = SceneArguments { sets: self.sets(), ..self.subject.scenes.clone() }.sets();
        sets.push(format!("camera.size=[{}, {}]", camera.size[0], camera.size[1]));
        if self.scene.frames.is_none() {
            // A view that was fitted to another size stays.
            sets.push(format!("camera.position={}", list(camera.position)));
            sets.push(format!("camera.target={}", list(camera.target)));
        }
        self.scene.written(&sets)
    }

    /// Takes all settings of the window back.
    pub(super) fn reset(&mut self) -> Result<()> {
        self.redo.clear();
        self.replace(Vec::new())
    }

    /// Adopts another view.
    pub(super) fn look(&mut self, camera: Camera) {
        for (key, value) in [("camera.position", camera.position), ("camera.target", camera.target)] {
            self.note(key, list(value));
        }
        self.scene.camera = Camera { position: camera.position, target: camera.target, ..self.scene.camera.clone() };
    }

    /// Turns the light about the middle of the scene, by degrees as the camera sees it.
    pub(super) fn turn_light(&mut self, right: f64, up: f64) -> Result<()> {
        let (middle, _) = self.middle();
        self.change_light(|light, camera| turn_light(light, camera, middle, right, up))
    }

    /// Shifts the light, by parts of the picture's height as the camera sees it where the light is.
    pub(super) fn shift_light(&mut self, right: f64, up: f64) -> Result<()> {
        let (middle, extent) = self.middle();
        self.change_light(|light, camera| {
            let Some(place) = place_of(light, middle, extent) else { return Vec::new() };
            let depth = project(camera, place).map_or(extent, |(_, depth)| depth);
            let (across, upwards, _) = camera.basis();
            let height = 2.0 * depth * (camera.fov.to_radians() / 2.0).tan();
            move_light(light, middle, place + height * (across * right + upwards * up))
        })
    }

    /// Where each light is seen, in pixels from the upper left; none for one that is not seen, or can't be moved.
    pub(super) fn handles(&self) -> Vec<Option<[f64; 2]>> {
        let (middle, extent) = self.middle();
        let seen = |light| project(&self.scene.camera, place_of(light, middle, extent)?).map(|(at, _)| at);
        self.scene.lights.iter().map(seen).collect()
    }

    /// The middle of the scene, and half its diagonal.
    fn middle(&self) -> (DVec3, f64) {
        let (low, high) = self.scene.bounds();
        ((low + high) / 2.0, (high - low).length() / 2.0)
    }

    /// Changes the light, unless it would get into an object; `change` returns the keys it changes.
    fn change_light(&mut self, change: impl FnOnce(&mut Light, &Camera) -> Keys) -> Result<()> {
        let Some(light) = self.scene.lights.get_mut(self.light) else { return Ok(()) };
        let before = light.clone();
        let keys = change(light, &self.scene.camera);
        if let Err(error) = self.scene.check_lights() {
            self.scene.lights[self.light] = before;
            return Err(error);
        }
        for (key, value) in keys {
            self.note(&format!("light.{}.{key}", self.light), value);
        }
        Ok(())
    }

    /// Multiplies what the light emits.
    pub(super) fn brighten_light(&mut self, factor: f64) -> Result<()> {
        self.change_light(|light, _| brighten(light, factor))
    }

    /// The next light.
    pub(super) fn next_light(&mut self) {
        self.light = (self.light + 1) % self.scene.lights.len().max(1);
    }

    /// Reads the scene again if its file has changed; returns whether it has.
    pub(super) fn reload(&mut self) -> Result<bool> {
        let Some((path, known)) = &mut self.file else { return Ok(false) };
        // A file that is being replaced may be missing for a moment.
        let Some(now) = state(path).filter(|now| now != known) else { return Ok(false) };
        *known = now;
        self.read().map(|()| true)
    }

    /// The settings of the window as arguments.
    pub(super) fn arguments(&self) -> Vec<String> {
        self.made.iter().flat_map(|(key, value)| ["--set".to_owned(), format!("{key}={value}")]).collect()
    }

    /// The settings of the command line, then those of the window.
    fn sets(&self) -> Vec<String> {
        let made = self.made.iter().map(|(key, value)| format!("{key}={value}"));
        self.given.iter().cloned().chain(made).collect()
    }

    /// Makes a setting without reading the scene.
    fn note(&mut self, key: &str, value: String) {
        self.redo.clear();
        self.made.retain(|(known, _)| known != key);
        self.made.push((key.to_owned(), value));
    }

    /// Reads the scene with all settings.
    fn read(&mut self) -> Result<()> {
        self.subject.scenes.sets = self.sets();
        let scene = self.subject.at(self.subject.scenes.frame)?;
        // The window gives the picture its size.
        let camera = scene.camera.clone().sized(self.scene.camera.size)?;
        (self.scene, self.adjusted) = (Scene { camera, ..scene }, false);
        if self.light >= self.scene.lights.len() {
            self.light = self.scene.lights.iter().position(moves).unwrap_or(0);
        }
        Ok(())
    }
}

/// The state of a plain file; none for anything else.
fn state(path: &PathBuf) -> Option<FileState> {
    let known = std::fs::metadata(path).ok().filter(std::fs::Metadata::is_file)?;
    Some((known.modified().ok(), known.len()))
}
