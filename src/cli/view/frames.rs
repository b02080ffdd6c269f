//! The pictures of the window: fast drafts while something moves, and the picture of `render` once everything rests.
//!
//! Drafts have a session of their own: coarse pixels, one sample of each, and a coarse tolerance. The picture that
//! replaces them is made step by step: a frame through the pixels' centres, then a frame for each sample.

use std::time::{Duration, Instant};

use milkglass::error::Result;
use milkglass::internals::gpu::{Buffer, Device, Timing};
use milkglass::internals::pipeline::frame::stage;
use milkglass::internals::pipeline::plan::{Change, Options, ShadingMethod};
use milkglass::internals::session::run::Session;
use milkglass::internals::state::Need;
use milkglass::internals::view::pixel_receivers;
use milkglass::scene::{Scene, Source};

/// What the pixels of a draft may take, ms; otherwise the next one is coarser.
const PIXELS: f64 = 80.0;
/// What the pixels of a finer draft may be expected to take, ms.
const FINER: f64 = 60.0;
/// If the first frame of a picture takes less, there are no drafts.
const QUICK: Duration = Duration::from_millis(50);
/// For how long everything must rest before the picture is made.
const REST: Duration = Duration::from_millis(250);
/// The tolerance of drafts, if the scene's is not coarser.
const COARSE: f64 = 0.1;
/// Rays to the sky of a draft's face, and samples along each side of an area light.
const SAMPLES: [u32; 2] = [4, 2];
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
    /// How long each draft took, ms.
    drafts: Vec<f64>,
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
            drafts: Vec::new(),
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
        if self.due(held).is_none_or(|due| due > Instant::now()) {
            return Ok(());
        }
        let start = Instant::now();
        let times = match self.progress {
            Progress::Changed if !self.quick => self.draft(scene)?,
            Progress::Changed | Progress::Draft(_) => {
                self.full.show(scene).map_err(|error| scene.placed(error))?;
                let times = self.full.frame(Change::default())?;
                self.full.finished_rays()?;
                self.quick = start.elapsed() < QUICK;
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
        if matches!(self.progress, Progress::Draft(_)) {
            self.drafts.push(self.wall);
        }
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
        for light in &mut coarse.lights {
            match &mut light.source {
                Source::Environment { occlusion, .. } => *occlusion = SAMPLES[0].min(*occlusion),
                Source::Area { samples, .. } => *samples = SAMPLES[1].min(*samples),
                _ => {}
            }
        }
        let transport = match self.options.transport {
            ShadingMethod::Octree
            | ShadingMethod::Brute
            | ShadingMethod::Walk
            | ShadingMethod::Diffusion
            | ShadingMethod::Auto => ShadingMethod::Hierarchy,
            other => other,
        };
        let placed = |error| coarse.placed(error);
        let known = self.draft_size() == size;
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
        // The first of a size may have to compile kernels.
        if known {
            self.coarseness = next(self.coarseness, of_pixels(&times, start.elapsed().as_secs_f64() * 1e3));
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

    /// How long drafts took, ms: the median and the most; none without a draft.
    pub(super) fn draft_times(&self) -> Option<[f64; 2]> {
        let mut sorted = self.drafts.clone();
        sorted.sort_by(f64::total_cmp);
        Some([*sorted.get(sorted.len() / 2)?, *sorted.last()?])
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

/// The coarseness after a draft whose pixels took so many milliseconds.
fn next(coarseness: usize, pixels: f64) -> usize {
    let finer = coarseness.saturating_sub(1);
    let more = f64::from(FACTORS[coarseness]) / f64::from(FACTORS[finer]);
    match pixels {
        slow if slow > PIXELS => (coarseness + 1).min(FACTORS.len() - 1),
        fast if fast * more * more < FINER => finer,
        _ => coarseness,
    }
}

/// What depends on the number of pixels in a frame that took `all` milliseconds: all but the stages that do not.
fn of_pixels(times: &[Timing], all: f64) -> f64 {
    let mut pixels = false;
    let fixed = times.iter().filter(|time| {
        let name = time.name.split(' ').next().unwrap_or_default();
        // Where pixels are the receivers, so are all stages after this one.
        pixels |= name == pixel_receivers::STAGE.name;
        !pixels
            && time.milliseconds.is_finite()
            && stage(name).is_none_or(|stage| !stage.needs.contains(&Need::Picture))
    });
    (all - fixed.map(|time| time.milliseconds).sum::<f64>()).max(0.0)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn drafts_get_coarser_where_pixels_take_long_and_finer_where_they_do_not() {
        // A cost of 1 ms per thousand pixels of a window of 640 x 480, and one of a hundredth.
        for (thousand, wanted) in [(1.0, 3), (0.01, 1), (100.0, 8)] {
            let mut coarseness = 3;
            for _ in 0..10 {
                let pixels = 640.0 * 480.0 / f64::from(FACTORS[coarseness].pow(2));
                coarseness = next(coarseness, 1e-3 * pixels * thousand);
            }
            assert_eq!(FACTORS[coarseness], wanted, "{thousand}");
        }
        let step = |name: &str, milliseconds| Timing { name: name.into(), milliseconds, start: 0.0 };
        let receivers = pixel_receivers::STAGE.name;
        let picture = milkglass::internals::view::visibility::STAGE.name;
        let fixed = milkglass::internals::geometry::refit::STAGE.name;
        let times = [step(fixed, 10.0), step(picture, 20.0), step(receivers, 1.0), step(fixed, 5.0)];
        assert_eq!(of_pixels(&times, 40.0), 30.0);
    }
}
