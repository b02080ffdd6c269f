//! Stage `update_links`: updates kept links after a change of shape. Pairs that touch an altered cluster are decided
//! again: links that the oracle no longer allows are demoted to pairs of children, and links whose parents it now
//! allows are promoted.
//!
//! The result is the links that `refine` would make in the same frame. Receivers are walked level by level as there,
//! but each one only visits pairs that are altered, or that only one of the two refinements, the one before and the
//! one now, contains. Pairs whose emitter's light has changed are visited, too, because the receiver has to be summed
//! again.

mod walk;

pub use self::walk::{Edits, walk};

use rayon::prelude::*;

use super::refine::{self, open};
use super::update_form_factors::groups;
use super::{LINKS, not_incremental};
use crate::error::Result;
use crate::layout::{ALTERED_MOVED, BufferId, Buffers, DUE_MERGED, Link, MOST_PAIRS, PAIR_BOTH, Range, Span};
use crate::state::{Granularity, Pass, Role, Scope, Size, Stage, State, Tolerance, Update, narrow, wide};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "update_links",
    about: "kept links demoted and promoted where a cluster is altered; those that touch one are marked",
    equation: "Mertens et al. 2003, section 5.5; Forsyth et al. 1994",
    writes: &[
        (BufferId::edits, Role::Update, Tolerance::Exact),
        (BufferId::handed, Role::Update, Tolerance::Exact),
        (BufferId::counters, Role::Update, Tolerance::Exact),
        (BufferId::added_links, Role::Output, Tolerance::Exact),
        (BufferId::removed_links, Role::Output, Tolerance::Exact),
        (BufferId::spans, Role::Update, Tolerance::Exact),
        (BufferId::links, Role::Update, Tolerance::Exact),
        (BufferId::factors, Role::Update, Tolerance::Float { relative: 1e-6, floor: 0.0 }),
        (BufferId::stale, Role::Update, Tolerance::Exact),
        (BufferId::stale_counts, Role::Update, Tolerance::Exact),
        (BufferId::active_receivers, Role::Update, Tolerance::Exact),
        (BufferId::due_groups, Role::Update, Tolerance::Exact),
    ],
    reason: "decisions as in refine; a form factor's stand-in until it is computed is a quotient and a product",
    sizes: &[
        (BufferId::added_links, Size::Grows(|state| state.data.object_params[0].edit_capacity as usize)),
        (BufferId::removed_links, Size::Grows(|state| state.data.object_params[0].edit_capacity as usize)),
        (BufferId::stale, LINKS),
    ],
    granularity: Granularity::Chunk,
    skip: not_incremental,
    runs: Update::updates_links,
    ..super::stage(cpu, gpu)
};

fn cpu(state: &mut State, at: Scope) {
    let chunk = at.chunk;
    open(&mut state.data.counters[0], chunk);
    let top = chunk == 0 && state.object(at).schedule.chunks.len() > 1;
    for level in state.object(at).schedule.chunks[chunk].levels.clone() {
        level_of(&mut state.data, level, top);
    }
    let nodes = state.object(at).schedule.chunks[chunk].nodes.clone();
    let nodes = nodes.start as usize..nodes.end as usize;
    place(&mut state.data, nodes.clone());
    if !state.data.counters[0].void() {
        let ((base, _), (stale, _)) = (state.part(BufferId::links, at), state.part(BufferId::stale, at));
        for place in nodes {
            let receiver = state.data.order[place];
            merge(&mut state.data, receiver, base, stale);
        }
    }
}

/// Walks every receiver of a level; appends its edits to the lists, one receiver after the other, if all fit.
fn level_of(data: &mut Buffers, level: std::ops::Range<u32>, top: bool) {
    let receivers = data.order[level.start as usize..level.end as usize].to_vec();
    let handed = |receiver: u32| match data.edits.get(data.topology[receiver as usize].parent as usize) {
        Some(span) => data.handed.get(span.hand as usize..(span.hand + span.hands) as usize).unwrap_or_default(),
        None => &[PAIR_BOTH],
    };
    let mut lists: Vec<Edits> = receivers.par_iter().map(|&receiver| walk(data, receiver, handed(receiver))).collect();
    let (params, counters) = (data.object_params[0], &mut data.counters[0]);
    for list in lists.iter_mut().filter(|l| l.made.len().max(l.undone.len()).max(l.hands.len()) > MOST_PAIRS) {
        counters.unfinished = 1;
        *list = Edits::default();
    }
    let counts = |l: &Edits| [l.made.len() as u32, l.undone.len() as u32, l.fresh, l.hands.len() as u32];
    let add = |sum: [u32; 4], n: [u32; 4]| std::array::from_fn(|k| sum[k] + n[k]);
    let mut next = [counters.links, counters.areas, counters.edges, counters.hands];
    let total: [u32; 4] = lists.iter().map(counts).fold(next, add);
    let fit = [total[0].max(total[1]) <= params.edit_capacity, total[3] <= params.hand_capacity];
    counters.required_entries = counters.required_entries.max(total[0].max(total[1]));
    counters.required_hands = counters.required_hands.max(total[3]);
    counters.overflow |= u32::from(fit != [true; 2]);
    for (&receiver, list) in receivers.iter().zip(&lists) {
        let n = counts(list);
        let had = [fit[0], fit[0], fit[0], fit[1]].map(u32::from);
        let [links, areas, edges, hands] = std::array::from_fn(|k| n[k] * had[k]);
        let [link, area, edge, hand] = next;
        data.edits[receiver as usize] = Span { link, links, area, areas, edge, edges, hand, hands };
        if fit[0] {
            data.added_links[link as usize..][..list.made.len()].copy_from_slice(&list.made);
            data.removed_links[area as usize..][..list.undone.len()].copy_from_slice(&list.undone);
        }
        if fit[1] {
            data.handed[hand as usize..][..list.hands.len()].copy_from_slice(&list.hands);
        }
        next = add(next, n);
    }
    let counters = &mut data.counters[0];
    [counters.links, counters.areas, counters.edges, counters.hands] = next;
    if top {
        counters.kept = counters.hands;
    }
}

