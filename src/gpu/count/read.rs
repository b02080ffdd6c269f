//! What a module of SPIR-V declares, and what its instructions do.

use std::collections::{BTreeMap, BTreeSet};

use spirq::spirv::{Decoration, GLOp, Op, StorageClass};

use super::code::Code;
use super::tally::{Block, CHAIN, Traffic};
use crate::gpu::spirv_module::{Declared, Instruction, instructions};

/// What the values of a module are, as far as counting needs it. Keys are ids.
pub(super) struct Module<'a> {
    pub(super) declared: Declared<'a>,
    /// The type of each value.
    values: BTreeMap<u32, u32>,
    /// The binding behind each pointer into a buffer.
    pointers: BTreeMap<u32, u32>,
    /// Pointers into shared memory.
    shared: BTreeSet<u32>,
    /// The instruction set GLSL.std.450.
    glsl: u32,
}

/// What the values of a block come from, one after the other, as [`Chain`](super::Chain) has it.
#[derive(Default)]
pub(super) struct Chains {
    of: BTreeMap<u32, [u32; CHAIN]>,
    /// What came before the last barrier, for which all that follows waits.
    floor: [u32; CHAIN],
}

/// How large a type is.
#[derive(Clone, Copy)]
struct TypeSize {
    /// Numbers in it: those of a vector or a matrix, else one.
    components: u32,
    /// Bytes without padding; none of a pointer.
    bytes: u32,
}

/// A number of 32 bits, which stands for every type that is not known.
const WORD: TypeSize = TypeSize { components: 1, bytes: 4 };

/// Instructions of arithmetic in the time of a root, a quotient or an exponential.
const SPECIAL: u32 = 8;

/// What an extended instruction costs.
#[derive(Default)]
struct Cost {
    flops: u32,
    roots: u32,
    exps: u32,
}

impl<'a> Module<'a> {
    /// Reads a module.
    pub(super) fn of(words: &'a [u32]) -> Self {
        const STORAGE_BUFFER: u32 = StorageClass::StorageBuffer as u32;
        // Where buffers are before version 1.3.
        const UNIFORM: u32 = StorageClass::Uniform as u32;
        const WORKGROUP: u32 = StorageClass::Workgroup as u32;
        let declared = Declared::of(words);
        let (mut values, mut pointers, mut shared) = (BTreeMap::new(), BTreeMap::new(), BTreeSet::new());
        let (mut glsl, mut typed) = (0, false);
        for Instruction { op, operands, .. } in instructions(words) {
            match (op, operands) {
                (Some(Op::ExtInstImport), [id, ..]) => glsl = *id,
                (Some(Op::Variable), [_, id, STORAGE_BUFFER | UNIFORM, ..]) => {
                    pointers.extend(declared.decoration(*id, Decoration::Binding).map(|binding| (*id, binding)));
                }
                (Some(Op::Variable), [_, id, WORKGROUP, ..]) => drop(shared.insert(*id)),
                (Some(Op::AccessChain | Op::InBoundsAccessChain), [_, id, base, ..]) => {
                    if shared.contains(base) {
                        shared.insert(*id);
                    }
                    let binding = pointers.get(base).copied();
                    pointers.extend(binding.map(|binding| (*id, binding)));
                }
                _ => {}
            }
            // After the first type, an instruction that begins with a type gives a value of that type.
            typed |= op.is_some_and(|op| (Op::TypeVoid..=Op::TypeFunction).contains(&op));
            if let [ty, value, ..] = operands
                && typed
                && op.is_none_or(|op| op > Op::TypeFunction)
                && declared.types.contains_key(ty)
            {
                values.insert(*value, *ty);
            }
        }
        Self { declared, values, pointers, shared, glsl }
    }

