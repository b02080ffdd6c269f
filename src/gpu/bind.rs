//! What is bound to a kernel.

use super::memory::Buffer;

/// A range of a buffer, and the binding number that it is bound to.
#[derive(Clone, Copy)]
pub struct Binding<'a> {
    /// The binding number.
    pub number: u32,
    /// The buffer.
    pub buffer: &'a Buffer,
    /// First byte bound.
    pub offset: u64,
    /// Number of bytes bound.
    pub size: u64,
}
