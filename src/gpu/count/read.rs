//! What a module of SPIR-V declares, and what its instructions do.

use std::collections::BTreeMap;

use spirq::spirv::{Decoration, GLOp, Op, StorageClass};

use super::code::Code;
use super::tally::{Block, Traffic};
use crate::gpu::spirv_module::{Declared, Instruction, instructions};

/// What the values of a module are, as far as counting needs it. Keys are ids.
pub(super) struct Module<'a> {
    pub(super) declared: Declared<'a>,
    /// The type of each value.
    values: BTreeMap<u32, u32>,
    /// The binding behind each pointer into a buffer.
    pointers: BTreeMap<u32, u32>,
    /// The instruction set GLSL.std.450.
    glsl: u32,
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
        let declared = Declared::of(words);
        let (mut values, mut pointers, mut glsl, mut typed) = (BTreeMap::new(), BTreeMap::new(), 0, false);
        for Instruction { op, operands, .. } in instructions(words) {
            match (op, operands) {
                (Some(Op::ExtInstImport), [id, ..]) => glsl = *id,
                (Some(Op::Variable), [_, id, STORAGE_BUFFER, ..]) => {
                    pointers.extend(declared.decoration(*id, Decoration::Binding).map(|binding| (*id, binding)));
                }
                (Some(Op::AccessChain | Op::InBoundsAccessChain), [_, id, base, ..]) => {
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
        Self { declared, values, pointers, glsl }
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