    /// The size of a type.
    fn size(&self, ty: u32) -> TypeSize {
        let single = |bytes| TypeSize { components: 1, bytes };
        match self.declared.types.get(&ty) {
            Some((Op::TypeInt | Op::TypeFloat, [bits, ..])) => single(bits / 8),
            Some((Op::TypeVector | Op::TypeMatrix, [part, count])) => {
                let TypeSize { components, bytes } = self.size(*part);
                TypeSize { components: components * count, bytes: bytes * count }
            }
            Some((Op::TypeArray, [part, length])) => {
                let count = self.declared.constants.get(length).copied().unwrap_or(1);
                single(self.size(*part).bytes * count)
            }
            Some((Op::TypeStruct, members)) => single(members.iter().map(|member| self.size(*member).bytes).sum()),
            Some((Op::TypeVoid | Op::TypeRuntimeArray | Op::TypePointer | Op::TypeFunction, _)) => single(0),
            _ => WORD,
        }
    }

    fn bytes_of(&self, value: u32) -> u64 {
        self.values.get(&value).map_or(WORD, |ty| self.size(*ty)).bytes.into()
    }

    /// The binding of a variable that is a buffer.
    #[cfg(feature = "measure")]
    pub(super) fn binding(&self, variable: u32) -> Option<u32> {
        self.declared.decoration(variable, Decoration::Binding)
    }

    /// Whether a value is known to be an unsigned integer.
    #[cfg(feature = "measure")]
    pub(super) fn is_unsigned(&self, value: u32) -> bool {
        self.values.get(&value).is_some_and(|ty| self.declared.types.get(ty) == Some(&(Op::TypeInt, &[32, 0])))
    }

    /// Adds what an instruction does to its block.
    pub(super) fn add(&self, block: &mut Block, instruction: Instruction<'_>) {
        let Instruction { op: Some(op), operands, .. } = instruction else { return };
        block.codes.extend(Code::of(op, operands, self.glsl));
        if let Some((pointer, traffic)) = self.traffic(op, operands) {
            if let Some(&binding) = self.pointers.get(&pointer) {
                block.moved.entry(binding).or_default().add(1, traffic);
                block.atomics += u32::from(replaces(op));
            } else if self.shared.contains(&pointer) {
                block.shared += u32::try_from((traffic.loaded + traffic.stored) / 4).unwrap_or(u32::MAX);
            }
            return;
        }
        let [ty, _, arguments @ ..] = operands else { return };
        let n = self.size(*ty).components;
        let components = |k: usize| self.components_of(arguments.get(k), n);
        match op {
            Op::FAdd | Op::FSub | Op::FMul | Op::VectorTimesScalar | Op::MatrixTimesScalar | Op::OuterProduct => {
                block.flops += n;
            }
            Op::FDiv | Op::FRem | Op::FMod => block.roots += n,
            Op::VectorTimesMatrix => block.flops += 2 * components(1) - n,
            Op::MatrixTimesVector => block.flops += 2 * components(0) - n,
            Op::Dot => block.flops += 2 * components(0) - 1,
            Op::ExtInst if arguments.first() == Some(&self.glsl) => {
                let function = arguments.get(1).and_then(|number| GLOp::from_u32(*number));
                let cost = function.map_or_else(Cost::default, |function| extended(function, n, components(2)));
                block.flops += cost.flops;
                block.roots += cost.roots;
                block.exps += cost.exps;
            }
            _ => {}
        }
    }

