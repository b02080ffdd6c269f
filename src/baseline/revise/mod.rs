//! Stage `revise`: kept links after a change of shape. Pairs that touch an altered cluster are decided anew: links that the
//! oracle does not allow any more are demoted to pairs of children, those whose parents it allows now are promoted.
//!
//! The links are then those of `refine` on the same frame. Receivers are walked level by level as there, but each is told only
//! of pairs that are altered, or that the refinement before has and that of now has not, or the other way round. Pairs whose
//! emitter has another light are told, too: the receiver has to be summed again.

mod walk;

pub use walk::{Edits, walk};

use rayon::prelude::*;

use super::refine::open;
use super::renew::groups;
use crate::baseline::not_incremental;
use crate::error::Result;
use crate::layout::{ALTERED_MOVED, Buffers, DUE_MERGED, Link, MOST_PAIRS, PAIR_BOTH, Range, Slot, Span};
use crate::state::{
    Carrier, Need, Pass, Place, Role, Serves, Size, Stage, State, Tolerance, Unit, Update, narrow, wide,
};

/// The table's entry.
pub static STAGE: Stage = Stage {
    name: "revise",
    room: "baseline",
    about: "kept links demoted and promoted where a cluster is altered; those that touch one are marked",
    equation: "Mertens et al. 2003, section 5.5; Forsyth et al. 1994",
    writes: &[
        (Slot::edits, Role::Update, Tolerance::Exact),
        (Slot::handed, Role::Update, Tolerance::Exact),
        (Slot::cursor, Role::Update, Tolerance::Exact),
        (Slot::made, Role::Output, Tolerance::Exact),
        (Slot::undone, Role::Output, Tolerance::Exact),
        (Slot::spans, Role::Update, Tolerance::Exact),
        (Slot::links, Role::Update, Tolerance::Exact),
        (Slot::factors, Role::Update, Tolerance::Float { relative: 1e-6, floor: 0.0 }),
        (Slot::stale, Role::Update, Tolerance::Exact),
        (Slot::waiting, Role::Update, Tolerance::Exact),
        (Slot::busy, Role::Update, Tolerance::Exact),
        (Slot::due_groups, Role::Update, Tolerance::Exact),
    ],
    reason: "decisions as those of refine; what stands for a form factor until it is computed is a quotient and a product",
    sizes: &[
        (Slot::made, Size::Grows(|state| state.data.frame[0].edit_room as usize)),
        (Slot::undone, Size::Grows(|state| state.data.frame[0].edit_room as usize)),
        (Slot::stale, Size::Grows(|state| state.chunk_parts() * state.data.frame[0].link_room as usize)),
    ],
    unit: Unit::Chunk,
    carriers: &[Carrier::Links],
    needs: &[Need::Light],
    serves: Serves::TRANSLUCENT,
    skip: not_incremental,
    runs: Update::updates_links,
    cpu,
    gpu,
};

fn cpu(state: &mut State, at: Place) {
    let chunk = at.chunk;
    open(&mut state.data.cursor[0], chunk);
    let top = chunk == 0 && state.object(at).schedule.chunks.len() > 1;
    for level in state.object(at).schedule.chunks[chunk].levels.clone() {
        level_of(&mut state.data, level, top);
    }
    let nodes = state.object(at).schedule.chunks[chunk].nodes.clone();
    let nodes = nodes.start as usize..nodes.end as usize;
    place(&mut state.data, nodes.clone());
    if !state.data.cursor[0].void() {
        let ((base, _), (stale, _)) = (state.part(Slot::links, at), state.part(Slot::stale, at));
        for place in nodes {
            let receiver = state.data.order[place];
            merge(&mut state.data, receiver, base, stale);
        }
    }
}

