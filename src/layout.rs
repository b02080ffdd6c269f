//! The one source of truth for what lies in a buffer: every record, every buffer, its element and its binding.
//!
//! Rust takes its `#[repr(C)]` structs and the [`Buffers`] of a frame from here; the build script reads the same
//! tables and writes the GLSL structs and buffer declarations (`layout.glsl`), so that neither side can drift.
//! A test compares the offsets found in the compiled SPIR-V with those of the Rust structs.

#![allow(dead_code)] // the build script includes this file and uses half of it

use bytemuck::{Pod, Zeroable};

/// How four bytes are to be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Number {
    /// An IEEE 754 single.
    Float,
    /// An unsigned integer.
    Unsigned,
}

/// One four-byte word of an element: its path inside the element, and how to read it.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Word {
    /// `center.1`, `skip`; empty for a plain number.
    pub path: String,
    /// How to read it.
    pub number: Number,
}

/// Something a buffer can hold: its GLSL type, and its words in order.
pub trait Element: Pod {
    /// The GLSL name of the type.
    const GLSL: &'static str;
    /// The words of one element, in memory order, without padding.
    fn words() -> Vec<Word>;
}

macro_rules! plain {
    ($($kind:ty, $glsl:literal, $count:literal, $number:ident;)*) => { $(
        impl Element for $kind {
            const GLSL: &'static str = $glsl;
            fn words() -> Vec<Word> {
                let path = |i: usize| if $count == 1 { String::new() } else { i.to_string() };
                (0..$count).map(|i| Word { path: path(i), number: Number::$number }).collect()
            }
        }
    )* };
}

plain! {
    f32, "float", 1, Float;
    u32, "uint", 1, Unsigned;
    [f32; 3], "vec3", 3, Float;
    [f32; 4], "vec4", 4, Float;
    [u32; 3], "uvec3", 3, Unsigned;
}

/// A struct shared by host and device, as the build script and the layout test see it.
pub struct Record {
    /// Its name on both sides.
    pub name: &'static str,
    /// Field name, GLSL type, and the host's byte offset.
    pub fields: Vec<(&'static str, &'static str, usize)>,
    /// The host's size in bytes.
    pub size: usize,
}

