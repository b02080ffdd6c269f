//! Stage `form_factor`: F of every link, by one sample, by area points, or for the nearest triangles by the edge
//! form; near clusters by the edge form of their projection, unless `transport.cluster` selects one sample. Where
//! `transport.near` selects point sampling, uniform samples replace the edge form, for comparison with the paper.

use glam::DVec3;
use rayon::prelude::*;

use super::LINKS;
use super::refine::{cluster_rule, rule};
use crate::dipole::distance2;
use crate::dipole::form_factor::edge::edge_form;
use crate::dipole::form_factor::gauss;
use crate::dipole::form_factor::points::{SIX, THREE, TWELVE, midpoint_moment, sampled};
use crate::dipole::form_factor::polygon::polygon_form;
use crate::dipole::form_factor::uniform;
use crate::dipole::profile::{Dipole, kernel};
use crate::error::Result;
use crate::layout::{BufferId, Buffers, RULE_AREA, RULE_EDGE, RULE_SAMPLE};
use crate::state::{Distance, Granularity, Near, Pass, Role, Scope, Stage, State, Tolerance, Update, narrow, wide};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "form_factor",
    about: "form factor of every link: one sample, area points, or the edge form",
    equation: "Mertens et al. 2003, equations 7 to 13, free of cancellation",
    writes: &[(BufferId::factors, Role::Output, Tolerance::Float { relative: 1e-4, floor: 2e-7 })],
    reason: "e^{-a} carries the rounding of a, up to 100 x 2^-24; an edge's integral is rounded at 2^-24 of itself, and \
             the edges of a sliver cancel down to a small share of it, hence the floor of some 3 x 2^-24",
    sizes: &[(BufferId::factors, LINKS)],
    granularity: Granularity::Chunk,
    runs: Update::makes_links,
    ..super::stage(cpu, gpu)
};

/// How a form factor is evaluated.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum QuadratureRule {
    /// One sample at the centre; for a triangle with its second moment.
    Center,
    /// An area rule: 0, 1, 2 for 3, 6, 12 points.
    Points(usize),
    /// The edge form; of a cluster, over the border of its projection.
    Edges,
    /// This many uniform point samples.
    Uniform(u32),
}

/// All nodes as emitters, with the data that their form factors depend on.
pub struct Emitters<'a> {
    data: &'a Buffers,
    distance: crate::dipole::form_factor::Distance,
    near: Near,
    dipoles: [Dipole; 3],
}

impl<'a> Emitters<'a> {
    /// The emitters of the tree and material of `data`.
    pub fn new(data: &'a Buffers, distance: Distance, near: Near) -> Self {
        let distance = match distance {
            Distance::Radial => crate::dipole::form_factor::Distance::Radial,
            Distance::Table1 => crate::dipole::form_factor::Distance::Table1 { clamp: true },
        };
        Self { data, distance, near, dipoles: [0, 1, 2].map(|channel| Dipole::of(&data.object_params[0], channel)) }
    }

    /// The quadrature rule of a link from this node to a receiver at `center`: decided as in the shaders.
    pub fn rule(&self, node: u32, center: [f32; 3]) -> QuadratureRule {
        let d2 = distance2(center, self.data.clusters[node as usize].center);
        let Some(&reach) = self.data.reach.get(self.data.topology[node as usize].face as usize) else {
            let near = cluster_rule(d2, self.data.cluster_reach.get(node as usize)) == RULE_EDGE;
            return if near { QuadratureRule::Edges } else { QuadratureRule::Center };
        };
        match rule(d2, reach) {
            RULE_SAMPLE => QuadratureRule::Center,
            RULE_AREA if d2 >= reach[1] => QuadratureRule::Points(0),
            RULE_AREA if d2 >= reach[2] => QuadratureRule::Points(1),
            RULE_AREA => QuadratureRule::Points(2),
            _ if self.near == Near::PointSampling => {
                let area = self.data.clusters[node as usize].area;
                QuadratureRule::Uniform(uniform::count(area, uniform::density(&self.data.object_params[0])))
            }
            _ => QuadratureRule::Edges,
        }
    }

