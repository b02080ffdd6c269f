//! Stage `snapshot`: copies the positions and clusters that the links are made for, so that the next frame can find
//! changes.

use super::not_incremental;
use crate::error::Result;
use crate::layout::BufferId;
use crate::state::{Pass, Role, Scope, Size, Stage, State, Tolerance, Update};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "snapshot",
    about: "copy of the vertices and clusters that the links were made for; the next frame compares with it",
    equation: "Mertens et al. 2003, section 5.5",
    writes: &[
        (BufferId::kept_positions, Role::Update, Tolerance::Exact),
        (BufferId::kept_clusters, Role::Update, Tolerance::Exact),
    ],
    reason: "a copy",
    sizes: &[(BufferId::kept_positions, Size::Elements(|state| state.data.positions.len()))],
    skip: not_incremental,
    runs: Update::shape,
    ..super::stage(cpu, gpu)
};

fn cpu(state: &mut State, _at: Scope) {
    let data = &mut state.data;
    if data.counters[0].void() {
        return;
    }
    let vertices = data.object_params[0].first_vertex as usize
        ..(data.object_params[0].first_vertex + data.object_params[0].vertices) as usize;
    data.kept_positions[vertices.clone()].copy_from_slice(&data.positions[vertices]);
    data.kept_clusters.copy_from_slice(&data.clusters);
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    let count = pass.object().count;
    pass.dispatch(None, &[], &[], count.nodes.max(count.vertices))
}
