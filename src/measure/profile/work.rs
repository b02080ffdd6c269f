//! Operations and memory traffic of each stage of a frame, counted by instrumented kernels, on a device or without.

use std::collections::{BTreeMap, BTreeSet};

use serde::Serialize;

use super::agreement::agreement;
use super::{Settings, result, variant};
use crate::error::{Error, Result};
use crate::gpu::count::{Tally, Traffic};
use crate::gpu::{Choices, Device, Timed, waits};
use crate::layout::{BUFFER_IDS, BufferId};
use crate::measure::interpret::stage::Interpreter;
use crate::pipeline::frame::owner;
use crate::pipeline::plan::{Change, Mode};
use crate::scene::Scene;
use crate::session::diffusion::submitted;
use crate::session::requirements::union;
use crate::session::run::Session;
use crate::state::{Dispatch, State, Width, dispatches};

/// The largest relative L2 difference of results that differ by rounding only.
const ROUNDING: f64 = 1e-4;

/// The work of a stage in one frame.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Work {
    /// Invocations, rounded up to whole workgroups.
    pub invocations: u64,
    /// Floating-point additions, subtractions and multiplications; a fused multiply-add counts two.
    pub flops: u64,
    /// Divisions and square roots.
    #[serde(rename = "divisions_roots")]
    pub roots: u64,
    /// Exponentials, logarithms and trigonometric functions.
    pub exps: u64,
    /// Lower bound of the bytes read from memory: per buffer, the bytes loaded or the bytes bound, whichever is less.
    #[serde(rename = "bytes_read")]
    pub read: u64,
    /// Lower bound of the bytes written to memory, likewise.
    #[serde(rename = "bytes_written")]
    pub written: u64,
    /// Bytes that loads request, with repetitions.
    #[serde(rename = "bytes_loaded")]
    pub loaded: u64,
    /// Bytes that stores request, with repetitions.
    #[serde(rename = "bytes_stored")]
    pub stored: u64,
    /// Instructions that all invocations issue, estimated: one a number of arithmetic, integers included, eight a root,
    /// quotient or exponential, one for 16 bytes of a load or store.
    pub instructions: u64,
    /// Those of them that compute no float.
    #[serde(rename = "other_instructions")]
    pub others: u64,
    /// Subgroups of all dispatches.
    pub subgroups: u64,
    /// Instructions that subgroups issue: one that several invocations run together counts once. `instructions` over
    /// this is the mean number of active lanes.
    pub issued: u64,
    /// Words of shared memory that are loaded and stored.
    #[serde(rename = "shared_words")]
    pub shared: u64,
    /// Operations on buffers that read a word and write it in one step.
    pub atomics: u64,
    /// Instructions that wait for one another, of the invocation with the most of them, summed over the dispatches.
    pub longest_steps: u64,
    /// Loads of buffers that wait for one another, likewise.
    pub longest_loads: u64,
    /// Loads of shared memory, barriers and exchanges in a group, likewise.
    pub longest_shared: u64,
}

/// The work of each stage in a frame of this scene on a device, by a session of its own.
pub fn work(scene: &Scene, device: &Device, settings: &Settings) -> Result<BTreeMap<String, Work>> {
    let mut plain = variant(scene, Some(device), settings)?.session;
    of(scene, &device.counting(), settings, &mut plain)
}

/// The work of each stage in a frame of this scene, on a device with instrumented kernels; the result must be that of
/// the session `plain`: see [`same_work`].
pub(super) fn of(
    scene: &Scene,
    device: &Device,
    settings: &Settings,
    plain: &mut Session,
) -> Result<BTreeMap<String, Work>> {
    let Counted { session, tallies } = counted(scene, device, settings, plain)?;
    let bound = bound(&session.dispatches(settings.change)?, session.state(), timed(&session))?;
    let mut stages: BTreeMap<String, Tally> = BTreeMap::new();
    for (kernel, tally) in tallies {
        if let Some(name) = row_of(timed(&session), &kernel, &tally) {
            stages.entry(name).or_default().add(&tally);
        }
    }
    Ok(stages.into_iter().map(|(stage, tally)| (stage.clone(), bound.work(&stage, &tally))).collect())
}

/// What a stage, a kernel or a dispatch has done.
#[derive(Clone, Debug)]
pub struct Counts {
    /// Its name.
    pub stage: String,
    /// Its dispatches.
    pub dispatches: u64,
    /// Its work.
    pub work: Work,
}

/// What a dispatch begins after.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum After {
    /// The host submits it, first of a list.
    Submission,
    /// A barrier.
    Barrier,
    /// Nothing: it runs beside the one before it.
    Nothing,
}

