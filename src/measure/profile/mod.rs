//! The profile of a scene: the time, the operations and the memory traffic of each stage of a frame, compared with
//! the device's rates.
//!
//! Times come from whole frames, with timestamps around each stage. Operations are counted, not estimated: one more
//! frame runs with instrumented kernels that count how often each block runs (`gpu::count`). It must make the same
//! lists, and its result may differ by rounding only.

mod agreement;
pub mod file;
pub mod history;
mod model;
mod quantiles;
mod rates;
mod roofline;
mod sheet;
mod trace;
pub mod why;
mod work;

pub use self::agreement::{Agreement, agreement};
pub use self::model::{Model, Predicted, Prediction, predict, predict_interpreted};
pub use self::quantiles::Quantiles;
pub use rates::{FinerRates, Rates, finer_rates, rates};
pub use roofline::roofline;
pub use sheet::counts_csv;
pub use trace::trace;
pub use work::{Counts, Work, interpreted, work};

use std::collections::BTreeSet;

use crate::error::{Input, Result};
use crate::gpu::{Device, Kernels, Timed, Timing};
use crate::layout::BufferId;
use crate::measure::rounds::{self, Forecast, Frame, InProcess, Measured, Samples, Schedule, Starter, compare, run};
use crate::measure::statistics::Interval;
use crate::pipeline::plan::{Change, Options, ShadingMethod};
use crate::scene::Scene;
use crate::session::run::Session;
use crate::state::Dispatch;
use crate::transport::octree::HOST;

/// Settings of a measurement.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// The shading method, and what is kept between frames.
    pub options: Options,
    /// What changes before each frame.
    pub change: Change,
    /// Number of timed frames, after the warm-up; at least 1.
    pub frames: usize,
    /// Timing stops after this many seconds, once three frames, or one start of a comparison, are timed.
    pub enough: f64,
    /// Timing stops once every interval that matters is at most this share wide on either side.
    pub until: Option<f64>,
    /// The seed of the order of what is compared, and of the bootstrap.
    pub seed: u64,
    /// Whether the links of each frame are counted and the device's clock is read, for [`Profile::trace`].
    pub traces: bool,
}

impl Default for Settings {
    fn default() -> Self {
        let options = Options::default();
        let (enough, change) = (f64::INFINITY, Change::EVERYTHING);
        Self { options, change, frames: 11, enough, until: None, seed: 1, traces: false }
    }
}

impl Settings {
    /// How many rounds are timed, and for how long.
    #[must_use]
    pub fn schedule(&self) -> Schedule {
        Schedule { rounds: self.frames, until: self.until, budget: self.enough, seed: self.seed }
    }
}

/// Measurements of one stage.
#[derive(Clone, Debug)]
pub struct Row {
    /// Its name; the kernel's, where kernels are timed.
    pub stage: String,
    /// Steps per frame, or a kernel's dispatches: one per object, chunk, group or batch.
    pub steps: usize,
    /// Dispatches per frame; 0 on the CPU.
    pub dispatches: usize,
    /// Milliseconds per frame by device timestamps; `None` without timestamps, and for stages on the host.
    pub device: Option<Quantiles>,
    /// The median of `device`, or on the CPU and without timestamps of `wall`, and its interval of 95 %; `None` where a
    /// stage on a device has no timestamps.
    pub interval: Option<Interval>,
    /// Milliseconds per frame by the host's clock; on a device, each step is submitted and waited for separately. Of a
    /// kernel, the device's own time.
    pub wall: Quantiles,
    /// Operations and traffic per frame; `None` on the CPU, and if the device rejects the instrumented kernels.
    pub work: Option<Work>,
}

/// The profile of one scene.
#[derive(Clone, Debug)]
pub struct Profile {
    /// The scene's name.
    pub scene: String,
    /// The device's name, or `cpu`.
    pub device: String,
    /// The driver's name and version.
    pub driver: String,
    /// Number of timed frames, those that turned out to be warming up included.
    pub frames: usize,
    /// The device's rates; `None` on the CPU and without timestamps.
    pub rates: Option<Rates>,
    /// The stages, in the order of the frame.
    pub rows: Vec<Row>,
    /// Milliseconds of a frame from call to result.
    pub wall: Quantiles,
    /// Sum over the stages by device timestamps, milliseconds.
    pub on_device: Option<Quantiles>,
    /// Peak device memory, bytes, including the first frame and staging copies; on the CPU the size of the buffers.
    pub peak: u64,
    /// Notes, such as why something was not measured.
    pub notes: Vec<String>,
    /// The times of all frames.
    pub samples: Samples,
    /// Each timed frame.
    pub trace: Vec<Frame>,
}

impl Row {
    /// Device time in seconds, the basis of the shares.
    fn seconds(&self) -> Option<f64> {
        self.device.map(|spread| spread.median * 1e-3).filter(|seconds| *seconds > 0.0)
    }

