//! A SPIR-V module as the words that it is made of: its instructions, what it declares, and copies of it with changes.

use std::collections::{BTreeMap, BTreeSet};

use spirq::spirv::{Capability, Decoration, ExecutionMode, Op, StorageClass};

/// The first word of a module.
pub(super) const MAGIC: u32 = 0x0723_0203;
/// Words of a module's header.
const HEADER_WORDS: usize = 5;
/// The word of the header that holds the version.
const VERSION: usize = 1;
/// The word of the header that holds the bound: every id of the module is smaller.
const BOUND: usize = 3;

/// An instruction of a module.
#[derive(Clone, Copy)]
pub(crate) struct Instruction<'a> {
    /// What it does; none for an instruction that is newer than the enumeration.
    pub(crate) op: Option<Op>,
    /// The words after the first one: ids and literals.
    pub(crate) operands: &'a [u32],
    /// All its words; the first one holds its length and its opcode.
    words: &'a [u32],
}

/// The instructions of a module, in their order.
pub(crate) fn instructions(module: &[u32]) -> impl Iterator<Item = Instruction<'_>> {
    let mut rest = module.get(HEADER_WORDS..).unwrap_or_default();
    std::iter::from_fn(move || {
        let first = *rest.first()?;
        let length = ((first >> 16).max(1) as usize).min(rest.len());
        let (words, after) = rest.split_at(length);
        rest = after;
        Some(Instruction { op: Op::from_u32(first & 0xffff), operands: &words[1..], words })
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

/// The words that are in these bytes.
pub(crate) fn words_in(bytes: &[u8]) -> Vec<u32> {
    bytes.as_chunks().0.iter().map(|word| u32::from_le_bytes(*word)).collect()
}

/// The text of a literal.
pub(crate) fn text(words: &[u32]) -> String {
    let bytes = words.iter().flat_map(|word| word.to_le_bytes()).take_while(|byte| *byte != 0);
    String::from_utf8_lossy(&bytes.collect::<Vec<_>>()).into_owned()
}

/// The names of a module's entry points.
pub(super) fn entry_points(module: &[u32]) -> Vec<String> {
    let name = |instruction: Instruction<'_>| match (instruction.op, instruction.operands) {
        (Some(Op::EntryPoint), [_, _, words @ ..]) => Some(text(words)),
        _ => None,
    };
    instructions(module).filter_map(name).collect()
}

/// What a module declares. Keys are ids.
#[derive(Default)]
pub(super) struct Declared<'a> {
    /// The function that a kernel begins with.
    pub(super) entry: u32,
    /// Its capabilities.
    pub(super) capabilities: BTreeSet<u32>,
    /// How types are made, and of what.
    pub(super) types: BTreeMap<u32, (Op, &'a [u32])>,
    /// The only word of each constant.
    pub(super) constants: BTreeMap<u32, u32>,
    /// The type and the storage class of each variable.
    variables: BTreeMap<u32, (u32, u32)>,
    /// The first operand of each decoration that has one, by what it decorates: an id, and of a struct a member.
    decorations: BTreeMap<(u32, Option<u32>, u32), u32>,
}

impl<'a> Declared<'a> {
    /// Reads what a module declares.
    pub(super) fn of(module: &'a [u32]) -> Self {
        let mut found = Self::default();
        for Instruction { op, operands, .. } in instructions(module) {
            match (op, operands) {
                (Some(Op::EntryPoint), [_, id, ..]) => found.entry = *id,
                (Some(Op::Capability), [number, ..]) => drop(found.capabilities.insert(*number)),
                (Some(Op::Decorate), [id, what, operand, ..]) => {
                    found.decorations.insert((*id, None, *what), *operand);
                }
                (Some(Op::MemberDecorate), [id, member, what, operand, ..]) => {
                    found.decorations.insert((*id, Some(*member), *what), *operand);
                }
                (Some(Op::Constant), [_, id, value]) => drop(found.constants.insert(*id, *value)),
                (Some(Op::Variable), [ty, id, class, ..]) => drop(found.variables.insert(*id, (*ty, *class))),
                (Some(op), [id, parts @ ..]) if (Op::TypeVoid..=Op::TypeFunction).contains(&op) => {
                    found.types.insert(*id, (op, parts));
                }
                _ => {}
            }
        }
        found
    }

    /// The operand of a decoration.
    pub(super) fn decoration(&self, id: u32, what: Decoration) -> Option<u32> {
        self.decorations.get(&(id, None, what as u32)).copied()
    }

    /// The ids that have this decoration with this operand.
    #[cfg(feature = "measure")]
    pub(super) fn decorated(&self, what: Decoration, operand: u32) -> Vec<u32> {
        let has = |(key, known): (&(u32, Option<u32>, u32), &u32)| {
            let (id, member, decoration) = *key;
            (member.is_none() && decoration == what as u32 && *known == operand).then_some(id)
        };
        self.decorations.iter().filter_map(has).collect()
    }

    /// The first byte of a member of a struct.
    pub(super) fn offset(&self, id: u32, member: u32) -> Option<u32> {
        self.decorations.get(&(id, Some(member), Decoration::Offset as u32)).copied()
    }

    /// The type that is made of these parts.
    pub(super) fn type_of(&self, op: Op, parts: &[u32]) -> Option<u32> {
        self.types.iter().find(|(_, known)| **known == (op, parts)).map(|(id, _)| *id)
    }

    /// The block of push constants: the variable and its type.
    pub(super) fn pushed(&self) -> Option<(u32, u32)> {
        let (id, (pointer, _)) =
            self.variables.iter().find(|(_, (_, class))| *class == StorageClass::PushConstant as u32)?;
        match self.types.get(pointer)? {
            (Op::TypePointer, [_, block]) => Some((*id, *block)),
            _ => None,
        }
    }
}

/// A copy of a module, as it is written.
pub(super) struct Edited {
    words: Vec<u32>,
    /// Decorations to come before the first one of the module.
    decorations: Vec<u32>,
    /// Declarations to come before the first function.
    declarations: Vec<u32>,
}

impl Edited {
    /// Begins with the header; none where a module has not even that.
    pub(super) fn begin(module: &[u32]) -> Option<Self> {
        let words = module.get(..HEADER_WORDS)?.to_vec();
        Some(Self { words, decorations: Vec::new(), declarations: Vec::new() })
    }

    /// The version of SPIR-V: 0x10300 is 1.3.
    pub(super) fn version(&self) -> u32 {
        self.words[VERSION]
    }

    /// An id that is not in use.
    pub(super) fn id(&mut self) -> u32 {
        self.words[BOUND] += 1;
        self.words[BOUND] - 1
    }

    /// Appends an instruction.
    pub(super) fn put(&mut self, op: Op, operands: &[u32]) {
        append(&mut self.words, op, operands);
    }

    /// Appends an instruction as it is.
    pub(super) fn keep(&mut self, instruction: Instruction<'_>) {
        self.words.extend(instruction.words);
    }

    /// Adds a decoration.
    pub(super) fn decorate(&mut self, id: u32, what: Decoration, operands: &[u32]) {
        append(&mut self.decorations, Op::Decorate, &[&[id, what as u32], operands].concat());
    }

    /// Adds a decoration of a struct's member.
    pub(super) fn decorate_member(&mut self, id: u32, member: u32, what: Decoration, operand: u32) {
        append(&mut self.decorations, Op::MemberDecorate, &[id, member, what as u32, operand]);
    }

    /// Adds a type, a constant or a variable.
    pub(super) fn declare(&mut self, op: Op, operands: &[u32]) {
        append(&mut self.declarations, op, operands);
    }

    /// The whole module, where `edit` writes something in place of each instruction; none where it finds one that it
    /// can't replace.
    pub(super) fn finish(
        mut self,
        module: &[u32],
        mut edit: impl FnMut(&mut Self, Instruction<'_>) -> Option<()>,
    ) -> Option<Vec<u32>> {
        for instruction in instructions(module) {
            match instruction.op {
                Some(Op::Decorate | Op::MemberDecorate) => self.words.append(&mut self.decorations),
                Some(Op::Function) => self.words.append(&mut self.declarations),
                _ => {}
            }
            edit(&mut self, instruction)?;
        }
        Some(self.words)
    }
}

/// Appends an instruction to a module.
fn append(module: &mut Vec<u32>, op: Op, operands: &[u32]) {
    module.push(((operands.len() as u32 + 1) << 16) | op as u32);
    module.extend(operands);
}

/// A module of these instructions, for tests.
#[cfg(test)]
pub(super) fn module_of(list: &[(Op, &[u32])]) -> Vec<u32> {
    let mut module = vec![0; HEADER_WORDS];
    module[VERSION] = 0x10500;
    list.iter().for_each(|(op, operands)| append(&mut module, *op, operands));
    module
}

/// The module where `edit` writes something in place of each instruction.
pub(super) fn edited(module: &[u32], mut edit: impl FnMut(&mut Edited, Instruction<'_>)) -> Vec<u32> {
    let all = |out: &mut Edited, instruction: Instruction<'_>| {
        edit(out, instruction);
        Some(())
    };
    Edited::begin(module).and_then(|out| out.finish(module, all)).unwrap_or_else(|| module.to_vec())
}

/// The module with a request that additions, multiplications and the like of 32-bit floats round to nearest: a
/// capability after the header, before version 1.4 an extension, and an execution mode before the first one. A module
/// without execution modes, which no compute kernel is, stays as it is.
pub(super) fn round_to_nearest(module: Vec<u32>) -> Vec<u32> {
    let (entry, mut begun, mut requested) = (Declared::of(&module).entry, false, false);
    let mut extended = module.get(VERSION).is_some_and(|version| *version >= 0x10400);
    let rounding = edited(&module, |out, instruction| {
        if !begun {
            out.put(Op::Capability, &[Capability::RoundingModeRTE as u32]);
        }
        if !extended && instruction.op != Some(Op::Capability) {
            let name = b"SPV_KHR_float_controls\0\0".as_chunks::<4>().0;
            out.put(Op::Extension, &name.iter().map(|four| u32::from_le_bytes(*four)).collect::<Vec<_>>());
            extended = true;
        }
        if instruction.op == Some(Op::ExecutionMode) && !requested {
            out.put(Op::ExecutionMode, &[entry, ExecutionMode::RoundingModeRTE as u32, 32]);
            requested = true;
        }
        begun = true;
        out.keep(instruction);
    });
    if requested { rounding } else { module }
}

/// The module without that request: one that was written down for another device has it already.
pub(super) fn without_rounding(module: &[u32]) -> Vec<u32> {
    edited(module, |out, instruction| match (instruction.op, instruction.operands) {
        (Some(Op::Capability), [what]) if *what == Capability::RoundingModeRTE as u32 => {}
        (Some(Op::ExecutionMode), [_, what, 32]) if *what == ExecutionMode::RoundingModeRTE as u32 => {}
        _ => out.keep(instruction),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_request_to_round_comes_after_the_header_and_before_the_first_mode() {
        let size = [7, ExecutionMode::LocalSize as u32, 64, 1, 1];
        let module = module_of(&[(Op::EntryPoint, &[5, 7, 0]), (Op::ExecutionMode, &size)]);
        let rounding = round_to_nearest(module.clone());
        let ops: Vec<_> = instructions(&rounding).map(|instruction| instruction.op.unwrap()).collect();
        assert_eq!(ops, [Op::Capability, Op::EntryPoint, Op::ExecutionMode, Op::ExecutionMode]);
        let modes: Vec<_> = instructions(&rounding).skip(2).map(|mode| mode.operands[..2].to_vec()).collect();
        assert_eq!(modes, [[7, ExecutionMode::RoundingModeRTE as u32], [7, ExecutionMode::LocalSize as u32]]);
        assert_eq!(round_to_nearest(module_of(&[])), module_of(&[]));
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
