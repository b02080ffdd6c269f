//! Why a frame takes as long as it does: what bounds each stage, what dispatches, barriers and submissions cost, and
//! how long pipelines took to compile.

use std::collections::BTreeMap;

use serde::Serialize;

use super::{Profile, Row, Settings};
use crate::error::Result;
use crate::gpu::{COUNTERS, Device, STATISTICS};
use crate::measure::overheads::{Overheads, overheads};
use crate::pipeline::frame::owner;
use crate::pipeline::plan::Change;
use crate::scene::Scene;
use crate::session::run::Session;

/// The parts of a stage's time; shares, whose sum is 1.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Bounds {
    /// Moving data as fast as the device copies.
    pub copy: f64,
    /// Additions and multiplications at the device's rate.
    pub fma: f64,
    /// Exponentials at the device's rate.
    pub exp: f64,
    /// Dispatches, as long as empty ones take.
    pub launches: f64,
    /// Barriers.
    pub barriers: f64,
    /// The rest: waits for loads that depend on each other, branches that diverge, operations without a rate.
    pub waits: f64,
}

impl Bounds {
    /// The parts of a stage's time, from the shares of it that launches and barriers take, and that copies,
    /// multiply-adds and exponentials would take each. The last three overlap, so that only the largest of them counts,
    /// and no more than launches and barriers leave.
    fn of(launches: f64, barriers: f64, rates: [f64; 3]) -> Self {
        let launches = launches.clamp(0.0, 1.0);
        let barriers = barriers.clamp(0.0, 1.0 - launches);
        let left = 1.0 - launches - barriers;
        let most = rates.iter().copied().fold(0.0, f64::max);
        let first = rates.iter().position(|rate| *rate == most);
        let [copy, fma, exp] = [0, 1, 2].map(|k| if first == Some(k) { most.min(left) } else { 0.0 });
        Self { copy, fma, exp, launches, barriers, waits: left - copy - fma - exp }
    }

    /// The parts with their names.
    #[must_use]
    pub fn parts(&self) -> [(&'static str, f64); 6] {
        [
            ("copy", self.copy),
            ("FMA", self.fma),
            ("exp", self.exp),
            ("launches", self.launches),
            ("barriers", self.barriers),
            ("waits", self.waits),
        ]
    }

    /// The largest part.
    #[must_use]
    pub fn largest(&self) -> &'static str {
        self.parts().iter().max_by(|a, b| a.1.total_cmp(&b.1)).map_or("waits", |(name, _)| *name)
    }
}

/// A stage.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Stage {
    /// Its name.
    pub stage: String,
    /// Median milliseconds of a frame, by the device's timestamps.
    pub ms: f64,
    /// Its share of the device's time.
    pub share: f64,
    /// Dispatches of a frame.
    pub dispatches: usize,
    /// Barriers of a frame.
    pub barriers: usize,
    /// Where its time goes; `None` if its work was not counted.
    pub bounds: Option<Bounds>,
    /// Pipelines created for it.
    pub pipelines: usize,
    /// Milliseconds in which the driver created them, by the host's clock.
    pub creation_ms: f64,
    /// Milliseconds that its first run took beyond a later one, by the device's timestamps: some drivers compile then.
    pub first_run_ms: Option<f64>,
    /// What the driver's compiler says of each pipeline: kernel, and name and value of each statistic.
    pub statistics: Vec<(String, Vec<(String, f64)>)>,
}

/// Milliseconds of a frame by the host's clock; the parts sum up to `wall`.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct FrameParts {
    /// From call to result.
    pub wall: f64,
    /// The stages' own work on the device.
    pub work: f64,
    /// Dispatches on the device.
    pub launches: f64,
    /// Barriers on the device.
    pub barriers: f64,
    /// Submissions and waits for them.
    pub submissions: f64,
    /// Whatever else the host does: recording, copies, stages on the host.
    pub host: f64,
}

/// Why a frame takes as long as it does.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Why {
    /// The least times of a dispatch, a barrier and a submission, microseconds.
    pub overheads_us: Overheads,
    /// Where the frame's time goes, milliseconds.
    pub frame_ms: FrameParts,
    /// Submissions of a frame, those of copies included.
    pub submissions: u64,
    /// The stages on the device, in the order of the frame.
    pub stages: Vec<Stage>,
    /// The names of the hardware's counters, where the driver offers some.
    pub counters: Vec<String>,
    /// Extensions that the driver lacks, and what is missing without them.
    pub lacks: Vec<String>,
}

