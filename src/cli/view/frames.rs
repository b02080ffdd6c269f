//! The pictures of the window: fast drafts while something moves, and the picture of `render` once everything rests.
//!
//! Drafts have sessions of their own: see [`super::drafts`]. The picture that replaces them is made in parts: those of
//! a frame through the pixels' centres, then those of a frame for each sample. A layer is made in one step.

mod check;
mod draft;
mod numbers;
mod parts;
mod whole;

use std::time::{Duration, Instant};

use milkglass::error::{Error, Result};
use milkglass::internals::gpu::{Buffer, Device, Timing};
use milkglass::internals::pipeline::plan::Options;
use milkglass::internals::session::frame_parts::FrameParts;
use milkglass::internals::session::run::Session;
use milkglass::scene::Scene;

use self::check::{Check, REST};
use super::drafts::{LEVELS, Policy};
use super::history::History;
use super::inspect::{Inspector, Layer};
use crate::cli::greet;

/// How far the picture is.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Progress {
    /// The scene has changed since the last picture.
    Changed,
    /// A draft is shown, since this time.
    Draft(Instant),
    /// The picture has this many samples; with 0 it shows rays through the pixels' centres.
    Sample(u32),
    /// The picture is what `render` writes.
    Whole,
}

/// Renders what the window shows.
pub(super) struct Frames {
    device: Device,
    options: Options,
    full: Session,
    /// The sessions of drafts with transport, and without; made when they are first needed.
    drafts: [Option<Session>; 2],
    pub(super) policy: Policy,
    /// Whether more than the camera has changed since the last draft.
    all: bool,
    /// Whether a picture's first frame is fast enough to do without drafts: after a change of the camera alone, and
    /// after any other one.
    quick: [bool; 2],
    /// Whether more than the camera has changed since the last whole frame.
    heavy: bool,
    pub(super) progress: Progress,
    /// What is shown of the scene, and the pixel that is picked for it.
    layer: Layer,
    pick: [u32; 2],
    pub(super) inspector: Inspector,
    /// Why a layer could not be shown, until it is told.
    pub(super) refused: Option<Error>,
    pub(super) history: History,
    /// A frame of the whole picture while it is under way, and what it took so far.
    under_way: Option<(FrameParts, Duration)>,
    /// The longest time between two looks at the input while a whole picture is made.
    longest: Duration,
    check: Check,
    /// How long each draft took, ms.
    drafted: Vec<f64>,
    /// How many drafts there were before the first whole picture, once that is there.
    first_drafts: Option<usize>,
}

impl Frames {
    /// The frames of a scene on a device.
    pub(super) fn new(scene: &Scene, device: &Device, options: Options) -> Result<Self> {
        let mut full = parts::open(scene, device, options)?;
        greet(&mut full);
        Ok(Self {
            device: device.clone(),
            options,
            full,
            drafts: [None, None],
            policy: Policy::default(),
            all: true,
            quick: [false; 2],
            heavy: true,
            progress: Progress::Changed,
            layer: Layer::Light,
            pick: [0; 2],
            inspector: Inspector::new(device),
            refused: None,
            history: History::new(),
            under_way: None,
            longest: Duration::ZERO,
            check: Check::default(),
            drafted: Vec::new(),
            first_drafts: None,
        })
    }

    /// Goes over to other options; what was shown stays if that fails.
    pub(super) fn set_options(&mut self, scene: &Scene, options: Options) -> Result<()> {
        let full = parts::open(scene, &self.device, options)?;
        (self.full, self.under_way) = (full, None);
        self.check.forget();
        (self.options, self.drafts, self.quick) = (options, [None, None], [false; 2]);
        self.policy = Policy::default();
        self.change(true);
        Ok(())
    }

    /// Says that the scene has changed: `all` of it, or the camera alone.
    pub(super) fn change(&mut self, all: bool) {
        self.progress = Progress::Changed;
        self.check.change(all);
        if let Some((frame, _)) = self.under_way.take() {
            self.full.leave(frame);
        }
        self.all |= all;
        self.heavy |= all;
    }

    /// What is shown.
    pub(super) fn layer(&self) -> Layer {
        self.layer
    }

    /// Goes over to another layer; a pixel is picked for one of them.
    pub(super) fn set_layer(&mut self, layer: Layer, pick: [u32; 2]) {
        (self.layer, self.pick) = (layer, pick);
        self.change(false);
    }

