//! The scene in the window and what the user does with it, apart from the window itself.

mod change;

use std::path::PathBuf;

use clap::ValueEnum;

use milkglass::error::{Error, Result};
use milkglass::internals::gpu::Device;
use milkglass::internals::view::picture::save_png;
use milkglass::scene::Scene;

use self::change::Changed;
use super::edits::Edits;
use super::frames::{Frames, Progress};
use super::keys::Action;
use super::panel::Facts;
use crate::cli::bare::Subject;
use crate::cli::open_session;
use crate::cli::run_args::{OptionArguments, TransportArgument, quoted};

/// A scene that is looked at and changed.
pub(super) struct Viewer {
    pub(super) edits: Edits,
    pub(super) frames: Frames,
    device: Device,
    options: OptionArguments,
    methods: Vec<String>,
    /// The arguments of `render` besides those of the window.
    words: Vec<String>,
    /// The object that is changed.
    object: usize,
    /// Its largest extent, mm, and the factor on its coefficients.
    extent: f64,
    scale: f64,
    /// The last scene that could be rendered, if another one is now to be.
    good: Option<Scene>,
    pub(super) message: Option<String>,
    pub(super) panel: bool,
    keys: bool,
    /// Whether the picture is to be saved once it is whole.
    saves: bool,
    pub(super) quits: bool,
}

impl Viewer {
    /// A scene with the picture's size in pixels, if it is another than the scene's.
    pub(super) fn new(
        subject: Subject,
        size: Option<[u32; 2]>,
        device: &Device,
        options: OptionArguments,
        words: Vec<String>,
    ) -> Result<Self> {
        let mut edits = Edits::of(subject)?;
        if let Some(size) = size {
            edits.scene.camera = edits.scene.camera.clone().sized(size)?;
        }
        let session = open_session(&edits.scene, Some(device), options.options())?;
        let frames = Frames::new(session, device, options.options());
        let names = TransportArgument::value_variants().iter().filter_map(ValueEnum::to_possible_value);
        let mut viewer = Self {
            edits,
            frames,
            device: device.clone(),
            options,
            methods: names.map(|name| name.get_name().to_owned()).collect(),
            words,
            object: 0,
            extent: 0.0,
            scale: 1.0,
            good: None,
            message: None,
            panel: true,
            keys: false,
            saves: false,
            quits: false,
        };
        viewer.measure();
        Ok(viewer)
    }

    /// The size of the object that is changed.
    fn measure(&mut self) {
        let scene = &self.edits.scene;
        self.object = self.object.min(scene.objects.len() - 1);
        let (low, high) = scene.objects[self.object].bounds();
        self.extent = (high - low).max_element() * scene.unit_mm;
        self.scale = self.edits.number(&format!("object.{}.material.scale", self.object)).unwrap_or(1.0);
    }

    /// Reads the scene's file again if it has changed.
    pub(super) fn reload(&mut self) -> Result<()> {
        let before = self.edits.scene.clone();
        match self.edits.reload() {
            Ok(false) => Ok(()),
            Ok(true) => {
                self.adopt(before);
                Ok(())
            }
            Err(error) => self.tell(error),
        }
    }

    /// Goes over to a scene that was just read.
    fn adopt(&mut self, before: Scene) {
        self.good.get_or_insert(before);
        self.message = None;
        self.frames.change();
        self.measure();
    }

    /// Shows an error, unless it is the device's.
    fn tell(&mut self, error: Error) -> Result<()> {
        if error.is_device_fault() {
            return Err(error);
        }
        self.message = Some(error.to_string());
        Ok(())
    }

    /// Does what the user asks for. The first of several actions that one undo takes back is `fresh`.
    pub(super) fn perform(&mut self, action: Action, fresh: bool) -> Result<()> {
        if fresh && action.is_change() {
            self.edits.begin();
        }
        let before = self.edits.scene.clone();
        match self.change(action) {
            Ok(Changed::Nothing) => Ok(()),
            Ok(Changed::View) => {
                self.frames.change();
                Ok(())
            }
            Ok(Changed::Scene) => {
                self.adopt(before);
                Ok(())
            }
            Err(error) => self.tell(error),
        }
    }