/// Explains a profile of a scene on a device; opens the device once more, so that all pipelines are made anew.
pub fn why(scene: &Scene, device: &Device, settings: &Settings, found: &Profile) -> Result<Why> {
    let overheads = overheads(device, settings.seed)?;
    let fresh = device.with_statistics()?;
    let mut session = Session::new(scene, Some(&fresh), settings.options)?;
    let first = session.frame(Change::EVERYTHING)?;
    let mut pipelines: BTreeMap<&str, Vec<_>> = BTreeMap::new();
    for (key, creation, statistics) in session.pipeline_facts()? {
        if let Some(stage) = owner(&key.name) {
            pipelines.entry(stage.name).or_default().push((key.name, creation.as_secs_f64() * 1e3, statistics));
        }
    }
    // A repeated frame keeps the latest run of a stage only, and later frames may run fewer stages.
    let later = session.frame(Change::EVERYTHING)?;
    let sum = |steps: &[crate::gpu::Timing], stage: &str| -> f64 {
        steps.iter().filter(|step| step.name == stage).map(|step| step.milliseconds).sum()
    };
    let before = fresh.submissions();
    session.frame(settings.change)?;
    let submissions = fresh.submissions() - before;

    let total: f64 = found.rows.iter().filter_map(|row| Some(row.device?.median)).sum();
    let stages = found.rows.iter().filter_map(|row| {
        let ms = row.device?.median;
        let counts = |count: fn(&crate::gpu::Timing) -> usize| -> usize {
            let last = found.trace.last().map_or(&[][..], |frame| &frame.steps[..]);
            last.iter().filter(|step| step.name == row.stage).map(count).sum()
        };
        let (dispatches, barriers) = (counts(|step| step.dispatches), counts(|step| step.barriers));
        let own = pipelines.get(row.stage.as_str()).map_or(&[][..], |own| &own[..]);
        let extra = sum(&first, &row.stage) - sum(&later, &row.stage);
        Some(Stage {
            stage: row.stage.clone(),
            ms,
            share: ms / total,
            dispatches,
            barriers,
            bounds: bounds(found, row, [dispatches, barriers], &overheads),
            pipelines: own.len(),
            creation_ms: own.iter().map(|(_, ms, _)| ms).sum(),
            first_run_ms: Some(extra).filter(|ms| ms.is_finite()),
            statistics: own
                .iter()
                .filter(|(_, _, statistics)| !statistics.is_empty())
                .map(|(kernel, _, known)| (kernel.clone(), known.iter().map(|s| (s.name.clone(), s.value)).collect()))
                .collect(),
        })
    });
    let stages: Vec<Stage> = stages.collect();
    let mut lacks = Vec::new();
    for (extension, what) in [(STATISTICS, "registers and the like of each pipeline"), (COUNTERS, "hardware counters")]
    {
        if !device.offers(extension)? {
            lacks.push(format!("{}: {what}", extension.to_string_lossy()));
        }
    }
    Ok(Why {
        frame_ms: FrameParts::of(found.wall.median, &stages, submissions, &overheads),
        overheads_us: overheads,
        submissions,
        stages,
        counters: device.counter_names()?,
        lacks,
    })
}

/// The parts of a stage's time, with these dispatches and barriers.
fn bounds(found: &Profile, row: &Row, counts: [usize; 2], overheads: &Overheads) -> Option<Bounds> {
    let ms = row.device?.median;
    let [copy, fma, exp] = found.shares(row);
    let cost = |count: usize, microseconds: f64| count as f64 * microseconds.max(0.0) * 1e-3 / ms;
    let launches = cost(counts[0], overheads.dispatch.value);
    Some(Bounds::of(launches, cost(counts[1], overheads.barrier.value), [copy?, fma?, exp?]))
}

impl FrameParts {
    fn of(wall: f64, stages: &[Stage], submissions: u64, overheads: &Overheads) -> Self {
        let device: f64 = stages.iter().map(|stage| stage.ms).sum::<f64>().min(wall);
        let cost = |count: usize, cost: f64| count as f64 * cost.max(0.0) * 1e-3;
        let launches = cost(stages.iter().map(|stage| stage.dispatches).sum(), overheads.dispatch.value).min(device);
        let barriers = cost(stages.iter().map(|stage| stage.barriers).sum(), overheads.barrier.value);
        let barriers = barriers.min(device - launches);
        let submitting = cost(submissions as usize, overheads.submission.value).min(wall - device);
        let (work, host) = (device - launches - barriers, wall - device - submitting);
        Self { wall, work, launches, barriers, submissions: submitting, host }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_the_whole() {
        for (launches, barriers, rates, largest) in [
            (0.1, 0.05, [0.2, 0.6, 0.1], "FMA"),
            (0.1, 0.05, [0.2, 0.1, 0.1], "waits"),
            (0.7, 0.9, [0.5, 0.1, 0.1], "launches"),
            (3.0, 1.0, [2.0, 2.0, 2.0], "launches"),
            (0.0, 0.0, [1.4, 0.3, 0.2], "copy"),
            (-0.1, -0.1, [0.0, 0.0, 0.9], "exp"),
        ] {
            let bounds = Bounds::of(launches, barriers, rates);
            let parts = bounds.parts();
            assert!((parts.iter().map(|(_, share)| share).sum::<f64>() - 1.0).abs() < 1e-12, "{bounds:?}");
            assert!(parts.iter().all(|(_, share)| (-1e-12..=1.0).contains(share)), "{bounds:?}");
            assert_eq!(bounds.largest(), largest, "{bounds:?}");
        }
    }
}
