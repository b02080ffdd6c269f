//! A plan run on the CPU or on a device: room for the lists, one submit a frame, and once more where a list overflowed.

use std::time::Instant;

use super::plan::{Change, Mode, Options, Plan};
use super::prepare::{Prepared, Units, camera, lights, prepare, schedule};
use crate::error::{Error, Result};
use crate::geometry::trace::UNFINISHED;
use crate::gpu::{Device, Timing};
use crate::layout::{Cursor, Slot};
use crate::scene::{Camera, Light, Scene};
use crate::state::{DeviceState, State};
use crate::view::picture::Picture;

/// Faces of a chunk to begin with; fewer once a chunk's lists turn out not to fit a binding.
const CHUNK_FACES: usize = 1 << 14;
/// Largest list on the CPU, bytes: what the smallest devices allow.
const CPU_BINDING: u64 = 1 << 27;
/// Largest list anywhere, bytes.
const MOST_BINDING: u64 = 1 << 29;
/// Links per face to begin with.
const LINKS: usize = 640;

/// Where the stages run.
pub enum Backend {
    /// The reference, on the host.
    Cpu,
    /// A Vulkan device.
    Gpu(DeviceState),
}

/// First sizes, for tests that want lists to overflow or chunks to be small.
#[derive(Clone, Copy, Debug)]
pub struct Room {
    /// Faces of a chunk.
    pub chunk_faces: usize,
    /// Links per face of a chunk.
    pub links: usize,
    /// Largest list, bytes; further limited by the device.
    pub binding: u64,
}

impl Default for Room {
    fn default() -> Self {
        Self { chunk_faces: CHUNK_FACES, links: LINKS, binding: MOST_BINDING }
    }
}

/// A scene being rendered, frame after frame.
pub struct Session {
    /// The state, its units and the order of its faces.
    pub prepared: Prepared,
    /// What runs.
    pub plan: Plan,
    /// Where it runs.
    pub backend: Backend,
    /// How often a frame had to run again because a list overflowed.
    pub retries: usize,
    scene: Scene,
    room: Room,
    chunk_faces: usize,
}

impl Session {
    /// Prepares a scene for a device, or for the CPU where there is none.
    pub fn new(scene: &Scene, device: Option<&Device>, options: Options, room: Room) -> Result<Self> {
        let mut prepared = prepare(scene);
        prepared.state.keep = options.mode == Mode::Render;
        let plan = Plan::new(&prepared.state, options);
        let (backend, allowed) = match device {
            Some(device) => (Backend::Gpu(DeviceState::new(device, false)), device.limits().binding_bytes),
            None => (Backend::Cpu, CPU_BINDING),
        };
        let room = Room { binding: room.binding.min(allowed), ..room };
        let chunk_faces = room.chunk_faces;
        let mut session = Self { prepared, plan, backend, retries: 0, scene: scene.clone(), room, chunk_faces };
        session.cut()?;
        Ok(session)
    }

    /// The state.
    pub fn state(&self) -> &State {
        &self.prepared.state
    }

    /// The units.
    pub fn units(&self) -> &Units {
        &self.prepared.units
    }

    /// The scene.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// Replaces the lights; the next frame has to be one of [`Change::Light`] or [`Change::Everything`].
    pub fn set_lights(&mut self, list: &[Light]) -> Result<()> {
        self.scene.lights = list.to_vec();
        lights(&mut self.prepared.state, list, &mut self.prepared.units, &self.scene.object.mesh);
        self.send(&[Slot::frame, Slot::lights, Slot::camera])
    }

    /// Replaces the camera (its picture may have another size).
    pub fn set_camera(&mut self, new: &Camera) -> Result<()> {
        self.scene.camera = new.clone();
        camera(&mut self.prepared.state, new, self.prepared.units);
        self.size_picture();
        self.send(&[Slot::camera])
    }

