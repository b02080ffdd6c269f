//! What a frame works on ([`State`]), what a [`Stage`] is, and the state's copy on a device.

mod alternate;
mod carrier;
mod change;
mod device;
mod objects;
pub mod options;
mod parts;
mod pass;
mod schedule;
pub mod stage;
mod tolerance;
mod trace;

pub use carrier::Carrier;
pub use change::{Change, Changes, Update};
pub use device::{Call, DeviceState, Groups};
pub use objects::{Extent, LitAt, Object};
pub use pass::{Bound, Dispatch, Pass, Width, dispatches, requested};
pub use schedule::{Chunk, Schedule};
pub use stage::{Host, Need, Role, Serves, Size, Stage, Step};
pub use tolerance::{Field, Rounding, Tolerance};
pub use trace::{Trace, Traced, TracedBinding};

use crate::layout::Buffers;
pub use crate::scene::{Distance, Near, Scheme};

/// All that a frame reads and writes on the host, and how its work is divided.
#[derive(Clone, Debug, Default)]
pub struct State {
    /// The buffers.
    pub data: Buffers,
    /// The objects; empty where nothing is rendered.
    pub objects: Vec<Object>,
    /// The distance convention.
    pub distance: Distance,
    /// Whether each chunk or batch keeps its lists for later frames, or all share one buffer part.
    pub keep: bool,
    /// The switches of the transport.
    pub method: Method,
}

/// Colour channels that are carried together: their irradiances are proportional on every face.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Group {
    /// Bit c is set for channel c.
    pub channels: u32,
    /// The channel whose irradiance weights the moments; the irradiance of the others is that times
    /// `object_params.tint`.
    pub lead: u32,
}

/// Which part of the work a step does; by default the first of each.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Scope {
    /// The object.
    pub object: usize,
    /// The chunk of the tree, the batch of blocks, or the step of a solver.
    pub chunk: usize,
    /// The group of channels.
    pub group: usize,
}

impl Scope {
    /// All objects at once.
    pub const SCENE: Self = Self { object: usize::MAX, chunk: 0, group: 0 };
}

/// How often a stage runs in a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Granularity {
    /// Once, for all objects.
    Scene,
    /// Once per object.
    Object,
    /// Once per chunk of the tree.
    Chunk,
    /// Once per group of channels.
    Group,
    /// Once per batch of blocks and group of channels.
    Batch,
    /// Once per step of a solver, and once for the start before the first.
    Iteration,
}

/// The switches of the hierarchical transport, fixed for a session.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Method {
    /// How light gets from clusters to receivers.
    pub scheme: Scheme,
    /// Order of the emitters' moments: 0 a point at the centroid of the area, 1 at the centroid of the light, 2 with
    /// second moments.
    pub order: u32,
    /// Quadrature nodes per edge of the edge form: 3, 6 or 12.
    pub nodes: u32,
    /// Whether an error estimate is carried along.
    pub estimate: bool,
    /// Whether lists of blocks are made to serve any light, as in mode `render`.
    pub any_light: bool,
    /// Whether links are kept while the shape changes: mode `incremental` with scheme `links`.
    pub incremental: bool,
    /// How scheme `links` evaluates triangles too near for a few samples.
    pub near: Near,
    /// Whether scheme `links` projects clusters too near for one sample.
    pub projected: bool,
    /// Steps of a solver at most, from one start to the next; 0 where there is nothing to solve.
    pub steps: u32,
    /// Whether the solver starts from the solution found so far.
    pub warm: bool,
    /// The local shading that takes the place of transport, if any.
    pub local: Option<Local>,
}

/// Shading without transport through the material.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Local {
    /// max(cos, 0).
    Lambert,
    /// The curvature-dependent reflectance function, in closed form.
    Closed,
    /// The same from a table of this many rows and columns, linear between its entries.
    Table(u32),
    /// Irradiance blurred over the texture coordinates.
    Blur,
}

impl Local {
    /// Whether objects do not shadow themselves: their own shadow would cut off the glow beyond 90 degrees.
    #[must_use]
    pub fn spares_itself(self) -> bool {
        self != Self::Blur
    }
}

impl Method {
    /// Whether a system of equations is solved for any object: diffusion.
    #[must_use]
    pub fn solves(&self) -> bool {
        self.steps > 0
    }
}

impl Default for Method {
    fn default() -> Self {
        Self {
            scheme: Scheme::Blocks,
            order: 2,
            nodes: 6,
            estimate: false,
            any_light: false,
            incremental: false,
            near: Near::Exact,
            projected: false,
            steps: 0,
            warm: false,
            local: None,
        }
    }
}

/// Three stored `f32` as `f64`.
pub fn wide(v: [f32; 3]) -> glam::DVec3 {
    glam::DVec3::new(v[0].into(), v[1].into(), v[2].into())
}

/// Three `f64`, each rounded once to the `f32` that is stored.
pub fn narrow(v: glam::DVec3) -> [f32; 3] {
    [v.x as f32, v.y as f32, v.z as f32]
}
