//! Stage `sum_links`: the light that each node receives at its centre by its own links, the sum of E times F (equation
//! 6).

use rayon::prelude::*;

use crate::error::Result;
use crate::layout::{BufferId, Range};
use crate::state::{Granularity, Pass, Role, Scope, Stage, State, Tolerance, narrow, wide};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "sum_links",
    about: "sum of irradiance times form factor over each node's links",
    equation: "Mertens et al. 2003, equation 6",
    writes: &[(BufferId::gathered, Role::Update, Tolerance::Float { relative: 3e-5, floor: 1e-7 })],
    reason: "a sum of non-negative terms in fixed order: n terms of f32 rounding, n up to a few thousand",
    granularity: Granularity::Chunk,
    runs: |update| update.sums_all_links() && update.sums(),
    ..super::stage(cpu, gpu)
};

fn cpu(state: &mut State, at: Scope) {
    let nodes = state.object(at).schedule.chunks[at.chunk].nodes.clone();
    let receivers = state.data.order[nodes.start as usize..nodes.end as usize].to_vec();
    sum(state, at, &receivers);
}

/// Computes the sums of these receivers of a chunk.
pub(super) fn sum(state: &mut State, at: Scope, receivers: &[u32]) {
    let (base, _) = state.part(BufferId::links, at);
    let data = &mut state.data;
    let sums: Vec<[f32; 3]> = receivers
        .par_iter()
        .map(|&receiver| {
            let span = data.spans[receiver as usize];
            // A list that did not fit is empty and may begin beyond the end; if any did not, no factor is computed.
            let count = if data.counters[0].overflow == 0 { span.links as usize } else { 0 };
            let links = base + span.link as usize..base + span.link as usize + count;
            let part = data.links.get(links.clone()).unwrap_or_default();
            let terms = part.iter().zip(data.factors.get(links).unwrap_or_default());
            narrow(terms.map(|(l, &f)| wide(data.cluster_irradiance[l.emitter as usize]) * wide(f)).sum())
        })
        .collect();
    for (&receiver, sum) in receivers.iter().zip(sums) {
        data.gathered[receiver as usize] = sum;
    }
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    let nodes = pass.object().schedule.chunks[pass.at.chunk].nodes.clone();
    let range = Range { first: nodes.start, count: nodes.end - nodes.start };
    pass.dispatch(None, &[], bytemuck::bytes_of(&range), range.count as usize)
}
