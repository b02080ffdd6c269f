//! Stage `link`: the lists of each block of receivers: emitters to expand, to link directly, or to take triangle by
//! triangle.
//!
//! Decisions: `f32` additions, multiplications and comparisons in the order of
//! `glsl/transport/blocks/link/walk.glsl`, so that all devices agree bit for bit. Lists are counted, placed by a
//! prefix sum, and written; a block has no fixed capacity.

use rayon::prelude::*;

use crate::dipole::distance2;
use crate::error::Result;
use crate::layout::{
    BLOCK_CLASSES, BLOCK_RECEIVERS, BufferId, Emitter, GROUP_SIZE, GROUPS_A_ROW, LINK_AREA, LINK_DIRECT, LINK_DROPPED,
    LINK_EDGE, LINK_EXPANDED, LINK_KEPT, LINK_KINDS, LINK_OPENED, MOST_DIRECT, NOTED_EXTRA, NOTED_LEAST, PART_HEADER,
    Range, Runs, Sphere,
};
use crate::state::{Carrier, Granularity, Pass, Role, Scope, Size, Stage, State, Tolerance, Update};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "link",
    about: "the lists of each block: emitters to expand, to link directly, or to integrate by area points or the edge form",
    equation: "Mertens et al. 2003, section 5.2, by contribution: |x - c|^2 >= (radius of the rule + radius of the block)^2",
    writes: &[
        (BufferId::runs, Role::Update, Tolerance::Exact),
        (BufferId::counters, Role::Update, Tolerance::Exact),
        (BufferId::decisions, Role::Scratch, Tolerance::Exact),
        (BufferId::entries, Role::Output, Tolerance::Exact),
        (BufferId::near, Role::Update, Tolerance::Exact),
        (BufferId::near_groups, Role::Update, Tolerance::Exact),
    ],
    reason: "decisions: additions, multiplications and comparisons in f32, the same everywhere",
    sizes: &[
        (BufferId::runs, Size::Elements(blocks_of_batches)),
        (BufferId::decisions, Size::Grows(decided)),
        (BufferId::near, Size::Elements(blocks_of_batches)),
        (BufferId::near_groups, Size::Elements(|state| state.batch_parts() * 64)),
        (
            BufferId::entries,
            Size::Grows(|state| state.batch_parts() * state.data.object_params[0].entry_capacity as usize),
        ),
    ],
    granularity: Granularity::Batch,
    carriers: &[Carrier::Blocks, Carrier::Diffusion],
    runs,
    ..super::stage(cpu, gpu)
};

fn runs(update: &Update) -> bool {
    let made_for = match (update.keeps, update.any_light) {
        (_, true) => false,
        // Lists of blocks depend on the light.
        (true, false) => update.transport(),
        (false, false) => update.sums(),
    };
    made_for || update.material() || update.other_receivers() || update.change.relink
}

/// What one invocation keeps for each block of a batch, and room for what groups note of them.
fn decided(state: &State) -> usize {
    let blocks = state.largest_batch();
    let entries = state.data.object_params[0].entry_capacity as usize;
    (blocks * LINK_KEPT).max(blocks * NOTED_EXTRA + entries + entries / NOTED_LEAST * PART_HEADER)
}

/// One element per block of each batch, rounded up so that a device can bind each batch's part.
fn blocks_of_batches(state: &State) -> usize {
    state.batch_parts() * state.largest_batch().next_multiple_of(64)
}

/// How a block treats an emitter.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Kind {
    /// Its light is neglected.
    Dropped = LINK_DROPPED,
    /// It is expanded about the block's centre.
    Expanded = LINK_EXPANDED,
    /// It is evaluated at each receiver.
    Direct = LINK_DIRECT,
    /// A triangle that takes area points.
    Area = LINK_AREA,
    /// A triangle that takes the edge form.
    Edge = LINK_EDGE,
    /// Its children are visited instead.
    Opened = LINK_OPENED,
}

/// Whether a squared distance is at least (reach + radius)^2; always true for a reach far below 0.
fn beyond(d2: f32, reach: f32, radius: f32) -> bool {
    let sum = (reach + radius).max(0.0);
    d2 >= sum * sum
}

