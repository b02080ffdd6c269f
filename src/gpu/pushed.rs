//! A copy of a SPIR-V module whose push constants are a uniform buffer, or specialization constants.

use std::collections::{BTreeMap, BTreeSet};

use spirq::spirv::{Decoration, Op, StorageClass};

use super::spirv_module::{BOUND, HEADER_WORDS, Instruction, append, instructions};

/// The specialization constant that stands for the first word of the push constants; others follow.
pub(super) const BAKED_ID: u32 = 200;
/// The descriptor set of the uniform buffer; its binding is 0.
pub(super) const UNIFORM_SET: u32 = 1;

const PUSH: u32 = StorageClass::PushConstant as u32;

/// The module with its push constants in a uniform buffer of the same layout.
pub(super) fn as_uniform(words: &[u32]) -> Vec<u32> {
    let variable = instructions(words).find_map(|one| match (one.op, one.operands) {
        (Some(Op::Variable), [_, id, PUSH, ..]) => Some(*id),
        _ => None,
    });
    let Some(variable) = variable else { return words.to_vec() };
    let mut out = words[..HEADER_WORDS].to_vec();
    let mut decorated = false;
    for Instruction { op, operands, words, .. } in instructions(words) {
        match (op, operands) {
            (Some(Op::Decorate | Op::MemberDecorate), _) if !decorated => {
                decorated = true;
                append(&mut out, Op::Decorate, &[variable, Decoration::DescriptorSet as u32, UNIFORM_SET]);
                append(&mut out, Op::Decorate, &[variable, Decoration::Binding as u32, 0]);
            }
            (Some(Op::TypePointer), [id, PUSH, of]) => {
                append(&mut out, Op::TypePointer, &[*id, StorageClass::Uniform as u32, *of]);
                continue;
            }
            (Some(Op::Variable), [ty, id, PUSH, ..]) => {
                append(&mut out, Op::Variable, &[*ty, *id, StorageClass::Uniform as u32]);
                continue;
            }
            _ => {}
        }
        out.extend(words);
    }
    out
}

/// The types of a module, as far as push constants have them.
#[derive(Default)]
struct Types {
    /// The type of the components, and their number, of vectors and arrays.
    repeated: BTreeMap<u32, (u32, u32)>,
    /// Bytes from one element of an array to the next.
    strides: BTreeMap<u32, u32>,
    /// The types of members.
    structs: BTreeMap<u32, Vec<u32>>,
    /// The first byte of each member.
    offsets: BTreeMap<(u32, u32), u32>,
    scalars: BTreeSet<u32>,
}

/// What is added to a module: constants with their decorations.
struct Added<'a> {
    types: &'a Types,
    decorations: Vec<u32>,
    constants: Vec<u32>,
    bound: u32,
}

impl Added<'_> {
    /// A constant of this type, of the push constants from this byte on; its id.
    fn constant(&mut self, ty: u32, offset: u32) -> Option<u32> {
        if self.types.scalars.contains(&ty) {
            let id = self.next();
            append(&mut self.decorations, Op::Decorate, &[id, Decoration::SpecId as u32, BAKED_ID + offset / 4]);
            append(&mut self.constants, Op::SpecConstant, &[ty, id, 0]);
            return Some(id);
        }
        let parts: Vec<u32> = match (self.types.repeated.get(&ty), self.types.structs.get(&ty)) {
            (Some(&(of, count)), _) => {
                let stride = self.types.strides.get(&ty).copied().unwrap_or(4);
                (0..count).map(|k| self.constant(of, offset + k * stride)).collect::<Option<_>>()?
            }
            (None, Some(members)) => {
                let types = self.types;
                let place = |k: u32| types.offsets.get(&(ty, k)).copied();
                (0..).zip(members).map(|(k, of)| self.constant(*of, offset + place(k)?)).collect::<Option<_>>()?
            }
            (None, None) => return None,
        };
        let id = self.next();
        append(&mut self.constants, Op::SpecConstantComposite, &[&[ty, id], parts.as_slice()].concat());
        Some(id)
    }

    fn next(&mut self) -> u32 {
        self.bound += 1;
        self.bound - 1
    }
}

