//! Why a frame takes as long as it does: what bounds each stage, what dispatches, barriers and submissions cost, and
//! how long pipelines took to compile.

use std::collections::BTreeMap;

use serde::Serialize;

use super::{FinerRates, Profile, Rates, Row, Settings, Work, finer_rates};
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
    /// Loads and stores of buffers, as fast as the nearest cache serves loads that wait for each other.
    pub loads: f64,
    /// Loads and stores of shared memory, likewise.
    pub shared: f64,
    /// Atomic operations on buffers.
    pub atomics: f64,
    /// Additions and multiplications at the device's rate.
    pub fma: f64,
    /// Exponentials at the device's rate.
    pub exp: f64,
    /// Divisions and square roots, at the device's rate of divisions.
    pub divide: f64,
    /// All other instructions, at the device's rate of integer instructions.
    pub integer: f64,
    /// Dispatches, as long as empty ones take.
    pub launches: f64,
    /// Barriers.
    pub barriers: f64,
    /// Extra time of buffer loads if each fell anywhere in all that the stage binds.
    pub misses: f64,
    /// The rest, such as operations that wait for each other.
    pub waits: f64,
}

/// What a stage's work would take at the device's rates, shares of its time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
struct Shares {
    copy: f64,
    /// Loads of buffers, of shared memory, and atomic operations.
    accesses: [f64; 3],
    /// Multiply-adds, exponentials, divisions and other instructions.
    arithmetic: [f64; 4],
    /// By how much longer the loads of buffers could take.
    misses: f64,
    /// Whether loads and arithmetic take turns, as a processor's vectors do.
    in_turn: bool,
}

/// The rates that a stage's work is held against.
struct Limits<'a> {
    rates: &'a Rates,
    finer: &'a FinerRates,
    in_turn: bool,
}

impl<'a> Limits<'a> {
    /// Those of a device, if all of these rates are known.
    fn of(device: &Device, rates: &'a Rates, finer: &'a FinerRates) -> Option<Self> {
        let loads = finer.loads.iter().map(|(_, rate)| *rate);
        let others = [rates.copy, rates.fma, rates.exp, finer.integer, finer.divide, finer.shared, finer.atomic];
        let known = loads.chain(others).all(|rate| rate.is_finite() && rate > 0.0);
        known.then(|| Self { rates, finer, in_turn: device.adapter().kind == "cpu" })
    }

    /// What a row's work would take; arithmetic takes as long for the idle lanes of a subgroup, and where a processor's
    /// vectors load lane by lane, so do loads and stores.
    fn shares(&self, row: &Row) -> Option<Shares> {
        let (rates, finer, work, seconds) = (self.rates, self.finer, row.work?, row.seconds()?);
        let share = |count: u64, rate: f64| count as f64 / rate / seconds;
        let width = work.invocations as f64 / work.subgroups.max(1) as f64;
        let idle = f64::max(1.0, width * work.issued as f64 / work.instructions.max(1) as f64);
        let idle_loads = if self.in_turn { idle } else { 1.0 };
        let arithmetic = [
            share(work.flops, 2.0 * rates.fma),
            share(work.exps, rates.exp),
            share(work.roots, finer.divide),
            share(work.others, finer.integer),
        ];
        // An atomic operation is counted as a load and a store of a word, too.
        let moved = (work.loaded + work.stored).saturating_sub(8 * work.atomics);
        let bound = work.read + work.written;
        let loads = idle_loads * share(moved, finer.loads_in(0)?);
        let shared = idle_loads * share(work.shared, finer.shared);
        Some(Shares {
            copy: share(bound, rates.copy),
            accesses: [loads, shared, share(work.atomics, finer.atomic)],
            arithmetic: arithmetic.map(|part| part * idle),
            misses: (idle_loads * share(moved, finer.loads_in(bound)?) - loads).max(0.0),
            in_turn: self.in_turn,
        })
    }
}

