//! What a kernel really does: its SPIR-V is rewritten so that every basic block counts how often it runs, and what a
//! block does when it runs once is read from its instructions.
//!
//! Additions, subtractions and multiplications of floats count one per component, a fused multiply-add two. Divisions
//! and square roots are counted separately, and so are exponentials, logarithms and circular functions. Integers,
//! comparisons, minima, maxima and conversions count as instructions only. Loads and stores count the bytes of buffers
//! and the words of shared memory that they name, atomic operations also themselves. The kinds of instructions of each
//! block are noted, too, so that coverage knows which were executed.
//!
//! Each invocation also adds up what it goes through one after the other, instructions and loads, whatever they work
//! on. The most of each, over the invocations of a dispatch, say about how long that takes, however wide the device is.
//! One invocation of those that a subgroup has in a block also adds up what the subgroup issues there, once for all of
//! them: that is what a device with vectors pays for.

mod code;
mod read;
mod tally;
#[cfg(feature = "measure")]
mod touch;
mod write;

use std::collections::BTreeSet;

use spirq::spirv::Op;

use super::spirv_module::{Edited, instructions};
use read::{Chains, Module};
use write::Counters;

pub use code::Code;
pub(crate) use tally::Block;
use tally::CHAIN;
pub use tally::{Chain, Tally, Traffic};
#[cfg(feature = "measure")]
pub(crate) use touch::touching;
pub(crate) use write::BINDING;

/// A kernel that counts.
pub(crate) struct Counted {
    /// Its SPIR-V.
    pub(crate) words: Vec<u32>,
    /// Its blocks that count, in the order of their counters.
    pub(crate) blocks: Vec<Block>,
}

impl Counted {
    /// Words of a dispatch's counters: two a block, the lower one first, those of the longest [`Chain`], and two each
    /// of what subgroups issue and of how many there are.
    pub(crate) fn counters(blocks: &[Block]) -> usize {
        2 * blocks.len() + CHAIN + 4
    }
}

/// The kernel with counters at [`BINDING`]; none where the SPIR-V is not of the kind that the build makes.
pub(crate) fn counted(words: &[u32]) -> Option<Counted> {
    let module = Module::of(words);
    let blocks = blocks(&module, words);
    let mut out = Edited::begin(words)?;
    let longest = 2 * blocks.len() as u32;
    let most = blocks.iter().flat_map(|block| [block.instructions].into_iter().chain(block.chain)).max().unwrap_or(0);
    let counters = Counters::declare(&mut out, &module.declared, most.max(longest + CHAIN as u32 + 3), true);
    let (mut waiting, mut numbered, mut function) = (None::<(&Block, u32)>, blocks.iter().zip(0..), 0);
    let words = out.finish(words, |out, instruction| {
        // Counting comes after the phis and variables of a block.
        if !matches!(instruction.op, Some(Op::Line | Op::NoLine | Op::Phi | Op::Variable))
            && let Some((block, number)) = waiting.take()
        {
            counters.count(out, number);
            counters.add(out, block.chain);
            counters.issue(out, block.instructions, block.entry);
        }
        match (instruction.op, instruction.operands) {
            (Some(Op::Function), [_, id, ..]) => function = *id,
            (Some(Op::Label), _) => waiting = Some(numbered.next()?),
            (Some(Op::Return), _) if function == module.declared.entry => counters.end(out, longest),
            _ => {}
        }
        counters.keep(out, instruction);
        Some(())
    })?;
    Some(Counted { words, blocks })
}

/// What each block of a module does when it runs once, in their order.
fn blocks(module: &Module<'_>, words: &[u32]) -> Vec<Block> {
    let (mut all, mut function, mut chains) = (Vec::<Block>::new(), 0, Chains::default());
    let declared: BTreeSet<Code> = instructions(words).filter_map(Code::declared).collect();
    for instruction in instructions(words) {
        match (instruction.op, instruction.operands) {
            (Some(Op::Function), [_, id, ..]) => function = *id,
            (Some(Op::Label), _) => {
                let entry = function == module.declared.entry && !all.iter().any(|block| block.entry);
                // What a module declares is used once the kernel begins.
                let codes = if entry { declared.clone() } else { BTreeSet::new() };
                all.push(Block { entry, codes, ..Block::default() });
                chains = Chains::default();
            }
            _ => {
                if let Some(block) = all.last_mut() {
                    let before = (block.floats(), block.instructions);
                    module.add(block, instruction);
                    module.chain(block, instruction, &mut chains);
                    if block.floats() == before.0 {
                        block.others += block.instructions - before.1;
                    }
                }
            }
        }
    }
    for block in &mut all {
        block.chain[0] = block.chain[0].max(block.instructions.div_ceil(2));
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::reflect::words_of;

    #[test]
    fn a_fused_multiply_add_is_two_operations_and_one_instruction() {
        let counted = counted(&words_of("measure/fma").unwrap()).unwrap();
        let block = counted.blocks.iter().max_by_key(|block| block.flops).unwrap();
        assert!(block.flops > 10 && block.instructions < block.flops, "{block:?}");
    }
}
