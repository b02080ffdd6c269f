//! What a frame works on ([`State`]), what a [`Stage`] is, and the state's twin on a device.

mod device;
mod schedule;

pub use device::{DeviceState, Pass};
pub use schedule::{Chunk, Schedule};

use crate::error::Result;
use crate::layout::{Buffers, Slot};
pub use crate::scene::Distance;

/// All that a frame reads and writes on the host, and how its work is cut up.
#[derive(Clone, Debug, Default)]
pub struct State {
    /// The buffers.
    pub data: Buffers,
    /// The order of the work on the tree.
    pub schedule: Schedule,
    /// The distance convention.
    pub distance: Distance,
    /// Whether each chunk keeps links and form factors for later frames, or all share one room.
    pub keep: bool,
}

impl State {
    /// The part of a buffer that a dispatch of this chunk binds: first element and number of elements.
    pub fn part(&self, slot: Slot, chunk: usize) -> (usize, usize) {
        let spec = slot.spec();
        let all = self.data.bytes(slot).len() / spec.stride;
        let parts = self.schedule.chunks.len().max(1);
        if !spec.chunked || !self.keep {
            return (0, all);
        }
        let room = all / parts;
        (chunk * room, room)
    }
}

/// One piece of a frame: a stage, and for a stage that works by chunks the chunk.
#[derive(Clone, Copy)]
pub struct Step {
    /// The stage.
    pub stage: &'static Stage,
    /// The chunk; 0 for a stage that works on everything at once.
    pub chunk: usize,
}

impl std::fmt::Debug for Step {
    fn fmt(&self, out: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(out, "{}[{}]", self.stage.name, self.chunk)
    }
}

/// How near a device's value has to come to the reference's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Tolerance {
    /// Bit for bit: decisions, indices, minima and maxima.
    Exact,
    /// A float may differ by `relative` times the reference's magnitude plus `floor` times the largest magnitude of
    /// its field in the buffer; everything that is not a float bit for bit.
    Float {
        /// Share of the value itself.
        relative: f32,
        /// Share of the field's largest value.
        floor: f32,
    },
    /// Each float field by its own rule; everything that is not a float bit for bit.
    Fields(&'static [Field]),
}

/// How near one field of a record has to come.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Field {
    /// The field.
    pub name: &'static str,
    /// Share of the value itself.
    pub relative: f32,
    /// Added to that: a share of the field `of` of the same element.
    pub floor: f32,
    /// The field that the floor is a share of, or empty: of 1.
    pub of: &'static str,
}

/// What becomes of a buffer that a stage writes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Role {
    /// Its old contents don't matter: conformance poisons it first.
    Output,
    /// Part of its old contents is read or must survive.
    Update,
}

/// One step of the frame, on the CPU and on the GPU.
pub struct Stage {
    /// Its one name: here, in GLSL, in the profile, in the conformance table, in the README.
    pub name: &'static str,
    /// The room it lives in; its shaders are `glsl/ROOM/NAME.comp` or `glsl/ROOM/NAME/*.comp`.
    pub room: &'static str,
    /// What it does, in one sentence.
    pub about: &'static str,
    /// The equation or section it comes from.
    pub equation: &'static str,
    /// The buffers it writes, what becomes of their old contents, and how near the two sides have to be.
    pub writes: &'static [(Slot, Role, Tolerance)],
    /// Why the tolerances are what they are.
    pub reason: &'static str,
    /// Whether it runs once a chunk.
    pub chunked: bool,
    /// The reference.
    pub cpu: fn(&mut State, usize),
    /// Records its dispatches.
    pub gpu: fn(&mut Pass<'_>) -> Result<()>,
}

/// Three stored singles as doubles.
pub fn wide(v: [f32; 3]) -> glam::DVec3 {
    glam::DVec3::new(v[0].into(), v[1].into(), v[2].into())
}

/// Doubles rounded once to what is stored.
pub fn narrow(v: glam::DVec3) -> [f32; 3] {
    [v.x as f32, v.y as f32, v.z as f32]
}
