//! The reference of `boundary_integrals`: the layers of every cluster, and sums over the lists of each block.

use glam::{DMat3, DVec3};
use rayon::prelude::*;

use super::Medium;
use super::far::{Layers, Quadratic, area_moment};
use super::near::{by_edges, depth, sampled, too_near};
use super::near_layers::{computed, corners, kept, slots};
use crate::dipole::form_factor::gauss::{Node, legendre};
use crate::layout::{BLOCK_RECEIVERS, BufferId, Buffers, Expansion, LayerFirst, LayerPlace, LayerSecond, NONE, Runs};
use crate::state::{Scope, State, wide};
use crate::transport::blocks::link::batch;

/// A density on the surface that the operator is applied to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Density {
    /// The light that collides, at its own depth: a single layer only.
    Source,
    /// A vector of the basis.
    Vector(usize),
    /// The solution.
    Solution,
}

/// The layers of all nodes, in one channel.
fn climb(data: &Buffers, base: usize, density: Density, c: usize) -> Vec<Layers> {
    let z_b = Medium::of(&data.object_params[0], c).boundary;
    let mut all = vec![Layers::ZERO; data.topology.len()];
    for node in (0..all.len()).rev() {
        let center = wide(data.moments[base + node].center);
        if data.topology[node].face != NONE {
            let (face, cluster) = (data.topology[node].face as usize, &data.clusters[node]);
            let value = match density {
                Density::Source => data.deposits[face].light[c],
                Density::Vector(k) => data.krylov[k * data.triangles.len() + face][c],
                Density::Solution => data.solution[face][c],
            };
            let source = density == Density::Source;
            let charge = f64::from(value) * f64::from(cluster.area) / z_b;
            all[node] = Layers {
                center: if source { center + depth(data, face, c) } else { center },
                charge,
                first: if source { DVec3::ZERO } else { f64::from(value) * wide(cluster.normal) },
                second: 0.5 * charge * area_moment(&data.second_moments[base + node]),
            };
            continue;
        }
        let children = [all[node + 1], all[data.topology[node + 1].skip as usize]];
        let charge = children[0].charge + children[1].charge;
        let center = match density {
            Density::Source if charge > 0.0 => {
                children.map(|child| child.charge * child.center).iter().sum::<DVec3>() / charge
            }
            Density::Source => 0.5 * (children[0].center + children[1].center),
            _ => center,
        };
        let [l, r] = children.map(|child| child.about(center));
        all[node] = Layers { center, charge, first: l.first + r.first, second: l.second + r.second };
        if density == Density::Source {
            all[node].first = DVec3::ZERO;
        }
    }
    all
}

/// Writes the layers of all nodes, one channel of each field.
fn store(data: &mut Buffers, c: usize, all: &[Layers]) {
    for (node, m) in all.iter().enumerate() {
        let (place, first) = (&mut data.layer_places[node], &mut data.layer_firsts[node]);
        let LayerPlace { x, y, z, charge } = place;
        (x[c], y[c], z[c]) = (m.center.x as f32, m.center.y as f32, m.center.z as f32);
        charge[c] = m.charge as f32;
        let LayerFirst { x, y, z } = first;
        (x[c], y[c], z[c]) = (m.first.x as f32, m.first.y as f32, m.first.z as f32);
        let [xx, yy, zz] = [m.second.x_axis.x, m.second.y_axis.y, m.second.z_axis.z].map(|v| v as f32);
        let [yz, zx, xy] = [m.second.y_axis.z, m.second.z_axis.x, m.second.x_axis.y].map(|v| v as f32);
        let LayerSecond { x, y, z } = &mut data.layer_squares[node];
        (x[c], y[c], z[c]) = (xx, yy, zz);
        let LayerSecond { x, y, z } = &mut data.layer_products[node];
        (x[c], y[c], z[c]) = (yz, zx, xy);
    }
}

/// One channel's sums over lists.
struct Sums<'a> {
    data: &'a Buffers,
    /// The first element of the object's part of `emitters`.
    emitters: usize,
    base: usize,
    density: Density,
    c: usize,
    medium: Medium,
    nodes: &'a [Node],
}

