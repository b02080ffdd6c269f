//! Stage `recollect`: what `collect` does, for those receivers alone whose links, form factors or emitters are not what they
//! were; what the others received before, they would receive again to the last bit.

use super::collect::sum;
use super::not_incremental;
use crate::error::Result;
use crate::layout::{DUE_SUMMED, Range, Slot};
use crate::state::{Carrier, Need, Pass, Place, Role, Serves, Stage, State, Tolerance, Unit};

/// The table's entry.
pub static STAGE: Stage = Stage {
    name: "recollect",
    room: "baseline",
    about: "the same for nodes whose links, form factors or emitters have changed",
    equation: "Mertens et al. 2003, equation 6",
    writes: &[(Slot::gathered, Role::Update, Tolerance::Float { relative: 3e-5, floor: 1e-7 })],
    reason: "that of collect",
    sizes: &[],
    unit: Unit::Chunk,
    carriers: &[Carrier::Links],
    needs: &[Need::Light],
    serves: Serves::TRANSLUCENT,
    skip: not_incremental,
    runs: |update| !update.sums_all_links() && (update.shape() || update.resums()),
    cpu,
    gpu,
};

fn cpu(state: &mut State, at: Place) {
    let first = state.object(at).schedule.chunks[at.chunk].nodes.start as usize;
    let receivers = state.data.busy[first..first + state.data.cursor[0].busy as usize].to_vec();
    sum(state, at, &receivers);
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    let nodes = pass.object().schedule.chunks[pass.at.chunk].nodes.clone();
    let range = Range { first: nodes.start, count: nodes.end - nodes.start };
    pass.dispatch_counted("receiver", &[], bytemuck::bytes_of(&range), (Slot::due_groups, DUE_SUMMED))
}
