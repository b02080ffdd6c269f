//! Links kept while the shape changes: their budget, stale form factors, and capacity for new links.

use super::capacity::need;
use super::run::Session;
use crate::error::{Input, Result};
use crate::layout::{BufferId, Link};
use crate::pipeline::plan::{Change, Changes};
use crate::state::{Scope, State};

/// Divides the budget of form factors per frame among the objects, by their triangles.
pub(crate) fn share_budget(state: &mut State, budget: Option<u32>) -> Result<()> {
    let Some(budget) = budget.filter(|_| state.method.incremental) else {
        state.data.object_params.iter_mut().for_each(|params| params.budget = u32::MAX);
        return Ok(());
    };
    let faces = |opaque: bool, count: usize| if opaque { 0 } else { count as u64 };
    let all = state.sum(|object| faces(object.opaque, object.count.faces) as usize).max(1) as u64;
    let mut before = 0;
    for (object, params) in state.objects.iter().zip(&mut state.data.object_params) {
        // Rounded so that the shares add up to the budget.
        let triangles = faces(object.opaque, object.count.faces);
        let until = |faces: u64| u64::from(budget) * faces / all;
        params.budget = (until(before + triangles) - until(before)) as u32;
        before += triangles;
        if triangles > 0 && params.budget == 0 {
            let fault = Input::new("too small for the objects of the scene").key("transport.budget").found(budget);
            return Err(fault.expected("at least one form factor a frame for each object, shared by triangles").into());
        }
    }
    Ok(())
}

impl Session {
    /// Number of kept links whose form factors are stale.
    #[must_use]
    pub fn waiting(&self) -> u64 {
        self.state().data.counters.iter().map(|counters| u64::from(counters.stale)).sum()
    }

    /// Form factors that the last frame computed for kept links; 0 if it rebuilt all links.
    #[must_use]
    pub fn renewed(&self) -> u64 {
        self.spent + self.state().data.counters.iter().map(|counters| u64::from(counters.computed)).sum::<u64>()
    }

    /// The change that a frame has to make because of stale form factors.
    pub(crate) fn waiting_change(&self) -> Change {
        if self.waiting() > 0 { Change::RESUM } else { Change::default() }
    }

    /// The changes, with the flag whether links are rebuilt rather than updated. Without a budget a change of material
    /// rebuilds them: all of their form factors are computed anyway.
    pub(crate) fn links_anew(&self, changes: &Changes) -> Changes {
        if !self.state().method.incremental {
            return changes.clone();
        }
        let all = self.scene.transport.budget.is_none();
        changes.map(|change| {
            let relink = (change.everything && !self.linked) || (change.material && (all || !self.linked));
            Change { relink, ..change }
        })
    }

    /// Lets the next frame rebuild the links if more than half of the vertices have moved, where updating costs more.
    /// With a budget they are updated all the same.
    pub(crate) fn unlink_where_much_moves(&mut self, before: &[[f32; 3]]) {
        let now = &self.state().data.positions;
        let moved = before.iter().zip(now).filter(|(before, now)| before != now).count();
        self.linked &= 2 * moved <= now.len() || self.scene.transport.budget.is_some();
    }

    /// Restores a frame's full budget, whatever the previous frame has spent.
    pub(crate) fn open_budget(&mut self) -> Result<()> {
        self.prepared.state.data.counters.iter_mut().for_each(|counters| counters.computed = 0);
        if self.spent == 0 {
            return Ok(());
        }
        self.spent = 0;
        share_budget(&mut self.prepared.state, self.scene.transport.budget)?;
        self.send(&[BufferId::object_params])
    }