/// Walks the tree of emitters for a block and reports each decision, in order.
pub fn walk(sphere: &Sphere, emitters: &[Emitter], expands: &[[f32; 4]], mut tell: impl FnMut(Kind, u32)) {
    let class = BLOCK_CLASSES.iter().position(|&most| sphere.relative_moment <= most);
    let mut node = 0;
    while node < emitters.len() {
        let e = &emitters[node];
        let [x, y, z, drop] = e.place;
        let d2 = distance2(sphere.center, [x, y, z]);
        let kind = if beyond(d2, drop, sphere.radius) {
            Kind::Dropped
        } else if class.is_some_and(|class| beyond(d2, expands[node][class], sphere.radius)) {
            Kind::Expanded
        } else if beyond(d2, e.accept, sphere.radius) {
            Kind::Direct
        } else if e.skip as usize != node + 1 {
            Kind::Opened
        } else if beyond(d2, e.area, sphere.radius) {
            Kind::Area
        } else {
            Kind::Edge
        };
        tell(kind, node as u32);
        node = if kind == Kind::Opened { node + 1 } else { e.skip as usize };
    }
}

/// The blocks of a batch, and the first elements of its parts of `runs` and of `entries`.
pub fn batch(state: &State, at: Scope) -> (std::ops::Range<usize>, usize, usize) {
    let blocks = state.object(at).schedule.batches[at.chunk].clone();
    (blocks.start as usize..blocks.end as usize, state.part(BufferId::runs, at).0, state.part(BufferId::entries, at).0)
}

fn cpu(state: &mut State, at: Scope) {
    let (blocks, run_base, entry_base) = batch(state, at);
    let (base, _) = state.part(BufferId::emitters, at);
    let data = &mut state.data;
    if (at.chunk, at.group) == (0, 0) {
        data.counters[0] = data.counters[0].opened();
    }
    let emitters = &data.emitters[base..base + data.topology.len()];
    let expands = &data.expansion_distances[base..base + data.topology.len()];
    let lists: Vec<[Vec<u32>; LINK_KINDS]> = (data.spheres[blocks].par_iter())
        .map(|sphere| {
            let mut lists: [Vec<u32>; LINK_KINDS] = Default::default();
            walk(sphere, emitters, expands, |kind, node| lists[kind as usize].push(node));
            lists
        })
        .collect();

    let near = |lists: &[Vec<u32>; LINK_KINDS]| lists[Kind::Area as usize].len() + lists[Kind::Edge as usize].len();
    if lists.iter().any(|lists| lists[Kind::Direct as usize].len() > MOST_DIRECT) {
        data.counters[0].unfinished = 1;
    }
    let most_near = lists.iter().map(near).max().unwrap_or(0) as u32;

    let kept = Kind::Expanded as usize..=Kind::Edge as usize;
    let total: usize = lists.iter().map(|lists| lists[kept.clone()].iter().map(Vec::len).sum::<usize>()).sum();
    let fits = total <= data.object_params[0].entry_capacity as usize;
    let counters = &mut data.counters[0];
    counters.entries = total as u32;
    counters.required_entries = counters.required_entries.max(total as u32);
    counters.required_near = counters.required_near.max(most_near);
    counters.overflow |= u32::from(!fits || most_near > data.object_params[0].near_capacity);

    let (near_base, groups_base) = (state.part(BufferId::near, at).0, state.part(BufferId::near_groups, at).0);
    let data = &mut state.data;
    let (mut near, mut next) = (0, 0);
    for (i, lists) in lists.iter().enumerate() {
        let [dropped, expanded, direct, area, edge, _] = lists.each_ref().map(|list| list.len() as u32);
        data.runs[run_base + i] = if fits {
            Runs { first: next, expanded, direct, area, edge, dropped }
        } else {
            Runs { dropped, ..Runs::default() }
        };
        for list in lists[kept.clone()].iter().filter(|_| fits) {
            let start = entry_base + next as usize;
            data.entries[start..start + list.len()].copy_from_slice(list);
            next += list.len() as u32;
        }
        if area + edge > 0 {
            data.near[near_base + near] = i as u32;
            near += 1;
        }
    }
    let near = if fits { near } else { 0 };
    let groups = (near * BLOCK_RECEIVERS).div_ceil(GROUP_SIZE as usize) as u32;
    data.near_groups[groups_base] = [groups, 1, 1];
    data.near_groups[groups_base + 1] = rows(near as u32);
    data.near_groups[groups_base + 2] = [near as u32, 0, 0];
}

/// This many groups, in rows.
pub(crate) fn rows(count: u32) -> [u32; 3] {
    [count.min(GROUPS_A_ROW), count.div_ceil(GROUPS_A_ROW), 1]
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    let blocks = pass.object().schedule.batches[pass.at.chunk].clone();
    let range = Range { first: blocks.start, count: blocks.end - blocks.start };
    let push = bytemuck::bytes_of(&range);
    if (pass.at.chunk, pass.at.group) == (0, 0) {
        pass.dispatch(Some("open"), &[], &[], 1)?;
    }
    pass.dispatch(Some("count"), &[], push, range.count as usize)?;
    pass.dispatch(Some("scan"), &[], push, 1)?;
    pass.dispatch(Some("write"), &[], push, range.count as usize)
}
