//! Stage `refine`: decides which node receives from which, by refining the pair (root, root) with the oracle of section
//! 5.2.
//!
//! Receivers are walked level by level. Each takes the emitters that its parent handed down and, for each one, hands
//! it down to its own children, splits the emitter, or links. Lists are counted, scanned and written, so that the
//! links of every receiver are contiguous and in a fixed order. Lists have a fixed capacity; the counters record the
//! capacity that they need.

mod walk;

pub use self::walk::{Choice, Walk, children, choose, cluster_rule, rule};

use rayon::prelude::*;

use super::LINKS;
use crate::error::Result;
use crate::layout::{BufferId, Link, ListCounters, MOST_PAIRS, ObjectParams, RULE_AREA, RULE_SAMPLE, Range, Span};
use crate::state::{Granularity, Pass, Role, Scope, Size, Stage, State, Tolerance, Update};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "refine",
    about: "links between clusters by the two solid-angle thresholds and the planarity measure",
    equation: "Mertens et al. 2003, section 5.2; planarity A'/A of section 5.1.1",
    writes: &[
        (BufferId::spans, Role::Update, Tolerance::Exact),
        (BufferId::handed, Role::Update, Tolerance::Exact),
        (BufferId::counters, Role::Update, Tolerance::Exact),
        (BufferId::links, Role::Output, Tolerance::Exact),
        (BufferId::area_links, Role::Output, Tolerance::Exact),
        (BufferId::edge_links, Role::Output, Tolerance::Exact),
    ],
    reason: "decisions: additions, multiplications and comparisons in f32, the same everywhere",
    sizes: &[
        (BufferId::handed, Size::Grows(|state| state.data.object_params[0].hand_capacity as usize)),
        (BufferId::links, LINKS),
        (
            BufferId::area_links,
            Size::Grows(|state| state.chunk_parts() * state.data.object_params[0].area_capacity as usize),
        ),
        (
            BufferId::edge_links,
            Size::Grows(|state| state.chunk_parts() * state.data.object_params[0].edge_capacity as usize),
        ),
    ],
    granularity: Granularity::Chunk,
    runs: Update::makes_links,
    ..super::stage(cpu, gpu)
};

/// One receiver's decisions, in order.
#[derive(Default)]
struct Lists {
    links: Vec<u32>,
    areas: Vec<u32>,
    edges: Vec<u32>,
    hands: Vec<u32>,
}

impl Lists {
    /// Links, area links, edge links, and emitters handed down.
    fn sizes(&self) -> [u32; 4] {
        [self.links.len(), self.areas.len(), self.edges.len(), self.hands.len()].map(|n| n as u32)
    }
}

fn cpu(state: &mut State, at: Scope) {
    let chunk = at.chunk;
    open(&mut state.data.counters[0], chunk);
    let (link_base, _) = state.part(BufferId::links, at);
    let (area_base, _) = state.part(BufferId::area_links, at);
    let (edge_base, _) = state.part(BufferId::edge_links, at);
    let top = chunk == 0 && state.object(at).schedule.chunks.len() > 1;
    for level in state.object(at).schedule.chunks[chunk].levels.clone() {
        let data = &mut state.data;
        let receivers = &data.order[level.start as usize..level.end as usize];

        // Decide for every receiver of the level, in parallel.
        let walk = Walk::new(data);
        let mut lists: Vec<Lists> = receivers.par_iter().map(|&receiver| decide(&walk, data, receiver)).collect();

        let counters = &mut data.counters[0];
        let (mut next, fits) = reserve(counters, &data.object_params[0], &mut lists);

        // Write the lists that fit.
        for (&receiver, list) in receivers.iter().zip(&lists) {
            let counts = list.sizes();
            let n: [u32; 4] = std::array::from_fn(|k| if fits[k] { counts[k] } else { 0 });
            data.spans[receiver as usize] = Span {
                link: next[0],
                links: n[0],
                area: next[1],
                areas: n[1],
                edge: next[2],
                edges: n[2],
                hand: next[3],
                hands: n[3],
            };
            let [link, area, edge, hand] = next.map(|n| n as usize);
            if fits[0] {
                for (k, &emitter) in list.links.iter().enumerate() {
                    data.links[link_base + link + k] = Link { receiver, emitter };
                }
                for (k, &index) in list.areas.iter().enumerate() {
                    data.area_links[area_base + area + k] = next[0] + index;
                }
                for (k, &index) in list.edges.iter().enumerate() {
                    data.edge_links[edge_base + edge + k] = next[0] + index;
                }
            }
            if fits[3] {
                data.handed[hand..hand + list.hands.len()].copy_from_slice(&list.hands);
            }
            next = std::array::from_fn(|k| next[k] + counts[k]);
        }
        [counters.links, counters.areas, counters.edges, counters.hands] = next;
        if top {
            counters.kept = counters.hands;
        }
    }
}