impl Sums<'_> {
    fn area(&self, node: u32) -> DMat3 {
        area_moment(&self.data.second_moments[self.base + node as usize])
    }

    fn expand(&self, center: DVec3, list: &[u32]) -> Quadratic {
        let mut sum = Quadratic::ZERO;
        for &node in list {
            let layers = Layers::of(self.data, node as usize, self.c);
            let one = layers.expanded(self.medium.decay, &self.area(node), center);
            sum.value += one.value;
            sum.gradient += one.gradient;
            sum.second += one.second;
        }
        sum
    }

    /// All but the expansion at a triangle's centroid; `known`: the layers of the last ones of its near triangles, with
    /// charge 1.
    fn receive(&self, face: usize, x: DVec3, run: &Runs, entries: &[u32], known: &[f64]) -> f64 {
        let (direct, rest) = entries[run.expanded as usize..].split_at(run.direct as usize);
        let (area, rest) = rest.split_at(run.area as usize);
        let k = self.medium.decay;
        let far = |node: &u32| Layers::of(self.data, *node as usize, self.c).at(k, &self.area(*node), x);
        let mut sum: f64 = direct.iter().map(far).sum();
        let edge = &rest[..run.edge as usize];
        let charge = |node: u32| f64::from(self.data.layer_places[node as usize].charge[self.c]);
        let last = area.iter().chain(edge).skip(area.len() + edge.len() - known.len());
        sum += last.zip(known).map(|(&node, known)| charge(node) * known).sum::<f64>();
        let anew = computed(run, known.len());
        let source = self.density == Density::Source;
        for (list, points) in [(&area[..anew[0]], true), (&edge[..anew[1]], false)] {
            for &node in list {
                let emitter = self.data.topology[node as usize].face as usize;
                let cluster = &self.data.clusters[node as usize];
                let moved = if source { depth(self.data, emitter, self.c) } else { DVec3::ZERO };
                let (ids, corners) = corners(self.data, emitter);
                let corners = corners.map(|corner| corner + moved);
                let points = if source {
                    let distance = self.data.emitters[self.emitters + node as usize].area;
                    !too_near(self.data, node as usize, distance, self.data.receiver_positions[face])
                } else {
                    points
                };
                let size = f64::from(cluster.area).max(1e-37);
                let charge = charge(node);
                if points {
                    let normal = wide(self.data.layer_firsts[node as usize].of(self.c));
                    let one = sampled(k, &corners, normal, x);
                    sum += charge * one.single + one.double;
                } else {
                    let one = by_edges(k, &corners, ids, x, !source && emitter == face, self.nodes);
                    let double = if source { 0.0 } else { self.medium.boundary * one.double };
                    sum += charge / size * (one.single + double);
                }
            }
        }
        sum
    }
}

impl LayerFirst {
    fn of(&self, c: usize) -> [f32; 3] {
        [self.x[c], self.y[c], self.z[c]]
    }
}

/// Computes the layers of all clusters, and sums the lists of every block into `expansions` and `received`.
pub(super) fn add_up(state: &mut State, at: Scope, density: Density) {
    let first = Scope { chunk: 0, ..at };
    let [base, emitters] = [BufferId::moments, BufferId::emitters].map(|id| state.part(id, first).0);
    for c in 0..3 {
        let all = climb(&state.data, base, density, c);
        store(&mut state.data, c, &all);
    }
    let nodes = legendre(state.method.nodes as usize);
    for chunk in 0..state.object(at).schedule.batches.len() {
        let (blocks, run_base, entry_base) = batch(state, Scope { chunk, ..at });
        let kept = if density == Density::Source { 0 } else { kept(state.object(at)) };
        let known_base = state.part(BufferId::near_layers, Scope { chunk, ..at }).0;
        let data = &state.data;
        let runs = &data.runs[run_base..run_base + blocks.len()];
        let slots = slots(runs);
        let of_block = |number: usize| {
            let (run, slot) = (runs[number - blocks.start], slots[number - blocks.start]);
            let list = &data.entries[entry_base + run.first as usize..];
            let block = data.blocks[number];
            let faces = block.first as usize..(block.first + block.count) as usize;
            let mut expansion = Expansion::default();
            let mut received = vec![[0.0f32; 3]; faces.len()];
            for c in 0..3 {
                let medium = Medium::of(&data.object_params[0], c);
                let sums = Sums { data, emitters, base, density, c, medium, nodes: &nodes };
                let e = sums.expand(wide(data.spheres[number].center), &list[..run.expanded as usize]);
                put(&mut expansion, c, &e);
                for (face, received) in faces.clone().zip(&mut received) {
                    let known = |i: usize| {
                        let place = (slot * kept + i) * BLOCK_RECEIVERS + face - faces.start;
                        f64::from(data.near_layers[known_base + place][c])
                    };
                    let known: Vec<f64> = (0..kept.min((run.area + run.edge) as usize)).map(known).collect();
                    received[c] = sums.receive(face, wide(data.receiver_positions[face]), &run, list, &known) as f32;
                }
            }
            (number, expansion, received)
        };
        let results: Vec<_> = blocks.clone().into_par_iter().map(of_block).collect();
        for (number, expansion, received) in results {
            let first = state.data.blocks[number].first as usize;
            state.data.expansions[number] = expansion;
            state.data.received[first..first + received.len()].copy_from_slice(&received);
        }
    }
}

