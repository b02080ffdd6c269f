//! Stage `mark_relit`: which clusters contain a triangle whose irradiance differs from the one that radiosity was
//! last summed with.

use super::not_incremental;
use crate::error::Result;
use crate::layout::{ALTERED_RELIT, BufferId};
use crate::state::{Pass, Role, Scope, Stage, State, Tolerance};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "mark_relit",
    about: "clusters with a triangle whose irradiance has changed since the last sum",
    equation: "Mertens et al. 2003, section 5.5",
    writes: &[
        (BufferId::arrivals, Role::Update, Tolerance::Exact),
        (BufferId::change_flags, Role::Update, Tolerance::Exact),
    ],
    reason: "comparisons of f32 for equality",
    skip: not_incremental,
    runs: |update| update.updates_links() && !update.sums_all_links(),
    ..super::stage(cpu, gpu)
};

fn cpu(state: &mut State, _at: Scope) {
    let data = &mut state.data;
    for (&leaf, light) in data.leaves.iter().zip(&data.irradiance) {
        if *light == data.cluster_irradiance[leaf as usize] {
            continue;
        }
        // Mark the leaf and every cluster above it.
        let mut node = leaf;
        while let Some(altered) = data.change_flags.get_mut(node as usize) {
            *altered |= ALTERED_RELIT;
            node = data.topology[node as usize].parent;
        }
    }
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    pass.dispatch(Some("leaf"), &[], &[], pass.object().count.faces)?;
    pass.climb("cluster", &[])
}