    /// Runs one frame and returns each step's time: on the device, or on the host's clock for the CPU.
    pub fn frame(&mut self, change: Change) -> Result<Vec<Timing>> {
        let mut change = change;
        loop {
            let steps = self.plan.steps(&self.prepared.state, change);
            let times = match &mut self.backend {
                Backend::Gpu(twin) => twin.run(&self.prepared.state, &steps)?,
                Backend::Cpu => {
                    let state = &mut self.prepared.state;
                    let mut time = |step: &crate::state::Step| {
                        let start = Instant::now();
                        (step.stage.cpu)(state, step.chunk);
                        let milliseconds = start.elapsed().as_secs_f64() * 1e3;
                        Timing { name: step.stage.name.to_string(), milliseconds }
                    };
                    steps.iter().map(&mut time).collect()
                }
            };
            if !steps.iter().any(|step| step.stage.name == "link") {
                return Ok(times);
            }
            self.fetch(&[Slot::cursor])?;
            if self.prepared.state.data.cursor[0].unfinished != 0 {
                return Err(unfinished("linking", "raise transport.receiver_angle and transport.emitter_angle"));
            }
            if self.prepared.state.data.cursor[0].overflow == 0 {
                return Ok(times);
            }
            self.retries += 1;
            self.grow()?;
            change = Change::Everything;
        }
    }

    /// Brings these buffers to the host.
    pub fn fetch(&mut self, slots: &[Slot]) -> Result<()> {
        match &self.backend {
            Backend::Gpu(twin) => twin.download(&mut self.prepared.state, slots),
            Backend::Cpu => Ok(()),
        }
    }

    /// The picture of the last frame, linear radiance row by row.
    pub fn picture(&mut self) -> Result<Picture> {
        self.fetch(&[Slot::hits, Slot::radiance])?;
        let data = &self.prepared.state.data;
        if data.hits.iter().any(|hit| hit.face == UNFINISHED) {
            return Err(unfinished("tracing a ray through the tree", "use a mesh with fewer overlapping parts"));
        }
        let [width, height] = self.scene.camera.size.map(|n| n as usize);
        Ok(Picture { width, height, pixels: data.radiance.clone() })
    }

    fn send(&mut self, slots: &[Slot]) -> Result<()> {
        match &mut self.backend {
            Backend::Gpu(twin) => twin.upload(&self.prepared.state, slots),
            Backend::Cpu => Ok(()),
        }
    }

    /// Cuts the tree into chunks, gives every list its first room, and sends the inputs.
    fn cut(&mut self) -> Result<()> {
        schedule(&mut self.prepared, self.chunk_faces);
        let faces = self.largest_chunk().div_ceil(2);
        let room = |per: usize, stride| ((faces * per).clamp(64, self.most(stride)) / 64 * 64) as u32;
        let rooms = [room(self.room.links, 12), room(16, 4), room(4, 4), room(96, 4)];
        self.set_rooms(rooms);
        self.resize()
    }

    /// Room for links, those with area points, those with the edge form, and hand-downs.
    fn set_rooms(&mut self, rooms: [u32; 4]) {
        let frame = &mut self.prepared.state.data.frame[0];
        [frame.link_room, frame.area_room, frame.edge_room, frame.hand_room] = rooms;
    }

    fn largest_chunk(&self) -> usize {
        let sizes = self.prepared.state.schedule.chunks.iter().map(|c| c.nodes.len());
        sizes.max().unwrap_or(0)
    }

    /// Elements of this many bytes that one list can have, a multiple of 64.
    fn most(&self, stride: u64) -> usize {
        (self.room.binding.min(u64::from(u32::MAX)) / stride / 64 * 64) as usize
    }

