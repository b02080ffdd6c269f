//! What a block of a kernel does when it runs once, and what a kernel has done in all.

use std::collections::{BTreeMap, BTreeSet};

use super::code::Code;

/// What a block does when it runs once.
#[derive(Clone, Debug, Default, PartialEq)]
pub(in super::super) struct Block {
    /// Whether the kernel begins with it.
    pub(super) entry: bool,
    /// Additions and multiplications.
    pub(super) flops: u32,
    /// Divisions and square roots.
    pub(super) roots: u32,
    /// Exponentials and the like.
    pub(super) exps: u32,
    /// What it is made of; of the first block also what the module declares.
    pub(super) codes: BTreeSet<Code>,
    /// Bytes of buffers, by binding.
    pub(super) moved: BTreeMap<u32, Traffic>,
}

/// Bytes of one buffer that loads and stores name.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Traffic {
    /// Bytes that loads name.
    pub loaded: u64,
    /// Bytes that stores name.
    pub stored: u64,
}

impl Traffic {
    /// Adds `times` times another buffer's traffic, or the same buffer's in another block.
    pub(super) fn add(&mut self, times: u64, other: Self) {
        self.loaded += times * other.loaded;
        self.stored += times * other.stored;
    }
}

/// What a kernel has done.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tally {
    /// Invocations, whole groups.
    pub invocations: u64,
    /// Additions and multiplications of floats.
    pub flops: u64,
    /// Divisions and square roots.
    pub roots: u64,
    /// Exponentials, logarithms, circular functions.
    pub exps: u64,
    /// Bytes that loads and stores name, by binding.
    pub moved: BTreeMap<u32, Traffic>,
    /// What it is made of.
    pub listed: BTreeSet<Code>,
    /// What of that is in blocks that ran.
    pub executed: BTreeSet<Code>,
}

impl Tally {
    /// What the blocks have done together, each having run `counts` times.
    pub(in super::super) fn new(blocks: &[Block], counts: &[u64]) -> Self {
        let mut tally = Self::default();
        for (block, &count) in blocks.iter().zip(counts) {
            tally.invocations += if block.entry { count } else { 0 };
            tally.flops += count * u64::from(block.flops);
            tally.roots += count * u64::from(block.roots);
            tally.exps += count * u64::from(block.exps);
            tally.listed.extend(block.codes.iter().cloned());
            if count > 0 {
                tally.executed.extend(block.codes.iter().cloned());
            }
            for (&binding, &traffic) in &block.moved {
                tally.moved.entry(binding).or_default().add(count, traffic);
            }
        }
        tally
    }

    /// Adds what another kernel has done.
    pub fn add(&mut self, other: &Self) {
        self.invocations += other.invocations;
        self.flops += other.flops;
        self.roots += other.roots;
        self.exps += other.exps;
        self.listed.extend(other.listed.iter().cloned());
        self.executed.extend(other.executed.iter().cloned());
        for (&binding, &traffic) in &other.moved {
            self.moved.entry(binding).or_default().add(1, traffic);
        }
    }
}
