//! How large the buffers are that a plan's stages write.

use super::frame::STAGES;
use super::plan::{Plan, Transport};
use super::run::Session;
use crate::error::Result;
use crate::layout::{Cut, SLOTS, Slot};
use crate::state::{Extent, Size, State};
use crate::view::shade;

/// What the host and the picture read of every frame, whether a stage writes it or not.
const RESULTS: [Slot; 6] =
    [Slot::irradiance, Slot::radiosity, Slot::vertex_radiosity, Slot::estimate, Slot::cursor, Slot::seen];

/// How many elements a buffer has that stages write: as one of them says, or by what the buffer has one element each.
fn elements(state: &State, slot: Slot) -> usize {
    let Extent { vertices, faces, nodes, blocks, receivers } = state.extent();
    if let Some((Size::Elements(count) | Size::Grows(count), _)) = declared(slot) {
        return count(state);
    }
    match slot.spec().cut {
        Cut::Object => state.objects.len(),
        Cut::Vertex => vertices,
        Cut::Start => vertices + 1,
        Cut::Face => faces,
        Cut::Corner => 3 * faces,
        Cut::Shadow => faces * state.data.frame[0].shadow_words as usize,
        Cut::Node => nodes,
        Cut::Block => blocks,
        Cut::Receiver => receivers,
        Cut::Group => state.sum(|object| object.groups.len() * object.count.nodes.next_multiple_of(64)),
        Cut::Whole | Cut::Chunk | Cut::Batch => 0,
    }
}

/// What a stage says of a buffer's size, and which one.
pub fn declared(slot: Slot) -> Option<(Size, &'static str)> {
    let of = |stage: &&crate::state::Stage| Some((stage.sizes.iter().find(|(sized, _)| *sized == slot)?.1, stage.name));
    STAGES.iter().find_map(of)
}

/// Whether a frame turns out to need more or less of a buffer than there is to begin with.
pub fn grows(slot: Slot) -> bool {
    matches!(declared(slot), Some((Size::Grows(_), _)))
}

/// Whether a frame of this plan has to do with a buffer that stages write.
fn wanted(state: &State, plan: &Plan, slot: Slot) -> bool {
    // In local shading only stage `shade` and what it needs read radiosity.
    let carries = state.method.local.is_none() || plan.has(&shade::STAGE);
    match slot {
        Slot::irradiance | Slot::radiosity | Slot::vertex_radiosity => carries,
        Slot::estimate => state.method.estimate,
        // Where nothing is lit there is no stage that finds receivers; `shade` reads on, and finds no radiosity.
        Slot::seen => state.objects.iter().any(|object| object.by_pixel),
        _ => plan.writes(slot) || RESULTS.contains(&slot),
    }
}

/// Gives every buffer that a plan's stages write its size, zeroed; the others stay empty, as does the error estimate
/// where none is requested.
pub fn size(state: &mut State, plan: &Plan) {
    resize(state, plan, |_| true);
}

/// The same for those of these buffers that stages write.
fn resize(state: &mut State, plan: &Plan, chosen: impl Fn(Slot) -> bool) {
    for slot in SLOTS.iter().copied().filter(|slot| chosen(*slot) && !Plan::inputs().any(|input| input == *slot)) {
        let count = if wanted(state, plan, slot) { elements(state, slot) } else { 0 };
        state.data.resize(slot, 0);
        state.data.resize(slot, count);
    }
}

impl Session {
    /// Gives every buffer its size and sends the inputs.
    pub(super) fn resize(&mut self) -> Result<()> {
        size(&mut self.prepared.state, &self.plan);
        self.linked = false;
        self.size_picture();
        self.check_bindings()?;
        let inputs: Vec<Slot> = Plan::inputs().collect();
        self.send(&inputs)?;
        // What no stage of the plan writes must be zero where a stage or the host reads it.
        let carried = self.plan.options().transport != Transport::None;
        let unwritten = |slot: &Slot| !self.plan.writes(*slot) || (*slot == Slot::radiosity && !carried);
        let blank: Vec<Slot> = RESULTS[..4].iter().copied().filter(unwritten).collect();
        self.send(&blank)?;
        // And what the host asks of every object, though not every object has lists.
        self.send(&[Slot::cut_short, Slot::cursor, Slot::stale, Slot::waiting])
    }

    /// Gives the lists their size, for a frame that has come as far as they are made.
    pub(super) fn lengthen(&mut self) -> Result<()> {
        resize(&mut self.prepared.state, &self.plan, grows);
        self.check_bindings()?;
        self.send(&[Slot::frame])
    }

    pub(super) fn size_picture(&mut self) {
        resize(&mut self.prepared.state, &self.plan, |slot| slot.spec().per == "pixel");
    }
}