/// What each of these dispatches, submitted together, begins after.
fn after(state: &State, dispatches: &[Dispatch]) -> Result<impl Iterator<Item = After>> {
    let uses = dispatches.iter().map(|dispatch| dispatch.uses(state)).collect::<Result<Vec<_>>>()?;
    let waits = waits(uses, Choices::default().barriers);
    Ok(waits.into_iter().enumerate().map(|(at, wait)| match wait {
        _ if at == 0 => After::Submission,
        Some(_) => After::Barrier,
        None => After::Nothing,
    }))
}

/// A frame that the interpreter counted.
pub(super) struct Interpreted {
    /// What each of its dispatches has done, after the kernel's name and its own.
    pub(super) tallies: Vec<([String; 2], Tally)>,
    /// What each begins after.
    pub(super) after: Vec<After>,
    /// Submissions.
    pub(super) submissions: u64,
    dispatches: Vec<Dispatch>,
    state: State,
}

impl Interpreted {
    /// Counts a frame of this scene. The reference runs each step after it, so that all begin with right input.
    pub(super) fn of(scene: &Scene, interpreter: &Interpreter, settings: &Settings) -> Result<Self> {
        let mut session = Session::new(scene, None, settings.options)?;
        session.frame(Change::EVERYTHING)?;
        let (mut state, width) = (session.state().clone(), interpreter.settings().width());
        let (first, mut numbered) = (state.clone(), BTreeMap::<String, u32>::new());
        let mut found =
            Self { tallies: Vec::new(), after: Vec::new(), submissions: 0, dispatches: Vec::new(), state: first };
        for list in submitted(&session.steps_taken(settings.change)) {
            let dispatches = dispatches(&state, &list, width)?;
            found.after.extend(after(&state, &dispatches)?);
            found.submissions += u64::from(!dispatches.is_empty());
            found.dispatches.extend(dispatches);
            for step in list {
                for (kernel, tally) in interpreter.run(&state, step, false)?.tallies {
                    let number = numbered.entry(kernel.clone()).or_default();
                    *number += 1;
                    let part = format!("{kernel} #{number}");
                    found.tallies.push(([kernel, part], tally));
                }
                step.reference(&mut state);
            }
        }
        Ok(found)
    }
}

/// The work of each stage, kernel or dispatch in a frame of this scene, without a device: an interpreter counts it.
pub fn interpreted(scene: &Scene, interpreter: &Interpreter, settings: &Settings, timed: Timed) -> Result<Vec<Counts>> {
    let Interpreted { tallies, dispatches, state, .. } = Interpreted::of(scene, interpreter, settings)?;
    let (bound, mut rows) = (bound(&dispatches, &state, timed)?, Vec::<(String, Tally)>::new());
    for (names, tally) in tallies {
        let Some(name) = row_of(timed, &names, &tally) else { continue };
        match rows.iter_mut().find(|(known, _)| *known == name) {
            Some((_, all)) => all.add(&tally),
            None => rows.push((name, tally)),
        }
    }
    let row = |(stage, tally): (String, Tally)| {
        let (dispatches, work) = (tally.dispatches, bound.work(&stage, &tally));
        Counts { stage, dispatches, work }
    };
    Ok(rows.into_iter().map(row).collect())
}

/// What each dispatch of a frame on this session's device begins after, with its kernel's name.
pub(super) fn planned(session: &Session, change: Change, width: Width) -> Result<Vec<(String, After)>> {
    let mut found = Vec::new();
    for list in submitted(&session.steps_taken(change)) {
        let dispatches = dispatches(session.state(), &list, width)?;
        let after = after(session.state(), &dispatches)?;
        found.extend(dispatches.iter().map(|dispatch| dispatch.kernel.clone()).zip(after));
    }
    Ok(found)
}

/// A frame that was counted.
pub(super) struct Counted {
    /// The session that ran it.
    pub(super) session: Session,
    /// What each of its dispatches has done, after the kernel's name and that of the part that was timed with it.
    pub(super) tallies: Vec<([String; 2], Tally)>,
}

/// Counts a frame of this scene, on a device with instrumented kernels; the result must be that of the session `plain`.
pub(super) fn counted(scene: &Scene, device: &Device, settings: &Settings, plain: &mut Session) -> Result<Counted> {
    // Instrumented kernels are slow: the first frame serves as the measured one if the others would be the same.
    let mut session = Session::new(scene, Some(device), settings.options)?;
    let frame = |session: &mut Session, change: Change| session.frame(change).and_then(|_| session.tallies());
    let mut tallies = frame(&mut session, Change::EVERYTHING)?;
    let keeps = settings.options.mode != Mode::OnTheFly;
    if keeps || settings.change != Change::EVERYTHING || session.retries() + session.relinks() > 0 {
        tallies = frame(&mut session, settings.change)?;
    }
    same_work(&mut session, plain)?;
    Ok(Counted { session, tallies })
}

