//! Stage `widen`: the trees of all objects as shadow rays walk them: the boxes of a node's up to eight children side by
//! side, so that eight invocations load and test them at once.

use rayon::prelude::*;

use super::shadow;
use crate::error::Result;
use crate::layout::{Bounds, BufferId, NO_BOX, NONE, Range};
use crate::state::{Carrier, Granularity, Need, Pass, Role, Scope, Size, Stage, State, Tolerance, Update};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "widen",
    module: "lighting",
    about: "the boxes of up to eight nodes side by side, for shadow rays",
    equation: "copies of the boxes, in the order of hierarchy::wide",
    writes: &[(BufferId::wide_boxes, Role::Output, Tolerance::Exact)],
    reason: "copies",
    sizes: &[(BufferId::wide_boxes, Size::Elements(|state| state.data.wide_links.len()))],
    granularity: Granularity::Scene,
    carriers: Carrier::ALL,
    needs: &[Need::Light],
    serves: shadow::STAGE.serves,
    skip: shadow::STAGE.skip,
    runs: Update::placed,
    cpu,
    gpu,
};

fn cpu(state: &mut State, _at: Scope) {
    let boxes = state.data.bounds_in_scene();
    let of = |&[node, next]: &[u32; 2]| match boxes.get(node as usize).filter(|_| node != NONE) {
        Some(own) => Bounds { next, ..*own },
        None => Bounds { low: [NO_BOX; 3], next: 0, high: [-NO_BOX; 3], face: 0 },
    };
    let wide = state.data.wide_links.par_iter().map(of).collect();
    state.data.wide_boxes = wide;
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    let count = pass.state.data.wide_links.len();
    pass.dispatch(None, &[], bytemuck::bytes_of(&Range { first: 0, count: count as u32 }), count)
}