    /// When there is something to do next; none if the picture is whole. While something is `held`, drafts stay.
    pub(super) fn due(&self, held: bool) -> Option<Instant> {
        match self.progress {
            _ if self.under_way.is_some() => Some(Instant::now()),
            Progress::Changed | Progress::Sample(_) => Some(Instant::now()),
            Progress::Draft(_) if held => None,
            Progress::Draft(since) => Some(since + REST),
            Progress::Whole => self.check.due(),
        }
    }

    /// Has a second solution sharpen the estimated error.
    pub(super) fn sharpen(&mut self) {
        self.check.sharpen();
    }

    /// Whether the next step is the first one of a whole picture.
    pub(super) fn begins(&self, held: bool) -> bool {
        let rests = match self.progress {
            Progress::Changed => self.quick[usize::from(self.heavy)] && !(held && self.layer != Layer::Light),
            Progress::Draft(_) => true,
            _ => false,
        };
        rests && self.under_way.is_none() && self.due(held).is_some_and(|due| due <= Instant::now())
    }

    /// Does the next step, if it is due: a draft of the scene, or a part of its picture. The scene's camera has the
    /// window's size. `before` is what was spent on the change itself. After an error that is not the device's the
    /// picture shows an earlier scene.
    pub(super) fn advance(&mut self, scene: &Scene, held: bool, before: Duration) -> Result<()> {
        if self.due(held).is_none_or(|due| due > Instant::now()) {
            return Ok(());
        }
        let turn = Instant::now();
        // The frame began when the change did.
        let mut start = Instant::now().checked_sub(before).unwrap_or_else(Instant::now);
        let steps = match self.progress {
            Progress::Changed if !self.begins(held) => self.draft(scene, before)?,
            Progress::Draft(_) if self.lacks_coarsest() => {
                self.open_coarsest(scene)?;
                self.drafted.push(turn.elapsed().as_secs_f64() * 1e3);
                return Ok(());
            }
            Progress::Changed | Progress::Draft(_) if self.layer != Layer::Light => self.inspect(scene)?,
            Progress::Changed | Progress::Draft(_) | Progress::Sample(_) => {
                let part = self.part(scene, start)?;
                self.longest = self.longest.max(turn.elapsed());
                let Some((steps, took)) = part else { return Ok(()) };
                start = Instant::now().checked_sub(took).unwrap_or(start);
                steps
            }
            Progress::Whole => {
                self.check.advance(scene, &self.device, self.options);
                self.longest = self.longest.max(turn.elapsed());
                return Ok(());
            }
        };
        self.history.add(start, steps);
        if self.progress == Progress::Whole {
            self.check.whole();
            self.first_drafts.get_or_insert(self.drafted.len());
        }
        if matches!(self.progress, Progress::Draft(_)) {
            self.drafted.push(start.elapsed().as_secs_f64() * 1e3);
        }
        Ok(())
    }

    /// Renders the layer; goes back to light if it can't be shown.
    fn inspect(&mut self, scene: &Scene) -> Result<Vec<Timing>> {
        let mut scene = scene.clone();
        if let Some(exposure) = self.full.metered() {
            (scene.camera.exposure, scene.camera.metered) = (exposure, false);
        }
        match self.inspector.render(&scene, self.options, self.layer, self.pick) {
            Ok(steps) => {
                self.progress = Progress::Whole;
                Ok(steps)
            }
            Err(error) if error.is_device_fault() => Err(error),
            Err(error) => {
                self.refused = Some(error);
                self.set_layer(Layer::Light, self.pick);
                Ok(Vec::new())
            }
        }
    }

    /// The picture to show, with its size; none before the first one.
    pub(super) fn shown(&mut self) -> Result<Option<([u32; 2], &Buffer)>> {
        // The picture is exposed anew when it is whole, and as the last one until then.
        let exposure = self.full.metered().filter(|_| self.progress != Progress::Whole);
        let [transported, local] = &mut self.drafts;
        let draft = if LEVELS[self.policy.level].transport { transported } else { local };
        let session = match (self.progress, draft) {
            (Progress::Draft(_), Some(draft)) => draft,
            (Progress::Changed, _) => return Ok(None),
            (Progress::Whole, _) if self.layer != Layer::Light => return self.inspector.shown(),
            _ => &mut self.full,
        };
        session.hold_exposure(exposure);
        let size = session.scene().camera.size;
        Ok(session.shown_on_device()?.map(|buffer| (size, buffer)))
    }

    /// The session of whole pictures.
    pub(super) fn full(&mut self) -> &mut Session {
        &mut self.full
    }
}