/// What each receiver of a level does, one after the other in the lists if all fit.
fn level_of(data: &mut Buffers, level: std::ops::Range<u32>, top: bool) {
    let receivers = data.order[level.start as usize..level.end as usize].to_vec();
    let handed = |receiver: u32| match data.edits.get(data.topology[receiver as usize].parent as usize) {
        Some(span) => data.handed.get(span.hand as usize..(span.hand + span.hands) as usize).unwrap_or_default(),
        None => &[PAIR_BOTH],
    };
    let mut lists: Vec<Edits> = receivers.par_iter().map(|&receiver| walk(data, receiver, handed(receiver))).collect();
    let (frame, cursor) = (data.frame[0], &mut data.cursor[0]);
    for list in lists.iter_mut().filter(|l| l.made.len().max(l.undone.len()).max(l.hands.len()) > MOST_PAIRS) {
        cursor.unfinished = 1;
        *list = Edits::default();
    }
    let counts = |l: &Edits| [l.made.len() as u32, l.undone.len() as u32, l.fresh, l.hands.len() as u32];
    let add = |sum: [u32; 4], n: [u32; 4]| std::array::from_fn(|k| sum[k] + n[k]);
    let mut next = [cursor.links, cursor.areas, cursor.edges, cursor.hands];
    let total: [u32; 4] = lists.iter().map(counts).fold(next, add);
    let fit = [total[0].max(total[1]) <= frame.edit_room, total[3] <= frame.hand_room];
    cursor.need_entries = cursor.need_entries.max(total[0].max(total[1]));
    cursor.need_hands = cursor.need_hands.max(total[3]);
    cursor.overflow |= u32::from(fit != [true; 2]);
    for (&receiver, list) in receivers.iter().zip(&lists) {
        let n = counts(list);
        let had = [fit[0], fit[0], fit[0], fit[1]].map(u32::from);
        let [links, areas, edges, hands] = std::array::from_fn(|k| n[k] * had[k]);
        let [link, area, edge, hand] = next;
        data.edits[receiver as usize] = Span { link, links, area, areas, edge, edges, hand, hands };
        if fit[0] {
            data.made[link as usize..][..list.made.len()].copy_from_slice(&list.made);
            data.undone[area as usize..][..list.undone.len()].copy_from_slice(&list.undone);
        }
        if fit[1] {
            data.handed[hand as usize..][..list.hands.len()].copy_from_slice(&list.hands);
        }
        next = add(next, n);
    }
    let cursor = &mut data.cursor[0];
    [cursor.links, cursor.areas, cursor.edges, cursor.hands] = next;
    if top {
        cursor.kept = cursor.hands;
    }
}

/// Whether anything about a receiver's links is to be merged, or its links to be summed again.
pub(super) fn has_edits(data: &Buffers, receiver: u32) -> bool {
    let edit = data.edits[receiver as usize];
    edit.links + edit.areas > 0
}

/// Lists that change get new places behind all others of the chunk.
fn place(data: &mut Buffers, nodes: std::ops::Range<usize>) {
    let receivers = data.order[nodes.clone()].iter().map(|&receiver| receiver as usize);
    let mut next = receivers.clone().map(|r| data.spans[r].link + data.spans[r].links).max().unwrap_or(0);
    for receiver in receivers {
        let (edit, links) = (&mut data.edits[receiver], data.spans[receiver].links);
        let room = if edit.areas + edit.edges > 0 { links + edit.links } else { 0 };
        if (links + edit.links + edit.areas) as usize > MOST_PAIRS {
            data.cursor[0].unfinished = 1;
        }
        (edit.edge, edit.edges) = (next, room);
        next += room;
    }
    let edited: Vec<u32> = data.order[nodes.clone()].iter().copied().filter(|&r| has_edits(data, r)).collect();
    data.busy[nodes.start..][..edited.len()].copy_from_slice(&edited);
    data.due_groups[DUE_MERGED] = groups(edited.len() as u32);
    let cursor = &mut data.cursor[0];
    cursor.busy = edited.len() as u32;
    cursor.edited += cursor.busy;
    cursor.need_links = cursor.need_links.max(next);
    cursor.overflow |= u32::from(next > data.frame[0].link_room);
}

/// A receiver's links as they are now: those before without what is undone, with what is made, in the order of the emitters.
fn merge(data: &mut Buffers, receiver: u32, base: usize, stale_base: usize) {
    if !has_edits(data, receiver) {
        return;
    }
    let edit = data.edits[receiver as usize];
    let span = data.spans[receiver as usize];
    let made = &data.made[edit.link as usize..][..edit.links as usize];
    let undone = &data.undone[edit.area as usize..][..edit.areas as usize];
    let area = |emitter: u32| f64::from(data.clusters[emitter as usize].area);
    let altered = |node: u32| data.altered[node as usize];

    // Every emitter of either list, once, in order.
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
    data.waiting[receiver as usize] = lists.iter().map(|list| list.2).sum();
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
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
    let nodes = schedule.chunks[chunk].nodes.clone();
    let range = Range { first: nodes.start, count: nodes.end - nodes.start };
    pass.dispatch(Some("place"), &[], bytemuck::bytes_of(&range), 1)?;
    pass.dispatch_counted("merge", &[], bytemuck::bytes_of(&range), (Slot::due_groups, DUE_MERGED))
}