    /// Minimum memory traffic as a share of what the device copies in that time.
    pub fn share_of_copy(&self, rates: &Rates) -> Option<f64> {
        Some((self.work?.read + self.work?.written) as f64 / self.seconds()? / rates.copy)
    }

    /// Additions and multiplications, a fused one counting two, as a share of the device's FMA rate.
    pub fn share_of_fma(&self, rates: &Rates) -> Option<f64> {
        Some(self.work?.flops as f64 / 2.0 / self.seconds()? / rates.fma)
    }

    /// Exponentials and other transcendental functions as a share of the device's rate of exponentials.
    pub fn share_of_exp(&self, rates: &Rates) -> Option<f64> {
        Some(self.work?.exps as f64 / self.seconds()? / rates.exp)
    }
}

/// Profiles a scene on a device, or on the CPU.
pub fn profile(scene: &Scene, device: Option<&Device>, settings: &Settings) -> Result<Profile> {
    // Rates are measured before and after the frames, because the device may slow down meanwhile.
    let earlier = device.map(rates).transpose()?.flatten();
    if let Some(device) = device {
        device.forget_peak();
    }
    let mut only = variant(scene, device, settings)?;
    let Measured { samples, frames } = run(&mut only, &settings.schedule())?;
    let (mut session, trace) = (only.session, frames.into_iter().next().unwrap_or_default());
    let peak = device.map_or(session.bytes(), |device| device.memory().peak);
    let later = device.map(rates).transpose()?.flatten();
    let rates = earlier.zip(later).map(|(one, other)| one.with(other));
    let mut notes = Vec::new();
    match device {
        None => notes.push("on the CPU: the reference in f64, by the host's clock; no device is measured".into()),
        Some(_) if rates.is_none() => {
            notes.push("the queue has no timestamps: the host's clock only, no shares".into())
        }
        _ => {}
    }
    notes.extend(session.rebuilt());
    notes.extend(session.walk_reports().iter().map(|walk| {
        let (object, photons) = (walk.object, 3 * u64::from(walk.photons));
        let rate = photons as f64 / walk.seconds.max(1e-9);
        format!("walk, object {object}: {photons} photons in {:.2} s, {rate:.2e} photons a second", walk.seconds)
    }));
    if settings.options.transport == ShadingMethod::Octree {
        notes.push("the octree runs on the host".into());
    }
    let mut rows = rows(&mut session, &trace, &samples, settings)?;
    if let Some(device) = device {
        match work::of(scene, &device.counting(), settings, &mut session) {
            Ok(tallies) => rows.iter_mut().for_each(|row| row.work = tallies.get(row.stage.as_str()).copied()),
            Err(error) if error.is_device_fault() => notes.push(format!("what stages do was not counted: {error}")),
            Err(error) => return Err(error),
        }
    }
    notes.extend(samples.doubts());
    let kept = &trace[samples.warm_up..];
    let stages = |frame: &Frame| {
        frame.steps.iter().filter(|time| time.name != HOST.name).map(|time| time.milliseconds).sum::<f64>()
    };
    let sums: Vec<f64> = kept.iter().map(stages).collect();
    Ok(Profile {
        scene: scene.name.clone(),
        device: device.map_or("cpu", Device::name).to_string(),
        driver: device.map_or("the f64 reference", Device::driver).to_string(),
        frames: trace.len(),
        rates,
        rows,
        wall: Quantiles::of(kept.iter().map(|frame| frame.wall).collect()),
        on_device: device.is_some().then(|| Quantiles::of(sums)).filter(|spread| spread.median.is_finite()),
        peak,
        notes,
        samples,
        trace,
    })
}

/// Opens a device, with its own pipelines; `None` is the CPU.
pub type Open<'a> = &'a dyn Fn() -> Result<Option<Device>>;

