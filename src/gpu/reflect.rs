//! What a kernel binds and takes, read from its SPIR-V, so that no binding number, group size or size of push constants
//! is written twice.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex};

use spirq::prelude::*;
use spirq::spirv::{Capability, Decoration, ExecutionMode, Op};
use spirq::ty::{AccessType, DescriptorType, ScalarType, Type};

use super::spirv_module::{Declared, Instruction, edited, instructions, words_in};
use crate::error::{Error, Result};
use crate::layout::GROUP_ID;

include!(concat!(env!("OUT_DIR"), "/kernels.rs"));

/// How a kernel uses a buffer, as GLSL declares by `readonly` and `writeonly`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Access {
    /// The binding.
    pub binding: u32,
    /// Whether it reads.
    pub reads: bool,
    /// Whether it writes.
    pub writes: bool,
    /// Whether it asks how many elements are bound, by `length()`.
    pub asks_length: bool,
}

/// The names of all kernels in the program.
pub fn kernel_names() -> impl Iterator<Item = &'static str> {
    SPIRV.iter().map(|(name, _)| *name)
}

/// The names of the kernels that there are without subgroup operations, too.
pub fn kernels_without_subgroups() -> impl Iterator<Item = &'static str> {
    SPIRV_WITHOUT_SUBGROUPS.iter().map(|(name, _)| *name)
}

/// The SPIR-V of a kernel of the program, as bytes of little-endian words.
pub fn spirv(name: &str) -> Option<&'static [u8]> {
    SPIRV.iter().find(|(known, _)| *known == name).map(|(_, bytes)| *bytes)
}

/// The names of the specialization constants of a kernel of the program, by their ids.
pub fn constants(name: &str) -> Result<Vec<String>> {
    Ok(reflect(name, &words_of(name)?)?.set_by_program().map(|(_, constant)| constant.name.clone()).collect())
}

/// Whether a kernel of the program leaves the size of its groups open.
pub fn group_is_open(name: &str) -> bool {
    let found = words_of(name).and_then(|words| reflect(name, &words));
    found.is_ok_and(|found| found.constants.contains_key(&GROUP_ID))
}

/// How a kernel of the program uses its buffers.
pub fn accesses(name: &str) -> Result<Vec<Access>> {
    /// By name: a frame asks for the same kernel hundreds of times.
    static KNOWN: Mutex<BTreeMap<String, Vec<Access>>> = Mutex::new(BTreeMap::new());
    if let Some(found) = KNOWN.lock().ok().and_then(|known| known.get(name).cloned()) {
        return Ok(found);
    }
    let found = reflect(name, &words_of(name)?)?.accesses.clone();
    if let Ok(mut known) = KNOWN.lock() {
        known.insert(name.to_string(), found.clone());
    }
    Ok(found)
}

pub(crate) fn words_of(name: &str) -> Result<Vec<u32>> {
    let bytes =
        spirv(name).ok_or_else(|| Error::device(format!("looking for kernel {name}"), "no such shader was built"))?;
    Ok(words_in(bytes))
}

/// The SPIR-V of a kernel without subgroup operations, where the build's own has some.
pub(super) fn words_without_subgroups(name: &str) -> Option<Vec<u32>> {
    let found = SPIRV_WITHOUT_SUBGROUPS.iter().find(|(known, _)| *known == name);
    found.map(|(_, bytes)| words_in(bytes))
}

/// Whether a module has subgroup operations, by its capabilities.
pub(super) fn has_subgroups(words: &[u32]) -> bool {
    let subgroups = Capability::GroupNonUniform as u32..=Capability::GroupNonUniformQuad as u32;
    let declares = |found: Instruction<'_>| found.op == Some(Op::Capability) && subgroups.contains(&found.operands[0]);
    instructions(words).any(declares)
}

