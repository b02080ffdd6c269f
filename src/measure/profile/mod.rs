//! The profile of a scene: the time, the operations and the memory traffic of each stage of a frame, compared with
//! the device's peak rates.
//!
//! Times come from whole frames, with timestamps around each stage. Operations are counted, not estimated: one more
//! frame runs with instrumented kernels that count how often each block runs (`gpu::count`), and must give the same
//! bits.

mod quantiles;
mod rates;
mod sheet;
mod work;

use std::time::Instant;

pub use self::quantiles::Quantiles;
pub use rates::{Rates, rates};
pub use work::Work;

use crate::error::Result;
use crate::gpu::{Device, Timing};
use crate::layout::BufferId;
use crate::pipeline::plan::{Change, Options, ShadingMethod};
use crate::scene::Scene;
use crate::session::run::Session;
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
    /// Timing stops after this many seconds, once three frames are timed.
    pub enough: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self { options: Options::default(), change: Change::EVERYTHING, frames: 11, enough: f64::INFINITY }
    }
}

/// Measurements of one stage.
#[derive(Clone, Debug)]
pub struct Row {
    /// Its name.
    pub stage: String,
    /// Steps per frame: one per object, chunk, group or batch.
    pub steps: usize,
    /// Dispatches per frame; 0 on the CPU.
    pub dispatches: usize,
    /// Milliseconds per frame by device timestamps; `None` without timestamps, and for stages on the host.
    pub device: Option<Quantiles>,
    /// Milliseconds per frame by the host's clock; on a device, each step is submitted and waited for separately.
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
    /// Number of timed frames.
    pub frames: usize,
    /// The device's peak rates; `None` on the CPU and without timestamps.
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
    /// Each timed frame: start and duration by the host's clock in milliseconds, and its steps.
    pub trace: Vec<(f64, f64, Vec<Timing>)>,
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
    // Rates are measured before and after the frames, and the better ones kept, because the device may slow down for
    // a while.
    let earlier = device.map(rates).transpose()?.flatten();
    if let Some(device) = device {
        device.forget_peak();
    }
    let mut session = ready(scene, device, settings)?;
    let found = timed(&mut [&mut session], settings)?;
    let peak = device.map_or(session.bytes(), |device| device.memory().peak);
    let later = device.map(rates).transpose()?.flatten();
    let rates = earlier.zip(later).map(|(one, other)| one.best(other));
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
    let mut rows = rows(&mut session, &found[0], settings)?;
    if let Some(device) = device {
        match work::of(scene, &device.counting(), settings, &mut session) {
            Ok(tallies) => rows.iter_mut().for_each(|row| row.work = tallies.get(row.stage.as_str()).copied()),
            Err(error) if error.is_device_fault() => notes.push(format!("what stages do was not counted: {error}")),
            Err(error) => return Err(error),
        }
    }
    let stages = |times: &Vec<Timing>| {
        times.iter().filter(|time| time.name != HOST.name).map(|time| time.milliseconds).sum::<f64>()
    };
    let sums: Vec<f64> = found[0].iter().map(|(_, _, times)| stages(times)).collect();
    Ok(Profile {
        scene: scene.name.clone(),
        device: device.map_or("cpu", Device::name).to_string(),
        driver: device.map_or("the f64 reference", Device::driver).to_string(),
        frames: found[0].len(),
        rates,
        rows,
        wall: Quantiles::of(found[0].iter().map(|frame| frame.1).collect()),
        on_device: device.is_some().then(|| Quantiles::of(sums)).filter(|spread| spread.median.is_finite()),
        peak,
        notes,
        trace: found.into_iter().next().unwrap_or_default(),
    })
}

/// One stage, or the whole frame, on two devices.
#[derive(Clone, Debug)]
pub struct Against {
    /// The stage's name, `stages` for the sum of all, or `frame` for the time from call to result.
    pub what: String,
    /// Milliseconds on the first and on the second device.
    pub times: [Quantiles; 2],
    /// Ratio of the medians, second to first.
    pub ratio: f64,
}

