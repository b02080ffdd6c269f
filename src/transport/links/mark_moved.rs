//! Stage `mark_moved`: which clusters contain a triangle that has moved since the kept links were made.

use super::not_incremental;
use crate::error::Result;
use crate::layout::{ALTERED_MOVED, BufferId};
use crate::state::{Pass, Role, Scope, Stage, State, Tolerance, Update};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "mark_moved",
    about: "clusters with a triangle that has moved since the kept links were made",
    equation: "Mertens et al. 2003, section 5.5",
    writes: &[
        (BufferId::arrivals, Role::Update, Tolerance::Exact),
        (BufferId::change_flags, Role::Output, Tolerance::Exact),
    ],
    reason: "comparisons of f32 for equality",
    skip: not_incremental,
    runs: Update::updates_links,
    ..super::stage(cpu, gpu)
};

fn cpu(state: &mut State, _at: Scope) {
    let data = &mut state.data;
    let moved = |&v: &u32| data.positions[v as usize] != data.kept_positions[v as usize];
    // Count the moved triangles before each node: nodes are stored depth first, so a subtree has one if the count
    // grows in it.
    let before: Vec<usize> = std::iter::once(0)
        .chain(data.topology.iter().scan(0, |sum, place| {
            let triangle = data.triangles.get(place.face as usize);
            *sum += usize::from(triangle.is_some_and(|corners| corners.iter().any(moved)));
            Some(*sum)
        }))
        .collect();
    let altered = |(node, place): (usize, &crate::layout::Topology)| before[place.skip as usize] > before[node];
    data.change_flags =
        data.topology.iter().enumerate().map(altered).map(|altered| if altered { ALTERED_MOVED } else { 0 }).collect();
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    pass.dispatch(Some("leaf"), &[], &[], pass.object().count.faces)?;
    pass.climb("cluster", &[])
}