/// What reflection finds in a kernel.
#[derive(Default)]
pub(super) struct Reflected {
    /// The buffers it binds, by binding.
    pub(super) accesses: Vec<Access>,
    /// The types of its buffers and push constants.
    types: Vec<Type>,
    /// Bytes from one element to the next, by binding.
    pub(super) strides: BTreeMap<u32, usize>,
    pub(super) push_bytes: u32,
    /// The members of its push constants: name and first byte.
    pub(super) pushed: Vec<(String, u32)>,
    /// Invocations of a group.
    pub(super) group: u32,
    /// Invocations of a group in its first dimension.
    pub(super) across: u32,
    /// Its specialization constants by id; by those from [`GROUP_ID`] on it leaves a choice open.
    pub(super) constants: BTreeMap<u32, SpecConstant>,
}

/// A specialization constant.
#[derive(Clone)]
pub(super) struct SpecConstant {
    /// Its name, or else its id.
    pub(super) name: String,
    pub(super) ty: ScalarType,
}

impl Reflected {
    /// The specialization constants that leave no choice open, with their ids.
    pub(super) fn set_by_program(&self) -> impl Iterator<Item = (&u32, &SpecConstant)> {
        self.constants.range(..GROUP_ID)
    }
}

/// Bytes from one element of a buffer to the next.
fn stride(ty: &Type) -> Option<usize> {
    let Type::Struct(whole) = ty else { return None };
    match &whole.members.last()?.ty {
        Type::Array(array) => array.stride,
        _ => None,
    }
}

/// The bindings of buffers whose number of elements the module asks for.
fn asked_lengths(words: &[u32]) -> BTreeSet<u32> {
    let declared = Declared::of(words);
    let binding = |instruction: Instruction<'_>| match (instruction.op, instruction.operands) {
        (Some(Op::ArrayLength), [_, _, variable, _]) => declared.decoration(*variable, Decoration::Binding),
        _ => None,
    };
    instructions(words).filter_map(binding).collect()
}

/// The module with a plain constant in place of each one that is computed from others, such as `gl_WorkGroupSize.x`:
/// `spirq` knows few of those. It has the default value where that is a 32-bit integer that lengths are computed by,
/// else 0.
fn computed(words: &[u32]) -> Vec<u32> {
    let (mut values, mut composites) = (BTreeMap::new(), BTreeMap::new());
    edited(words, |out, instruction| {
        match (instruction.op, instruction.operands) {
            (Some(Op::Constant | Op::SpecConstant), [_, id, value]) => drop(values.insert(*id, *value)),
            (Some(Op::SpecConstantComposite), [_, id, parts @ ..]) => drop(composites.insert(*id, parts.to_vec())),
            (Some(Op::SpecConstantOp), [ty, id, what, of @ ..]) => {
                let value = |k: usize| values.get(of.get(k)?).copied();
                let both = value(0).zip(value(1));
                let part = || values.get(composites.get(of.first()?)?.get(*of.get(1)? as usize)?).copied();
                let found = match Op::from_u32(*what) {
                    Some(Op::CompositeExtract) => part(),
                    Some(Op::IAdd) => both.map(|(a, b)| a.wrapping_add(b)),
                    Some(Op::ISub) => both.map(|(a, b)| a.wrapping_sub(b)),
                    Some(Op::IMul) => both.map(|(a, b)| a.wrapping_mul(b)),
                    Some(Op::UDiv) => both.and_then(|(a, b)| a.checked_div(b)),
                    _ => None,
                };
                values.extend(found.map(|value| (*id, value)));
                return match found {
                    Some(value) => out.put(Op::Constant, &[*ty, *id, value]),
                    None => out.put(Op::ConstantNull, &[*ty, *id]),
                };
            }
            _ => {}
        }
        out.keep(instruction);
    })
}

/// The most modules whose contents are kept.
const MOST_KNOWN: usize = 512;

