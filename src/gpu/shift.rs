//! A copy of a SPIR-V module whose groups count from another one than 0.

use spirq::spirv::{BuiltIn, Decoration, Op};

use super::spirv_module::{Declared, Edited};

/// The module with this many added to the number of the group, across; none where it takes that number in a way that
/// kernels of the build do not.
pub(crate) fn shifted(words: &[u32], by: u32) -> Option<Vec<u32>> {
    let declared = Declared::of(words);
    let builtin = |which: BuiltIn| declared.decorated(Decoration::BuiltIn, which as u32);
    if !builtin(BuiltIn::GlobalInvocationId).is_empty() {
        return None;
    }
    let (variables, uint) = (builtin(BuiltIn::WorkgroupId), declared.type_of(Op::TypeInt, &[32, 0])?);
    let mut out = Edited::begin(words)?;
    let first = out.id();
    out.declare(Op::Constant, &[uint, first, by]);
    // Pointers to the number across.
    let (mut pointers, mut loads) = (Vec::new(), 0);
    let shifted = out.finish(words, |out, instruction| {
        match (instruction.op, instruction.operands) {
            (Some(Op::Load), [_, _, pointer, ..]) if variables.contains(pointer) => return None,
            (Some(Op::Load), [ty, id, pointer, rest @ ..]) if pointers.contains(pointer) => {
                let number = out.id();
                out.put(Op::Load, &[&[*ty, number, *pointer], rest].concat());
                out.put(Op::IAdd, &[*ty, *id, number, first]);
                loads += 1;
                return Some(());
            }
            (Some(Op::AccessChain), [_, id, base, index]) if variables.contains(base) => {
                pointers.extend((declared.constants.get(index)? == &0).then_some(*id));
            }
            _ => {}
        }
        out.keep(instruction);
        Some(())
    });
    shifted.filter(|_| loads > 0)
}