    /// After an overflow while links were updated: makes the lists longer, or removes the gaps from the lists of
    /// links. Where that is not enough, links are rebuilt. Finished updates are kept: the repeated frame updates the
    /// rest.
    pub(crate) fn make_room(&mut self) -> Result<()> {
        let bound = self.scene.transport.budget.is_some();
        let need = need(self.state());
        let data = &mut self.prepared.state.data;
        for (params, counters) in data.object_params.iter_mut().zip(&data.counters) {
            self.spent += u64::from(counters.computed);
            params.budget -= if bound { counters.computed } else { 0 };
        }
        let (most, params) = (self.lists.most(4) as u32, data.object_params[0]);
        let more = |need: u32| need.saturating_add(need / 8).next_multiple_of(64).min(most);
        if need.required_entries.max(need.required_hands) > most {
            self.linked = false;
            return Ok(());
        }
        if need.required_entries > params.edit_capacity || need.required_hands > params.hand_capacity {
            // Emitters that could not be handed down hide those below them from the count.
            let edits = more(need.required_entries.max(params.edit_capacity));
            let hands = if need.required_hands > params.hand_capacity {
                2 * need.required_hands.min(most / 2)
            } else {
                params.hand_capacity
            };
            for params in &mut data.object_params {
                (params.edit_capacity, params.hand_capacity) = (edits, hands);
            }
            data.added_links = bytemuck::zeroed_vec(edits as usize);
            data.removed_links = data.added_links.clone();
            data.handed = bytemuck::zeroed_vec(hands as usize);
        }
        if need.required_links > params.link_capacity {
            return self.compact(need.required_links);
        }
        self.send(&[BufferId::object_params])
    }

    /// Removes the gaps from the lists of links, and makes them longer where that is not enough.
    fn compact(&mut self, need: u32) -> Result<()> {
        self.fetch(&[BufferId::spans, BufferId::links, BufferId::factors, BufferId::stale])?;
        let state = &mut self.prepared.state;
        let (mut parts, mut end) = (Vec::new(), 0);
        for (object, part) in state.objects.iter().enumerate().filter(|(_, part)| !part.opaque) {
            for chunk in 0..part.schedule.chunks.len() {
                let nodes = part.schedule.chunks[chunk].nodes.clone();
                let ordered = &state.data.order[part.first.nodes..][nodes.start as usize..nodes.end as usize];
                let base = state.part(BufferId::links, Scope { object, chunk, group: 0 }).0;
                let mut list: Vec<usize> = Vec::new();
                for &node in ordered {
                    let span = &mut state.data.spans[part.first.nodes + node as usize];
                    let links = base + span.link as usize..base + (span.link + span.links) as usize;
                    end = end.max(span.link + span.links);
                    span.link = list.len() as u32;
                    list.extend(links);
                }
                parts.push(list);
            }
        }
        // New links are appended behind the existing ones.
        let live = parts.iter().map(Vec::len).max().unwrap_or(0);
        let (had, want) =
            (state.data.object_params[0].link_capacity as usize, live + need.saturating_sub(end) as usize);
        let room = if want > had { (want + want / 8).next_multiple_of(64) } else { had };
        let much = self.scene.transport.budget.is_none() && want - live > live / 4;
        if much || room > self.lists.most(12) || (12 * room * state.chunk_count().max(1)) as u64 > self.lists.allocation
        {
            self.linked = false;
            return self.send(&[BufferId::object_params]);
        }
        let data = &mut state.data;
        let (links, factors, stale) = (data.links.clone(), data.factors.clone(), data.stale.clone());
        data.links = vec![Link::default(); parts.len() * room];
        data.factors = vec![[0.0; 3]; parts.len() * room];
        data.stale = vec![0; parts.len() * room];
        for (part, list) in parts.iter().enumerate() {
            for (k, &old) in list.iter().enumerate() {
                let at = part * room + k;
                (data.links[at], data.factors[at], data.stale[at]) = (links[old], factors[old], stale[old]);
            }
        }
        data.due_links = vec![0; room];
        data.ranked_links = vec![0; room];
        data.object_params.iter_mut().for_each(|params| params.link_capacity = room as u32);
        self.send(&[BufferId::object_params, BufferId::spans, BufferId::links, BufferId::factors, BufferId::stale])
    }
}