impl Shares {
    /// The share that copies take or, if longer, loads and arithmetic: their sum where they take turns, else the longer
    /// one. `further` is added to the loads.
    fn work(&self, further: f64) -> f64 {
        let (accesses, arithmetic) = (self.accesses.iter().sum::<f64>() + further, self.arithmetic.iter().sum());
        self.copy.max(if self.in_turn { accesses + arithmetic } else { accesses.max(arithmetic) })
    }
}

impl Bounds {
    /// The parts of a stage's time, from the shares of it that launches and barriers take and what its work would.
    ///
    /// Copies overlap with all else: only the longer of copies and the rest counts. Of loads and arithmetic the longer
    /// counts, or both where they take turns. All are scaled down to fit what launches and barriers leave.
    fn of(launches: f64, barriers: f64, shares: &Shares) -> Self {
        let launches = launches.clamp(0.0, 1.0);
        let barriers = barriers.clamp(0.0, 1.0 - launches);
        let left = 1.0 - launches - barriers;
        let (work, accesses, arithmetic) =
            (shares.work(0.0), shares.accesses.iter().sum::<f64>(), shares.arithmetic.iter().sum::<f64>());
        let fits = if work > left { left / work } else { 1.0 };
        let counted = |counts: bool| if counts { fits } else { 0.0 };
        let copies = shares.copy >= work;
        let loads = counted(!copies && (shares.in_turn || accesses >= arithmetic));
        let operations = counted(!copies && (shares.in_turn || accesses < arithmetic));
        let misses = (shares.work(shares.misses) - work).min(left - fits * work).max(0.0);
        let [fma, exp, divide, integer] = shares.arithmetic.map(|part| operations * part);
        Self {
            copy: counted(copies) * shares.copy,
            loads: loads * shares.accesses[0],
            shared: loads * shares.accesses[1],
            atomics: loads * shares.accesses[2],
            fma,
            exp,
            divide,
            integer,
            launches,
            barriers,
            misses,
            waits: (left - fits * work - misses).max(0.0),
        }
    }

