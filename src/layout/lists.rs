//! The structs of lists, and of what is dispatched, shared by host and device.

use bytemuck::{Pod, Zeroable};

use super::{Element, Record, Word};

records! { list_records:
    /// A receiver of the coarse solution.
    Sample {
        /// The triangle.
        face: u32,
        /// Probability that a draw chooses it.
        chance: f32,
        /// Its radiosity.
        value: [f32; 3],
        /// The square of the irradiance that enters it, as a multiple of the object's mean, times its share of the area
        /// over its chance.
        light: f32,
    }
    /// Where a receiver's lists lie in its chunk.
    Span {
        /// First link.
        link: u32,
        /// Number of links.
        links: u32,
        /// First entry among the links that take area points.
        area: u32,
        /// Number of those.
        areas: u32,
        /// First entry among the links that take the edge form.
        edge: u32,
        /// Number of those.
        edges: u32,
        /// First emitter handed down to the children.
        hand: u32,
        /// Number of those.
        hands: u32,
    }
    /// One transfer of light.
    Link {
        /// The node that receives, at its centre.
        receiver: u32,
        /// The node that emits.
        emitter: u32,
    }
    /// How full an object's lists are, and the capacity that they need; padded as `ObjectParams` is.
    ListCounters {
        /// Links of this chunk.
        links: u32,
        /// Links that take area points.
        areas: u32,
        /// Links that take the edge form.
        edges: u32,
        /// Emitters handed down.
        hands: u32,
        /// Handed-down emitters of the top of the tree, kept for every chunk.
        kept: u32,
        /// Largest count of links met in a chunk.
        required_links: u32,
        /// Largest count of links that take area points.
        required_areas: u32,
        /// Largest count of links that take the edge form.
        required_edges: u32,
        /// Largest count of handed-down emitters.
        required_hands: u32,
        /// Entries of this batch.
        entries: u32,
        /// Largest count of entries met in a batch.
        required_entries: u32,
        /// Most triangles that one block takes by area points or the edge form.
        required_near: u32,
        /// Not 0 if a list did not fit: the results are void, and the frame must run again with more capacity.
        overflow: u32,
        /// Not 0 if a driver ended a loop early, or would: lavapipe does so after 65,535 iterations.
        unfinished: u32,
        /// If lists serve any light: its contrast now, root mean square irradiance over the reference level, per
        /// channel.
        contrast: [f32; 3],
        /// The contrast that the lists were made for.
        served: [f32; 3],
        /// Kept links of this chunk whose form factors this frame computes.
        due: u32,
        /// Those of them that take area points.
        due_areas: u32,
        /// Those of them that take the edge form.
        due_edges: u32,
        /// Form factors that a frame computes over links that are kept, so far.
        computed: u32,
        /// Kept links whose form factors wait for a later frame, so far.
        stale: u32,
        /// Receivers of this chunk that are listed in `active_receivers`.
        receivers: u32,
        /// Receivers that a frame merges kept links of, so far.
        edited: u32,
        /// Receivers that a frame sums kept links of again, so far.
        summed: u32,
        /// Unused.
        padding: [u32; 32],
        /// Unused.
        more_padding: [u32; 3],
        /// Words of `decisions` that groups have taken for this batch; 0 once its lists are written.
        noted: u32,
    }
    /// A run of elements for one dispatch.
    Range {
        /// First element.
        first: u32,
        /// Number of elements.
        count: u32,
    }
    /// A single form factor to evaluate, relative to the receiving point, in multiples of a length of its own.
    Query {
        /// First corner.
        a: [f32; 3],
        /// Second corner.
        b: [f32; 3],
        /// Third corner.
        c: [f32; 3],
        /// Dipole strength alpha' / (4 pi).
        strength: f32,
        /// Effective transport coefficient.
        sigma: f32,
        /// Depth of the real source.
        z_real: f32,
        /// Height of the virtual source.
        z_virtual: f32,
    }
}

impl ListCounters {
    /// The counters at the start of a frame's lists: empty, and for the contrast of now.
    #[must_use]
    pub fn opened(&self) -> Self {
        Self { contrast: self.contrast, served: self.contrast, ..Self::default() }
    }

    /// Whether the frame's results are void.
    #[must_use]
    pub fn void(&self) -> bool {
        self.overflow != 0 || self.unfinished != 0
    }

    /// Whether the lists serve the light of now.
    #[must_use]
    pub fn serves(&self) -> bool {
        self.contrast == self.served
    }
}
