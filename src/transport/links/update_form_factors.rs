//! Stage `update_form_factors`: computes the form factors of stale links in the order of the receivers, as far as the
//! budget goes.

use rayon::prelude::*;

use super::form_factor::{Emitters, QuadratureRule};
use super::not_incremental;
use super::update_links::has_edits;
use crate::dipole::form_factor::uniform;
use crate::error::Result;
use crate::layout::{BufferId, GROUP_SIZE, RULE_AREA, RULE_EDGE, RULE_SAMPLE, Range};
use crate::state::{Distance, Granularity, Near, Pass, Role, Scope, Size, Stage, State, Tolerance, narrow, wide};
use crate::transport::blocks::link::rows;

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "update_form_factors",
    about: "form factors of kept links that wait for them, up to the budget",
    equation: "Mertens et al. 2003, section 5.5, equations 7 to 13",
    writes: &[
        (BufferId::edits, Role::Update, Tolerance::Exact),
        (BufferId::counters, Role::Update, Tolerance::Exact),
        (BufferId::due_links, Role::Output, Tolerance::Exact),
        (BufferId::ranked_links, Role::Output, Tolerance::Exact),
        (BufferId::due_groups, Role::Update, Tolerance::Exact),
        (BufferId::active_receivers, Role::Update, Tolerance::Exact),
        (BufferId::stale, Role::Update, Tolerance::Exact),
        (BufferId::stale_counts, Role::Update, Tolerance::Exact),
        (BufferId::factors, Role::Update, Tolerance::Float { relative: 1e-4, floor: 2e-7 }),
    ],
    reason: "which are computed is counting; the values are those of form_factor",
    sizes: &[
        (BufferId::due_links, Size::Grows(|state| state.data.object_params[0].link_capacity as usize)),
        (BufferId::ranked_links, Size::Grows(|state| state.data.object_params[0].link_capacity as usize)),
        (BufferId::due_groups, Size::Elements(|_| GROUPS)),
    ],
    granularity: Granularity::Chunk,
    skip: not_incremental,
    runs: |update| update.updates_links() || update.renews_factors(),
    ..super::stage(cpu, gpu)
};

pub use crate::layout::{DUE_GROUPS as GROUPS, DUE_MERGED as EDITED, DUE_SUMMED as SUMMED};

/// Work groups to dispatch for this many elements.
pub(super) fn groups(count: u32) -> [u32; 3] {
    rows(count.div_ceil(GROUP_SIZE))
}

fn cpu(state: &mut State, at: Scope) {
    let nodes = state.object(at).schedule.chunks[at.chunk].nodes.clone();
    let ((base, _), (flags, _)) = (state.part(BufferId::links, at), state.part(BufferId::stale, at));
    let data = &mut state.data;
    let spent = if at.chunk == 0 { 0 } else { data.counters[0].computed };
    let left = if data.counters[0].void() { 0 } else { data.object_params[0].budget - spent };

    // Take the first stale links; receivers that have any of them, or were merged, are summed again.
    let mut active = Vec::new();
    let (mut due, mut rest) = (Vec::new(), 0);
    for &receiver in &data.order[nodes.start as usize..nodes.end as usize] {
        let edited = has_edits(data, receiver);
        let (span, edit) = (data.spans[receiver as usize], &mut data.edits[receiver as usize]);
        let waiting = &mut data.stale_counts[receiver as usize];
        let count = (*waiting).min(left - due.len() as u32);
        (edit.edge, edit.edges) = (due.len() as u32, count);
        let mut taken = 0;
        for k in span.link..span.link + span.links {
            let flag = data.stale.get_mut(flags + k as usize).filter(|flag| **flag != 0 && taken < count);
            if let Some(flag) = flag {
                *flag = 0;
                due.push(k);
                taken += 1;
            }
        }
        *waiting -= count;
        rest += *waiting;
        if !data.counters[0].void() && (edited || count > 0) {
            active.push(receiver);
            (edit.links, edit.areas) = (0, 0);
        }
    }
    data.active_receivers[nodes.start as usize..][..active.len()].copy_from_slice(&active);
    let counters = &mut data.counters[0];
    counters.receivers = active.len() as u32;
    counters.summed = counters.receivers + if at.chunk == 0 { 0 } else { counters.summed };
    (counters.due, counters.computed) = (due.len() as u32, spent + due.len() as u32);
    counters.stale = rest + if at.chunk == 0 { 0 } else { counters.stale };

    // Sort by quadrature rule.
    let emitters = Emitters::new(&state.data, state.distance, state.method.near);
    let center = |k: u32| state.data.clusters[state.data.links[base + k as usize].receiver as usize].center;
    let emitter = |k: u32| state.data.links[base + k as usize].emitter;
    let rule = |k: u32| emitters.rule(emitter(k), center(k));
    let kind = |&k: &u32| match rule(k) {
        QuadratureRule::Center => RULE_SAMPLE,
        QuadratureRule::Points(_) => RULE_AREA,
        QuadratureRule::Edges | QuadratureRule::Uniform(_) => RULE_EDGE,
    };
    let mut ranked = due.clone();
    ranked.sort_by_key(kind);
    let counts = [RULE_SAMPLE, RULE_AREA, RULE_EDGE].map(|all| ranked.iter().filter(|k| kind(k) == all).count() as u32);
    let factors: Vec<[f32; 3]> =
        due.par_iter().map(|&k| narrow(emitters.factor(emitter(k), wide(center(k)), rule(k)))).collect();
    let data = &mut state.data;
    for (&k, factor) in due.iter().zip(factors) {
        data.factors[base + k as usize] = factor;
    }
    data.due_links[..due.len()].copy_from_slice(&due);
    data.ranked_links[..due.len()].copy_from_slice(&ranked);
    (data.counters[0].due_areas, data.counters[0].due_edges) = (counts[1], counts[2]);
    data.due_groups[..3].copy_from_slice(&counts.map(groups));
    data.due_groups[SUMMED] = groups(data.counters[0].receivers);
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    let nodes = pass.object().schedule.chunks[pass.at.chunk].nodes.clone();
    let range = Range { first: nodes.start, count: nodes.end - nodes.start };
    let chunk = pass.at.chunk as u32;
    pass.dispatch(Some("select"), &[], bytemuck::bytes_of(&[range.first, range.count, chunk]), 1)?;
    pass.dispatch_counted("pick", &[], bytemuck::bytes_of(&range), (BufferId::due_groups, SUMMED))?;
    pass.dispatch(Some("sort"), &[], &[], 1)?;
    let displaced = u32::from(pass.state.distance == Distance::Table1);
    pass.dispatch_counted("far", &[displaced], &[], (BufferId::due_groups, RULE_SAMPLE as usize))?;
    pass.dispatch_counted("area", &[displaced], &[], (BufferId::due_groups, RULE_AREA as usize))?;
    let density = uniform::density(&pass.state.data.object_params[0]).to_le_bytes();
    if pass.state.method.projected {
        pass.dispatch_counted("projected", &[displaced], &[], (BufferId::due_groups, RULE_EDGE as usize))?;
    }
    match pass.state.method.near {
        Near::Exact => pass.dispatch_counted("edge", &[displaced], &[], (BufferId::due_groups, RULE_EDGE as usize)),
        Near::PointSampling => {
            pass.dispatch_counted("uniform", &[displaced], &density, (BufferId::due_groups, RULE_EDGE as usize))
        }
    }
}
