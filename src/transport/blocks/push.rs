//! Stage `push`: a receiver's radiosity B: the light that it received itself, plus its block's expansion at its
//! position. (Section 3.2 adds up clusters' constants; here a block hands down a quadratic.)

use rayon::prelude::*;

use super::estimate;
use crate::error::Result;
use crate::layout::{BLOCK_RECEIVERS, BufferId, Expansion, Range};
use crate::state::{Granularity, Object, Pass, Role, Scope, Stage, State, Tolerance, Update, wide};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "push",
    about: "radiosity of each receiver: its own sums, plus its block's expansion at the receiver",
    equation: "B = max(0, received + f + g.d + d.H.d / 2), d from the block's centre (section 3.2, to second order)",
    writes: &[
        (BufferId::estimate, Role::Update, Tolerance::Float { relative: 1e-4, floor: 1e-6 }),
        (BufferId::radiosity, Role::Output, Tolerance::Float { relative: 2e-5, floor: 1e-6 }),
    ],
    reason: "a short sum whose terms may cancel in part",
    granularity: Granularity::Object,
    runs: Update::sums_receivers,
    ..super::stage(cpu, gpu)
};

/// Bits of the channels that are in any group.
fn alive(object: &Object) -> u32 {
    object.groups.iter().fold(0, |mask, group| mask | group.channels)
}

/// The expansion of one channel at an offset.
fn expanded(e: &Expansion, c: usize, d: glam::DVec3) -> f64 {
    let at = |field: &[f32; 3]| f64::from(field[c]);
    let linear = d.x * at(&e.x) + d.y * at(&e.y) + d.z * at(&e.z);
    let squares = d.x * d.x * at(&e.xx) + d.y * d.y * at(&e.yy) + d.z * d.z * at(&e.zz);
    let mixed = d.y * d.z * at(&e.yz) + d.z * d.x * at(&e.zx) + d.x * d.y * at(&e.xy);
    at(&e.value) + linear + 0.5 * squares + mixed
}

fn cpu(state: &mut State, at: Scope) {
    let (mask, estimated) = (alive(state.object(at)), state.method.estimate);
    let data = &state.data;
    let push = |number: usize| {
        let (block, e, near) = (data.blocks[number], &data.expansions[number], data.near_channels[number]);
        let center = wide(data.spheres[number].center);
        let radius = f64::from(data.spheres[number].radius);
        let face = move |face: usize| {
            let d = wide(data.receiver_positions[face]) - center;
            let (mut value, mut error) = ([0.0; 3], data.estimate.get(face).copied().unwrap_or_default());
            for c in 0..3 {
                if mask >> c & 1 == 0 {
                    error[c] = if estimated { 0.0 } else { error[c] };
                    continue;
                }
                let own = |bit: usize, values: &[[f32; 3]]| {
                    if near >> (bit + c) & 1 == 0 { 0.0 } else { f64::from(values[face][c]) }
                };
                let received =
                    f64::from(data.received[face][c]) + own(0, &data.area_received) + own(3, &data.edge_received);
                let sum = received + expanded(e, c, d);
                value[c] = sum.max(0.0) as f32;
                if estimated {
                    let [own, center, rim] = [error[c], e.error[c], e.bend[c]].map(f64::from);
                    let [sigma, rounding] =
                        [&data.object_params[0].sigma, &data.object_params[0].rounding].map(|x| f64::from(x[c]));
                    error[c] = estimate::close([sigma, rounding], own, [center, rim], [d.length(), radius], sum) as f32;
                }
            }
            (face, value, error)
        };
        (block.first as usize..(block.first + block.count) as usize).map(face).collect::<Vec<_>>()
    };
    let results: Vec<_> = (0..data.blocks.len()).into_par_iter().flat_map_iter(push).collect();
    for (face, value, error) in results {
        state.data.radiosity[face] = value;
        if estimated {
            state.data.estimate[face] = error;
        }
    }
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    let blocks = pass.object().count.blocks;
    let range = Range { first: 0, count: blocks as u32 };
    let constants = [alive(pass.object()), u32::from(pass.state.method.estimate)];
    pass.dispatch(None, &constants, bytemuck::bytes_of(&range), blocks * BLOCK_RECEIVERS)
}
