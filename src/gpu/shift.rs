//! A copy of a SPIR-V module whose groups count from another one than 0.

use spirq::spirv::{BuiltIn, Decoration, Op};

use super::spirv_module::{BOUND, HEADER_WORDS, append, instructions};

/// The module with this many added to the number of the group, across; none where it takes that number in a way that
/// kernels of the build do not.
pub(crate) fn shifted(words: &[u32], by: u32) -> Option<Vec<u32>> {
    let (mut variables, mut pointers, mut uint) = (Vec::new(), Vec::new(), None);
    let mut constants = std::collections::BTreeMap::new();
    for instruction in instructions(words) {
        match (instruction.op, instruction.operands) {
            (Some(Op::Decorate), [id, what, builtin]) if *what == Decoration::BuiltIn as u32 => {
                if *builtin == BuiltIn::GlobalInvocationId as u32 {
                    return None;
                }
                variables.extend((*builtin == BuiltIn::WorkgroupId as u32).then_some(*id));
            }
            (Some(Op::TypeInt), [id, 32, 0]) => uint = Some(*id),
            (Some(Op::Constant), [_, id, value]) => drop(constants.insert(*id, *value)),
            // The number across.
            (Some(Op::AccessChain), [_, id, base, index]) if variables.contains(base) => {
                pointers.extend((constants.get(index)? == &0).then_some(*id));
            }
            (Some(Op::Load), [_, _, pointer, ..]) if variables.contains(pointer) => return None,
            _ => {}
        }
    }
    let (uint, first) = (uint?, *words.get(BOUND)?);
    let (mut bound, mut declared) = (first + 1, false);
    let mut out = words.get(..HEADER_WORDS)?.to_vec();
    for instruction in instructions(words) {
        match (instruction.op, instruction.operands) {
            (Some(Op::Function), _) if !declared => {
                declared = true;
                append(&mut out, Op::Constant, &[uint, first, by]);
                out.extend(instruction.words);
            }
            (Some(Op::Load), [ty, id, pointer, rest @ ..]) if pointers.contains(pointer) => {
                append(&mut out, Op::Load, &[&[*ty, bound, *pointer], rest].concat());
                append(&mut out, Op::IAdd, &[*ty, *id, bound, first]);
                bound += 1;
            }
            _ => out.extend(instruction.words),
        }
    }
    out[BOUND] = bound;
    (bound > first + 1).then_some(out)
}