    /// Adds what an instruction of a block issues, and what it lengthens a chain of its block by.
    ///
    /// An instruction waits for those that its operands come from; those that do not need one another wait together.
    /// Across blocks all wait: a branch in between needs most of them. An atomic operation waits like a load.
    pub(super) fn chain(&self, block: &mut Block, instruction: Instruction<'_>, chains: &mut Chains) {
        let Instruction { op: Some(op), operands, .. } = instruction else { return };
        let issued = self.issued(op, operands);
        block.instructions += issued;
        if op == Op::ControlBarrier {
            block.chain[2] += 1;
            *chains = Chains { of: BTreeMap::new(), floor: block.chain };
            return;
        }
        let known = values_among(op, operands).iter().filter_map(|id| chains.of.get(id));
        let mut chain = known.fold(chains.floor, |all, own| std::array::from_fn(|kind| all[kind].max(own[kind])));
        chain[0] += if issued == 0 { 0 } else { self.special(op, operands).unwrap_or(1) };
        match (op, operands) {
            (op, _) if exchanges(op) => chain[2] += 1,
            (op, [_, _, pointer, ..]) if matches!(op, Op::Load | Op::AtomicLoad) || replaces(op) => {
                chain[1] += u32::from(self.pointers.contains_key(pointer));
                chain[2] += u32::from(self.shared.contains(pointer));
            }
            _ => {}
        }
        block.chain = std::array::from_fn(|kind| block.chain[kind].max(chain[kind]));
        if let [_, id, ..] = operands
            && self.values.contains_key(id)
            && !matches!(op, Op::Store | Op::AtomicStore)
        {
            chains.of.insert(*id, chain);
        }
    }

    /// How many instructions take as long as this one does for a number, if special units have it, at an eighth of the
    /// rate. Without integer division in hardware, compilers go by a float's reciprocal.
    fn special(&self, op: Op, operands: &[u32]) -> Option<u32> {
        match op {
            Op::FDiv | Op::FRem | Op::FMod => Some(SPECIAL),
            Op::UDiv | Op::SDiv | Op::UMod | Op::SRem | Op::SMod => Some(2 * SPECIAL),
            Op::ExtInst => {
                let Cost { roots, exps, flops } = self.cost_of(operands, 1);
                Some(SPECIAL * (roots + exps) + flops.min(2)).filter(|cost| *cost > 0)
            }
            _ => None,
        }
    }

    /// How many instructions of one number a processor issues for this one: one a component of arithmetic, one for 16
    /// bytes that are loaded or stored. What only names, picks or puts together values takes registers and no
    /// instruction.
    fn issued(&self, op: Op, operands: &[u32]) -> u32 {
        let result = || operands.first().map_or(WORD, |ty| self.size(*ty)).components.max(1);
        match op {
            Op::Line | Op::NoLine | Op::Label | Op::Variable | Op::Phi | Op::LoopMerge | Op::SelectionMerge => 0,
            Op::CompositeConstruct | Op::CompositeExtract | Op::CompositeInsert | Op::VectorShuffle => 0,
            Op::CopyObject | Op::CopyLogical | Op::Bitcast | Op::Undef | Op::FunctionEnd | Op::FunctionParameter => 0,
            // Variables of an invocation are registers, as long as it does not run out of them.
            Op::Load | Op::Store => {
                let moved = self.traffic(op, operands).filter(|(pointer, _)| self.in_memory(*pointer));
                moved.map_or(0, |(_, moved)| {
                    u32::try_from((moved.loaded + moved.stored).div_ceil(16)).unwrap_or(1).max(1)
                })
            }
            Op::AccessChain | Op::InBoundsAccessChain => operands.get(1).map_or(0, |id| self.in_memory(*id).into()),
            Op::Dot => self.components_of(operands.get(2), 1),
            Op::VectorTimesMatrix | Op::MatrixTimesVector | Op::MatrixTimesMatrix => 3 * result(),
            Op::ExtInst => {
                let Cost { flops, roots, exps } = self.cost_of(operands, result());
                (flops + SPECIAL * (roots + exps)).max(result())
            }
            _ if operands.is_empty() || !self.values.contains_key(operands.get(1).unwrap_or(&0)) => 1,
            _ => self.special(op, operands).unwrap_or(1) * result(),
        }
    }

    /// Whether a pointer is into a buffer or shared memory.
    fn in_memory(&self, pointer: u32) -> bool {
        self.pointers.contains_key(&pointer) || self.shared.contains(&pointer)
    }