fn put(out: &mut Expansion, c: usize, e: &Quadratic) {
    out.value[c] = e.value as f32;
    for (field, value) in [&mut out.x, &mut out.y, &mut out.z].into_iter().zip(e.gradient.to_array()) {
        field[c] = value as f32;
    }
    let m = &e.second;
    let second = [m.x_axis.x, m.y_axis.y, m.z_axis.z, m.y_axis.z, m.z_axis.x, m.x_axis.y];
    let fields = [&mut out.xx, &mut out.yy, &mut out.zz, &mut out.yz, &mut out.zx, &mut out.xy];
    for (field, value) in fields.into_iter().zip(second) {
        field[c] = value as f32;
    }
}

/// A block's expansion at a place, in one channel.
pub(super) fn expanded(e: &Expansion, c: usize, d: DVec3) -> f64 {
    let at = |field: &[f32; 3]| f64::from(field[c]);
    let gradient = DVec3::new(at(&e.x), at(&e.y), at(&e.z));
    let mixed = d.y * d.z * at(&e.yz) + d.z * d.x * at(&e.zx) + d.x * d.y * at(&e.xy);
    let squares = d.x * d.x * at(&e.xx) + d.y * d.y * at(&e.yy) + d.z * d.z * at(&e.zz);
    at(&e.value) + gradient.dot(d) + 0.5 * squares + mixed
}

/// The layers of a triangle of value 1 at another triangle's centroid, in one channel, by its edges with these nodes:
/// its single layer over z_b, at the depth of its light if it is a `source`, and its double layer, which a source does
/// not have. All pairs together are the dense system that lists approximate.
#[must_use]
pub fn pair(data: &Buffers, [emitter, receiver]: [usize; 2], c: usize, source: bool, nodes: &[Node]) -> [f64; 2] {
    let medium = Medium::of(&data.object_params[0], c);
    let moved = if source { depth(data, emitter, c) } else { DVec3::ZERO };
    let ids = data.triangles[emitter];
    let corners = ids.map(|v| wide(data.positions[v as usize]) + moved);
    let x = wide(data.clusters[data.leaves[receiver] as usize].center);
    let both = by_edges(medium.decay, &corners, ids, x, !source && emitter == receiver, nodes);
    [both.single / medium.boundary, if source { 0.0 } else { both.double }]
}

/// The left-hand side of the equation for the solution at these triangles of one object, by all pairs.
#[must_use]
pub fn applied(state: &State, faces: &[usize]) -> Vec<[f64; 3]> {
    let solution = &state.data.solution;
    let mut sums = by_pairs(&state.data, faces, solution, false);
    for (sum, &face) in sums.iter_mut().zip(faces) {
        (0..3).for_each(|c| sum[c] += 0.5 * f64::from(solution[face][c]));
    }
    sums
}

/// The right-hand side of the equation at these triangles, by all pairs.
#[must_use]
pub fn source(state: &State, faces: &[usize]) -> Vec<[f64; 3]> {
    let light: Vec<[f32; 3]> = state.data.deposits.iter().map(|deposit| deposit.light).collect();
    by_pairs(&state.data, faces, &light, true)
}

fn by_pairs(data: &Buffers, faces: &[usize], values: &[[f32; 3]], source: bool) -> Vec<[f64; 3]> {
    let nodes = legendre(12);
    let received = |&face: &usize| {
        std::array::from_fn(|c| {
            let term = |emitter: usize| match f64::from(values[emitter][c]) {
                0.0 => 0.0,
                value => value * pair(data, [emitter, face], c, source, &nodes).iter().sum::<f64>(),
            };
            (0..data.triangles.len()).map(term).sum()
        })
    };
    faces.par_iter().map(received).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::transport::diffusion::far::{kernel, outer, slope};

    #[test]
    fn one_point_is_what_the_series_starts_with() {
        let (place, normal) = (DVec3::new(0.1, -0.2, 0.3), DVec3::Y);
        let layers = Layers { center: place, charge: 2.0, first: 3.0 * normal, second: DMat3::ZERO };
        let x = DVec3::new(1.0, 0.5, -0.4);
        let d = x - place;
        let exact = 2.0 * kernel(0.7, d.length()) - 3.0 * slope(0.7, d.length()) * d.dot(normal);
        assert!((layers.at(0.7, &DMat3::ZERO, x) - exact).abs() < 1e-15);
        assert_eq!(outer(DVec3::X, DVec3::Y).y_axis.x, 1.0);
    }
}
