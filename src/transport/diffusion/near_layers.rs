//! Stage `near_layers`: the layers of each near triangle at each receiver of its block, with charge 1. They depend on
//! shape and material alone, and serve every step of the solver; blocks with more near triangles than are kept compute
//! the first ones anew in each step.

use glam::DVec3;
use rayon::prelude::*;

use super::Medium;
use super::near::{by_edges, sampled};
use crate::dipole::form_factor::gauss::{Node, legendre};
use crate::error::Result;
use crate::layout::{BLOCK_RECEIVERS, BufferId, Buffers, Range, Runs};
use crate::state::{Granularity, Object, Pass, Role, Scope, Size, Stage, State, Tolerance, wide};
use crate::transport::blocks::link::{self, batch};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "near_layers",
    about: "single and double layer of each block's near triangles at its receivers, for all steps of the solver",
    equation: "int [g/z_b + dg/dn] dA over a triangle, times z_b over its area, by area points or the edge form",
    writes: &[(BufferId::near_layers, Role::Update, Tolerance::Float { relative: 1e-4, floor: 1e-5 })],
    reason: "quadrature in f32: e^-a with the rounding of a; the edges of a distant triangle cancel",
    sizes: &[(BufferId::near_layers, Size::Elements(|state| state.batch_parts() * room(state)))],
    granularity: Granularity::Batch,
    runs: |update| (link::STAGE.runs)(update),
    ..super::stage(cpu, gpu)
};

/// Most near triangles of a block that are kept.
const MOST_KEPT: usize = 64;
/// Most bytes of an object's kept layers; every device can bind this many.
const MOST_BYTES: usize = 1 << 27;

/// Receivers of an object's largest batch, rounded up so that a device can bind each batch's part.
fn receivers(object: &Object) -> usize {
    let largest = object.schedule.batches.iter().map(|batch| batch.len()).max().unwrap_or(0);
    (largest * BLOCK_RECEIVERS).next_multiple_of(64)
}

/// Most near triangles of a block that are kept: fewer in large objects.
pub(super) fn kept(object: &Object) -> usize {
    let all = receivers(object) * object.schedule.batches.len() * BufferId::near_layers.spec().stride;
    (MOST_BYTES / all.max(1)).min(MOST_KEPT)
}

/// Elements of a batch's part of `near_layers`.
fn room(state: &State) -> usize {
    let solved = state.objects.iter().filter(|object| object.solves());
    solved.map(|object| receivers(object) * kept(object)).max().unwrap_or(0)
}

/// How many near triangles of a block are computed anew in each step: of those that take area points, and of those
/// that take the edge form.
pub(super) fn computed(run: &Runs, kept: usize) -> [usize; 2] {
    let [area, edge] = [run.area as usize, run.edge as usize];
    let anew = (area + edge).saturating_sub(kept);
    [anew.min(area), anew.saturating_sub(area)]
}

/// A triangle's vertices and their positions.
pub(super) fn corners(data: &Buffers, face: usize) -> ([u32; 3], [DVec3; 3]) {
    let ids = data.triangles[face];
    (ids, ids.map(|v| wide(data.positions[v as usize])))
}

/// The place of each block among those that have near triangles.
pub(super) fn slots(runs: &[Runs]) -> Vec<usize> {
    let next =
        |next: &mut usize, run: &Runs| Some(std::mem::replace(next, *next + usize::from(run.area + run.edge > 0)));
    runs.iter().scan(0, next).collect()
}

fn cpu(state: &mut State, at: Scope) {
    let (blocks, run_base, entry_base) = batch(state, at);
    let (kept, base) = (kept(state.object(at)), state.part(BufferId::near_layers, at).0);
    let near_base = state.part(BufferId::near, at).0;
    let nodes = legendre(state.method.nodes as usize);
    let data = &state.data;
    let groups = state.part(BufferId::near_groups, at).0;
    let of_slot = |slot: usize| {
        let number = data.near[near_base + slot] as usize;
        let (run, block) = (&data.runs[run_base + number], &data.blocks[blocks.start + number]);
        let list = near_list(data, run, entry_base);
        let [area, edge] = computed(run, kept);
        let mut layers = Vec::new();
        for (i, &node) in list.iter().enumerate().skip(area + edge) {
            for face in block.first as usize..(block.first + block.count) as usize {
                layers.push([0, 1, 2].map(|c| layers_at(data, node, face, c, i < run.area as usize, &nodes) as f32));
            }
        }
        (slot, block.count as usize, layers)
    };
    let all: Vec<_> = (0..data.near_groups[groups + 2][0] as usize).into_par_iter().map(of_slot).collect();
    for (slot, count, layers) in all {
        for (i, of_triangle) in layers.chunks(count).enumerate() {
            let first = base + (slot * kept + i) * BLOCK_RECEIVERS;
            state.data.near_layers[first..first + count].copy_from_slice(of_triangle);
        }
    }
}

/// The near triangles of a block: those that take area points, then those that take the edge form.
fn near_list<'a>(data: &'a Buffers, run: &Runs, entry_base: usize) -> &'a [u32] {
    let first = entry_base + (run.first + run.expanded + run.direct) as usize;
    &data.entries[first..first + (run.area + run.edge) as usize]
}

/// The layers of a triangle of charge 1 at a receiver, in one channel.
fn layers_at(data: &Buffers, node: u32, face: usize, c: usize, points: bool, nodes: &[Node]) -> f64 {
    let Medium { decay, boundary } = Medium::of(&data.object_params[0], c);
    let (cluster, emitter) = (&data.clusters[node as usize], data.topology[node as usize].face as usize);
    let (ids, corners) = corners(data, emitter);
    let (area, x) = (f64::from(cluster.area).max(1e-37), wide(data.receiver_positions[face]));
    if points {
        let both = sampled(decay, &corners, wide(cluster.normal) / area, x);
        return both.single + boundary * both.double;
    }
    let both = by_edges(decay, &corners, ids, x, emitter == face, nodes);
    (both.single + boundary * both.double) / area
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    let blocks = pass.object().schedule.batches[pass.at.chunk].clone();
    let range = Range { first: blocks.start, count: blocks.end - blocks.start };
    let constants = [kept(pass.object()) as u32, pass.state.method.nodes];
    pass.dispatch_counted("layers", &constants, bytemuck::bytes_of(&range), (BufferId::near_groups, 0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_large_object_keeps_fewer() {
        let object_of = |batches: &[std::ops::Range<u32>]| {
            let mut object = Object::default();
            object.schedule.batches.extend_from_slice(batches);
            object
        };
        assert_eq!(kept(&object_of(&[0..640, 640..1280])), MOST_KEPT);
        let object = object_of(&[0..100_000, 100_000..150_000]);
        let bytes = 2 * receivers(&object) * kept(&object) * BufferId::near_layers.spec().stride;
        assert!(kept(&object) < MOST_KEPT && bytes <= MOST_BYTES && bytes > MOST_BYTES / 2, "{bytes}");
        assert_eq!(kept(&object_of(&[0..10_000_000, 10_000_000..20_000_000])), 0);
    }

    #[test]
    fn what_is_not_kept_is_computed_from_the_first_on() {
        let run = |area, edge| Runs { area, edge, ..Runs::default() };
        assert_eq!(computed(&run(9, 50), 64), [0, 0]);
        assert_eq!(computed(&run(9, 60), 64), [5, 0]);
        assert_eq!(computed(&run(9, 70), 64), [9, 6]);
        assert_eq!(computed(&run(9, 70), 0), [9, 70]);
    }
}