    /// Makes a setting, `key=value`.
    pub(super) fn setting(&mut self, set: &str) -> Result<()> {
        let (key, value) = set.split_once('=').unwrap_or((set, ""));
        self.edits.begin();
        let before = self.edits.scene.clone();
        match self.edits.set(key.trim(), value.to_owned()) {
            Ok(()) => {
                self.adopt(before);
                Ok(())
            }
            Err(error) => self.tell(error),
        }
    }

    /// Gives the picture a size in pixels.
    pub(super) fn resize(&mut self, size: [u32; 2]) -> Result<()> {
        let size = size.map(|side| side.max(1));
        if self.edits.scene.camera.size == size {
            return Ok(());
        }
        match self.edits.scene.camera.clone().sized(size) {
            Ok(camera) => {
                self.edits.scene.camera = camera;
                self.frames.change();
                Ok(())
            }
            Err(error) => self.tell(error),
        }
    }

    /// Renders the next step, if it is due. A scene that can't be rendered is told, and the last good one comes back.
    pub(super) fn advance(&mut self, held: bool) -> Result<()> {
        match self.frames.advance(&self.edits.scene, held) {
            Ok(()) => {
                if self.frames.progress != Progress::Changed {
                    self.good = None;
                }
            }
            Err(error) => match self.good.take() {
                Some(good) if !error.is_device_fault() => {
                    let camera = good.camera.clone().sized(self.edits.scene.camera.size)?;
                    self.edits.scene = Scene { camera, ..good };
                    self.message = Some(error.to_string());
                    self.frames.change();
                }
                _ => return Err(error),
            },
        }
        if self.saves && self.frames.progress == Progress::Whole {
            self.saves = false;
            self.message = Some(match self.save() {
                Ok(file) => format!("saved {}", file.display()),
                Err(error) if error.is_device_fault() => return Err(error),
                Err(error) => error.to_string(),
            });
        }
        Ok(())
    }

    /// Writes the picture as `SCENE-N.png`, with the first number that is free.
    fn save(&mut self) -> Result<PathBuf> {
        let name = &self.edits.scene.name;
        let files = (1..).map(|number| PathBuf::from(format!("{name}-{number}.png")));
        let file = files.into_iter().find(|file| !file.exists()).unwrap_or_default();
        let size = self.edits.scene.camera.size.map(|side| side as usize);
        save_png(&file, size, &self.frames.full().shown()?)?;
        Ok(file)
    }

    /// The command that renders the picture.
    fn command(&self) -> String {
        let [width, height] = self.edits.scene.camera.size;
        let output = ["-o".to_owned(), format!("{}.png", self.edits.scene.name), format!("--size={width}x{height}")];
        let words = self.words.iter().cloned().chain(self.options.words()).chain(self.edits.arguments());
        let all: Vec<String> = words.chain(output).map(|word| quoted(&word)).collect();
        format!("milkglass render {}", all.join(" "))
    }

    /// What the panel shows.
    pub(super) fn facts(&self) -> Facts<'_> {
        let scene = &self.edits.scene;
        let method = TransportArgument::value_variants().iter().position(|method| *method == self.options.transport);
        Facts {
            scene: &scene.name,
            device: self.device.name(),
            size: scene.camera.size,
            progress: self.frames.progress,
            samples: scene.camera.samples,
            shown: self.frames.draft_size(),
            object: [self.object + 1, scene.objects.len()],
            material: &scene.objects[self.object].material.name,
            extent: self.extent,
            scale: self.scale,
            light: [self.edits.light + 1, scene.lights.len()],
            method: method.and_then(|method| self.methods.get(method)).map_or("", String::as_str),
            methods: &self.methods,
            tolerance: scene.transport.tolerance,
            times: &self.frames.times,
            wall: self.frames.wall,
            memory: self.device.memory().allocated,
            message: self.message.as_deref(),
            panel: self.panel,
            keys: self.keys,
        }
    }
}
