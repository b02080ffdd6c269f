//! What a kernel really does: its SPIR-V is rewritten so that every basic block counts how often it runs, and what a
//! block does when it runs once is read from its instructions.
//!
//! Additions, subtractions and multiplications of floats count one per component, a fused multiply-add two. Divisions
//! and square roots are counted separately, and so are exponentials, logarithms and circular functions. Integers,
//! comparisons, minima, maxima and conversions are not counted. Loads and stores count the bytes of buffers that they
//! name. Every instruction is noted, too, so that coverage knows which were executed.

mod code;
mod read;
mod tally;
#[cfg(feature = "measure")]
mod touch;
mod write;

use std::collections::BTreeSet;

use spirq::spirv::Op;

use super::spirv_module::{Edited, instructions};
use read::Module;
use write::Counters;

pub use code::Code;
pub(super) use tally::Block;
pub use tally::{Tally, Traffic};
#[cfg(feature = "measure")]
pub(crate) use touch::touching;
pub(crate) use write::BINDING;

/// A kernel that counts.
pub(super) struct Counted {
    /// Its SPIR-V.
    pub(super) words: Vec<u32>,
    /// Its blocks that count, in the order of their counters.
    pub(super) blocks: Vec<Block>,
}

/// The kernel with counters at [`BINDING`]; none where the SPIR-V is not of the kind that the build makes.
pub(super) fn counted(words: &[u32]) -> Option<Counted> {
    // What each block does.
    let module = Module::of(words);
    let (mut all, mut function) = (Vec::<Block>::new(), 0);
    let declared: BTreeSet<Code> = instructions(words).filter_map(Code::declared).collect();
    for instruction in instructions(words) {
        match (instruction.op, instruction.operands) {
            (Some(Op::Function), [_, id, ..]) => function = *id,
            (Some(Op::Label), _) => {
                let entry = function == module.declared.entry && !all.iter().any(|block| block.entry);
                // What a module declares is used once the kernel begins.
                let codes = if entry { declared.clone() } else { BTreeSet::new() };
                all.push(Block { entry, codes, ..Block::default() });
            }
            _ => all.last_mut().into_iter().for_each(|block| module.add(block, instruction)),
        }
    }

    // Counters for those that do something.
    let blocks: Vec<Block> = all.iter().filter(|block| **block != Block::default()).cloned().collect();
    let mut out = Edited::begin(words)?;
    let counters = Counters::declare(&mut out, &module.declared, blocks.len() as u32);
    let (mut waiting, mut all, mut number) = (None, all.iter(), 0..);
    let words = out.finish(words, |out, instruction| {
        // Counting comes after the phis and variables of a block.
        if !matches!(instruction.op, Some(Op::Line | Op::NoLine | Op::Phi | Op::Variable)) {
            waiting.take().into_iter().for_each(|counter| counters.count(out, counter));
        }
        counters.keep(out, instruction);
        if instruction.op == Some(Op::Label) && *all.next()? != Block::default() {
            waiting = number.next();
        }
        Some(())
    })?;
    Some(Counted { words, blocks })
}
