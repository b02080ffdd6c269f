//! The one source of truth for what host and device share: every record, every buffer with its element and binding, and
//! every constant that both sides use.
//!
//! Rust takes its `#[repr(C)]` structs, the [`Buffers`] of a frame and the constants from here. The build script reads
//! the same tables and writes `layout.glsl`, which every shader includes, so that neither side can drift from the
//! other. A test compares the offsets found in the compiled SPIR-V with those of the Rust structs.

#![allow(dead_code)] // the build script includes this file and uses half of it

use bytemuck::Pod;

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
    [f32; 2], "vec2", 2, Float;
    [f32; 3], "vec3", 3, Float;
    [f32; 4], "vec4", 4, Float;
    [u32; 2], "uvec2", 2, Unsigned;
    [u32; 3], "uvec3", 3, Unsigned;
    [u32; 8], "uint[8]", 8, Unsigned;
    [u32; 16], "uint[16]", 16, Unsigned;
    [u32; 20], "uint[20]", 20, Unsigned;
    [u32; 32], "uint[32]", 32, Unsigned;
}

// A device may require that offsets of bound parts are multiples of up to 256 bytes.
const _: () = assert!(size_of::<ObjectParams>().is_multiple_of(256) && size_of::<ListCounters>().is_multiple_of(256));
const _: () = assert!(size_of::<WalkParams>().is_multiple_of(256));

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
    (
        $list:ident:
        $($(#[doc = $about:literal])* $name:ident { $($(#[doc = $note:literal])* $field:ident: $kind:ty,)* })*
    ) => {
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
        /// Every record of this file, in the order of declaration.
        pub fn $list() -> Vec<Record> {
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

/// What is known of a buffer but its content.
pub struct BufferSpec {
    /// Its name on both sides.
    pub name: &'static str,
    /// What each element belongs to: `face`, `pixel`.
    pub per: &'static str,
    /// GLSL type of an element.
    pub glsl: &'static str,
    /// Bytes of an element.
    pub stride: usize,
    /// The words of an element.
    pub words: fn() -> Vec<Word>,
    /// The parts that it is divided into; a dispatch binds one.
    pub partition: Partition,
}

/// The parts that a buffer is divided into.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Partition {
    /// It is bound whole.
    Whole,
    /// One element an object.
    Object,
    /// A run of elements an object: one a vertex.
    Vertex,
    /// One a vertex, and one more.
    Start,
    /// One a triangle.
    Face,
    /// Three a triangle.
    Corner,
    /// `object_params.shadow_words` a triangle.
    Shadow,
    /// One a node of its tree.
    Node,
    /// One a block of receivers.
    Block,
    /// One a receiver.
    Receiver,
    /// The vectors of a Krylov space, each one element a triangle.
    Vectors,
    /// `SMALL_SYSTEM` an object.
    Small,
    /// One part a chunk of the tree, where links are kept.
    Chunk,
    /// One part a group of channels.
    Group,
    /// One part a batch of blocks and group of channels, where lists are kept.
    Batch,
}

macro_rules! partition {
    (object) => {
        Partition::Object
    };
    (vertex) => {
        Partition::Vertex
    };
    (start) => {
        Partition::Start
    };
    (face) => {
        Partition::Face
    };
    (corner) => {
        Partition::Corner
    };
    (shadow) => {
        Partition::Shadow
    };
    (node) => {
        Partition::Node
    };
    (block) => {
        Partition::Block
    };
    (receiver) => {
        Partition::Receiver
    };
    (vectors) => {
        Partition::Vectors
    };
    (small) => {
        Partition::Small
    };
    (chunk) => {
        Partition::Chunk
    };
    (group) => {
        Partition::Group
    };
    (batch) => {
        Partition::Batch
    };
    ($other:ident) => {
        Partition::Whole
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
        pub enum BufferId { $($(#[doc = $about])* $name,)* }

        /// Every buffer id, in the order of their numbers.
        pub const BUFFER_IDS: &[BufferId] = &[$(BufferId::$name,)*];

        impl BufferId {
            /// What is known of this buffer but its content.
            pub fn spec(self) -> BufferSpec {
                match self { $(BufferId::$name => BufferSpec {
                    name: stringify!($name),
                    per: stringify!($per),
                    glsl: <$kind as Element>::GLSL,
                    stride: size_of::<$kind>(),
                    words: <$kind as Element>::words,
                    partition: partition!($per),
                },)* }
            }
        }

        impl Buffers {
            /// The bytes of a buffer.
            pub fn bytes(&self, id: BufferId) -> &[u8] {
                match id { $(BufferId::$name => bytemuck::cast_slice(&self.$name),)* }
            }
            /// Makes a buffer this many elements long, with zeros where it grows.
            pub fn resize(&mut self, id: BufferId, elements: usize) {
                match id { $(BufferId::$name => self.$name.resize(elements, <$kind as bytemuck::Zeroable>::zeroed()),)* }
            }
            /// Makes a buffer this many elements long, all zeros. Memory that nobody touches costs nothing.
            pub fn clear(&mut self, id: BufferId, elements: usize) {
                match id { $(BufferId::$name => self.$name = bytemuck::allocation::zeroed_vec(elements),)* }
            }
            /// The bytes of a buffer, to be overwritten.
            pub fn bytes_mut(&mut self, id: BufferId) -> &mut [u8] {
                match id { $(BufferId::$name => bytemuck::cast_slice_mut(&mut self.$name),)* }
            }
        }
    };
}

#[macro_use]
mod constants;
mod buffers;
mod deform;
mod diffusion;
mod glsl;
mod kinds;
mod layers;
mod lighting;
mod lists;
mod numbers;
mod placed;
mod records;
mod shading;
mod view;
mod walk;

pub use self::{layers::*, lighting::*, shading::*, view::*};
pub use buffers::*;
pub use constants::{Constant, Shared};
pub use deform::*;
pub use diffusion::*;
pub use glsl::declarations;
pub use kinds::*;
pub use lists::*;
pub use numbers::*;
pub use records::*;
pub use walk::*;

/// Every record.
pub fn records() -> Vec<Record> {
    let lists = [frame_records(), list_records(), local_records(), light_records(), view_records(), layer_records()];
    lists.into_iter().chain([walk_records(), diffusion_records(), deform_records()]).flatten().collect()
}