/// Times frames on two devices alternately, for example one device with and without a replaced kernel.
pub fn against(scene: &Scene, devices: [&Device; 2], settings: &Settings) -> Result<Vec<Against>> {
    let [mut before, mut after] =
        [ready(scene, Some(devices[0]), settings)?, ready(scene, Some(devices[1]), settings)?];
    let found = timed(&mut [&mut before, &mut after], settings)?;
    let row = |what: &str, values: [Vec<f64>; 2]| {
        let times = values.map(Quantiles::of);
        Against { what: what.to_string(), times, ratio: times[1].median / times[0].median }
    };
    let both = |of: &dyn Fn(&Frames) -> Vec<f64>| [of(&found[0]), of(&found[1])];
    let mut rows: Vec<Against> = Vec::new();
    for time in found[0].first().map_or(&Vec::new(), |frame| &frame.2) {
        if !rows.iter().any(|row| row.what == time.name) {
            rows.push(row(&time.name, both(&|frames| of_stage(frames, &time.name))));
        }
    }
    let all = |frames: &Frames| frames.iter().map(|frame| frame.2.iter().map(|time| time.milliseconds).sum()).collect();
    rows.push(row("stages", both(&all)));
    rows.retain(|row| row.ratio.is_finite());
    rows.push(row("frame", both(&|frames| frames.iter().map(|frame| frame.1).collect())));
    Ok(rows)
}

/// A warmed-up session: lists have their capacity and pipelines exist, so all further frames are alike.
pub(super) fn ready(scene: &Scene, device: Option<&Device>, settings: &Settings) -> Result<Session> {
    let mut session = Session::new(scene, device, settings.options)?;
    session.frame(Change::EVERYTHING)?;
    if device.is_some() {
        session.frame(settings.change)?;
    }
    Ok(session)
}

/// Start, duration and steps of each frame of a session; times in milliseconds.
pub(super) type Frames = Vec<(f64, f64, Vec<Timing>)>;

/// Times frames of several sessions alternately, so that other load on the machine affects all alike.
pub(super) fn timed(sessions: &mut [&mut Session], settings: &Settings) -> Result<Vec<Frames>> {
    let (begin, mut found) = (Instant::now(), vec![Vec::new(); sessions.len()]);
    for turn in 0..settings.frames.max(1) {
        if turn >= 3 && begin.elapsed().as_secs_f64() > settings.enough {
            break;
        }
        for (session, frames) in sessions.iter_mut().zip(&mut found) {
            let start = begin.elapsed().as_secs_f64() * 1e3;
            let times = session.frame(settings.change)?;
            frames.push((start, begin.elapsed().as_secs_f64() * 1e3 - start, times));
        }
    }
    Ok(found)
}

/// Milliseconds of a stage in each frame.
pub(super) fn of_stage(frames: &Frames, stage: &str) -> Vec<f64> {
    let sum = |times: &Vec<Timing>| times.iter().filter(|time| time.name == stage).map(|time| time.milliseconds).sum();
    frames.iter().map(|(_, _, times)| sum(times)).collect()
}

/// The rows of all stages in the order of their first step; `work` is filled in later.
fn rows(session: &mut Session, frames: &Frames, settings: &Settings) -> Result<Vec<Row>> {
    let on_device = session.device().is_some();
    let dispatches = if on_device { session.dispatches(settings.change)? } else { Vec::new() };
    let mut apart: Frames = Vec::new();
    // Time half as many frames again, with each step submitted separately.
    for _ in 0..if on_device { frames.len().div_ceil(2) } else { 0 } {
        apart.push((0.0, 0.0, session.apart(settings.change)?));
    }
    let mut rows: Vec<Row> = Vec::new();
    for time in frames.first().map_or(&Vec::new(), |frame| &frame.2) {
        if let Some(row) = rows.iter_mut().find(|row| row.stage == time.name) {
            row.steps += 1;
            continue;
        }
        let own = Quantiles::of(of_stage(frames, &time.name));
        let stage = on_device && time.name != HOST.name;
        rows.push(Row {
            stage: time.name.clone(),
            steps: 1,
            dispatches: dispatches.iter().filter(|dispatch| dispatch.stage == time.name).count(),
            device: (stage && own.median.is_finite()).then_some(own),
            wall: if stage { Quantiles::of(of_stage(&apart, &time.name)) } else { own },
            work: None,
        });
    }
    Ok(rows)
}

/// The frame's result, bit for bit: the picture, or else the radiosity. With receivers at pixels, radiosity that no
/// pixel shows is never written.
pub(super) fn result(session: &mut Session) -> Result<Vec<u8>> {
    let pictured = !session.state().data.radiance.is_empty();
    let slot = if pictured { BufferId::radiance } else { BufferId::radiosity };
    session.fetch(&[slot])?;
    Ok(session.state().data.bytes(slot).to_vec())
}