/// Whether a receiver has links to merge, or links to be summed again.
pub(super) fn has_edits(data: &Buffers, receiver: u32) -> bool {
    let edit = data.edits[receiver as usize];
    edit.links + edit.areas > 0
}

/// Reserves new ranges for the lists that change, behind all others of the chunk.
fn place(data: &mut Buffers, nodes: std::ops::Range<usize>) {
    let receivers = data.order[nodes.clone()].iter().map(|&receiver| receiver as usize);
    let mut next = receivers.clone().map(|r| data.spans[r].link + data.spans[r].links).max().unwrap_or(0);
    for receiver in receivers {
        let (edit, links) = (&mut data.edits[receiver], data.spans[receiver].links);
        let room = if edit.areas + edit.edges > 0 { links + edit.links } else { 0 };
        if (links + edit.links + edit.areas) as usize > MOST_PAIRS {
            data.counters[0].unfinished = 1;
        }
        (edit.edge, edit.edges) = (next, room);
        next += room;
    }
    let edited: Vec<u32> = data.order[nodes.clone()].iter().copied().filter(|&r| has_edits(data, r)).collect();
    data.active_receivers[nodes.start..][..edited.len()].copy_from_slice(&edited);
    data.due_groups[DUE_MERGED] = groups(edited.len() as u32);
    let counters = &mut data.counters[0];
    counters.receivers = edited.len() as u32;
    counters.edited += counters.receivers;
    counters.required_links = counters.required_links.max(next);
    counters.overflow |= u32::from(next > data.object_params[0].link_capacity);
}

/// The current links of a receiver: the previous ones without `undone`, with `made`, in the order of the emitters.
fn merge(data: &mut Buffers, receiver: u32, base: usize, stale_base: usize) {
    if !has_edits(data, receiver) {
        return;
    }
    let edit = data.edits[receiver as usize];
    let span = data.spans[receiver as usize];
    let made = &data.added_links[edit.link as usize..][..edit.links as usize];
    let undone = &data.removed_links[edit.area as usize..][..edit.areas as usize];
    let area = |emitter: u32| f64::from(data.clusters[emitter as usize].area);
    let altered = |node: u32| data.change_flags[node as usize];

    // Visit every emitter of either list once, in order.
    let old = base + span.link as usize..base + (span.link + span.links) as usize;
    let flags = stale_base + span.link as usize..stale_base + (span.link + span.links) as usize;
    let mut all: Vec<u32> =
        data.links[old.clone()].iter().map(|link| link.emitter).chain(made.iter().copied()).collect();
    all.sort_unstable();
    all.dedup();
    let mut share = [0.0f32; 3];
    let mut lists = Vec::new();
    for emitter in all {
        let before = data.links[old.clone()].binary_search_by_key(&emitter, |link| link.emitter).ok();
        let makes = made.binary_search(&emitter).is_ok();
        let factor = before.map(|k| data.factors[old.start + k]);
        if let Some(factor) = factor.filter(|_| area(emitter) > 0.0) {
            share = narrow(wide(factor) / area(emitter));
        }
        if !makes && undone.binary_search(&emitter).is_ok() {
            continue;
        }
        let touched = if makes { (altered(receiver) | altered(emitter)) & ALTERED_MOVED } else { 0 };
        let waits = before.map_or(1, |k| data.stale[flags.start + k] | touched);
        lists.push((emitter, factor.unwrap_or_else(|| narrow(wide(share) * area(emitter))), waits));
    }
    let first = if edit.edges > 0 { edit.edge } else { span.link };
    for (k, &(emitter, factor, waits)) in lists.iter().enumerate() {
        let at = first as usize + k;
        data.links[base + at] = Link { receiver, emitter };
        data.factors[base + at] = factor;
        data.stale[stale_base + at] = waits;
    }
    let span = &mut data.spans[receiver as usize];
    (span.link, span.links) = (first, lists.len() as u32);
    data.stale_counts[receiver as usize] = lists.iter().map(|list| list.2).sum();
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    refine::gpu(pass)?;
    let nodes = pass.object().schedule.chunks[pass.at.chunk].nodes.clone();
    let range = Range { first: nodes.start, count: nodes.end - nodes.start };
    pass.dispatch(Some("place"), &[], bytemuck::bytes_of(&range), 1)?;
    pass.dispatch_counted("merge", &[], bytemuck::bytes_of(&range), (BufferId::due_groups, DUE_MERGED))
}
