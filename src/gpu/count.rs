//! What a kernel really does: its SPIR-V is rewritten so that every basic block counts how often it runs, and what a
//! block does when it runs once is read from its instructions.
//!
//! Additions, subtractions and multiplications of floats count one per component, a fused multiply-add two. Divisions
//! and square roots are counted separately, and so are exponentials, logarithms and circular functions. Integers,
//! comparisons, minima, maxima and conversions are not counted. Loads and stores count the bytes of buffers that they
//! name.

mod read;
mod tally;
#[cfg(feature = "measure")]
mod touch;
mod write;

use spirq::spirv::Op;

use super::spirv_module::instructions;
use read::Module;
use write::Rewriter;

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
    let (mut module, mut all, mut function) = (Module::default(), Vec::<Block>::new(), 0);
    for instruction in instructions(words) {
        module.declare(instruction);
        match (instruction.op, instruction.operands) {
            (Some(Op::Function), [_, id, ..]) => function = *id,
            (Some(Op::Label), _) => {
                let entry = function == module.entry && !all.iter().any(|block| block.entry);
                all.push(Block { entry, ..Block::default() });
            }
            _ => {
                if let Some(block) = all.last_mut() {
                    module.add(block, instruction);
                }
            }
        }
    }

    // Counters for those that do something.
    let counts: Vec<bool> = all.iter().map(|block| *block != Block::default()).collect();
    let counters = counts.iter().filter(|counts| **counts).count() as u32;
    let mut out = Rewriter::new(words, &module, counters)?;
    let (mut waiting, mut number) = (None, 0);
    let mut blocks = Vec::new();
    for instruction in instructions(words) {
        // Counting comes after the phis and variables of a block.
        if let Some(counter) = waiting
            && !matches!(instruction.op, Some(Op::Line | Op::NoLine | Op::Phi | Op::Variable))
        {
            out.count(counter);
            waiting = None;
        }
        out.pass(instruction);
        if instruction.op == Some(Op::Label) {
            if counts[number] {
                waiting = Some(blocks.len() as u32);
                blocks.push(all[number].clone());
            }
            number += 1;
        }
    }
    Some(Counted { words: out.finish(), blocks })
}
