//! The pictures of the window: fast drafts while something moves, and the picture of `render` once everything rests.
//!
//! Drafts have a session of their own: coarse pixels, one sample of each, and a coarse tolerance. The picture that
//! replaces them is made step by step: a frame through the pixels' centres, then a frame for each sample.

use std::time::{Duration, Instant};

use milkglass::error::Result;
use milkglass::internals::gpu::{Buffer, Device, Timing};
use milkglass::internals::pipeline::plan::{Change, Options, ShadingMethod};
use milkglass::internals::session::run::Session;
use milkglass::scene::Scene;

/// A draft that takes longer makes the next one coarser.
const SLOW: Duration = Duration::from_millis(150);
/// A draft that takes less makes the next one finer.
const FAST: Duration = Duration::from_millis(50);
/// For how long everything must rest before the picture is made.
const REST: Duration = Duration::from_millis(250);
/// The tolerance of drafts, if the scene's is not coarser.
const COARSE: f64 = 0.1;
/// Pixels of the window along each side of a draft's pixel.
const FACTORS: [u32; 6] = [1, 2, 3, 4, 6, 8];

/// What is shown, and what is to be done for it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Progress {
    /// The scene has changed since the last picture.
    Changed,
    /// A draft is shown, since then.
    Draft(Instant),
    /// So many samples of the picture are in it; none: rays through the pixels' centres.
    Sample(u32),
    /// The picture is what `render` writes.
    Whole,
}

/// Renders what the window shows.
pub(super) struct Frames {
    device: Device,
    options: Options,
    full: Session,
    /// Made when it is first needed.
    draft: Option<Session>,
    /// The index among [`FACTORS`] of the next draft.
    coarseness: usize,
    /// Whether the last picture was fast enough to do without drafts.
    quick: bool,
    pub(super) progress: Progress,
    /// Each stage of the last frame with its time on the device, ms.
    pub(super) times: Vec<(String, f64)>,
    /// How long the last frame took on the host, ms.
    pub(super) wall: f64,
}

impl Frames {
    /// For a scene on a device; the session has not rendered yet.
    pub(super) fn new(full: Session, device: &Device, options: Options) -> Self {
        Self {
            device: device.clone(),
            options,
            full,
            draft: None,
            coarseness: 3,
            quick: false,
            progress: Progress::Changed,
            times: Vec::new(),
            wall: 0.0,
        }
    }

    /// Goes over to other options; what was shown stays if that fails.
    pub(super) fn set_options(&mut self, scene: &Scene, options: Options) -> Result<()> {
        self.full = Session::new(scene, Some(&self.device), options)?;
        (self.options, self.draft, self.quick) = (options, None, false);
        self.progress = Progress::Changed;
        Ok(())
    }

    /// Says that the scene has changed.
    pub(super) fn change(&mut self) {
        self.progress = Progress::Changed;
    }

    /// When there is something to do next; none if the picture is whole. While a button is `held`, drafts stay.
    pub(super) fn due(&self, held: bool) -> Option<Instant> {
        match self.progress {
            Progress::Changed | Progress::Sample(_) => Some(Instant::now()),
            Progress::Draft(_) if held => None,
            Progress::Draft(since) => Some(since + REST),
            Progress::Whole => None,
        }
    }

    /// Does the next step, if it is due: a draft of the scene, or a part of its picture. The scene's camera has the
    /// window's size. After an error that is not the device's the picture shows an earlier scene.
    pub(super) fn advance(&mut self, scene: &Scene, held: bool) -> Result<()> {
        if !self.due(held).is_some_and(|due| due <= Instant::now()) {
            return Ok(());
        }
        let start = Instant::now();
        let times = match self.progress {
            Progress::Changed if !self.quick => self.draft(scene)?,
            Progress::Changed | Progress::Draft(_) => {
                self.full.show(scene).map_err(|error| scene.placed(error))?;
                let times = self.full.frame(Change::default())?;
                self.full.finished_rays()?;
                self.quick = start.elapsed() < FAST;
                self.progress = if scene.camera.samples == 1 { Progress::Whole } else { Progress::Sample(0) };
                times
            }
            Progress::Sample(done) => {
                let times = self.full.sample_one(done)?;
                let whole = done + 1 == scene.camera.samples;
                self.progress = if whole { Progress::Whole } else { Progress::Sample(done + 1) };
                times
            }
            Progress::Whole => return Ok(()),
        };
        self.wall = start.elapsed().as_secs_f64() * 1e3;
        self.times = by_stage(times);
        Ok(())
    }

    /// Renders a draft, and chooses the next one's pixels by how long it took.
    fn draft(&mut self, scene: &Scene) -> Result<Vec<Timing>> {
        let mut coarse = scene.clone();
        let size = scene.camera.size.map(|side| side.div_ceil(FACTORS[self.coarseness]));
        coarse.camera = coarse.camera.sized(size)?;
        coarse.camera.samples = 1;
        coarse.transport.tolerance = coarse.transport.tolerance.max(COARSE);
        coarse.transport.subdivide = 0;
        let transport = match self.options.transport {
            ShadingMethod::Octree
            | ShadingMethod::Brute
            | ShadingMethod::Walk
            | ShadingMethod::Diffusion
            | ShadingMethod::Auto => ShadingMethod::Hierarchy,
            other => other,
        };
        let placed = |error| coarse.placed(error);
        let session = match &mut self.draft {
            Some(session) => {
                session.show(&coarse).map_err(placed)?;
                session
            }
            none => {
                let options = Options { transport, ..self.options };
                none.insert(Session::new(&coarse, Some(&self.device), options)?)
            }
        };
        let start = Instant::now();
        let times = session.frame(Change::default())?;
        match start.elapsed() {
            time if time > SLOW => self.coarseness = (self.coarseness + 1).min(FACTORS.len() - 1),
            time if time < FAST => self.coarseness = self.coarseness.saturating_sub(1),
            _ => {}
        }
        self.progress = Progress::Draft(Instant::now());
        Ok(times)
    }

    /// The picture to show, with its size; none before the first one.
    pub(super) fn shown(&mut self) -> Result<Option<([u32; 2], &Buffer)>> {
        let session = match (self.progress, &mut self.draft) {
            (Progress::Draft(_), Some(draft)) => draft,
            (Progress::Changed, _) => return Ok(None),
            _ => &mut self.full,
        };
        let size = session.scene().camera.size;
        Ok(session.shown_on_device()?.map(|buffer| (size, buffer)))
    }

    /// Width and height of the last draft in pixels.
    pub(super) fn draft_size(&self) -> [u32; 2] {
        self.draft.as_ref().map_or([0; 2], |draft| draft.scene().camera.size)
    }

    /// The session of whole pictures.
    pub(super) fn full(&mut self) -> &mut Session {
        &mut self.full
    }
}

/// The times of steps, by stage.
fn by_stage(times: Vec<Timing>) -> Vec<(String, f64)> {
    let mut sums: Vec<(String, f64)> = Vec::new();
    for time in times {
        let name = time.name.split(' ').next().unwrap_or_default();
        match sums.iter_mut().find(|(known, _)| known == name) {
            Some((_, sum)) => *sum += time.milliseconds,
            None => sums.push((name.to_owned(), time.milliseconds)),
        }
    }
    sums
}
