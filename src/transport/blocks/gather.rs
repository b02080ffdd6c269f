//! Stage `gather`: light from each block's lists at its receivers. Distant emitters are expanded once about the
//! block's centre, nearer ones evaluated at each receiver, and triangles too near for one sample take area points or
//! the edge form.

use glam::DVec3;
use rayon::prelude::*;

use super::estimate;
use super::link::{Kind, batch, walk};
use crate::dipole::derivatives::{ClusterMoments, GroupProfile};
use crate::dipole::form_factor::Distance;
use crate::dipole::form_factor::edge::edge_form;
use crate::dipole::form_factor::gauss::{Node, legendre};
use crate::dipole::form_factor::points::{SIX, sampled};
use crate::error::Result;
use crate::layout::{BLOCK_RECEIVERS, BufferId, Buffers, Emitter, Expansion, Range, Runs, Sphere};
use crate::state::{Granularity, Group, Pass, Role, Scope, Size, Stage, State, Tolerance, Update, wide};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "gather",
    about: "sums over each block's lists: expanded once per block, or evaluated at each receiver",
    equation: "B += W [p0 + (p1 tr Q + p2 d.Q.d)/2] (C.1); near triangles: equation 6 by area points or the edge form",
    writes: &[
        (BufferId::expansions, Role::Update, Tolerance::Float { relative: 1e-4, floor: 2e-6 }),
        (BufferId::received, Role::Update, Tolerance::Float { relative: 1e-4, floor: 2e-6 }),
        (BufferId::area_received, Role::Update, Tolerance::Float { relative: 1e-4, floor: 2e-6 }),
        (BufferId::edge_received, Role::Update, Tolerance::Float { relative: 1e-4, floor: 2e-6 }),
        (BufferId::near_channels, Role::Update, Tolerance::Exact),
        (BufferId::estimate, Role::Update, Tolerance::Float { relative: 1e-2, floor: 1e-6 }),
    ],
    reason: "sums of some hundred terms whose quadrupoles cancel in part, e^-a with the rounding of a; an estimate is a \
             ratio of such terms",
    sizes: &[(
        BufferId::estimate,
        Size::Elements(|state| if state.method.estimate { state.extent().receivers } else { 0 }),
    )],
    granularity: Granularity::Batch,
    runs: Update::sums_receivers,
    ..super::stage(cpu, gpu)
};

/// Near triangles per block and dispatch: lavapipe silently ends an invocation's loops after 65,535 iterations in
/// total, and the edge form takes up to 79 per triangle.
pub const NEAR_PART: u32 = 512;

/// Expands the distant emitters of a block about its centre.
fn expand(
    jets: &GroupProfile,
    order: u32,
    estimated: bool,
    sphere: &Sphere,
    cloud: &(dyn Fn(u32) -> ClusterMoments + Sync),
    list: &[u32],
    out: &mut Expansion,
) {
    let center = wide(sphere.center);
    for c in jets.channels() {
        let mut sum = [0.0; 12];
        for &node in list {
            let m = &cloud(node);
            let d = center - m.center;
            let d2 = d.length_squared();
            let jet = jets.at(c, d2);
            let w = m.weight;
            let (first, second) = (w * jet.first, w * jet.second);
            let (gradient, diagonal) = (first * d, first + second * d * d);
            let mixed = second * DVec3::new(d.y * d.z, d.z * d.x, d.x * d.y);
            let terms = [
                jets.link(c, m, center, order),
                gradient.x,
                gradient.y,
                gradient.z,
                diagonal.x,
                diagonal.y,
                diagonal.z,
                mixed.x,
                mixed.y,
                mixed.z,
                if estimated { estimate::moments(jets, c, m, d2, order) } else { 0.0 },
                if estimated { estimate::bend(jets, c, m, d2, f64::from(sphere.radius)) } else { 0.0 },
            ];
            for (sum, term) in sum.iter_mut().zip(terms) {
                *sum += term;
            }
        }
        let fields = [
            &mut out.value,
            &mut out.x,
            &mut out.y,
            &mut out.z,
            &mut out.xx,
            &mut out.yy,
            &mut out.zz,
            &mut out.yz,
            &mut out.zx,
            &mut out.xy,
            &mut out.error,
            &mut out.bend,
        ];
        for (field, sum) in fields.into_iter().zip(sum) {
            field[c] = sum as f32;
        }
    }
}

