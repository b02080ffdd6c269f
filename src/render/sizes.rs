//! How large the buffers are that a plan's stages write.

use super::plan::{Plan, Transport};
use super::room::{batches, chunks as parts_of_links, largest_batch};
use super::run::Session;
use crate::baseline::renew::GROUPS;
use crate::error::Result;
use crate::layout::{Cursor, Frame, Slot};
use crate::light::environment;
use crate::local::gaussians::GAUSSIANS;
use crate::state::{Extent, Local, State};
use crate::transport::radii::{ENTRIES as ENTRIES_OF_A_LAW, LAWS};

/// Gives every buffer that a plan's stages write its size, zeroed; the others stay empty, as does the error estimate
/// where nobody asked for it.
pub fn size(state: &mut State, plan: &Plan) {
    let estimate = state.method.estimate;
    let Extent { vertices, faces, nodes, blocks, receivers } = state.extent();
    let batches = if state.keep { batches(state) } else { 1 };
    let part = |count: usize| count.next_multiple_of(64);
    let each = part(largest_batch(state));
    let moments = state.sum(|object| object.groups.len() * part(object.count.nodes));
    let objects = state.objects.len();
    // In local shading only stage `shade` and what it needs read radiosity.
    let carries = state.method.local.is_none() || plan.stages.iter().any(|stage| stage.name == "shade");
    let table = match state.method.local {
        Some(Local::Table(side)) => side as usize,
        _ => 1,
    };
    let data = &mut state.data;
    let (frame, texels) = (data.frame[0], data.charts.len());
    let per = |slot: Slot, count: usize| if plan.writes(slot) { count } else { 0 };
    data.bounds = bytemuck::zeroed_vec(nodes);
    data.clusters = bytemuck::zeroed_vec(nodes);
    data.normals = bytemuck::zeroed_vec(vertices);
    data.lit = bytemuck::zeroed_vec(per(Slot::lit, faces * frame.shadow_words as usize));
    data.cut_short = bytemuck::zeroed_vec(per(Slot::cut_short, 1));
    data.harmonics = bytemuck::zeroed_vec(per(Slot::harmonics, environment::elements(frame.sky)));
    data.curvature = bytemuck::zeroed_vec(per(Slot::curvature, vertices));
    data.bends = bytemuck::zeroed_vec(per(Slot::bends, vertices));
    data.cdrf_grid = bytemuck::zeroed_vec(per(Slot::cdrf_grid, table * table));
    data.cdrf_cells = bytemuck::zeroed_vec(per(Slot::cdrf_cells, (table - 1) * (table - 1)));
    data.stretch = bytemuck::zeroed_vec(per(Slot::stretch, texels));
    data.sheets = bytemuck::zeroed_vec(per(Slot::sheets, (1 + GAUSSIANS) * texels));
    data.crossed = bytemuck::zeroed_vec(per(Slot::crossed, texels));
    data.irradiance = bytemuck::zeroed_vec(if carries { faces } else { 0 });
    data.cluster_irradiance = bytemuck::zeroed_vec(per(Slot::cluster_irradiance, nodes));
    data.spheres = bytemuck::zeroed_vec(blocks);
    data.moments = bytemuck::zeroed_vec(per(Slot::moments, moments));
    data.spreads = bytemuck::zeroed_vec(per(Slot::spreads, moments));
    data.emitters = bytemuck::zeroed_vec(per(Slot::emitters, moments));
    data.expands = bytemuck::zeroed_vec(per(Slot::expands, moments));
    data.samples = bytemuck::zeroed_vec(per(Slot::samples, 256));
    data.level = bytemuck::zeroed_vec(per(Slot::level, 1));
    data.ranges = bytemuck::zeroed_vec(per(Slot::ranges, LAWS * (ENTRIES_OF_A_LAW + 2)));
    data.runs = bytemuck::zeroed_vec(per(Slot::runs, batches * each));
    data.near = bytemuck::zeroed_vec(per(Slot::near, batches * each));
    data.near_groups = bytemuck::zeroed_vec(per(Slot::near_groups, batches * 64));
    data.expansions = bytemuck::zeroed_vec(per(Slot::expansions, blocks));
    data.places = bytemuck::zeroed_vec(if blocks > 0 { receivers } else { 0 });
    data.received = bytemuck::zeroed_vec(per(Slot::received, receivers));
    data.estimate = bytemuck::zeroed_vec(if estimate { receivers } else { 0 });
    data.reach = bytemuck::zeroed_vec(per(Slot::reach, faces));
    data.spans = bytemuck::zeroed_vec(per(Slot::spans, nodes));
    data.cursor = vec![Cursor::default(); objects];
    let vertices_of_all = data.positions.len();
    data.kept_positions = bytemuck::zeroed_vec(per(Slot::kept_positions, vertices_of_all));
    data.kept_clusters = bytemuck::zeroed_vec(per(Slot::kept_clusters, nodes));
    data.altered = bytemuck::zeroed_vec(per(Slot::altered, nodes));
    data.edits = bytemuck::zeroed_vec(per(Slot::edits, nodes));
    data.busy = bytemuck::zeroed_vec(per(Slot::busy, nodes));
    data.waiting = bytemuck::zeroed_vec(per(Slot::waiting, nodes));
    data.due_groups = bytemuck::zeroed_vec(per(Slot::due_groups, GROUPS));
    data.gathered = bytemuck::zeroed_vec(per(Slot::gathered, nodes));
    data.radiosity = bytemuck::zeroed_vec(if carries { receivers } else { 0 });
    data.vertex_radiosity = bytemuck::zeroed_vec(if carries { vertices } else { 0 });
    data.crowds = bytemuck::zeroed_vec(per(Slot::crowds, nodes));
    data.planes = bytemuck::zeroed_vec(per(Slot::planes, vertices));
    size_lists(state, plan);
}

