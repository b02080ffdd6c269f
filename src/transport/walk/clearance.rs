//! Stage `clearance`: for each cell of a grid, a lower bound on the distance of its points from the object's surface. A
//! photon whose flight is shorter collides without a look at the surface, as most do.

use rayon::prelude::*;

use super::exact::{inverse, root};
use crate::error::Result;
use crate::geometry::trace::{dot, minus};
use crate::layout::{BufferId, Buffers, CLEARANCE_SIDE, NONE};
use crate::state::{Pass, Role, Scope, Size, Stage, State, Tolerance};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "clearance",
    about: "lower bounds on distances to the surface, over a grid: where photons fly freely",
    equation: "distance to the nearest triangle's bounding box, less half a cell",
    writes: &[(BufferId::clearance, Role::Output, Tolerance::Exact)],
    reason: "decisions depend on it: additions, multiplications and comparisons in f32",
    sizes: &[(BufferId::clearance, Size::Elements(|_| CELLS))],
    ..super::stage(cpu, gpu)
};

/// Cells of the grid.
const CELLS: usize = (CLEARANCE_SIDE * CLEARANCE_SIDE * CLEARANCE_SIDE) as usize;
/// A factor on a distance, and a distance to subtract, that cover rounding.
const SURELY: [f32; 2] = [0.9999, 1e-5];

/// A lower bound on the distance from any point of a cell to the surface.
fn of_cell(data: &Buffers, cell: u32) -> f32 {
    let whole = &data.bounds[0];
    let step = minus(whole.high, whole.low).map(|x| x * (1.0 / CLEARANCE_SIDE as f32));
    let at = [cell % CLEARANCE_SIDE, cell / CLEARANCE_SIDE % CLEARANCE_SIDE, cell / (CLEARANCE_SIDE * CLEARANCE_SIDE)];
    let center: [f32; 3] = std::array::from_fn(|k| whole.low[k] + (at[k] as f32 + 0.5) * step[k]);
    let (first, nodes) = (data.object_params[0].first_node, data.object_params[0].nodes);
    let (mut best, mut node) = (16.0f32, 0);
    while node < nodes {
        let bounds = &data.bounds[node as usize];
        let apart: [f32; 3] =
            std::array::from_fn(|k| (bounds.low[k] - center[k]).max(center[k] - bounds.high[k]).max(0.0));
        let square = dot(apart, apart);
        if square < best && bounds.face == NONE {
            node += 1;
            continue;
        }
        best = best.min(if bounds.face == NONE { best } else { square });
        node = bounds.next - first;
    }
    (SURELY[0] * root(best) - 0.5 * root(dot(step, step)) - SURELY[1]).max(0.0)
}

/// A lower bound on the distance from a point in the object to the surface.
pub(super) fn around(data: &Buffers, place: [f32; 3]) -> f32 {
    let whole = &data.bounds[0];
    let at = |k: usize| {
        let per = CLEARANCE_SIDE as f32 * inverse((whole.high[k] - whole.low[k]).max(1e-20));
        ((place[k] - whole.low[k]).max(0.0) * per).min((CLEARANCE_SIDE - 1) as f32) as u32
    };
    data.clearance[(at(0) + CLEARANCE_SIDE * (at(1) + CLEARANCE_SIDE * at(2))) as usize]
}

fn cpu(state: &mut State, _at: Scope) {
    let data = &state.data;
    let cells: Vec<f32> = (0..CELLS as u32).into_par_iter().map(|cell| of_cell(data, cell)).collect();
    state.data.clearance.copy_from_slice(&cells);
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    pass.dispatch(None, &[], &[], CELLS)
}
