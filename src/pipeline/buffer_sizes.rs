//! Sizes of the buffers that a plan's stages write.

use super::frame::STAGES;
use super::plan::Plan;
use crate::layout::{BUFFER_IDS, BufferId, Partition, SMALL_SYSTEM};
use crate::state::{Extent, Object, Size, State};
use crate::view::shade;

/// Buffers that the host and the picture read in every frame, whether a stage writes them or not.
pub const RESULTS: [BufferId; 6] = [
    BufferId::irradiance,
    BufferId::radiosity,
    BufferId::vertex_radiosity,
    BufferId::estimate,
    BufferId::counters,
    BufferId::seen,
];

/// Number of elements of a buffer that stages write: as a stage declares, or as its partition implies.
fn elements(state: &State, id: BufferId) -> usize {
    let Extent { vertices, faces, nodes, blocks, receivers } = state.extent();
    if let Some(Size::Elements(count) | Size::Grows(count)) = declared(id) {
        return count(state);
    }
    match id.spec().partition {
        Partition::Object => state.objects.len(),
        Partition::Vertex => vertices,
        Partition::Start => vertices + 1,
        Partition::Face => faces,
        Partition::Corner => 3 * faces,
        Partition::Shadow => faces * state.data.object_params[0].shadow_words as usize,
        Partition::Node => nodes,
        Partition::Vectors => state.sum(Object::of_vectors),
        Partition::Small => state.objects.len() * SMALL_SYSTEM,
        Partition::Block => blocks,
        Partition::Receiver => receivers,
        Partition::Group => state.sum(|object| object.groups.len() * object.count.nodes.next_multiple_of(64)),
        Partition::Whole | Partition::Chunk | Partition::Batch => 0,
    }
}

/// The size that a stage declares for a buffer.
fn declared(id: BufferId) -> Option<Size> {
    STAGES.iter().flat_map(|stage| stage.sizes).find(|(sized, _)| *sized == id).map(|(_, size)| *size)
}

/// Whether the size of a buffer is a guess that a frame may correct.
pub fn grows(id: BufferId) -> bool {
    matches!(declared(id), Some(Size::Grows(_)))
}

/// Whether a frame of this plan needs a buffer that stages write.
fn wanted(state: &State, plan: &Plan, id: BufferId) -> bool {
    // In local shading only stage `shade`, and what it needs, reads radiosity.
    let carries = state.method.local.is_none() || plan.has(&shade::STAGE);
    match id {
        BufferId::irradiance | BufferId::radiosity | BufferId::vertex_radiosity => carries,
        BufferId::estimate => state.method.estimate,
        // Without light no stage writes this, but `shade` still reads it, and finds no radiosity.
        BufferId::seen => state.objects.iter().any(|object| object.by_pixel),
        _ => plan.writes(id) || RESULTS.contains(&id),
    }
}

/// Sets the size of every buffer that the plan's stages write, zeroed; all other buffers that stages write become
/// empty, as does the error estimate where it is not requested.
pub fn size(state: &mut State, plan: &Plan) {
    resize(state, plan, |_| true);
}

/// The same, but leaves buffers whose size is right as they are.
pub fn adjust(state: &mut State, plan: &Plan) {
    let right = |state: &State, id: BufferId| {
        let count = if wanted(state, plan, id) { elements(state, id) } else { 0 };
        state.data.bytes(id).len() == count * id.spec().stride
    };
    let wrong: Vec<BufferId> = BUFFER_IDS.iter().copied().filter(|id| !right(state, *id)).collect();
    resize(state, plan, |id| wrong.contains(&id));
}

/// The same for the buffers that `chosen` accepts.
pub fn resize(state: &mut State, plan: &Plan, chosen: impl Fn(BufferId) -> bool) {
    for id in BUFFER_IDS.iter().copied().filter(|id| chosen(*id) && !Plan::is_input(*id)) {
        let count = if wanted(state, plan, id) { elements(state, id) } else { 0 };
        state.data.clear(id, count);
    }
}