/// The same for lists whose length is room that turns out to be too little, or not.
fn size_lists(state: &mut State, plan: &Plan) {
    let (chunks, batches) = if state.keep { (parts_of_links(state), batches(state)) } else { (1, 1) };
    let data = &mut state.data;
    let Frame { entry_room, link_room, area_room, edge_room, hand_room, edit_room, .. } = data.frame[0];
    let room = |slot: Slot, parts: usize, room: u32| if plan.writes(slot) { parts * room as usize } else { 0 };
    data.entries = bytemuck::zeroed_vec(room(Slot::entries, batches, entry_room));
    data.links = bytemuck::zeroed_vec(room(Slot::links, chunks, link_room));
    data.factors = bytemuck::zeroed_vec(room(Slot::factors, chunks, link_room));
    data.area_links = bytemuck::zeroed_vec(room(Slot::area_links, chunks, area_room));
    data.edge_links = bytemuck::zeroed_vec(room(Slot::edge_links, chunks, edge_room));
    data.handed = bytemuck::zeroed_vec(room(Slot::handed, 1, hand_room));
    data.made = bytemuck::zeroed_vec(room(Slot::made, 1, edit_room));
    data.undone = bytemuck::zeroed_vec(room(Slot::undone, 1, edit_room));
    data.stale = bytemuck::zeroed_vec(room(Slot::stale, chunks, link_room));
    data.due = bytemuck::zeroed_vec(room(Slot::due, 1, link_room));
    data.ranked = bytemuck::zeroed_vec(room(Slot::ranked, 1, link_room));
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
        let blank: Vec<Slot> = [Slot::irradiance, Slot::radiosity, Slot::vertex_radiosity, Slot::estimate]
            .into_iter()
            .filter(unwritten)
            .collect();
        self.send(&blank)?;
        // And what the host asks of every object, though not every object has lists.
        self.send(&[Slot::cut_short, Slot::cursor, Slot::stale, Slot::waiting])
    }

    /// Gives the lists their size, for a frame that has come as far as they are made.
    pub(super) fn lengthen(&mut self) -> Result<()> {
        size_lists(&mut self.prepared.state, &self.plan);
        self.check_bindings()?;
        self.send(&[Slot::frame])
    }

    pub(super) fn size_picture(&mut self) {
        let data = &mut self.prepared.state.data;
        let camera = &data.camera[0];
        let shown = self.plan.stages.iter().any(|stage| stage.name == "visibility");
        let pixels = if shown { camera.width as usize * camera.height as usize } else { 0 };
        data.hits = bytemuck::zeroed_vec(pixels);
        data.radiance = bytemuck::zeroed_vec(pixels);
        let reached = self.plan.stages.iter().any(|stage| stage.name == "reached");
        let words = data.frame[0].shadow_words as usize;
        data.reached = bytemuck::zeroed_vec(if reached { words * pixels } else { 0 });
        // Where nothing is lit there is no stage `points`; `shade` reads on, and finds no radiosity.
        let by_pixel = self.prepared.state.objects.iter().any(|object| object.by_pixel);
        data.seen = bytemuck::zeroed_vec(if by_pixel { pixels } else { 0 });
    }
}
