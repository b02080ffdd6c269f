//! Stage `boundary_integrals`: single and double layer at every triangle, of a vector of the basis; in the first run,
//! of the light that was deposited below the surface, and of the solution to start from, if there is one (the second
//! vector then keeps the light's). Clusters are expanded about blocks of receivers or evaluated at each of them; near
//! triangles take area points or the edge form, or are known from `near_layers`.

use super::near_layers::kept;
use super::sums::{Density, add_up, expanded};
use crate::error::Result;
use crate::layout::{BLOCK_RECEIVERS, BufferId, Range};
use crate::state::{Field, Granularity, Pass, Role, Scope, Stage, State, Tolerance, wide};
use crate::transport::blocks::gather::NEAR_PART;

/// Tolerances of places: absolute, for an object of unit extent; of charges: relative to the largest.
const PLACE: &[Field] = &[
    Field { name: "x", relative: 0.0, floor: 1e-5, of: "" },
    Field { name: "y", relative: 0.0, floor: 1e-5, of: "" },
    Field { name: "z", relative: 0.0, floor: 1e-5, of: "" },
    Field { name: "charge", relative: 1e-4, floor: 1e-5, of: "" },
];

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "boundary_integrals",
    about: "single and double layer at each triangle, of a vector; first, of the light deposited below the surface",
    equation: "v/2 + int v(y) [g/z_b + dg/dn] dA(y), clusters by w g - U.grad g + Y:grad grad g - (Q,U):grad grad grad g/2",
    writes: &[
        (BufferId::arrivals, Role::Update, Tolerance::Exact),
        (BufferId::layer_places, Role::Output, Tolerance::Fields(PLACE)),
        (BufferId::layer_firsts, Role::Output, Tolerance::Float { relative: 1e-4, floor: 1e-4 }),
        (BufferId::layer_squares, Role::Output, Tolerance::Float { relative: 1e-4, floor: 1e-5 }),
        (BufferId::layer_products, Role::Output, Tolerance::Float { relative: 1e-4, floor: 1e-5 }),
        (BufferId::expansions, Role::Update, Tolerance::Float { relative: 1e-4, floor: 1e-5 }),
        (BufferId::received, Role::Update, Tolerance::Float { relative: 1e-4, floor: 1e-5 }),
        (BufferId::krylov, Role::Update, Tolerance::Float { relative: 1e-4, floor: 1e-5 }),
    ],
    reason: "sums of some hundred terms of both signs, e^-a with the rounding of a; where z_b is small, first moments are \
             large sums that cancel",
    granularity: Granularity::Iteration,
    ..super::stage(cpu, gpu)
};

/// The densities that the operator is applied to in a run, in order; step 0 is the start.
fn densities(state: &State, step: usize) -> Vec<Density> {
    match step {
        0 if state.method.warm => vec![Density::Source, Density::Solution],
        0 => vec![Density::Source],
        _ => vec![Density::Vector(step - 1)],
    }
}

fn cpu(state: &mut State, at: Scope) {
    for density in densities(state, at.chunk) {
        add_up(state, at, density);
        let data = &mut state.data;
        let faces = data.triangles.len();
        for (number, block) in data.blocks.iter().enumerate() {
            for face in block.first as usize..(block.first + block.count) as usize {
                let d = wide(data.receiver_positions[face]) - wide(data.spheres[number].center);
                for c in 0..3 {
                    let sum = f64::from(data.received[face][c]) + expanded(&data.expansions[number], c, d);
                    let old = f64::from(data.krylov[face][c]);
                    if density == Density::Solution {
                        data.krylov[faces + face][c] = data.krylov[face][c];
                    }
                    let (place, value) = match density {
                        Density::Source => (face, sum),
                        Density::Solution => (face, old - sum - 0.5 * f64::from(data.solution[face][c])),
                        Density::Vector(k) => {
                            ((k + 1) * faces + face, sum + 0.5 * f64::from(data.krylov[k * faces + face][c]))
                        }
                    };
                    data.krylov[place][c] = value as f32;
                }
            }
        }
    }
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    let step = pass.at.chunk;
    for density in densities(pass.state, step) {
        let source = u32::from(density == Density::Source);
        let solution = u32::from(density == Density::Solution);
        let vector = step.saturating_sub(1) as u32;
        let (faces, nodes) = (pass.object().count.faces, pass.state.method.nodes);
        // Layers of the source term are not kept: the place of its light, in each channel, changes with the light.
        let kept = if density == Density::Source { 0 } else { kept(pass.object()) as u32 };
        pass.dispatch(Some("leaf"), &[source, solution], bytemuck::bytes_of(&vector), faces)?;
        pass.climb("cluster", &[source])?;
        for batch in 0..pass.object().schedule.batches.len() {
            pass.at.chunk = batch;
            let blocks = pass.object().schedule.batches[batch].clone();
            let range = Range { first: blocks.start, count: blocks.end - blocks.start };
            let (push, count) = (bytemuck::bytes_of(&range), range.count as usize);
            pass.dispatch(Some("expand"), &[], push, count)?;
            pass.dispatch(Some("direct"), &[source], push, count * BLOCK_RECEIVERS)?;
            for first in (0..pass.state.data.object_params[0].near_capacity).step_by(NEAR_PART as usize) {
                let push = [range, Range { first, count: NEAR_PART }];
                let push = bytemuck::bytes_of(&push);
                let groups = (BufferId::near_groups, 0);
                if source > 0 {
                    pass.dispatch_counted("source_area", &[], push, groups)?;
                    pass.dispatch_counted("source_edge", &[nodes], push, groups)?;
                } else {
                    pass.dispatch_counted("area", &[kept], push, groups)?;
                    pass.dispatch_counted("edge", &[kept, nodes], push, groups)?;
                }
            }
            if kept > 0 {
                pass.dispatch_counted("near", &[kept], bytemuck::bytes_of(&range), (BufferId::near_groups, 0))?;
            }
        }
        pass.at.chunk = step;
        let blocks = pass.object().count.blocks;
        let push = [0, blocks as u32, vector];
        pass.dispatch(Some("apply"), &[source, solution], bytemuck::bytes_of(&push), blocks * BLOCK_RECEIVERS)?;
    }
    Ok(())
}