    /// The parts with their names.
    #[must_use]
    pub fn parts(&self) -> [(&'static str, f64); 12] {
        [
            ("copy", self.copy),
            ("loads", self.loads),
            ("shared", self.shared),
            ("atomics", self.atomics),
            ("FMA", self.fma),
            ("exp", self.exp),
            ("divide", self.divide),
            ("integer", self.integer),
            ("launches", self.launches),
            ("barriers", self.barriers),
            ("misses", self.misses),
            ("waits", self.waits),
        ]
    }

    /// Memory, as far as caches serve it, and arithmetic.
    #[must_use]
    pub fn work(&self) -> [f64; 2] {
        [self.copy + self.loads + self.shared + self.atomics, self.fma + self.exp + self.divide + self.integer]
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
    /// Milliseconds that its work, launches and barriers would take at the device's rates, were every load served by
    /// the nearest cache.
    pub model_ms: Option<f64>,
    /// Active invocations of a subgroup, averaged over the instructions that it issues.
    pub lanes: Option<f64>,
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
    /// Rates of the device beside those of the profile; `None` without timestamps.
    pub rates: Option<FinerRates>,
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
    let finer = finer_rates(device)?;
    let limits = found.rates.as_ref().zip(finer.as_ref()).and_then(|(rates, finer)| Limits::of(device, rates, finer));
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
        let held = limits.as_ref().and_then(|limits| bounds(row, [dispatches, barriers], &overheads, limits));
        let own = pipelines.get(row.stage.as_str()).map_or(&[][..], |own| &own[..]);
        let extra = sum(&first, &row.stage) - sum(&later, &row.stage);
        Some(Stage {
            stage: row.stage.clone(),
            ms,
            share: ms / total,
            dispatches,
            barriers,
            bounds: held.map(|(bounds, _)| bounds),
            model_ms: held.map(|(_, ms)| ms),
            lanes: row.work.and_then(Work::lanes),
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
    Ok(Why {
        frame_ms: FrameParts::of(found.wall.median, &stages, submissions, &overheads),
        overheads_us: overheads,
        rates: finer,
        submissions,
        stages,
        counters: device.counter_names()?,
        lacks: lacks(device)?,
    })
}

/// Extensions that the driver lacks, and what is missing without them.
fn lacks(device: &Device) -> Result<Vec<String>> {
    let mut lacks = Vec::new();
    for (extension, what) in [(STATISTICS, "registers and the like of each pipeline"), (COUNTERS, "hardware counters")]
    {
        if !device.offers(extension)? {
            lacks.push(format!("{}: {what}", extension.to_string_lossy()));
        }
    }
    Ok(lacks)
}

/// The parts of a stage's time, and the milliseconds of it that the device's rates explain, with these dispatches and
/// barriers.
fn bounds(row: &Row, counts: [usize; 2], overheads: &Overheads, limits: &Limits<'_>) -> Option<(Bounds, f64)> {
    let ms = row.device?.median;
    let cost = |count: usize, microseconds: f64| count as f64 * microseconds.max(0.0) * 1e-3 / ms;
    let launches = cost(counts[0], overheads.dispatch.value);
    let barriers = cost(counts[1], overheads.barrier.value);
    let shares = limits.shares(row)?;
    let model = ms * (launches + barriers + shares.work(0.0));
    Some((Bounds::of(launches, barriers, &shares), model))
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
    use super::super::Quantiles;
    use super::*;
    use crate::gpu::SingleKernel;
    use crate::layout::BUFFER_IDS;

    /// A stage with this work.
    fn row(work: Work, seconds: f64) -> Row {
        let times = Quantiles::of(vec![1e3 * seconds]);
        Row {
            stage: "a".into(),
            steps: 1,
            dispatches: 1,
            device: Some(times),
            interval: None,
            wall: times,
            work: Some(work),
        }
    }

    /// The shares of work of a second, on a device that does 100 of most a second.
    fn shares(work: Work, in_turn: bool) -> Shares {
        let rates = Rates { copy: 1e9, fma: 100.0, exp: 100.0 };
        let loads = vec![(1000, 100.0), (1_000_000, 10.0)];
        let finer = FinerRates { integer: 100.0, divide: 100.0, loads, shared: 100.0, atomic: 100.0 };
        Limits { rates: &rates, finer: &finer, in_turn }.shares(&row(work, 1.0)).unwrap()
    }

    /// Work of a kernel in subgroups of 8, so many instructions of which compute no float.
    fn of_eights(others: u64, instructions: u64, issued: u64) -> Work {
        Work { others, instructions, issued, invocations: 80, subgroups: 10, ..Work::default() }
    }

    #[test]
    fn parts_are_the_whole_and_have_the_cause_s_name() {
        let chase = |read: u64| Work { loaded: 30, read, ..of_eights(8, 8, 1) };
        let none = of_eights(0, 80, 10);
        for (launches, barriers, work, largest) in [
            (0.1, 0.05, of_eights(80, 80, 10), "integer"),
            // One lane of eight is active.
            (0.1, 0.05, of_eights(10, 10, 10), "integer"),
            (0.1, 0.05, Work { flops: 120, exps: 10, ..none }, "FMA"),
            (0.1, 0.05, Work { exps: 60, ..none }, "exp"),
            (0.1, 0.05, Work { roots: 60, ..none }, "divide"),
            (0.1, 0.05, Work { shared: 70, ..chase(20) }, "shared"),
            // 560 of these bytes are the atomic operations' own.
            (0.1, 0.05, Work { atomics: 70, loaded: 580, ..chase(20) }, "atomics"),
            (0.0, 0.0, Work { read: 1_400_000_000, loaded: 1, ..none }, "copy"),
            (0.1, 0.05, Work { loaded: 70, ..chase(20) }, "loads"),
            (0.1, 0.05, chase(20), "waits"),
            (0.1, 0.05, chase(1_000_000), "misses"),
            (0.7, 0.9, of_eights(80, 80, 10), "launches"),
            (3.0, 1.0, Work { loaded: 1000, ..chase(20) }, "launches"),
            (-0.1, -0.1, Work { exps: 90, ..none }, "exp"),
        ] {
            for in_turn in [false, true] {
                let bounds = Bounds::of(launches, barriers, &shares(work, in_turn));
                let parts = bounds.parts();
                assert!((parts.iter().map(|(_, share)| share).sum::<f64>() - 1.0).abs() < 1e-12, "{bounds:?}");
                assert!(parts.iter().all(|(_, share)| (-1e-12..=1.0).contains(share)), "{bounds:?}");
                assert_eq!(bounds.largest(), largest, "{bounds:?}");
            }
        }
    }

    #[test]
    fn kernels_are_named_as_what_they_are() {
        let Some(device) = Device::best().unwrap() else { panic!("no Vulkan device") };
        for (kernel, bytes, largest) in [
            ("chase", 1 << 14, "loads"),
            ("chase", 1 << 24, "misses"),
            ("integer", 16, "integer"),
            ("divide", 16, "divide"),
            ("exp", 16, "exp"),
            ("fma", 16, "FMA"),
            ("shared", 1 << 12, "shared"),
            ("atomic", 16, "atomics"),
        ] {
            let name = format!("measure/{kernel}");
            let alone = SingleKernel { name: &name, spirv: crate::gpu::spirv(&name).unwrap(), constants: &[64] };
            let mut buffers = [vec![0; bytes], vec![0; 1 << 12]];
            let tally = alone.tally(&device, &mut buffers, 1 << 10).unwrap().unwrap();
            let work = Work::new(&tally, |slot| if slot == BUFFER_IDS[0] { bytes as u64 } else { 1 << 12 });
            // It takes as long as it would on this device.
            let rates = Rates { copy: 4e6, fma: 4e6, exp: 2e6 };
            let loads = vec![(1 << 15, 4e6), (1 << 20, 4e5)];
            let finer = FinerRates { integer: 4e6, divide: 2e6, loads, shared: 2e5, atomic: 2e5 };
            let limits = Limits { rates: &rates, finer: &finer, in_turn: true };
            let a_second = limits.shares(&row(work, 1.0)).unwrap();
            let shares = limits.shares(&row(work, a_second.work(a_second.misses))).unwrap();
            assert_eq!(Bounds::of(0.0, 0.0, &shares).largest(), largest, "{kernel}: {work:?} {shares:?}");
        }
    }

    #[test]
    fn loads_and_arithmetic_add_up_where_they_take_turns() {
        let both = Work { loaded: 30, read: 1_000_000, ..of_eights(40, 40, 5) };
        let [in_turn, at_once] = [true, false].map(|in_turn| shares(both, in_turn));
        assert_eq!([in_turn.work(0.0), at_once.work(0.0)], [0.7, 0.4]);
        // Half of the lanes are idle: arithmetic takes twice as long, and so do loads of a processor's vectors.
        let half = Work { loaded: 30, ..of_eights(40, 40, 10) };
        assert_eq!([true, false].map(|in_turn| shares(half, in_turn).work(0.0)), [1.4, 0.8]);
        // Misses count as far as loads take longer than arithmetic then.
        assert_eq!(Bounds::of(0.0, 0.0, &Shares { misses: 0.2, ..at_once }).misses, 0.3 + 0.2 - 0.4);
    }

    #[test]
    fn a_device_without_a_rate_has_no_bounds() {
        let Some(device) = Device::best().unwrap() else { panic!("no Vulkan device") };
        let rates = Rates { copy: 1.0, fma: 1.0, exp: 1.0 };
        let finer = FinerRates { integer: 1.0, divide: 1.0, loads: vec![(1, 1.0)], shared: 1.0, atomic: 1.0 };
        assert!(Limits::of(&device, &rates, &finer).is_some());
        for lacking in [FinerRates { atomic: 0.0, ..finer.clone() }, FinerRates { loads: vec![(1, f64::NAN)], ..finer }]
        {
            assert!(Limits::of(&device, &rates, &lacking).is_none(), "{lacking:?}");
        }
    }
}
