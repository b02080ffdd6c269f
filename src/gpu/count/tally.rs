//! What a block of a kernel does when it runs once, and what a kernel has done in all.

use std::collections::{BTreeMap, BTreeSet};

use super::code::Code;

/// What a block does when it runs once.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Block {
    /// Whether the kernel begins with it.
    pub(super) entry: bool,
    /// Additions and multiplications.
    pub(super) flops: u32,
    /// Divisions and square roots.
    pub(super) roots: u32,
    /// Exponentials and the like.
    pub(super) exps: u32,
    /// Instructions that a processor issues, as [`Module`](super::read::Module) estimates them.
    pub(super) instructions: u32,
    /// Those of them that compute no float.
    pub(super) others: u32,
    /// What an invocation goes through one after the other, in the order of [`Chain`].
    pub(super) chain: [u32; CHAIN],
    /// What it is made of; of the first block also what the module declares.
    pub(super) codes: BTreeSet<Code>,
    /// Bytes of buffers, by binding.
    pub(super) moved: BTreeMap<u32, Traffic>,
    /// Words of shared memory that are loaded and stored.
    pub(super) shared: u32,
    /// Operations that read a word of a buffer and write it in one step.
    pub(super) atomics: u32,
}

impl Block {
    /// The float operations of all kinds.
    pub(super) fn floats(&self) -> u32 {
        self.flops + self.roots + self.exps
    }
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

/// Numbers of a [`Chain`].
pub(super) const CHAIN: usize = 3;

/// What an invocation goes through one after the other.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Chain {
    /// Instructions one of which needs the one before it; or half of those that it issues, if that is more: two that do
    /// not need one another take as long as one that does.
    pub steps: u64,
    /// Loads of buffers, one of which needs the one before it.
    pub loads: u64,
    /// Likewise loads of shared memory, and barriers and exchanges within a group.
    pub shared: u64,
}

impl Chain {
    /// From its numbers, in their order.
    fn of([steps, loads, shared]: [u32; CHAIN]) -> Self {
        Self { steps: steps.into(), loads: loads.into(), shared: shared.into() }
    }

    /// Adds what comes `times` times.
    fn add(&mut self, times: u64, other: Self) {
        self.steps += times * other.steps;
        self.loads += times * other.loads;
        self.shared += times * other.shared;
    }
}

/// What a kernel has done.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tally {
    /// Its dispatches.
    pub dispatches: u64,
    /// Invocations, whole groups.
    pub invocations: u64,
    /// Additions and multiplications of floats.
    pub flops: u64,
    /// Divisions and square roots.
    pub roots: u64,
    /// Exponentials, logarithms, circular functions.
    pub exps: u64,
    /// Instructions that all invocations issue, estimated: one a number of arithmetic, eight a root, quotient or
    /// exponential, one for 16 bytes of a load or store.
    pub instructions: u64,
    /// Those of them that compute no float.
    pub others: u64,
    /// Instructions that all subgroups issue, each once for those of its invocations that run it.
    pub issued: u64,
    /// Subgroups.
    pub subgroups: u64,
    /// Words of shared memory that are loaded and stored.
    pub shared: u64,
    /// Operations that read a word of a buffer and write it in one step.
    pub atomics: u64,
    /// What all invocations go through, together.
    pub chains: Chain,
    /// The most of each that one invocation goes through; of several dispatches, one after the other, the sum.
    pub longest: Chain,
    /// Bytes that loads and stores name, by binding.
    pub moved: BTreeMap<u32, Traffic>,
    /// What it is made of.
    pub listed: BTreeSet<Code>,
    /// What of that is in blocks that ran.
    pub executed: BTreeSet<Code>,
}

impl Tally {
    /// What the blocks have done together in a dispatch, from its [`counters`](super::Counted::counters).
    pub(crate) fn new(blocks: &[Block], counters: &[u32]) -> Self {
        let (counts, ends) = counters.split_at(2 * blocks.len());
        let number = |both: &[u32]| u64::from(both[1]) << 32 | u64::from(both[0]);
        let (longest, [issued, subgroups]) =
            (Chain::of([ends[0], ends[1], ends[2]]), [0, 2].map(|k| number(&ends[CHAIN + k..])));
        let mut tally = Self { dispatches: 1, longest, issued, subgroups, ..Self::default() };
        for (block, count) in blocks.iter().zip(counts.chunks(2).map(number)) {
            tally.invocations += if block.entry { count } else { 0 };
            tally.flops += count * u64::from(block.flops);
            tally.roots += count * u64::from(block.roots);
            tally.exps += count * u64::from(block.exps);
            tally.instructions += count * u64::from(block.instructions);
            tally.others += count * u64::from(block.others);
            tally.shared += count * u64::from(block.shared);
            tally.atomics += count * u64::from(block.atomics);
            tally.chains.add(count, Chain::of(block.chain));
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

    /// So many further dispatches have counted here, none of which has a longer chain.
    pub(in super::super) fn repeat(&mut self, further: u64) {
        self.dispatches += further;
        self.longest.add(further, self.longest);
    }

    /// Adds what another dispatch has done.
    pub fn add(&mut self, other: &Self) {
        self.dispatches += other.dispatches;
        self.invocations += other.invocations;
        self.flops += other.flops;
        self.roots += other.roots;
        self.exps += other.exps;
        self.instructions += other.instructions;
        self.others += other.others;
        self.issued += other.issued;
        self.subgroups += other.subgroups;
        self.shared += other.shared;
        self.atomics += other.atomics;
        self.chains.add(1, other.chains);
        self.longest.add(1, other.longest);
        self.listed.extend(other.listed.iter().cloned());
        self.executed.extend(other.executed.iter().cloned());
        for (&binding, &traffic) in &other.moved {
            self.moved.entry(binding).or_default().add(1, traffic);
        }
    }
}
