//! The oracle of section 5.2 as a walk over emitters: decisions, by `f32` additions, multiplications and comparisons
//! only, in the order of `glsl/transport/links/refine/walk.glsl`, so that the two agree bit for bit.

use crate::dipole::distance2;
use crate::layout::{
    Buffers, Cluster, FAR_FROM_DENORMAL, NONE, ObjectParams, PAIR_HANDED, PAIR_LINKED, PAIR_SPLIT, RULE_AREA,
    RULE_EDGE, RULE_SAMPLE, Topology,
};

/// What happens to an emitter at a receiver.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Decision {
    /// The emitter is handed down to the receiver's children.
    HandDown,
    /// It is linked.
    Link {
        /// How its form factor is evaluated: a `RULE_`.
        rule: u32,
    },
}

/// The inputs of the walk.
pub struct Walk<'a> {
    params: ObjectParams,
    topology: &'a [Topology],
    clusters: &'a [Cluster],
    reach: &'a [[f32; 4]],
    cluster_reach: &'a [f32],
}

/// The quadrature rule for a triangle with these squared radii at this squared distance: a `RULE_`.
pub fn rule(d2: f32, radii: [f32; 4]) -> u32 {
    if d2 >= radii[0] {
        RULE_SAMPLE
    } else if d2 >= radii[1].min(radii[2].min(radii[3])) {
        RULE_AREA
    } else {
        RULE_EDGE
    }
}

/// The quadrature rule for a cluster with this squared radius at this squared distance; without a radius, one sample.
pub fn cluster_rule(d2: f32, radius: Option<&f32>) -> u32 {
    if radius.is_some_and(|&radius| d2 < radius) { RULE_EDGE } else { RULE_SAMPLE }
}

/// What happens to a pair of clusters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Choice {
    /// It is linked.
    Linked = PAIR_LINKED,
    /// It is handed down to the receiver's children.
    Handed = PAIR_HANDED,
    /// The emitter is split: its children are visited instead.
    Split = PAIR_SPLIT,
}

/// Whether |A/d_child^2 - A/d^2| exceeds epsilon_1.
fn deviates(params: &ObjectParams, area: f32, d2: f32, child2: f32) -> bool {
    let change = (area * FAR_FROM_DENORMAL) * (d2 - child2).abs();
    let allowed = (params.receiver_angle * FAR_FROM_DENORMAL) * (d2 * child2);
    change > allowed
}

/// Whether A'/A is below the threshold of planarity.
fn bent(params: &ObjectParams, emitter: &Cluster) -> bool {
    let n = emitter.normal.map(|x| x * FAR_FROM_DENORMAL);
    let area = emitter.area * FAR_FROM_DENORMAL;
    n[0] * n[0] + n[1] * n[1] + n[2] * n[2] < params.planarity * (area * area)
}

/// The oracle's decision on one pair; the receiver is given by its centre and by those of its children, if it has
/// any.
pub fn choose(
    params: &ObjectParams,
    emitter: &Cluster,
    leaf: bool,
    center: [f32; 3],
    children: Option<[[f32; 3]; 2]>,
) -> Choice {
    let d2 = distance2(center, emitter.center);
    let far = |child: [f32; 3]| deviates(params, emitter.area, d2, distance2(child, emitter.center));
    if children.is_some_and(|children| children.into_iter().any(far)) {
        Choice::Handed
    } else if !leaf && (emitter.area > params.emitter_angle * d2 || bent(params, emitter)) {
        Choice::Split
    } else {
        Choice::Linked
    }
}

/// Centres of a node's children; none for a leaf.
pub fn children(topology: &[Topology], clusters: &[Cluster], node: usize) -> Option<[[f32; 3]; 2]> {
    (topology[node].face == NONE)
        .then(|| [node + 1, topology[node + 1].skip as usize].map(|child| clusters[child].center))
}

impl<'a> Walk<'a> {
    /// The walk over the tree of `data`, by its radii.
    pub fn new(data: &'a Buffers) -> Self {
        Self {
            params: data.object_params[0],
            topology: &data.topology,
            clusters: &data.clusters,
            reach: &data.reach,
            cluster_reach: &data.cluster_reach,
        }
    }

    /// Visits the emitters handed down to this receiver and reports each decision, with the emitter, in order.
    pub fn walk(&self, receiver: u32, handed: &[u32], mut tell: impl FnMut(Decision, u32)) {
        let receiver = receiver as usize;
        let center = self.clusters[receiver].center;
        let children = children(self.topology, self.clusters, receiver);
        for &start in handed {
            let mut node = start;
            let end = self.topology[start as usize].skip;
            while node < end {
                let emitter = &self.clusters[node as usize];
                let place = self.topology[node as usize];
                node = match choose(&self.params, emitter, place.face != NONE, center, children) {
                    Choice::Handed => {
                        tell(Decision::HandDown, node);
                        place.skip
                    }
                    Choice::Split => node + 1,
                    Choice::Linked => {
                        let d2 = distance2(center, emitter.center);
                        let rule = match self.reach.get(place.face as usize) {
                            Some(&radii) => rule(d2, radii),
                            None => cluster_rule(d2, self.cluster_reach.get(node as usize)),
                        };
                        tell(Decision::Link { rule }, node);
                        place.skip
                    }
                };
            }
        }
    }
}