    /// Makes room after an overflow: longer lists, or smaller chunks where a list can't grow any more.
    fn grow(&mut self) -> Result<()> {
        let need = self.prepared.state.data.cursor[0];
        let frame = self.prepared.state.data.frame[0];
        let mut lists = [
            ("links", need.need_links, frame.link_room, 12),
            ("area_links", need.need_areas, frame.area_room, 4),
            ("edge_links", need.need_edges, frame.edge_room, 4),
            ("handed", need.need_hands, frame.hand_room, 4),
        ];
        // Where emitters could not be handed down, what lies below is not counted: then that list at least doubles.
        if need.need_hands > frame.hand_room {
            lists[3].1 = need.need_hands.max(frame.hand_room.saturating_mul(2));
        }
        let mut rooms = lists.map(|(_, _, room, _)| room);
        for (room, (name, need, had, stride)) in rooms.iter_mut().zip(lists) {
            let (need, most) = (need as usize, self.most(stride));
            if need > most {
                // As many faces as would fit at this density, and a quarter less.
                let faces = self.largest_chunk().div_ceil(2).min(self.chunk_faces);
                self.chunk_faces = (faces as f64 * most as f64 / need as f64 * 0.75) as usize;
                if self.chunk_faces < 16 {
                    let what =
                        format!("it needs {need} entries for {faces} faces, a binding of the device takes {most}");
                    return Err(Error::device(format!("making room for buffer {name}"), what));
                }
                return self.cut();
            }
            if need > had as usize {
                *room = (need + need / 32).next_multiple_of(64).min(most) as u32;
            }
        }
        self.set_rooms(rooms);
        self.resize()
    }

    /// Gives every buffer its size and sends the inputs.
    fn resize(&mut self) -> Result<()> {
        size(&mut self.prepared.state, &self.plan);
        self.size_picture();
        let inputs: Vec<Slot> = Plan::inputs().collect();
        self.send(&inputs)?;
        // What no stage of the plan writes must be zero where a stage or the host reads it.
        let blank: Vec<Slot> = [Slot::irradiance, Slot::radiosity, Slot::vertex_radiosity]
            .into_iter()
            .filter(|slot| !self.plan.stages.iter().any(|s| s.writes.iter().any(|(w, _, _)| w == slot)))
            .collect();
        self.send(&blank)
    }

    fn size_picture(&mut self) {
        let data = &mut self.prepared.state.data;
        let camera = &data.camera[0];
        let shown = self.plan.stages.iter().any(|stage| stage.name == "visibility");
        let pixels = if shown { camera.width as usize * camera.height as usize } else { 0 };
        data.hits = bytemuck::zeroed_vec(pixels);
        data.radiance = bytemuck::zeroed_vec(pixels);
    }
}

/// The error of a driver that ends loops early.
fn unfinished(doing: &str, advice: &str) -> Error {
    Error::device(doing, format!("it takes more than 65,000 steps, where some drivers end a loop; {advice}"))
}

/// Gives every buffer that a plan's stages write its size, zeroed; the others stay empty.
pub fn size(state: &mut State, plan: &Plan) {
    let chunks = if state.keep { state.schedule.chunks.len() } else { 1 };
    let used = |slot: Slot| plan.stages.iter().any(|s| s.writes.iter().any(|(w, _, _)| *w == slot));
    let data = &mut state.data;
    let frame = data.frame[0];
    let (vertices, faces, nodes) = (frame.vertices as usize, frame.faces as usize, frame.nodes as usize);
    let per = |slot: Slot, count: usize| if used(slot) { count } else { 0 };
    data.bounds = bytemuck::zeroed_vec(nodes);
    data.clusters = bytemuck::zeroed_vec(nodes);
    data.normals = bytemuck::zeroed_vec(vertices);
    data.irradiance = bytemuck::zeroed_vec(faces);
    data.cluster_irradiance = bytemuck::zeroed_vec(per(Slot::cluster_irradiance, nodes));
    data.reach = bytemuck::zeroed_vec(per(Slot::reach, faces));
    data.spans = bytemuck::zeroed_vec(per(Slot::spans, nodes));
    data.handed = bytemuck::zeroed_vec(per(Slot::handed, frame.hand_room as usize));
    data.cursor = vec![Cursor::default()];
    data.links = bytemuck::zeroed_vec(per(Slot::links, chunks * frame.link_room as usize));
    data.factors = bytemuck::zeroed_vec(per(Slot::factors, chunks * frame.link_room as usize));
    data.area_links = bytemuck::zeroed_vec(per(Slot::area_links, chunks * frame.area_room as usize));
    data.edge_links = bytemuck::zeroed_vec(per(Slot::edge_links, chunks * frame.edge_room as usize));
    data.gathered = bytemuck::zeroed_vec(per(Slot::gathered, nodes));
    data.radiosity = bytemuck::zeroed_vec(faces);
    data.vertex_radiosity = bytemuck::zeroed_vec(vertices);
}
