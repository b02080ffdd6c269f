//! The scene in the window and what the user does with it, apart from the window itself.

mod change;
pub(super) mod outcome;
mod save;
mod timeline;

use std::time::{Duration, Instant};

use clap::ValueEnum;

use milkglass::error::{Error, Result};
use milkglass::internals::gpu::Device;
use milkglass::internals::pipeline::plan::{Mode, ShadingMethod};
use milkglass::scene::{Scene, Scheme};

use self::outcome::{Changed, Message, Output};
use self::timeline::Timeline;
use super::amounts::amounts;
use super::edits::{Edits, Made};
use super::frames::{Frames, Progress};
use super::inspect::Layer;
use super::keys::Action;
use super::panel::Facts;
use crate::cli::bare::Subject;
use crate::cli::run_args::OptionArguments;

/// A scene that is looked at and changed.
pub(super) struct Viewer {
    pub(super) edits: Edits,
    pub(super) frames: Frames,
    device: Device,
    options: OptionArguments,
    /// Names of the methods and modes.
    methods: Vec<String>,
    modes: Vec<String>,
    /// The arguments of `render` besides those of the window.
    words: Vec<String>,
    /// The object that is changed.
    object: usize,
    /// Its largest extent, mm, and the factor on its coefficients.
    extent: f64,
    scale: f64,
    /// The last scene that could be rendered, and its settings, while it is unknown whether the present one can.
    good: Option<(Scene, Made)>,
    pub(super) message: Option<Message>,
    pub(super) panel: bool,
    keys: bool,
    /// The deformation of the object that is changed.
    deform: usize,
    timeline: Timeline,
    /// The pixel that is picked for the layer of clusters.
    pick: [u32; 2],
    /// Where the pointer is, if it is over the picture.
    pub(super) pointer: Option<[f64; 2]>,
    pub(super) handles: bool,
    /// The file that is to be written, once its content is there.
    output: Option<Output>,
    /// The time that changes since the last frame took.
    spent: Duration,
    pub(super) quits: bool,
}

impl Viewer {
    /// A viewer of a scene; `size` is the picture's in pixels, if it is not the scene's.
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
        let frames = Frames::new(&edits.scene, device, options.options())?;
        let mut viewer = Self {
            edits,
            frames,
            device: device.clone(),
            options,
            methods: names::<ShadingMethod>(),
            modes: names::<Mode>(),
            words,
            object: 0,
            extent: 0.0,
            scale: 1.0,
            good: None,
            message: None,
            panel: true,
            keys: false,
            deform: 0,
            timeline: Timeline::new(),
            pick: [0; 2],
            pointer: None,
            handles: true,
            output: None,
            spent: Duration::ZERO,
            quits: false,
        };
        viewer.measure();
        Ok(viewer)
    }

    /// Updates the size of the object that is changed, and which of its deformations is.
    fn measure(&mut self) {
        let scene = &self.edits.scene;
        self.object = self.object.min(scene.objects.len() - 1);
        let (low, high) = scene.objects[self.object].bounds();
        self.extent = (high - low).max_element() * scene.unit_mm;
        self.scale = self.edits.number(&format!("object.{}.material.scale", self.object)).unwrap_or(1.0);
        self.deform %= amounts(&self.edits.scene.objects[self.object], 1.0).len().max(1);
    }

    /// Reads the scene's file again if it has changed.
    pub(super) fn reload(&mut self) -> Result<()> {
        let before = self.edits.state();
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
    fn adopt(&mut self, before: (Scene, Made)) {
        self.good.get_or_insert(before);
        self.message = None;
        self.frames.change(true);
        self.measure();
    }

    /// Shows an error, unless it is the device's.
    fn tell(&mut self, error: Error) -> Result<()> {
        if error.is_device_fault() {
            return Err(error);
        }
        self.message = Some(Message::of(&error));
        Ok(())
    }

    /// Does what the user asks for. The first of several actions that one undo takes back is `fresh`.
    pub(super) fn perform(&mut self, action: Action, fresh: bool) -> Result<()> {
        if fresh && action.is_change() {
            self.edits.begin();
        }
        let start = Instant::now();
        let before = self.edits.state();
        let changed = self.change(action);
        self.spent += start.elapsed();
        match changed {
            Ok(Changed::Nothing) => Ok(()),
            Ok(Changed::View) => {
                self.frames.change(false);
                Ok(())
            }
            Ok(Changed::Light) => {
                self.frames.change(true);
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
        let before = self.edits.state();
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
                self.frames.change(false);
                Ok(())
            }
            Err(error) => self.tell(error),
        }
    }

    /// Renders the next step, if it is due. A scene that can't be rendered is told, and the last good one comes back.
    pub(super) fn advance(&mut self, held: bool) -> Result<()> {
        let held = held || self.plays();
        if self.frames.begins(held)
            && let Err(error) = self.edits.settle()
        {
            self.tell(error)?;
            self.frames.change(true);
        }
        let spent = std::mem::take(&mut self.spent);
        match self.frames.advance(&self.edits.scene, held, spent) {
            Ok(()) => {
                // A draft leaves out much of what can fail.
                let rendered = matches!(self.frames.progress, Progress::Sample(_) | Progress::Whole);
                if rendered && self.frames.layer() == Layer::Light {
                    self.good = None;
                }
            }
            Err(error) => match self.good.take() {
                Some(good) if !error.is_device_fault() => {
                    self.edits.restore(good)?;
                    self.message = Some(Message::of(&error));
                    self.frames.change(true);
                }
                _ => return Err(error),
            },
        }
        if let Some(error) = self.frames.refused.take() {
            self.tell(error)?;
        }
        self.write()
    }

    /// What the panel shows.
    pub(super) fn facts(&self) -> Facts<'_> {
        let scene = &self.edits.scene;
        let object = &scene.objects[self.object];
        Facts {
            scene: &scene.name,
            device: self.device.name(),
            size: scene.camera.size,
            progress: self.frames.progress,
            samples: scene.camera.samples,
            shown: self.frames.draft_size(scene),
            object: [self.object + 1, scene.objects.len()],
            material: &object.material.name,
            extent: self.extent,
            scale: self.scale,
            amounts: amounts(object, self.extent / scene.unit_mm),
            deform: self.deform,
            light: [(self.edits.light + 1).min(scene.lights.len()), scene.lights.len()],
            handles: if self.handles { self.edits.handles() } else { Vec::new() },
            method: &self.methods[place(&self.options.transport)],
            methods: &self.methods,
            mode: &self.modes[place(&self.options.mode)],
            scheme: if scene.transport.scheme == Scheme::Links { "links" } else { "blocks" },
            tolerance: scene.transport.tolerance,
            error: self.frames.error(),
            settled: self.frames.due(false).is_none(),
            layer: self.frames.layer(),
            legend: &self.frames.inspector.legend,
            frames: scene.frames,
            frame: self.edits.frame(),
            plays: self.timeline.plays(),
            loops: self.timeline.loops,
            history: &self.frames.history,
            counts: self.frames.counts(),
            memory: self.device.memory().allocated,
            message: self.message.as_ref(),
            panel: self.panel,
            keys: self.keys,
        }
    }
}

/// The names of an argument's values.
fn names<T: ValueEnum>() -> Vec<String> {
    let names = T::value_variants().iter().filter_map(ValueEnum::to_possible_value);
    names.map(|name| name.get_name().to_owned()).collect()
}

/// The place of a value among those of its argument.
fn place<T: ValueEnum + PartialEq>(value: &T) -> usize {
    T::value_variants().iter().position(|other| other == value).unwrap_or(0)
}
