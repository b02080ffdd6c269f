//! Walks the refinements before and after a change side by side: decisions in the order of
//! `glsl/transport/links/update_links/walk.glsl`.

use crate::layout::{ALTERED_MOVED, Buffers, NONE, PAIR_BEFORE, PAIR_BOTH, PAIR_NOW};
use crate::transport::links::refine::{Choice, children, choose};

/// The edits of one receiver's links.
#[derive(Default)]
pub struct Edits {
    /// Emitters of links that are new, or that touch an altered or relit cluster.
    pub made: Vec<u32>,
    /// Emitters of links that are removed.
    pub undone: Vec<u32>,
    /// How many of `made` were not linked before.
    pub fresh: u32,
    /// Pairs that the receiver hands down, packed: four times the emitter, plus which refinements contain the pair
    /// (`PAIR_NOW`, `PAIR_BEFORE` or `PAIR_BOTH`).
    pub hands: Vec<u32>,
}

/// Visits the pairs that the parent handed down to a receiver.
pub fn walk(data: &Buffers, receiver: u32, handed: &[u32]) -> Edits {
    let node = receiver as usize;
    let centers =
        |clusters: &[crate::layout::Cluster]| (clusters[node].center, children(&data.topology, clusters, node));
    let (now_at, before_at) = (centers(&data.clusters), centers(&data.kept_clusters));
    let moved = data.change_flags[node] & ALTERED_MOVED != 0;
    let mut edits = Edits::default();
    for &item in handed {
        let (start, given) = (item >> 2, item & PAIR_BOTH);
        let (mut node, mut who, mut until) = (start, given, start);
        while node < data.topology[start as usize].skip {
            if node >= until {
                who = given;
            }
            let (i, place) = (node as usize, data.topology[node as usize]);
            let idle = who == PAIR_BOTH && !moved && data.change_flags[i] == 0;
            let choice = |has: u32, clusters: &[crate::layout::Cluster], at: ([f32; 3], Option<[[f32; 3]; 2]>)| {
                let looked = !idle && who & has != 0;
                looked.then(|| choose(&data.object_params[0], &clusters[i], place.face != NONE, at.0, at.1))
            };
            let now = choice(PAIR_NOW, &data.clusters, now_at);
            let before = choice(PAIR_BEFORE, &data.kept_clusters, before_at);
            let is = |choice: Option<Choice>, what: Choice| choice == Some(what);
            if is(now, Choice::Linked) {
                edits.made.push(node);
                edits.fresh += u32::from(!is(before, Choice::Linked));
            } else if is(before, Choice::Linked) {
                edits.undone.push(node);
            }
            let handers =
                PAIR_NOW * u32::from(is(now, Choice::Handed)) + PAIR_BEFORE * u32::from(is(before, Choice::Handed));
            if handers != 0 {
                edits.hands.push(4 * node + handers);
            }
            let down = is(now, Choice::Split) || is(before, Choice::Split);
            if down && who == PAIR_BOTH && now != before {
                who = if is(now, Choice::Split) { PAIR_NOW } else { PAIR_BEFORE };
                until = place.skip;
            }
            node = if down { node + 1 } else { place.skip };
        }
    }
    edits
}
