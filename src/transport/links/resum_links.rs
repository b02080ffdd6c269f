//! Stage `resum_links`: `sum_links` for only those receivers whose links, form factors or emitters have changed; for
//! all others the result would be the same to the last bit.

use super::not_incremental;
use super::sum_links::sum;
use crate::error::Result;
use crate::layout::{BufferId, DUE_SUMMED, Range};
use crate::state::{Granularity, Pass, Role, Scope, Stage, State, Tolerance};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "resum_links",
    about: "the same sum, only for nodes whose links, form factors or emitters have changed",
    equation: "Mertens et al. 2003, equation 6",
    writes: &[(BufferId::gathered, Role::Update, Tolerance::Float { relative: 3e-5, floor: 1e-7 })],
    reason: "that of sum_links",
    granularity: Granularity::Chunk,
    skip: not_incremental,
    runs: |update| !update.sums_all_links() && (update.shape() || update.renews_factors()),
    ..super::stage(cpu, gpu)
};

fn cpu(state: &mut State, at: Scope) {
    let first = state.object(at).schedule.chunks[at.chunk].nodes.start as usize;
    let receivers = state.data.active_receivers[first..first + state.data.counters[0].receivers as usize].to_vec();
    sum(state, at, &receivers);
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    let nodes = pass.object().schedule.chunks[pass.at.chunk].nodes.clone();
    let range = Range { first: nodes.start, count: nodes.end - nodes.start };
    pass.dispatch_counted("receiver", &[], bytemuck::bytes_of(&range), (BufferId::due_groups, DUE_SUMMED))
}