/// Evaluates the other lists at a receiver: the light of each, and the squared estimate of their error.
struct Near<'a> {
    data: &'a Buffers,
    cloud: &'a (dyn Fn(u32) -> ClusterMoments + Sync),
    jets: GroupProfile,
    order: u32,
    nodes: Vec<Node>,
}

impl Near<'_> {
    fn receive(&self, x: DVec3, run: &Runs, entries: &[u32], c: usize) -> ([f64; 3], f64) {
        let (direct, rest) = entries[run.expanded as usize..].split_at(run.direct as usize);
        let (area, rest) = rest.split_at(run.area as usize);
        let edge = &rest[..run.edge as usize];
        let (mut sums, mut error) = ([0.0; 3], 0.0);
        for &node in direct {
            let m = &(self.cloud)(node);
            sums[0] += self.jets.link(c, m, x, self.order);
            error += estimate::moments(&self.jets, c, m, x.distance_squared(m.center), self.order);
        }
        let dipole = self.jets.dipole(c);
        let corners = |node: u32| {
            let face = self.data.topology[node as usize].face as usize;
            (face, self.data.triangles[face], self.data.triangles[face].map(|v| wide(self.data.positions[v as usize])))
        };
        for &node in area {
            let m = &(self.cloud)(node);
            let (face, _, triangle) = corners(node);
            let area = f64::from(self.data.clusters[self.data.leaves[face] as usize].area).max(1e-37);
            sums[1] += m.weight / area * sampled(&triangle, x, dipole, Distance::Radial, &SIX);
            error += estimate::points(&self.jets, c, m, x.distance_squared(m.center));
        }
        let tint = f64::from(self.data.object_params[0].tint[c]).max(1e-37);
        for &node in edge {
            let (face, corner, triangle) = corners(node);
            let factor = edge_form(&triangle, corner, x, dipole, Distance::Radial, &self.nodes);
            let value = f64::from(self.data.irradiance[face][c]) / tint * factor;
            sums[2] += value;
            error += estimate::edge(dipole.sigma, &(self.cloud)(node), self.nodes.len() as u32, value);
        }
        (sums, error)
    }

    /// A receiver's sums over its block's direct, area and edge lists, with those of other groups' channels, and the
    /// estimate of its error.
    fn received(&self, face: usize, run: &Runs, entries: &[u32], estimated: bool) -> [[f32; 3]; 4] {
        let data = self.data;
        let x = wide(data.receiver_positions[face]);
        let [mut direct, mut area, mut edge] =
            [&data.received, &data.area_received, &data.edge_received].map(|received| received[face]);
        let mut error = data.estimate.get(face).copied().unwrap_or_default();
        for c in self.jets.channels() {
            let (sums, squared) = self.receive(x, run, entries, c);
            direct[c] = sums[0] as f32;
            area[c] = if run.area > 0 { sums[1] as f32 } else { area[c] };
            edge[c] = if run.edge > 0 { sums[2] as f32 } else { edge[c] };
            error[c] = if estimated { squared as f32 } else { error[c] };
        }
        [direct, area, edge, error]
    }

    /// For each channel of the group, the light that the emitters dropped by a block would have sent to its centre.
    fn dropped(&self, sphere: &Sphere, emitters: &[Emitter], expands: &[[f32; 4]]) -> Vec<(usize, f64)> {
        let center = wide(sphere.center);
        let mut sums: Vec<(usize, f64)> = self.jets.channels().map(|c| (c, 0.0)).collect();
        walk(sphere, emitters, expands, |kind, node| {
            let m = &(self.cloud)(node);
            let d2 = center.distance_squared(m.center);
            for (c, sum) in sums.iter_mut().filter(|_| kind == Kind::Dropped) {
                *sum += estimate::dropped(&self.jets, *c, m, d2);
            }
        });
        sums
    }
}