/// Where the lists of a level begin, and which of the four kinds fit; counts what they need.
fn reserve(counters: &mut ListCounters, params: &ObjectParams, lists: &mut [Lists]) -> ([u32; 4], [bool; 4]) {
    for list in lists.iter_mut().filter(|list| list.links.len() > MOST_PAIRS || list.hands.len() > MOST_PAIRS) {
        counters.unfinished = 1;
        *list = Lists::default();
    }
    let next = [counters.links, counters.areas, counters.edges, counters.hands];
    let total = lists.iter().map(Lists::sizes).fold(next, |sum, n| std::array::from_fn(|k| sum[k] + n[k]));
    let room = [params.link_capacity, params.area_capacity, params.edge_capacity, params.hand_capacity];
    let each: [bool; 4] = std::array::from_fn(|k| total[k] <= room[k]);
    let links = each[0] && each[1] && each[2];
    let fits = [links, links, links, each[3]];
    counters.required_links = counters.required_links.max(total[0]);
    counters.required_areas = counters.required_areas.max(total[1]);
    counters.required_edges = counters.required_edges.max(total[2]);
    counters.required_hands = counters.required_hands.max(total[3]);
    if fits.contains(&false) {
        counters.overflow = 1;
    }
    (next, fits)
}

/// Resets the counters of lists for a chunk.
pub fn open(counters: &mut ListCounters, chunk: usize) {
    if chunk == 0 {
        *counters = counters.opened();
    }
    (counters.links, counters.areas, counters.edges, counters.hands) = (0, 0, 0, counters.kept);
}

fn decide(walk: &Walk<'_>, data: &crate::layout::Buffers, receiver: u32) -> Lists {
    let parent = data.topology[receiver as usize].parent;
    let handed = match data.spans.get(parent as usize) {
        // A list that did not fit is empty and may begin beyond the end.
        Some(span) => data.handed.get(span.hand as usize..span.hand as usize + span.hands as usize).unwrap_or_default(),
        None => &[0],
    };
    let mut lists = Lists::default();
    walk.walk(receiver, handed, |decision, emitter| match decision {
        walk::Decision::HandDown => lists.hands.push(emitter),
        walk::Decision::Link { rule } => {
            let index = lists.links.len() as u32;
            match rule {
                RULE_SAMPLE => {}
                RULE_AREA => lists.areas.push(index),
                _ => lists.edges.push(index),
            }
            lists.links.push(emitter);
        }
    });
    lists
}

/// Starts a chunk, then counts, scans and writes each level; `update_links` starts with its own kernels in this order.
pub(super) fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    let (schedule, chunk) = (&pass.object().schedule, pass.at.chunk);
    pass.dispatch(Some("open"), &[], &(chunk as u32).to_le_bytes(), 1)?;
    let keep = u32::from(chunk == 0 && schedule.chunks.len() > 1);
    for level in &schedule.chunks[chunk].levels {
        let range = Range { first: level.start, count: level.end - level.start };
        let push = bytemuck::bytes_of(&range);
        pass.dispatch(Some("count"), &[], push, range.count as usize)?;
        pass.dispatch(Some("scan"), &[], bytemuck::bytes_of(&[range.first, range.count, keep]), 1)?;
        pass.dispatch(Some("write"), &[], push, range.count as usize)?;
    }
    Ok(())
}