    /// The form factor of a node for a receiver at `x`, per channel.
    pub fn factor(&self, node: u32, x: DVec3, rule: QuadratureRule) -> DVec3 {
        let face = self.data.topology[node as usize].face;
        let Some(corner) = self.data.triangles.get(face as usize) else {
            return if rule == QuadratureRule::Edges { self.projected(node, x) } else { self.cluster(node, x) };
        };
        let cloud = if let QuadratureRule::Uniform(count) = rule { uniform::samples(face, count) } else { Vec::new() };
        let triangle = corner.map(|v| wide(self.data.positions[v as usize]));
        let channel = |dipole: &Dipole| match rule {
            QuadratureRule::Center => midpoint_moment(&triangle, x, dipole, self.distance),
            QuadratureRule::Points(rule) => {
                let rule: &[_] = [&THREE[..], &SIX[..], &TWELVE[..]][rule.min(2)];
                sampled(&triangle, x, dipole, self.distance, rule)
            }
            QuadratureRule::Uniform(_) => sampled(&triangle, x, dipole, self.distance, &cloud),
            QuadratureRule::Edges => edge_form(&triangle, *corner, x, dipole, self.distance, &gauss::SIX),
        };
        DVec3::from_array(self.dipoles.each_ref().map(channel))
    }

    /// The polygon that a cluster's triangles make on the plane through its centre, across its mean normal, times A/A':
    /// it is smaller than the cluster, but sends out the cluster's light.
    fn projected(&self, node: u32, x: DVec3) -> DVec3 {
        let cluster = &self.data.clusters[node as usize];
        let normal = wide(cluster.normal);
        let share = f64::from(cluster.area) / normal.length().max(f64::MIN_POSITIVE);
        let plane = (wide(cluster.center), normal.normalize_or_zero());
        let [first, count] = self.data.borders[node as usize].map(|n| n as usize);
        let edges = &self.data.border_edges[first..first + count];
        let border: Vec<[DVec3; 2]> =
            edges.iter().map(|edge| edge.map(|v| wide(self.data.positions[v as usize]))).collect();
        let channel = |dipole: &Dipole| polygon_form(&border, plane, x, dipole, self.distance, &gauss::THREE);
        share * DVec3::from_array(self.dipoles.each_ref().map(channel))
    }

    /// One sample at a cluster's centre; displaced sources lie along its mean normal, whose length is at most 1.
    fn cluster(&self, node: u32, x: DVec3) -> DVec3 {
        let cluster = &self.data.clusters[node as usize];
        let (center, area) = (wide(cluster.center), f64::from(cluster.area));
        let mean = wide(cluster.normal) / area;
        let channel = |dipole: &Dipole| {
            let source = |z: f64, side: f64| {
                let s2 = match self.distance {
                    crate::dipole::form_factor::Distance::Radial => x.distance_squared(center) + z * z,
                    crate::dipole::form_factor::Distance::Table1 { .. } => {
                        x.distance_squared(center - side * z * mean).max(z * z)
                    }
                };
                z * kernel(dipole.sigma, s2.sqrt())
            };
            area * dipole.strength * (source(dipole.z_real, 1.0) + source(dipole.z_virtual, -1.0))
        };
        DVec3::from_array(self.dipoles.each_ref().map(channel))
    }
}

fn cpu(state: &mut State, at: Scope) {
    let (base, _) = state.part(BufferId::links, at);
    let data = &state.data;
    if data.counters[0].overflow != 0 {
        return;
    }
    let links = &data.links[base..base + data.counters[0].links as usize];
    let emitters = Emitters::new(data, state.distance, state.method.near);
    let factors: Vec<[f32; 3]> = links
        .par_iter()
        .map(|link| {
            let center = data.clusters[link.receiver as usize].center;
            narrow(emitters.factor(link.emitter, wide(center), emitters.rule(link.emitter, center)))
        })
        .collect();
    state.data.factors[base..base + factors.len()].copy_from_slice(&factors);
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    let displaced = u32::from(pass.state.distance == Distance::Table1);
    let params = pass.state.data.object_params[0];
    for (part, room) in [("far", params.link_capacity), ("area", params.area_capacity)] {
        pass.dispatch(Some(part), &[displaced], &[], room as usize)?;
    }
    let room = params.edge_capacity as usize;
    if pass.state.method.projected {
        pass.dispatch(Some("projected"), &[displaced], &[], room)?;
    }
    match pass.state.method.near {
        Near::Exact => pass.dispatch(Some("edge"), &[displaced], &[], room),
        Near::PointSampling => {
            pass.dispatch(Some("uniform"), &[displaced], &uniform::density(&params).to_le_bytes(), room)
        }
    }
}