/// The module with a specialization constant in place of each word of its push constants from the first member on that
/// begins at byte `from` or later; that of the first byte would be [`BAKED_ID`]. None where it takes them in a way that
/// kernels of the build do not.
pub(super) fn as_specialization(words: &[u32], from: u32) -> Option<Vec<u32>> {
    let mut types = Types::default();
    let (mut variable, mut pointers, mut constants) = (None, BTreeMap::new(), BTreeMap::new());
    for Instruction { op, operands, .. } in instructions(words) {
        match (op, operands) {
            (Some(Op::TypeInt | Op::TypeFloat), [id, 32, ..]) => drop(types.scalars.insert(*id)),
            (Some(Op::TypeVector), [id, of, count]) => drop(types.repeated.insert(*id, (*of, *count))),
            (Some(Op::TypeArray), [id, of, count]) => {
                types.repeated.extend(constants.get(count).map(|count| (*id, (*of, *count))));
            }
            (Some(Op::TypeStruct), [id, members @ ..]) => drop(types.structs.insert(*id, members.to_vec())),
            (Some(Op::MemberDecorate), [id, member, what, offset]) if *what == Decoration::Offset as u32 => {
                types.offsets.insert((*id, *member), *offset);
            }
            (Some(Op::Decorate), [id, what, stride]) if *what == Decoration::ArrayStride as u32 => {
                types.strides.insert(*id, *stride);
            }
            (Some(Op::Constant), [_, id, value]) => drop(constants.insert(*id, *value)),
            (Some(Op::TypePointer), [id, PUSH, of]) => drop(pointers.insert(*id, *of)),
            (Some(Op::Variable), [ty, id, PUSH, ..]) => variable = Some((*pointers.get(ty)?, *id)),
            _ => {}
        }
    }
    let (block, variable) = variable?;
    let bound = *words.get(BOUND)?;
    let mut added = Added { types: &types, decorations: Vec::new(), constants: Vec::new(), bound };
    let members = types.structs.get(&block)?;
    let offset = |k: u32| types.offsets.get(&(block, k)).copied();
    let kept = (0..members.len() as u32).take_while(|k| offset(*k).is_some_and(|at| at < from)).count() as u32;
    let mut parts = Vec::new();
    for (k, of) in (0..).zip(members).skip(kept as usize) {
        parts.push(added.constant(*of, offset(k)?)?);
    }
    let whole = added.next();
    if kept == 0 {
        append(&mut added.constants, Op::SpecConstantComposite, &[&[block, whole], parts.as_slice()].concat());
    }

    // Each pointer into the block is a path of members.
    let mut paths = BTreeMap::from([(variable, Vec::new())]);
    let mut out = words.get(..HEADER_WORDS)?.to_vec();
    let mut decorated = false;
    for Instruction { op, operands, words, .. } in instructions(words) {
        if let (Some(Op::Decorate | Op::MemberDecorate), false) = (op, decorated) {
            decorated = true;
            out.extend(&added.decorations);
        }
        match (op, operands) {
            (Some(Op::EntryPoint), _) if kept == 0 => {
                let kept: Vec<u32> = operands.iter().copied().filter(|id| *id != variable).collect();
                append(&mut out, Op::EntryPoint, &kept);
            }
            (Some(Op::Name | Op::Decorate), [id, ..]) if *id == variable && kept == 0 => {}
            (Some(Op::MemberName | Op::MemberDecorate), [id, k, ..]) if *id == block && kept > 0 && *k >= kept => {}
            (Some(Op::TypeStruct), [id, ..]) if *id == block && kept > 0 => {
                append(&mut out, Op::TypeStruct, &operands[..=kept as usize]);
            }
            (Some(Op::Variable), [_, id, ..]) if *id == variable => {
                out.extend(&added.constants);
                out.extend(words.iter().filter(|_| kept > 0));
            }
            (Some(Op::AccessChain | Op::InBoundsAccessChain), [_, _, base, first, ..])
                if *base == variable && constants.get(first).is_some_and(|k| *k < kept) =>
            {
                out.extend(words);
            }
            (Some(Op::AccessChain | Op::InBoundsAccessChain), [_, id, base, indices @ ..])
                if paths.contains_key(base) =>
            {
                let steps = indices.iter().map(|index| constants.get(index).copied()).collect::<Option<Vec<u32>>>()?;
                paths.insert(*id, [paths[base].as_slice(), steps.as_slice()].concat());
            }
            (Some(Op::Load), [ty, id, pointer, ..]) if paths.contains_key(pointer) => match paths[pointer].as_slice() {
                [] if kept == 0 => append(&mut out, Op::CopyObject, &[*ty, *id, whole]),
                [] => return None,
                [k] => append(&mut out, Op::CopyObject, &[*ty, *id, *parts.get((k - kept) as usize)?]),
                [k, path @ ..] => {
                    let part = *parts.get((k - kept) as usize)?;
                    append(&mut out, Op::CompositeExtract, &[&[*ty, *id, part], path].concat());
                }
            },
            _ => out.extend(words),
        }
    }
    out[BOUND] = added.bound;
    Some(out)
}
