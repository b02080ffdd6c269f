//! Stage `mark_stale`: after a change of material all kept links wait for their form factors, which are then computed
//! within the budget. The links stay: their oracle does not know the material.

use super::not_incremental;
use crate::error::Result;
use crate::layout::{BufferId, Range};
use crate::state::{Granularity, Pass, Role, Scope, Stage, State, Tolerance};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "mark_stale",
    about: "all kept links of an object whose material has changed are marked: their form factors wait",
    equation: "Mertens et al. 2003, section 5.5",
    writes: &[
        (BufferId::stale, Role::Update, Tolerance::Exact),
        (BufferId::stale_counts, Role::Update, Tolerance::Exact),
    ],
    reason: "flags and counts",
    granularity: Granularity::Chunk,
    skip: not_incremental,
    runs: |update| update.incremental && update.change.material && !update.makes_links(),
    ..super::stage(cpu, gpu)
};

fn cpu(state: &mut State, at: Scope) {
    let nodes = state.object(at).schedule.chunks[at.chunk].nodes.clone();
    let (base, _) = state.part(BufferId::stale, at);
    let data = &mut state.data;
    for &receiver in &data.order[nodes.start as usize..nodes.end as usize] {
        let span = data.spans[receiver as usize];
        let first = base + span.link as usize;
        data.stale[first..first + span.links as usize].fill(1);
        data.stale_counts[receiver as usize] = span.links;
    }
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    let nodes = pass.object().schedule.chunks[pass.at.chunk].nodes.clone();
    let range = Range { first: nodes.start, count: nodes.end - nodes.start };
    pass.dispatch(None, &[], bytemuck::bytes_of(&range), range.count as usize)
}