impl Work {
    /// The same but for chains, which are estimates, and for what depends on which invocations share a subgroup.
    #[must_use]
    pub fn counts(self) -> Self {
        Self { issued: 0, subgroups: 0, longest_steps: 0, longest_loads: 0, longest_shared: 0, ..self }
    }

    /// Active invocations of a subgroup, averaged over the instructions that it issues.
    #[must_use]
    pub fn lanes(self) -> Option<f64> {
        (self.issued > 0).then(|| self.instructions as f64 / self.issued as f64)
    }

    /// What was counted, where so many bytes of each buffer are bound.
    pub(super) fn new(tally: &Tally, bound: impl Fn(BufferId) -> u64) -> Self {
        let mut work = Self {
            invocations: tally.invocations,
            flops: tally.flops,
            roots: tally.roots,
            exps: tally.exps,
            instructions: tally.instructions,
            others: tally.others,
            subgroups: tally.subgroups,
            issued: tally.issued,
            shared: tally.shared,
            atomics: tally.atomics,
            longest_steps: tally.longest.steps,
            longest_loads: tally.longest.loads,
            longest_shared: tally.longest.shared,
            ..Self::default()
        };
        for (binding, &Traffic { loaded, stored }) in &tally.moved {
            let Some(&slot) = BUFFER_IDS.get(*binding as usize) else { continue };
            let most = bound(slot);
            work.loaded += loaded;
            work.stored += stored;
            work.read += loaded.min(most);
            work.written += stored.min(most);
        }
        work
    }
}

/// Fails unless the frame with kernels that count did the work of the one without. Compilers may contract the
/// arithmetic of the two differently, so that values differ in their last bits; what decides about work must not
/// differ.
fn same_work(counted: &mut Session, plain: &mut Session) -> Result<()> {
    let doing = "counting what kernels do";
    for session in [&mut *counted, &mut *plain] {
        session.fetch(&[BufferId::counters])?;
    }
    if counted.state().data.counters != plain.state().data.counters {
        return Err(Error::device(doing, "kernels that count make other lists than those that don't"));
    }
    let (counted, plain) = (result(counted)?, result(plain)?);
    let same = agreement(["kernels that count", "those that do not"], [&counted, &plain], ROUNDING);
    same.map(drop).map_err(|_| Error::device(doing, "kernels that count give other values than those that don't"))
}

/// How a session's frames are timed.
pub(super) fn timed(session: &Session) -> Timed {
    session.device().map_or(Timed::Steps, |device| device.choices().timed)
}

/// The row that a dispatch of this kernel and this timed part counts for: its stage, the kernel or the dispatch itself.
/// Dispatches that had to count together have none of their own, and neither has a kernel that is no stage's.
pub(super) fn row_of(timed: Timed, [kernel, part]: &[String; 2], tally: &Tally) -> Option<String> {
    let stage = owner(kernel)?;
    match timed {
        Timed::Steps => Some(stage.name.to_string()),
        Timed::Kernels => Some(kernel.clone()),
        Timed::Dispatches => (tally.dispatches == 1).then(|| part.clone()),
    }
}

/// Bytes of each buffer that a stage or a kernel binds in a frame, overlapping ranges counted once.
struct Bytes(BTreeMap<(String, BufferId), u64>);

impl Bytes {
    /// The work of a row.
    fn work(&self, row: &str, tally: &Tally) -> Work {
        // A dispatch binds at most what its kernel does.
        let kernel = row.split_once(" #").map_or(row, |(kernel, _)| kernel);
        Work::new(tally, |slot| self.0.get(&(kernel.to_string(), slot)).copied().unwrap_or_default())
    }
}

fn bound(dispatches: &[Dispatch], state: &State, timed: Timed) -> Result<Bytes> {
    let mut ranges: BTreeMap<(String, BufferId), BTreeSet<[u64; 2]>> = BTreeMap::new();
    for dispatch in dispatches {
        for bound in dispatch.bound(state)? {
            let name = if timed == Timed::Steps { dispatch.stage } else { &dispatch.kernel };
            ranges.entry((name.to_string(), bound.slot)).or_default().insert(bound.range);
        }
    }
    Ok(Bytes(ranges.into_iter().map(|(key, ranges)| (key, union(ranges))).collect()))
}
