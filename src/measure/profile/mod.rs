//! The profile of a scene: what each stage of a frame takes, does and moves, beside what the device can do at best.
//!
//! Times are those of whole frames, each stage between two timestamps. What a stage does is not estimated: one more
//! frame runs with kernels whose blocks count how often they are run (`gpu::count`), and has to give the same bits.

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
use crate::session::run::{CapacityHints, Session};
use crate::transport::octree::HOST;

/// What is to be measured.
#[derive(Clone, Copy, Debug)]
pub struct Settings {
    /// How light travels, and what is kept.
    pub options: Options,
    /// What changes before each frame.
    pub change: Change,
    /// Frames that are timed, after those that warm up; at least 1.
    pub frames: usize,
    /// Where three frames have taken that many seconds, no more are timed.
    pub enough: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self { options: Options::default(), change: Change::EVERYTHING, frames: 11, enough: f64::INFINITY }
    }
}

/// A stage of the frame.
#[derive(Clone, Debug)]
pub struct Row {
    /// Its name.
    pub stage: String,
    /// Times it ran in a frame: once an object, chunk, group or batch.
    pub steps: usize,
    /// Dispatches of a frame; 0 on the CPU.
    pub dispatches: usize,
    /// Milliseconds of a frame by the device's timestamps; none where there are none, and of what runs on the host.
    pub device: Option<Quantiles>,
    /// Milliseconds by the host's clock: on a device submitted and waited for by itself, step by step.
    pub wall: Quantiles,
    /// What its kernels do in a frame; none on the CPU, and where the device takes no kernel that counts.
    pub work: Option<Work>,
}

/// What was measured of a scene.
#[derive(Clone, Debug)]
pub struct Profile {
    /// The scene's name.
    pub scene: String,
    /// The device's name, or `cpu`.
    pub device: String,
    /// The driver's name and version.
    pub driver: String,
    /// Frames that were timed.
    pub frames: usize,
    /// What the device can do at best; none on the CPU and without timestamps.
    pub rates: Option<Rates>,
    /// The stages, in the order of the frame.
    pub rows: Vec<Row>,
    /// Milliseconds of a frame from call to result.
    pub wall: Quantiles,
    /// The sum of the stages by the device's timestamps.
    pub on_device: Option<Quantiles>,
    /// Most bytes of device memory at once, the first frame and copies included; of the CPU the buffers' bytes.
    pub peak: u64,
    /// What there is to say besides: why something was not measured.
    pub notes: Vec<String>,
    /// Each timed frame: when it began and how long it took, by the host's clock in milliseconds, and its steps.
    pub trace: Vec<(f64, f64, Vec<Timing>)>,
}

impl Row {
    /// The time that shares are taken of, seconds: the device's own.
    fn seconds(&self) -> Option<f64> {
        self.device.map(|spread| spread.median * 1e-3).filter(|seconds| *seconds > 0.0)
    }

    /// Bytes that have to move, as a share of what the device's copy moves in that time.
    pub fn share_of_copy(&self, rates: &Rates) -> Option<f64> {
        Some((self.work?.read + self.work?.written) as f64 / self.seconds()? / rates.copy)
    }

    /// Additions and multiplications, two to a fused one, as a share of what the device does in that time.
    pub fn share_of_fma(&self, rates: &Rates) -> Option<f64> {
        Some(self.work?.flops as f64 / 2.0 / self.seconds()? / rates.fma)
    }

    /// Exponentials and the like likewise.
    pub fn share_of_exp(&self, rates: &Rates) -> Option<f64> {
        Some(self.work?.exps as f64 / self.seconds()? / rates.exp)
    }
}

/// Measures a scene on a device, or on the CPU.
pub fn profile(scene: &Scene, device: Option<&Device>, settings: &Settings) -> Result<Profile> {
    // Before the frames and after them, for what else slows the device now and then.
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

/// A stage on two devices, or all of the frame.
#[derive(Clone, Debug)]
pub struct Against {
    /// The stage, `stages` for the sum of all, or `frame` from call to result.
    pub what: String,
    /// Milliseconds before and after.
    pub times: [Quantiles; 2],
    /// The ratio of the medians, after to before.
    pub ratio: f64,
}

/// Times frames on two devices in turn, such as one and the same with and without a replaced kernel.
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

/// A session whose next frames are all alike: lists have their capacity, pipelines are made.
pub(super) fn ready(scene: &Scene, device: Option<&Device>, settings: &Settings) -> Result<Session> {
    let mut session = Session::new(scene, device, settings.options, CapacityHints::default())?;
    session.frame(Change::EVERYTHING)?;
    if device.is_some() {
        session.frame(settings.change)?;
    }
    Ok(session)
}

/// Frames of each session.
pub(super) type Frames = Vec<(f64, f64, Vec<Timing>)>;

/// Times frames of several sessions in turn, so that what disturbs one disturbs the others.
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

/// The stages in the order of their first step; what they do is not known yet.
fn rows(session: &mut Session, frames: &Frames, settings: &Settings) -> Result<Vec<Row>> {
    let on_device = session.device().is_some();
    let dispatches = if on_device { session.dispatches(settings.change)? } else { Vec::new() };
    let mut apart: Frames = Vec::new();
    // Half of the frames once more, each stage by itself.
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

/// What a frame leaves behind, bit for bit: the picture, or radiosity where none is made. Of receivers at pixels the
/// radiosity of places that no pixel shows is never written.
pub(super) fn result(session: &mut Session) -> Result<Vec<u8>> {
    let pictured = !session.state().data.radiance.is_empty();
    let slot = if pictured { BufferId::radiance } else { BufferId::radiosity };
    session.fetch(&[slot])?;
    Ok(session.state().data.bytes(slot).to_vec())
}
