//! Stage `widen`: the trees of all objects as rays walk them on a device: the boxes of a node's up to eight children
//! side by side, so that eight invocations load and test them at once.
//!
//! Rays of neighbouring faces or pixels go together, a team of up to eight, or a team has one ray:
//! `glsl/geometry/shaft.glsl`. The reference
//! follows each ray by itself, through the binary tree. The triangles that a ray is tested against differ, but never
//! the outcome: triangles that a ray meets lie in boxes that it meets.

use rayon::prelude::*;

use crate::error::Result;
use crate::layout::{Bounds, BufferId, LEAST_TEAM, NO_BOX, NONE, Range, WIDE};
use crate::state::{Granularity, Need, Pass, Role, Scope, Size, Stage, State, Tolerance, Update};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "widen",
    about: "the boxes of up to eight nodes side by side, for rays",
    equation: "copies of the boxes, in the order of hierarchy::wide",
    writes: &[(BufferId::wide_boxes, Role::Output, Tolerance::Exact)],
    reason: "copies",
    sizes: &[(BufferId::wide_boxes, Size::Elements(|state| state.data.wide_links.len()))],
    granularity: Granularity::Scene,
    needs: &[Need::Rays],
    runs: Update::placed,
    ..super::stage(cpu, gpu)
};

fn cpu(state: &mut State, _at: Scope) {
    let boxes = state.data.bounds_in_scene();
    let child = |&[node, next]: &[u32; 2]| match boxes.get(node as usize).filter(|_| node != NONE) {
        Some(bounds) => Bounds { next, ..*bounds },
        None => Bounds { low: [NO_BOX; 3], next: 0, high: [-NO_BOX; 3], face: 0 },
    };
    let wide = state.data.wide_links.par_iter().map(child).collect();
    state.data.wide_boxes = wide;
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    let count = pass.state.data.wide_links.len();
    pass.dispatch(None, &[], bytemuck::bytes_of(&Range { first: 0, count: count as u32 }), count)
}

/// The number of invocations of a team, whose rays go together, or which share one: as many as share a subgroup, up to
/// the children of a wide node; 1 if each ray goes alone.
pub fn team(subgroup: usize) -> u32 {
    let most = subgroup.min(WIDE);
    if most < LEAST_TEAM { 1 } else { 1 << most.ilog2() }
}
