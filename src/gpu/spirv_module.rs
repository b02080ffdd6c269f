//! A SPIR-V module as the words that it is made of: its header, its instructions, and what is inserted between them.

use spirq::spirv::{Capability, ExecutionMode, Op};

/// The first word of a module.
pub(super) const MAGIC: u32 = 0x0723_0203;
/// Words of a module's header.
pub(super) const HEADER_WORDS: usize = 5;
/// The word of the header that holds the bound: every id of the module is smaller.
pub(super) const BOUND: usize = 3;

/// An instruction of a module.
#[derive(Clone, Copy)]
pub(super) struct Instruction<'a> {
    /// What it does; none for an instruction that is newer than the enumeration.
    pub(super) op: Option<Op>,
    /// The words after the first one: ids and literals.
    pub(super) operands: &'a [u32],
    /// All its words; the first one holds its length and its opcode.
    pub(super) words: &'a [u32],
    /// The index of its first word in the module.
    pub(super) start: usize,
}

/// The instructions of a module, in their order.
pub(super) fn instructions(module: &[u32]) -> impl Iterator<Item = Instruction<'_>> {
    let mut start = HEADER_WORDS;
    std::iter::from_fn(move || {
        let rest = module.get(start..)?;
        let first = *rest.first()?;
        let length = ((first >> 16).max(1) as usize).min(rest.len());
        let words = &rest[..length];
        let instruction = Instruction { op: Op::from_u32(first & 0xffff), operands: &words[1..], words, start };
        start += length;
        Some(instruction)
    })
}

/// Whether a module has a header and its instructions end where it ends.
pub(super) fn whole(module: &[u32]) -> bool {
    let mut at = HEADER_WORDS;
    while let Some(first) = module.get(at) {
        at += (first >> 16).max(1) as usize;
    }
    at == module.len() && at > HEADER_WORDS
}

/// Appends an instruction to a module.
pub(super) fn append(module: &mut Vec<u32>, op: Op, operands: &[u32]) {
    module.push(((operands.len() as u32 + 1) << 16) | op as u32);
    module.extend(operands);
}

/// The module with a request that additions, multiplications and the like of 32-bit floats round to nearest: a
/// capability after the header, and an execution mode before the first one. A module without execution modes, which no
/// compute kernel is, stays as it is.
pub(super) fn round_to_nearest(module: Vec<u32>) -> Vec<u32> {
    let mut entry = 0;
    for instruction in instructions(&module) {
        match (instruction.op, instruction.operands) {
            (Some(Op::EntryPoint), [_, function, ..]) => entry = *function,
            (Some(Op::ExecutionMode), _) => {
                let (header, rest) = module.split_at(HEADER_WORDS);
                let (before, after) = rest.split_at(instruction.start - HEADER_WORDS);
                let mut out = header.to_vec();
                append(&mut out, Op::Capability, &[Capability::RoundingModeRTE as u32]);
                out.extend(before);
                append(&mut out, Op::ExecutionMode, &[entry, ExecutionMode::RoundingModeRTE as u32, 32]);
                out.extend(after);
                return out;
            }
            _ => {}
        }
    }
    module
}

/// The module without that request: one that was written down for another device has it already.
pub(super) fn without_rounding(module: &[u32]) -> Vec<u32> {
    let mut out = module.get(..HEADER_WORDS).unwrap_or(module).to_vec();
    for instruction in instructions(module) {
        match (instruction.op, instruction.operands) {
            (Some(Op::Capability), [what]) if *what == Capability::RoundingModeRTE as u32 => {}
            (Some(Op::ExecutionMode), [_, what, 32]) if *what == ExecutionMode::RoundingModeRTE as u32 => {}
            _ => out.extend(instruction.words),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_request_to_round_comes_after_the_header_and_before_the_first_mode() {
        let mut module = vec![0; HEADER_WORDS];
        append(&mut module, Op::EntryPoint, &[5, 7, 0]);
        append(&mut module, Op::ExecutionMode, &[7, ExecutionMode::LocalSize as u32, 64, 1, 1]);
        let rounding = round_to_nearest(module.clone());
        let ops: Vec<_> = instructions(&rounding).map(|instruction| instruction.op.unwrap()).collect();
        assert_eq!(ops, [Op::Capability, Op::EntryPoint, Op::ExecutionMode, Op::ExecutionMode]);
        let modes: Vec<_> = instructions(&rounding).skip(2).map(|mode| mode.operands[..2].to_vec()).collect();
        assert_eq!(modes, [[7, ExecutionMode::RoundingModeRTE as u32], [7, ExecutionMode::LocalSize as u32]]);
        assert_eq!(round_to_nearest(vec![0; HEADER_WORDS]), [0; HEADER_WORDS]);
        assert_eq!(without_rounding(&rounding), module);
        assert_eq!(without_rounding(&module), module);
    }

    #[test]
    fn a_length_beyond_the_end_ends_the_module() {
        let module = [0, 0, 0, 0, 0, (9 << 16) | Op::Label as u32, 1];
        let found: Vec<_> = instructions(&module).map(|instruction| instruction.operands.len()).collect();
        assert_eq!(found, [1]);
    }
}