/// What is found in a module, which is looked for once: until a kernel is made it is asked for four times, and with
/// `RUST_BACKTRACE=1` `spirq` takes ten milliseconds, since it notes a backtrace of all that a module leaves out.
pub(super) fn reflect(name: &str, words: &[u32]) -> Result<Arc<Reflected>> {
    static KNOWN: Mutex<BTreeMap<Vec<u32>, Arc<Reflected>>> = Mutex::new(BTreeMap::new());
    if let Some(found) = KNOWN.lock().ok().and_then(|known| known.get(words).cloned()) {
        return Ok(found);
    }
    let found = Arc::new(reflect_anew(name, words)?);
    // Enough for all kernels of the program, few for those of a fuzzer.
    if let Some(mut known) = KNOWN.lock().ok().filter(|known| known.len() < MOST_KNOWN) {
        known.insert(words.to_vec(), found.clone());
    }
    Ok(found)
}

fn reflect_anew(name: &str, words: &[u32]) -> Result<Reflected> {
    let doing = || format!("reading kernel {name}");
    let entries = ReflectConfig::new()
        .spv(computed(words))
        .ref_all_rscs(false)
        .reflect()
        .map_err(|error| Error::device(doing(), format!("{error:?}")))?;
    let entry = entries.first().ok_or_else(|| Error::device(doing(), "it has no entry point"))?;
    let mut found = Reflected::default();
    let asked = asked_lengths(words);
    for variable in &entry.vars {
        match variable {
            Variable::Descriptor { desc_bind, desc_ty: DescriptorType::StorageBuffer(access), ty, .. } => {
                found.accesses.push(Access {
                    binding: desc_bind.bind(),
                    reads: *access != AccessType::WriteOnly,
                    writes: *access != AccessType::ReadOnly,
                    asks_length: asked.contains(&desc_bind.bind()),
                });
                found.strides.extend(stride(ty).map(|stride| (desc_bind.bind(), stride)));
                found.types.push(ty.clone());
            }
            Variable::Descriptor { name: which, .. } => {
                return Err(Error::device(doing(), format!("{which:?} is no storage buffer")));
            }
            Variable::PushConstant { ty, .. } => {
                found.push_bytes = u32::try_from(ty.nbyte().unwrap_or(0)).unwrap_or(u32::MAX);
                for member in ty.as_struct().into_iter().flat_map(|block| &block.members) {
                    let offset = member.offset.and_then(|offset| u32::try_from(offset).ok());
                    found.pushed.push((member.name.clone().unwrap_or_default(), offset.unwrap_or(u32::MAX)));
                }
                found.types.push(ty.clone());
            }
            Variable::SpecConstant { name, spec_id, ty: Type::Scalar(ty) } => {
                let name = name.clone().unwrap_or_else(|| spec_id.to_string());
                found.constants.insert(*spec_id, SpecConstant { name, ty: ty.clone() });
            }
            _ => {}
        }
    }
    found.accesses.sort_by_key(|access| access.binding);
    for mode in &entry.exec_modes {
        if mode.exec_mode == ExecutionMode::LocalSize {
            let sizes = mode.operands.iter().filter_map(|operand| operand.value.to_typeless());
            let sizes: Vec<u32> =
                sizes.filter_map(|b| Some(u32::from_le_bytes(b.get(..4)?.try_into().ok()?))).collect();
            (found.group, found.across) = (sizes.iter().product(), sizes.first().copied().unwrap_or_default());
        }
    }
    if found.group == 0 {
        return Err(Error::device(doing(), "it does not state its group size"));
    }
    Ok(found)
}

/// A struct as a kernel's SPIR-V has it.
pub struct Struct {
    /// The kernel.
    pub kernel: String,
    /// The struct's name, or the buffer's for an array of plain numbers.
    pub name: String,
    /// Its members, in their order; none where this is the stride of an array.
    pub members: Vec<Member>,
    /// Bytes from one element to the next, where the struct is the element of an array.
    pub stride: Option<usize>,
}

/// A member of a struct.
pub struct Member {
    /// Its name.
    pub name: String,
    /// Its first byte within the struct.
    pub offset: usize,
}

