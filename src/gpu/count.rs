//! What a kernel really does: its SPIR-V is rewritten so that each block counts how often it runs, and what a block does
//! once is read off its instructions.
//!
//! Additions, subtractions and multiplications of floats count one a component, a fused multiplication and addition two;
//! divisions and square roots are counted apart, and so are exponentials, logarithms and circular functions. Integers,
//! comparisons, minima, maxima and conversions are not counted. Loads and stores count the bytes of buffers that they name.

mod read;
mod write;

use std::collections::BTreeMap;

use read::Ids;
use write::Rewriter;

/// The binding of the counters, beyond every buffer of a frame.
pub(super) const BINDING: u32 = 200;
/// SPIR-V's storage class of buffers.
const STORAGE_BUFFER: u32 = 12;

/// What a block does when it runs once.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Block {
    /// Whether the kernel begins with it.
    entry: bool,
    /// Additions and multiplications.
    flops: u32,
    /// Divisions and square roots.
    roots: u32,
    /// Exponentials and the like.
    exps: u32,
    /// Bytes read and written, by binding.
    moved: BTreeMap<u32, [u32; 2]>,
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
    /// Bytes that loads and stores name, by binding: read, written.
    pub moved: BTreeMap<u32, [u64; 2]>,
}

impl Tally {
    pub(super) fn new(blocks: &[Block], counts: &[u64]) -> Self {
        let mut tally = Self::default();
        for (block, &count) in blocks.iter().zip(counts) {
            tally.invocations += if block.entry { count } else { 0 };
            tally.flops += count * u64::from(block.flops);
            tally.roots += count * u64::from(block.roots);
            tally.exps += count * u64::from(block.exps);
            for (&binding, moved) in &block.moved {
                let sum = tally.moved.entry(binding).or_default();
                (sum[0], sum[1]) = (sum[0] + count * u64::from(moved[0]), sum[1] + count * u64::from(moved[1]));
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
        for (&binding, moved) in &other.moved {
            let sum = self.moved.entry(binding).or_default();
            (sum[0], sum[1]) = (sum[0] + moved[0], sum[1] + moved[1]);
        }
    }
}

/// A kernel that counts.
pub(super) struct Counted {
    pub(super) words: Vec<u32>,
    /// Its blocks that count, in the order of their counters.
    pub(super) blocks: Vec<Block>,
}

/// The instructions of a module: opcode and operands.
fn instructions(words: &[u32]) -> impl Iterator<Item = (u32, &[u32])> {
    let mut rest = words.get(5..).unwrap_or_default();
    std::iter::from_fn(move || {
        let length = (rest.first()? >> 16).max(1) as usize;
        let (one, after) = rest.split_at(length.min(rest.len()));
        rest = after;
        Some((one[0] & 0xffff, &one[1..]))
    })
}

/// The kernel with counters at [`BINDING`]; none where the SPIR-V is not of the kind that the build makes.
pub(super) fn counted(words: &[u32]) -> Option<Counted> {
    let (mut ids, mut all, mut function) = (Ids::default(), Vec::<Block>::new(), 0);
    for (op, of) in instructions(words) {
        ids.learn(op, of);
        match (op, of) {
            (54, [_, id, ..]) => function = *id,
            (248, _) => {
                let first = function == ids.entry && !all.iter().any(|block| block.entry);
                all.push(Block { entry: first, ..Block::default() });
            }
            _ => {
                if let Some(block) = all.last_mut() {
                    ids.add(block, op, of);
                }
            }
        }
    }
    let counts: Vec<bool> = all.iter().map(|block| *block != Block::default()).collect();
    let mut out = Rewriter::new(words, &ids)?;
    let (mut next, mut waiting, mut number) = (0, None, 0);
    let mut blocks = Vec::new();
    for (op, of) in instructions(words) {
        // Counting comes after the phis and variables of a block.
        if let Some(number) = waiting
            && !matches!(op, 8 | 245 | 59 | 317)
        {
            out.count(number);
            waiting = None;
        }
        out.pass(op, of, counts.iter().filter(|counts| **counts).count() as u32);
        if op == 248 {
            if counts[number] {
                (waiting, next) = (Some(next), next + 1);
                blocks.push(all[number].clone());
            }
            number += 1;
        }
    }
    Some(Counted { words: out.finish(), blocks })
}