fn cpu(state: &mut State, at: Scope) {
    let (blocks, run_base, entry_base) = batch(state, at);
    let (base, _) = state.part(BufferId::moments, at);
    let Group { channels, .. } = state.object(at).groups[at.group];
    let method = state.method;
    let data = &state.data;
    let emitters = &data.emitters[base..base + data.topology.len()];
    let expands = &data.expansion_distances[base..base + data.topology.len()];
    let cloud = |node: u32| {
        ClusterMoments::new(&data.moments[base + node as usize], &data.second_moments[base + node as usize])
    };
    let near = Near {
        data,
        cloud: &cloud,
        jets: GroupProfile::new(&data.object_params[0], channels),
        order: method.order,
        nodes: legendre(method.nodes as usize),
    };
    let results: Vec<_> = blocks
        .clone()
        .into_par_iter()
        .map(|number| {
            let run = data.runs[run_base + number - blocks.start];
            let list = &data.entries[entry_base + run.first as usize..];
            let mut expansion = data.expansions[number];
            let far = &list[..run.expanded as usize];
            expand(&near.jets, method.order, method.estimate, &data.spheres[number], near.cloud, far, &mut expansion);
            if method.estimate {
                for (c, sum) in near.dropped(&data.spheres[number], emitters, expands) {
                    expansion.error[c] += (sum * sum) as f32;
                }
            }
            let [area, edge] = [run.area, run.edge].map(|count| u32::from(count > 0) * channels);
            let near_channels = (data.near_channels[number] & !(channels << 3 | channels)) | (edge << 3 | area);
            let block = data.blocks[number];
            let receive = |face: usize| (face, near.received(face, &run, list, method.estimate));
            let faces = block.first as usize..(block.first + block.count) as usize;
            (number, expansion, near_channels, faces.map(receive).collect::<Vec<_>>())
        })
        .collect();
    for (number, expansion, near_channels, faces) in results {
        state.data.expansions[number] = expansion;
        state.data.near_channels[number] = near_channels;
        for (face, [direct, area, edge, error]) in faces {
            state.data.received[face] = direct;
            state.data.area_received[face] = area;
            state.data.edge_received[face] = edge;
            if method.estimate {
                state.data.estimate[face] = error;
            }
        }
    }
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    let blocks = pass.object().schedule.batches[pass.at.chunk].clone();
    let range = Range { first: blocks.start, count: blocks.end - blocks.start };
    let push = bytemuck::bytes_of(&range);
    let (group, method) = (pass.object().groups[pass.at.group], pass.state.method);
    let (count, estimate) = (range.count as usize, u32::from(method.estimate));
    let (alone, any_light) = (u32::from(pass.object().groups.len() == 1), u32::from(method.any_light));
    // Without estimates no dispatch waits for another. Those of few invocations and long chains go first, so that the
    // others fill the device meanwhile.
    if !method.estimate {
        near(pass, range)?;
    }
    pass.dispatch(Some("expand"), &[group.channels, method.order, estimate, alone, any_light], push, count)?;
    if method.estimate {
        pass.dispatch(Some("dropped"), &[group.channels], push, count)?;
    }
    let places = count * BLOCK_RECEIVERS;
    pass.dispatch(Some("direct"), &[group.channels, method.order, estimate, any_light], push, places)?;
    // Errors are added to those of the direct lists.
    if method.estimate { near(pass, range) } else { Ok(()) }
}

/// Dispatches what sums the triangles too near for one sample.
fn near(pass: &mut Pass<'_>, range: Range) -> Result<()> {
    let (group, method) = (pass.object().groups[pass.at.group], pass.state.method);
    let (estimate, any_light) = (u32::from(method.estimate), u32::from(method.any_light));
    for first in (0..pass.state.data.object_params[0].near_capacity).step_by(NEAR_PART as usize) {
        let push = [range, Range { first, count: NEAR_PART }];
        let push = bytemuck::bytes_of(&push);
        let edge = [group.channels, method.nodes, estimate, any_light];
        pass.dispatch_counted("edge", &edge, push, (BufferId::near_groups, 0))?;
        pass.dispatch_counted("area", &[group.channels, estimate, any_light], push, (BufferId::near_groups, 0))?;
    }
    Ok(())
}
