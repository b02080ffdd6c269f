//! A copy of a SPIR-V module whose push constants are a uniform buffer, or specialization constants.

use std::collections::BTreeMap;

use spirq::spirv::{Decoration, Op, StorageClass};

use super::spirv_module::{Declared, Edited};

/// The specialization constant that stands for the first word of the push constants; others follow.
pub(super) const BAKED_ID: u32 = 200;
/// The descriptor set of the uniform buffer; its binding is 0.
pub(super) const UNIFORM_SET: u32 = 1;

const PUSH: u32 = StorageClass::PushConstant as u32;

/// The module with its push constants in a uniform buffer of the same layout.
pub(super) fn as_uniform(words: &[u32]) -> Vec<u32> {
    const UNIFORM: u32 = StorageClass::Uniform as u32;
    let (Some((variable, _)), Some(mut out)) = (Declared::of(words).pushed(), Edited::begin(words)) else {
        return words.to_vec();
    };
    out.decorate(variable, Decoration::DescriptorSet, &[UNIFORM_SET]);
    out.decorate(variable, Decoration::Binding, &[0]);
    let edited = out.finish(words, |out, instruction| {
        match (instruction.op, instruction.operands) {
            (Some(Op::TypePointer), [id, PUSH, pointee]) => out.put(Op::TypePointer, &[*id, UNIFORM, *pointee]),
            (Some(Op::Variable), [ty, id, PUSH, ..]) => out.put(Op::Variable, &[*ty, *id, UNIFORM]),
            _ => out.keep(instruction),
        }
        Some(())
    });
    edited.unwrap_or_else(|| words.to_vec())
}

/// Adds a specialization constant of this type for the push constants from this byte on; its id.
fn constant(out: &mut Edited, declared: &Declared<'_>, ty: u32, offset: u32) -> Option<u32> {
    let parts: Vec<u32> = match *declared.types.get(&ty)? {
        (Op::TypeInt | Op::TypeFloat, [32, ..]) => {
            let id = out.id();
            out.decorate(id, Decoration::SpecId, &[BAKED_ID + offset / 4]);
            out.declare(Op::SpecConstant, &[ty, id, 0]);
            return Some(id);
        }
        (op @ (Op::TypeVector | Op::TypeArray), [element, count]) => {
            let count = if op == Op::TypeArray { *declared.constants.get(count)? } else { *count };
            let stride = declared.decoration(ty, Decoration::ArrayStride).unwrap_or(4);
            (0..count).map(|k| constant(out, declared, *element, offset + k * stride)).collect::<Option<_>>()?
        }
        (Op::TypeStruct, members) => {
            let part = |(k, member): (u32, &u32)| constant(out, declared, *member, offset + declared.offset(ty, k)?);
            (0..).zip(members).map(part).collect::<Option<_>>()?
        }
        _ => return None,
    };
    let id = out.id();
    out.declare(Op::SpecConstantComposite, &[&[ty, id], parts.as_slice()].concat());
    Some(id)
}

/// The module with a specialization constant in place of each word of its push constants from the first member on that
/// begins at byte `from` or later; that of the first byte would be [`BAKED_ID`]. None where it takes them in a way that
/// kernels of the build do not.
pub(super) fn as_specialization(words: &[u32], from: u32) -> Option<Vec<u32>> {
    let declared = Declared::of(words);
    let (variable, block) = declared.pushed()?;
    let (Op::TypeStruct, members) = *declared.types.get(&block)? else { return None };
    let offset = |k: u32| declared.offset(block, k);
    let kept = (0..members.len() as u32).take_while(|k| offset(*k).is_some_and(|at| at < from)).count() as u32;
    let mut out = Edited::begin(words)?;
    let mut parts = Vec::new();
    for (k, member) in (0..).zip(members).skip(kept as usize) {
        parts.push(constant(&mut out, &declared, *member, offset(k)?)?);
    }
    let whole = out.id();
    if kept == 0 {
        out.declare(Op::SpecConstantComposite, &[&[block, whole], parts.as_slice()].concat());
    }

    // Each pointer into the block is a path of members.
    let mut paths = BTreeMap::from([(variable, Vec::new())]);
    out.finish(words, |out, instruction| {
        match (instruction.op, instruction.operands) {
            (Some(Op::EntryPoint), operands) if kept == 0 => {
                let others: Vec<u32> = operands.iter().copied().filter(|id| *id != variable).collect();
                out.put(Op::EntryPoint, &others);
            }
            (Some(Op::Name | Op::Decorate), [id, ..]) if *id == variable && kept == 0 => {}
            (Some(Op::MemberName | Op::MemberDecorate), [id, k, ..]) if *id == block && kept > 0 && *k >= kept => {}
            (Some(Op::TypeStruct), [id, ..]) if *id == block && kept > 0 => {
                out.put(Op::TypeStruct, &instruction.operands[..=kept as usize]);
            }
            (Some(Op::Variable), [_, id, ..]) if *id == variable && kept == 0 => {}
            (Some(Op::AccessChain | Op::InBoundsAccessChain), [_, _, base, first, ..])
                if *base == variable && declared.constants.get(first).is_some_and(|k| *k < kept) =>
            {
                out.keep(instruction);
            }
            (Some(Op::AccessChain | Op::InBoundsAccessChain), [_, id, base, indices @ ..])
                if paths.contains_key(base) =>
            {
                let steps = indices.iter().map(|index| declared.constants.get(index).copied());
                paths.insert(*id, [paths[base].as_slice(), &steps.collect::<Option<Vec<u32>>>()?].concat());
            }
            (Some(Op::Load), [ty, id, pointer, ..]) if paths.contains_key(pointer) => match paths[pointer].as_slice() {
                [] if kept == 0 => out.put(Op::CopyObject, &[*ty, *id, whole]),
                [] => return None,
                [k] => out.put(Op::CopyObject, &[*ty, *id, *parts.get((k - kept) as usize)?]),
                [k, path @ ..] => {
                    let part = *parts.get((k - kept) as usize)?;
                    out.put(Op::CompositeExtract, &[&[*ty, *id, part], path].concat());
                }
            },
            _ => out.keep(instruction),
        }
        Some(())
    })
}