    /// What a function of GLSL.std.450 whose result has `n` components takes: a fused multiply-add one instruction,
    /// though it is two operations.
    fn cost_of(&self, operands: &[u32], n: u32) -> Cost {
        match operands.get(3).and_then(|number| GLOp::from_u32(*number)) {
            Some(GLOp::Fma) => flops(n),
            Some(function) => extended(function, n, self.components_of(operands.get(4), n)),
            None => Cost::default(),
        }
    }

    /// The pointer that an instruction loads or stores through, and the bytes that it moves.
    fn traffic(&self, op: Op, operands: &[u32]) -> Option<(u32, Traffic)> {
        match (op, operands) {
            (Op::Load, [_, id, pointer, ..]) => Some((*pointer, Traffic { loaded: self.bytes_of(*id), stored: 0 })),
            (Op::Store, [pointer, value, ..]) => Some((*pointer, Traffic { loaded: 0, stored: self.bytes_of(*value) })),
            (Op::AtomicLoad, [_, _, pointer, ..]) => Some((*pointer, Traffic { loaded: 4, stored: 0 })),
            (Op::AtomicStore, [pointer, ..]) => Some((*pointer, Traffic { loaded: 0, stored: 4 })),
            (op, [_, _, pointer, ..]) if replaces(op) => Some((*pointer, Traffic { loaded: 4, stored: 4 })),
            _ => None,
        }
    }

    /// The components of an argument, or `otherwise` where its type is not known.
    fn components_of(&self, argument: Option<&u32>, otherwise: u32) -> u32 {
        argument.and_then(|value| self.values.get(value)).map_or(otherwise, |ty| self.size(*ty).components)
    }
}

/// The operands of an instruction that may be values, not literal numbers.
fn values_among(op: Op, operands: &[u32]) -> &[u32] {
    let range = match op {
        Op::CompositeExtract | Op::Load => 2..3,
        Op::CompositeInsert | Op::VectorShuffle => 2..4,
        Op::Store => 0..2,
        Op::ExtInst => 4..operands.len(),
        _ => 0..operands.len(),
    };
    operands.get(range).unwrap_or_default()
}

/// Whether an instruction exchanges values within a subgroup.
fn exchanges(op: Op) -> bool {
    (Op::GroupNonUniformElect..=Op::GroupNonUniformQuadSwap).contains(&op)
}

/// Whether an instruction reads a word and writes it in one step.
fn replaces(op: Op) -> bool {
    (Op::AtomicExchange..=Op::AtomicXor).contains(&op)
}

/// The cost of a function of GLSL.std.450 whose result has `n` components, and whose first argument has `argument`.
fn extended(function: GLOp, n: u32, argument: u32) -> Cost {
    match function {
        GLOp::Sin | GLOp::Cos | GLOp::Tan | GLOp::Asin | GLOp::Acos | GLOp::Atan | GLOp::Atan2 => exps(n),
        GLOp::Sinh | GLOp::Cosh | GLOp::Tanh | GLOp::Asinh | GLOp::Acosh | GLOp::Atanh => exps(n),
        GLOp::Exp | GLOp::Log | GLOp::Exp2 | GLOp::Log2 => exps(n),
        GLOp::Pow => exps(2 * n),
        GLOp::Sqrt | GLOp::InverseSqrt => Cost { roots: n, ..Cost::default() },
        GLOp::FMix => flops(3 * n),
        GLOp::SmoothStep => Cost { flops: 6 * n, roots: n, exps: 0 },
        GLOp::Fma => flops(2 * n),
        GLOp::Length => Cost { flops: 2 * argument - 1, roots: 1, exps: 0 },
        GLOp::Distance | GLOp::Normalize => Cost { flops: 3 * argument - 1, roots: 1, exps: 0 },
        GLOp::Cross => flops(9),
        GLOp::Reflect => flops(4 * argument),
        _ => Cost::default(),
    }
}

fn flops(flops: u32) -> Cost {
    Cost { flops, ..Cost::default() }
}

fn exps(exps: u32) -> Cost {
    Cost { exps, ..Cost::default() }
}