/// Every struct in the SPIR-V of every kernel.
pub fn reflect_records() -> Result<Vec<Struct>> {
    fn visit(kernel: &str, ty: &Type, out: &mut Vec<Struct>) {
        match ty {
            Type::Struct(record) => {
                let members = record
                    .members
                    .iter()
                    .map(|member| Member {
                        name: member.name.clone().unwrap_or_default(),
                        offset: member.offset.unwrap_or(usize::MAX),
                    })
                    .collect();
                let name = record.name.clone().unwrap_or_default();
                out.push(Struct { kernel: kernel.to_string(), name, members, stride: None });
                for member in &record.members {
                    visit(kernel, &member.ty, out);
                    if let Type::Array(array) = &member.ty {
                        let name = match &*array.element_ty {
                            Type::Struct(element) => element.name.clone().unwrap_or_default(),
                            _ => member.name.clone().unwrap_or_default(),
                        };
                        let stride = Some(array.stride.unwrap_or(0));
                        out.push(Struct { kernel: kernel.to_string(), name, members: Vec::new(), stride });
                    }
                }
            }
            Type::Array(array) => visit(kernel, &array.element_ty, out),
            _ => {}
        }
    }
    let mut out = Vec::new();
    for name in kernel_names() {
        for ty in &reflect(name, &words_of(name)?)?.types {
            visit(name, ty, &mut out);
        }
    }
    Ok(out)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::kernel::Shape;
    use crate::layout::MOST_WIDE;
    use spirq::spirv::StorageClass;

    /// The module with these values of specialization constants.
    fn specialized(words: &[u32], values: &[(u32, u32)]) -> Vec<u32> {
        let declared = Declared::of(words);
        edited(words, |out, instruction| match (instruction.op, instruction.operands) {
            (Some(Op::SpecConstant), [ty, id, _]) if declared.decoration(*id, Decoration::SpecId).is_some() => {
                let known = declared.decoration(*id, Decoration::SpecId);
                let value = values.iter().find(|(own, _)| Some(*own) == known).map(|(_, value)| *value);
                out.put(Op::Constant, &[*ty, *id, value.unwrap_or(instruction.operands[2])]);
            }
            _ => out.keep(instruction),
        })
    }

    /// Bytes of a type, vectors of three as four.
    fn bytes(declared: &Declared<'_>, ty: u32) -> u32 {
        match declared.types[&ty] {
            (Op::TypeBool, _) => 4,
            (Op::TypeInt | Op::TypeFloat, of) => of[0] / 8,
            (Op::TypeVector, [of, count]) => bytes(declared, *of) * count.next_power_of_two(),
            (Op::TypeArray, [of, count]) => bytes(declared, *of) * declared.constants[count],
            (Op::TypeStruct, of) => of.iter().map(|member| bytes(declared, *member)).sum(),
            (other, _) => panic!("{other:?} in shared memory"),
        }
    }

    #[test]
    fn groups_share_no_more_memory_than_every_device_has() {
        let mut most = 0;
        for name in kernel_names() {
            let words = words_of(name).unwrap();
            let found = reflect(name, &words).unwrap();
            for lanes in [1, 32, 64, 128, MOST_WIDE] {
                let values: Vec<_> = Shape::with_lanes(lanes, &found).constants().collect();
                let module = computed(&specialized(&words, &values));
                let declared = Declared::of(&module);
                let shared = instructions(&module).filter_map(|instruction| match instruction.operands {
                    [ty, _, class, ..]
                        if instruction.op == Some(Op::Variable) && *class == StorageClass::Workgroup as u32 =>
                    {
                        Some(bytes(&declared, declared.types[ty].1[1]))
                    }
                    _ => None,
                });
                let sum = shared.sum();
                assert!(sum <= 16 << 10, "{name}, {lanes} invocations an item: {sum} bytes");
                most = most.max(sum);
            }
        }
        assert!(most > 4 << 10, "{most}");
    }
}