macro_rules! records {
    ($($(#[doc = $about:literal])* $name:ident { $($(#[doc = $note:literal])* $field:ident: $kind:ty,)* })*) => {
        $(
            $(#[doc = $about])*
            #[repr(C)]
            #[derive(Clone, Copy, Debug, Default, PartialEq, Pod, Zeroable)]
            pub struct $name { $($(#[doc = $note])* pub $field: $kind,)* }

            impl Element for $name {
                const GLSL: &'static str = stringify!($name);
                fn words() -> Vec<Word> {
                    let mut words = Vec::new();
                    $(for word in <$kind as Element>::words() {
                        let dot = if word.path.is_empty() { "" } else { "." };
                        let path = format!("{}{dot}{}", stringify!($field), word.path);
                        words.push(Word { path, number: word.number });
                    })*
                    words
                }
            }
        )*
        /// Every record, in the order of declaration.
        pub fn records() -> Vec<Record> {
            vec![$(Record {
                name: stringify!($name),
                fields: vec![$((
                    stringify!($field),
                    <$kind as Element>::GLSL,
                    std::mem::offset_of!($name, $field),
                ),)*],
                size: size_of::<$name>(),
            },)*]
        }
    };
}

records! {
    /// What holds for the whole frame. Lengths are internal: the object has unit extent.
    Frame {
        /// Number of vertices.
        vertices: u32,
        /// Number of triangles.
        faces: u32,
        /// Number of nodes of the tree, 2 faces - 1.
        nodes: u32,
        /// Number of lights.
        lights: u32,
        /// Threshold epsilon_1 of section 5.2: largest deviation of the solid angle over a receiver, steradian.
        receiver_angle: f32,
        /// Threshold epsilon_2 of section 5.2: largest solid angle of an emitter, steradian.
        emitter_angle: f32,
        /// Square of the smallest planarity A'/A (section 5.1.1) of a cluster that may emit.
        planarity: f32,
        /// Room for links in one chunk.
        link_room: u32,
        /// Room for links whose form factor takes area points, in one chunk.
        area_room: u32,
        /// Room for links whose form factor takes the edge form, in one chunk.
        edge_room: u32,
        /// Room for emitters handed down from receiver to receiver.
        hand_room: u32,
        /// Dipole strength alpha' / (4 pi), per channel.
        strength: [f32; 3],
        /// Effective transport coefficient sigma_tr, per channel, 1/length.
        sigma: [f32; 3],
        /// Depth of the real source z_r, per channel.
        z_real: [f32; 3],
        /// Height of the virtual source z_v, per channel.
        z_virtual: [f32; 3],
        /// Relative index of refraction, per channel.
        eta: [f32; 3],
        /// chi below which 1 (with second moments), 3, 6 and 12 area points serve.
        ladder: [f32; 4],
    }
    /// A light. Directions point towards it.
    Light {
        /// 0 directional, 1 point.
        kind: u32,
        /// The unit direction towards the light, or its position.
        place: [f32; 3],
        /// Irradiance on a perpendicular plane, or intensity; scaled so that the brightest face is about 1.
        color: [f32; 3],
    }
    /// The camera: the ray through (x, y) in [-1,1]^2 runs along `forward + x right + y up`, not normalised.
    Camera {
        /// The eye.
        origin: [f32; 3],
        /// Half the picture's width at unit distance.
        right: [f32; 3],
        /// Half the picture's height at unit distance.
        up: [f32; 3],
        /// The unit viewing direction.
        forward: [f32; 3],
        /// Picture width in pixels.
        width: u32,
        /// Picture height in pixels.
        height: u32,
        /// Linear radiance where nothing is hit, in the scene's units.
        background: [f32; 3],
        /// What a radiance of the internal units has to be multiplied by.
        radiance: f32,
    }
    /// A node's place in the tree, stored depth first: the left child of `i` is `i + 1`.
    Topology {
        /// The first node after this subtree; also the right child of the parent's left child.
        skip: u32,
        /// The parent, or all ones at the root.
        parent: u32,
        /// The triangle of a leaf, or all ones.
        face: u32,
    }
    /// A node's bounding box.
    Bounds {
        /// Smallest corner.
        low: [f32; 3],
        /// Largest corner.
        high: [f32; 3],
    }
    /// A node as a cluster of faces.
    Cluster {
        /// Area-weighted centroid.
        center: [f32; 3],
        /// Total area A.
        area: f32,
        /// Vector area: the sum of A_k N_k; its length is the projected area A' of section 5.1.1.
        normal: [f32; 3],
        /// tau: trace of the second moment about the centroid, per area.
        spread: f32,
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
    /// How full the lists are, and how full they had to be.
    Cursor {
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
        need_links: u32,
        /// Largest count of links that take area points.
        need_areas: u32,
        /// Largest count of links that take the edge form.
        need_edges: u32,
        /// Largest count of handed-down emitters.
        need_hands: u32,
        /// Not 0 when a list did not fit: the results are void, and the frame must run again with more room.
        overflow: u32,
        /// Not 0 when a driver ended a loop early, or would: lavapipe does so after 65,535 iterations.
        unfinished: u32,
    }
    /// What a primary ray met.
    Hit {
        /// The triangle, or all ones.
        face: u32,
        /// Barycentric weight of the triangle's second corner.
        u: f32,
        /// Barycentric weight of the triangle's third corner.
        v: f32,
        /// Distance along the ray in multiples of its (unnormalised) direction.
        depth: f32,
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

/// What is known of a buffer without looking into it.
pub struct BufferSpec {
    /// Its name on both sides.
    pub name: &'static str,
    /// Of what there is one element each.
    pub per: &'static str,
    /// GLSL type of an element.
    pub glsl: &'static str,
    /// Bytes of an element.
    pub stride: usize,
    /// The words of an element.
    pub words: fn() -> Vec<Word>,
    /// Whether a dispatch binds only its chunk's part.
    pub chunked: bool,
}

macro_rules! chunked {
    (chunk) => {
        true
    };
    ($other:ident) => {
        false
    };
}

macro_rules! buffers {
    ($($(#[doc = $about:literal])* $name:ident: $kind:ty, $per:ident;)*) => {
        /// Every buffer of a frame, on the host.
        #[derive(Clone, Debug, Default)]
        pub struct Buffers { $($(#[doc = $about])* pub $name: Vec<$kind>,)* }

        /// The name of a buffer; its number is its binding in every shader.
        #[allow(non_camel_case_types)]
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
        #[repr(usize)]
        pub enum Slot { $($(#[doc = $about])* $name,)* }

        /// Every buffer's slot, in the order of their numbers.
        pub const SLOTS: &[Slot] = &[$(Slot::$name,)*];

        impl Slot {
            /// What is known of this buffer.
            pub fn spec(self) -> BufferSpec {
                match self { $(Slot::$name => BufferSpec {
                    name: stringify!($name),
                    per: stringify!($per),
                    glsl: <$kind as Element>::GLSL,
                    stride: size_of::<$kind>(),
                    words: <$kind as Element>::words,
                    chunked: chunked!($per),
                },)* }
            }
        }

        impl Buffers {
            /// The bytes of a buffer.
            pub fn bytes(&self, slot: Slot) -> &[u8] {
                match slot { $(Slot::$name => bytemuck::cast_slice(&self.$name),)* }
            }
            /// The bytes of a buffer, to be overwritten.
            pub fn bytes_mut(&mut self, slot: Slot) -> &mut [u8] {
                match slot { $(Slot::$name => bytemuck::cast_slice_mut(&mut self.$name),)* }
            }
        }
    };
}

buffers! {
    /// The numbers that hold for the whole frame; one element.
    frame: Frame, frame;
    /// The lights.
    lights: Light, light;
    /// The camera; one element.
    camera: Camera, frame;
    /// Vertex positions, centred and scaled to unit extent.
    positions: [f32; 3], vertex;
    /// Vertex indices of each triangle, in the order of the tree's leaves.
    triangles: [u32; 3], face;
    /// Where each vertex's entries in `corners` begin; one more at the end.
    corner_starts: u32, vertex;
    /// The triangles round each vertex.
    corners: u32, corner;
    /// The tree.
    topology: Topology, node;
    /// The leaf node of each triangle.
    leaves: u32, face;
    /// All nodes, sorted by chunk, then level, then index.
    order: u32, node;
    /// Bounding boxes.
    bounds: Bounds, node;
    /// Clusters.
    clusters: Cluster, node;
    /// Unit vertex normals, area-weighted.
    normals: [f32; 3], vertex;
    /// Irradiance that enters each triangle, E of equation 5.
    irradiance: [f32; 3], face;
    /// Area-weighted mean irradiance of each cluster.
    cluster_irradiance: [f32; 3], node;
    /// Squared centroid distances beyond which 1, 3, 6, 12 area points serve for a triangle.
    reach: [f32; 4], face;
    /// Each receiver's lists.
    spans: Span, node;
    /// Emitters that a receiver hands down to its children.
    handed: u32, hand;
    /// How full the lists are; one element.
    cursor: Cursor, frame;
    /// The links of a chunk, by receiver.
    links: Link, chunk;
    /// Form factor of each link, per channel.
    factors: [f32; 3], chunk;
    /// Indices of the links that take area points.
    area_links: u32, chunk;
    /// Indices of the links that take the edge form.
    edge_links: u32, chunk;
    /// Radiosity gathered at each node's own links.
    gathered: [f32; 3], node;
    /// Radiosity of each triangle, B of equation 4.
    radiosity: [f32; 3], face;
    /// Radiosity averaged at each vertex.
    vertex_radiosity: [f32; 3], vertex;
    /// What each pixel's ray met.
    hits: Hit, pixel;
    /// Linear radiance of each pixel.
    radiance: [f32; 3], pixel;
    /// Form factors to evaluate one by one.
    queries: Query, query;
    /// Their values: radial, then displaced sources (Table 1).
    answers: [f32; 3], query;
}
