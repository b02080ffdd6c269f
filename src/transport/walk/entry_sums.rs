//! Stage `entry_sums`: the light that enters each triangle, in integers summed from triangle to triangle, by which
//! photons are drawn; it also clears the photons, balances and exits of the walk.

use super::{blocks, factor, words64};
use crate::error::Result;
use crate::layout::{BufferId, Buffers, ENTRY_BLOCK, EntryBlock, EntrySum, ExitSum, Photon, WalkBalance};
use crate::state::{Pass, Role, Scope, Size, Stage, State, Tolerance};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "entry_sums",
    about: "area times irradiance of each triangle as an integer, summed up; photons and exits cleared",
    equation: "inclusive scan",
    writes: &[
        (BufferId::entry_sums, Role::Output, Tolerance::Exact),
        (BufferId::entry_blocks, Role::Output, Tolerance::Exact),
        (BufferId::photons, Role::Output, Tolerance::Exact),
        (BufferId::balances, Role::Output, Tolerance::Exact),
        (BufferId::exits, Role::Output, Tolerance::Exact),
    ],
    reason: "one multiplication in f32, then integers",
    sizes: &[(
        BufferId::entry_blocks,
        Size::Elements(|state| state.objects.iter().map(|object| blocks(object.count.faces) + 1).max().unwrap_or(0)),
    )],
    ..super::stage(cpu, gpu)
};

/// The light that enters a triangle, per channel.
fn light(data: &Buffers, face: usize) -> [f32; 3] {
    let area = data.clusters[data.leaves[face] as usize].area;
    data.irradiance[face].map(|e| Some(area * e).filter(|&x| x > 1e-30).unwrap_or(0.0))
}

fn cpu(state: &mut State, _at: Scope) {
    let data = &mut state.data;
    let (faces, slots) = (data.triangles.len(), data.walk_params[0].slots as usize);
    let count = blocks(faces);
    let most = |faces: std::ops::Range<usize>| {
        let lights = || faces.clone().map(|face| light(data, face));
        [0, 1, 2].map(|c| lights().map(|light| light[c]).fold(0.0, f32::max).to_bits())
    };
    let all = most(0..faces);
    let mut made = Vec::with_capacity(count + 1);
    let (mut sums, mut sum) = (Vec::with_capacity(faces), [0u64; 3]);
    let wide = |sum: [u64; 3], k: usize| sum.map(|sum| words64(sum)[k]);
    for block in 0..=count {
        let first = block * ENTRY_BLOCK as usize;
        let members = first..(first + ENTRY_BLOCK as usize).min(faces);
        let most = if block == count { all } else { most(members.clone()) };
        made.push(EntryBlock { low: wide(sum, 0), high: wide(sum, 1), most });
        for face in members {
            let light = light(data, face);
            sum = [0, 1, 2].map(|c| sum[c] + (light[c] * factor(all[c])) as u64);
            sums.push(EntrySum { low: wide(sum, 0), high: wide(sum, 1) });
        }
    }
    data.entry_blocks[..=count].copy_from_slice(&made);
    data.entry_sums = sums;
    data.exits.fill(ExitSum::default());
    data.photons[..slots].fill(Photon::default());
    data.balances[..slots].fill(WalkBalance::default());
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    let blocks = blocks(pass.object().count.faces);
    let slots = pass.state.data.walk_params[pass.at.object].slots as usize;
    pass.dispatch(Some("most"), &[], &[], blocks)?;
    pass.dispatch(Some("scale"), &[], &[], 3)?;
    pass.dispatch(Some("block"), &[], &[], blocks)?;
    pass.dispatch(Some("before"), &[], &[], 3)?;
    pass.dispatch(Some("face"), &[], &[], blocks)?;
    pass.dispatch(Some("clear"), &[], &[], slots)
}
