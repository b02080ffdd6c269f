//! The memory that kernels run on: buffers, of which a dispatch binds parts.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU32, Ordering};

/// The word that stands for what a stage has yet to write: NaN as a float, far beyond any index as an integer.
pub const POISON: u32 = 0xffc0_dead;
/// The word of a variable of an invocation that nothing has written; it is NaN, too.
pub(super) const UNDEFINED: u32 = 0xffc0_def0;
/// The word of a group's memory that nothing has written.
pub(super) const UNDEFINED_SHARED: u32 = 0xffc0_def1;

/// Whether a word stands for no value.
pub(super) fn is_undefined(value: u32) -> bool {
    matches!(value, POISON | UNDEFINED | UNDEFINED_SHARED)
}

/// A buffer: words that invocations of different groups may access at once.
pub struct Memory {
    words: Vec<AtomicU32>,
}

/// A part of a buffer, as it is bound.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Part {
    /// The buffer: its place in the list.
    pub memory: usize,
    /// The first word.
    pub first: usize,
    /// How many words.
    pub count: usize,
}

/// A dispatch of a kernel.
#[derive(Clone, Copy)]
pub struct Launched<'a> {
    /// Groups in each dimension.
    pub groups: [u32; 3],
    /// Push constants.
    pub push: &'a [u8],
    /// What is bound, by binding.
    pub bound: &'a BTreeMap<u32, Part>,
    /// The buffers.
    pub memory: &'a [&'a Memory],
    /// Invocations of a subgroup.
    pub subgroup: u32,
    /// Most blocks that a group runs, [`MOST_BLOCKS`](super::MOST_BLOCKS): a kernel that takes more is said not to end.
    pub most_blocks: u64,
}

impl Memory {
    /// A copy of these bytes, the last word filled up with zeros.
    #[must_use]
    pub fn of(bytes: &[u8]) -> Self {
        let word = |bytes: &[u8]| bytes.iter().rev().fold(0, |word, byte| word << 8 | u32::from(*byte));
        Self { words: bytes.chunks(4).map(|bytes| AtomicU32::new(word(bytes))).collect() }
    }

    /// Copies the words to these bytes.
    pub fn write(&self, bytes: &mut [u8]) {
        for (word, bytes) in self.words.iter().zip(bytes.chunks_mut(4)) {
            bytes.copy_from_slice(&word.load(Ordering::Relaxed).to_le_bytes()[..bytes.len()]);
        }
    }

    /// How many words it has.
    pub(super) fn len(&self) -> usize {
        self.words.len()
    }

    /// A word.
    #[must_use]
    pub fn get(&self, word: usize) -> u32 {
        self.words[word].load(Ordering::Relaxed)
    }

    /// A word as a float; none beyond the end.
    pub(super) fn float(&self, word: usize) -> Option<f32> {
        self.words.get(word).map(|word| f32::from_bits(word.load(Ordering::Relaxed)))
    }

    pub(super) fn set(&self, word: usize, value: u32) {
        self.words[word].store(value, Ordering::Relaxed);
    }

    /// Has a word changed by this function, in one step; returns the old word.
    pub(super) fn change(&self, word: usize, new: impl Fn(u32) -> u32) -> u32 {
        let changed = self.words[word].fetch_update(Ordering::Relaxed, Ordering::Relaxed, |old| Some(new(old)));
        changed.unwrap_or_else(|old| old)
    }
}
