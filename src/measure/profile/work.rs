//! What the stages of a frame do and move, counted by kernels that count.

use std::collections::{BTreeMap, BTreeSet};

use super::{Settings, result};
use crate::error::{Error, Result};
use crate::gpu::Device;
use crate::gpu::count::{Tally, Traffic};
use crate::layout::{BUFFER_IDS, BufferId};
use crate::pipeline::frame::owner;
use crate::pipeline::plan::Change;
use crate::scene::Scene;
use crate::session::requirements::union;
use crate::session::run::{CapacityHints, Session};

/// What a stage does in a frame.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Work {
    /// Invocations, whole groups.
    pub invocations: u64,
    /// Additions, subtractions and multiplications of floats, two in a fused one.
    pub flops: u64,
    /// Divisions and square roots.
    pub roots: u64,
    /// Exponentials, logarithms, circular functions.
    pub exps: u64,
    /// Bytes that have to come from memory at least: each one bound counts once, and no more than are asked for.
    pub read: u64,
    /// Bytes that have to go there likewise.
    pub written: u64,
    /// Bytes that loads ask for, repeated ones included.
    pub loaded: u64,
    /// Bytes that stores name.
    pub stored: u64,
}

/// What each stage does in a frame of this scene, on a device that counts; the frame has to leave what `plain` has.
pub(super) fn of(
    scene: &Scene,
    device: &Device,
    settings: &Settings,
    plain: &mut Session,
) -> Result<BTreeMap<&'static str, Work>> {
    // A kernel that counts takes its time: where the first frame is as the others are, it serves.
    let mut session = Session::new(scene, Some(device), settings.options, CapacityHints::default())?;
    session.frame(Change::EVERYTHING)?;
    let mut counted = tallies(&session)?;
    if settings.change != Change::EVERYTHING || session.retries() + session.relinks() > 0 {
        session.frame(settings.change)?;
        counted = tallies(&session)?;
    }
    if result(&mut session)? != result(plain)? {
        return Err(Error::device(
            "counting what kernels do",
            "kernels that count give other values than those that don't",
        ));
    }
    let bound = bound(&session, settings)?;
    let mut stages: BTreeMap<&'static str, Work> = BTreeMap::new();
    for (stage, tally) in counted {
        let work = stages.entry(stage).or_default();
        (work.invocations, work.flops, work.roots, work.exps) =
            (tally.invocations, tally.flops, tally.roots, tally.exps);
        for (binding, Traffic { loaded, stored }) in tally.moved {
            let Some(&slot) = BUFFER_IDS.get(binding as usize) else { continue };
            let most = bound.get(&(stage, slot)).copied().unwrap_or_default();
            work.loaded += loaded;
            work.stored += stored;
            work.read += loaded.min(most);
            work.written += stored.min(most);
        }
    }
    Ok(stages)
}

/// What the kernels of each stage have done since the last call.
fn tallies(session: &Session) -> Result<BTreeMap<&'static str, Tally>> {
    let mut stages: BTreeMap<&'static str, Tally> = BTreeMap::new();
    for (kernel, tally) in session.tallies()? {
        if let Some(stage) = owner(&kernel) {
            stages.entry(stage.name).or_default().add(&tally);
        }
    }
    Ok(stages)
}

/// Bytes of each buffer that a stage binds in a frame, each counted once.
fn bound(session: &Session, settings: &Settings) -> Result<BTreeMap<(&'static str, BufferId), u64>> {
    let mut ranges: BTreeMap<(&'static str, BufferId), BTreeSet<[u64; 2]>> = BTreeMap::new();
    for dispatch in session.dispatches(settings.change)? {
        for bound in dispatch.bound(session.state())? {
            ranges.entry((dispatch.stage, bound.slot)).or_default().insert(bound.range);
        }
    }
    Ok(ranges.into_iter().map(|(key, ranges)| (key, union(ranges))).collect())
}