/// Times frames on several devices in rounds, for example on one device with and without a replaced kernel. Each has a
/// name, and is opened anew for each start. `edited` stages and `told` are those of [`compare`].
pub fn against<'a>(
    scene: &'a Scene,
    devices: &[(&str, Open<'a>)],
    settings: &'a Settings,
    edited: &[String],
    told: &mut dyn FnMut(&Forecast),
) -> Result<Measured> {
    let mut starters = Vec::new();
    for (name, open) in devices {
        let open: Open<'a> = *open;
        let start = move || Ok(Box::new(variant(scene, open()?.as_ref(), settings)?) as _);
        starters.push(Starter { name: (*name).to_string(), start: Box::new(start) });
    }
    compare(&mut starters, &settings.schedule(), edited, told)
}

/// Times the dispatches of one stage by the kernels of two devices that share all else, in turn within a submission:
/// on the same memory, at the same point of a frame. `devices` opens both anew for each start.
pub fn alternate(
    scene: &Scene,
    devices: &dyn Fn() -> Result<[Device; 2]>,
    stage: &str,
    settings: &Settings,
    told: &mut dyn FnMut(&Forecast),
) -> Result<Measured> {
    let mut start = |rounds: &[[usize; 2]]| {
        // The first of the first round owns the session; one more round before it warms up.
        let first = rounds.first().map_or(0, |round| round[0]);
        let rounds: Vec<[usize; 2]> = rounds.iter().take(1).chain(rounds).copied().collect();
        let own = devices()?;
        let mut session = variant(scene, Some(&own[first]), settings)?.session;
        let others: Vec<[bool; 2]> = rounds.iter().map(|round| round.map(|which| which != first)).collect();
        let runs = session.alternate(settings.change, stage, &mut Kernels::new(&own[1 - first]), &others)?;
        let mut frames = [Vec::new(), Vec::new()];
        for (which, steps) in rounds.iter().flatten().zip(runs).skip(2) {
            if !steps.iter().any(|step| step.milliseconds.is_finite()) {
                let fault = Input::new("a frame does not run this stage on the device").key("--alternate");
                let run: BTreeSet<&str> = session.dispatches(settings.change)?.iter().map(|call| call.stage).collect();
                return Err(fault.found(stage).expected(run.into_iter().collect::<Vec<_>>().join(", ")).into());
            }
            frames[*which].push(Frame { wall: f64::NAN, steps, ..Frame::default() });
        }
        Ok(frames)
    };
    rounds::alternate(["built-in", "replaced"], &settings.schedule(), stage, &mut start, told)
}

/// A warmed-up session: lists have their capacity and pipelines exist, so all further frames are alike.
pub fn variant(scene: &Scene, device: Option<&Device>, settings: &Settings) -> Result<InProcess> {
    let mut session = Session::new(scene, device, settings.options)?;
    device.map(|device| device.align_clocks(settings.traces));
    session.frame(Change::EVERYTHING)?;
    if device.is_some() {
        session.frame(settings.change)?;
    }
    Ok(InProcess { session, change: settings.change, counts_links: settings.traces })
}

/// Milliseconds of a stage in each frame.
fn of_stage(frames: &[Frame], stage: &str) -> Vec<f64> {
    let sum = |times: &[Timing]| times.iter().filter(|time| time.name == stage).map(|time| time.milliseconds).sum();
    frames.iter().map(|frame| sum(&frame.steps)).collect()
}

/// The rows of all stages in the order of their first step; `work` is filled in later.
fn rows(session: &mut Session, frames: &[Frame], samples: &Samples, settings: &Settings) -> Result<Vec<Row>> {
    let on_device = session.device().is_some();
    let timed = session.device().map_or(Timed::Steps, |device| device.choices().timed);
    let by_stage = timed == Timed::Steps;
    let dispatches = if on_device { session.dispatches(settings.change)? } else { Vec::new() };
    let of = |name: &str| {
        let named = |dispatch: &&Dispatch| dispatch.stage == name || (!by_stage && dispatch.kernel == name);
        if timed == Timed::Dispatches { 1 } else { dispatches.iter().filter(named).count() }
    };
    let mut apart: Vec<Frame> = Vec::new();
    // Time half as many frames again, with each step submitted separately.
    for _ in 0..if on_device && by_stage { frames.len().div_ceil(2) } else { 0 } {
        apart.push(Frame { steps: session.apart(settings.change)?, ..Frame::default() });
    }
    let mut rows: Vec<Row> = Vec::new();
    for time in frames.first().map_or(&Vec::new(), |frame| &frame.steps) {
        if let Some(row) = rows.iter_mut().find(|row| row.stage == time.name) {
            row.steps += 1;
            continue;
        }
        let own = Quantiles::of(of_stage(&frames[samples.warm_up..], &time.name));
        let stage = on_device && time.name != HOST.name;
        rows.push(Row {
            stage: time.name.clone(),
            steps: 1,
            dispatches: of(&time.name),
            device: (stage && own.median.is_finite()).then_some(own),
            interval: samples.variants.first().and_then(|only| samples.median(only, &time.name)),
            wall: if stage && by_stage { Quantiles::of(of_stage(&apart, &time.name)) } else { own },
            work: None,
        });
    }
    Ok(rows)
}

/// The frame's result, bit for bit: the picture, or else the radiosity. With receivers at pixels, radiosity that no
/// pixel shows is never written.
pub fn result(session: &mut Session) -> Result<Vec<u8>> {
    let pictured = !session.state().data.radiance.is_empty();
    let slot = if pictured { BufferId::radiance } else { BufferId::radiosity };
    session.fetch(&[slot])?;
    Ok(session.state().data.bytes(slot).to_vec())
}
