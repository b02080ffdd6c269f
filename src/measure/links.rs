//! How many links of light a session's last frame used.

use crate::error::Result;
use crate::layout::BufferId;
use crate::pipeline::plan::ShadingMethod;
use crate::scene::Scheme;
use crate::session::run::Session;
use crate::state::State;

/// The links of the last frame; none for methods without lists, and where the lists of a part of the scene replace
/// those of another one within the frame.
pub fn links(session: &mut Session) -> Result<Option<u64>> {
    if !matches!(session.plan().options().transport, ShadingMethod::Hierarchy | ShadingMethod::Diffusion) {
        return Ok(None);
    }
    let state = session.state();
    let lists = match state.method.scheme {
        Scheme::Blocks => state.batches().count(),
        Scheme::Links => state.objects.iter().map(|object| object.schedule.chunks.len()).sum(),
    };
    if !state.keep && lists > 1 {
        return Ok(None);
    }
    session.fetch(&[BufferId::spans, BufferId::runs])?;
    let state = session.state();
    Ok(Some(match state.method.scheme {
        Scheme::Blocks => entries(state),
        Scheme::Links => state.data.spans.iter().map(|span| u64::from(span.links)).sum(),
    }))
}

/// Entries of the lists of all blocks: expanded entries count once, the others once per face of the block. Each group
/// of channels has its own lists, all of which count.
fn entries(state: &State) -> u64 {
    let mut sum = 0;
    for (at, batch) in state.batches() {
        let (first, _) = state.part(BufferId::runs, at);
        let blocks = &state.data.blocks[state.object(at).first.blocks..][batch.start as usize..batch.end as usize];
        for (block, run) in blocks.iter().zip(&state.data.runs[first..]) {
            let each = [run.direct, run.area, run.edge].map(u64::from).iter().sum::<u64>();
            sum += u64::from(run.expanded) + u64::from(block.count) * each;
        }
    }
    sum
}
