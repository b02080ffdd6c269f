//! How large the buffers are that a plan's stages write.

use super::frame::STAGES;
use super::plan::Plan;
use crate::layout::{BUFFER_IDS, BufferId, Partition};
use crate::state::{Extent, Size, State};
use crate::view::shade;

/// What the host and the picture read of every frame, whether a stage writes it or not.
pub const RESULTS: [BufferId; 6] = [
    BufferId::irradiance,
    BufferId::radiosity,
    BufferId::vertex_radiosity,
    BufferId::estimate,
    BufferId::counters,
    BufferId::seen,
];

/// How many elements a buffer has that stages write: as one of them says, or by what the buffer has one element each.
fn elements(state: &State, slot: BufferId) -> usize {
    let Extent { vertices, faces, nodes, blocks, receivers } = state.extent();
    if let Some(Size::Elements(count) | Size::Grows(count)) = declared(slot) {
        return count(state);
    }
    match slot.spec().partition {
        Partition::Object => state.objects.len(),
        Partition::Vertex => vertices,
        Partition::Start => vertices + 1,
        Partition::Face => faces,
        Partition::Corner => 3 * faces,
        Partition::Shadow => faces * state.data.object_params[0].shadow_words as usize,
        Partition::Node => nodes,
        Partition::Block => blocks,
        Partition::Receiver => receivers,
        Partition::Group => state.sum(|object| object.groups.len() * object.count.nodes.next_multiple_of(64)),
        Partition::Whole | Partition::Chunk | Partition::Batch => 0,
    }
}

/// The size that a stage declares for a buffer.
fn declared(slot: BufferId) -> Option<Size> {
    STAGES.iter().flat_map(|stage| stage.sizes).find(|(sized, _)| *sized == slot).map(|(_, size)| *size)
}

/// Whether a frame turns out to need more or less of a buffer than there is to begin with.
pub fn grows(slot: BufferId) -> bool {
    matches!(declared(slot), Some(Size::Grows(_)))
}

/// Whether a frame of this plan has to do with a buffer that stages write.
fn wanted(state: &State, plan: &Plan, slot: BufferId) -> bool {
    // In local shading only stage `shade` and what it needs read radiosity.
    let carries = state.method.local.is_none() || plan.has(&shade::STAGE);
    match slot {
        BufferId::irradiance | BufferId::radiosity | BufferId::vertex_radiosity => carries,
        BufferId::estimate => state.method.estimate,
        // Where nothing is lit there is no stage that finds receivers; `shade` reads on, and finds no radiosity.
        BufferId::seen => state.objects.iter().any(|object| object.by_pixel),
        _ => plan.writes(slot) || RESULTS.contains(&slot),
    }
}

/// Gives every buffer that a plan's stages write its size, zeroed; the others stay empty, as does the error estimate
/// where none is requested.
pub fn size(state: &mut State, plan: &Plan) {
    resize(state, plan, |_| true);
}

/// The same for those of these buffers that stages write.
pub fn resize(state: &mut State, plan: &Plan, chosen: impl Fn(BufferId) -> bool) {
    for slot in BUFFER_IDS.iter().copied().filter(|slot| chosen(*slot) && !Plan::is_input(*slot)) {
        let count = if wanted(state, plan, slot) { elements(state, slot) } else { 0 };
        state.data.resize(slot, 0);
        state.data.resize(slot, count);
    }
}
