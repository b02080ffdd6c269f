//! What a module of SPIR-V declares, and what its instructions do.

use std::collections::BTreeMap;

use spirq::spirv::{Decoration, GLOp, Op, StorageClass};

use super::tally::{Block, Traffic};
use crate::gpu::spirv_module::Instruction;

/// What a module declares, as far as counting needs it. Keys are ids.
#[derive(Default)]
pub(super) struct Module {
    types: BTreeMap<u32, TypeSize>,
    /// The first word of each constant.
    constants: BTreeMap<u32, u32>,
    /// The type of each value.
    values: BTreeMap<u32, u32>,
    /// The binding of each variable that has one.
    bindings: BTreeMap<u32, u32>,
    /// The binding behind each pointer into a buffer.
    pointers: BTreeMap<u32, u32>,
    /// The instruction set GLSL.std.450.
    glsl: u32,
    /// The function that a kernel begins with.
    pub(super) entry: u32,
    /// The type of 32-bit unsigned integers.
    pub(super) uint: Option<u32>,
    /// The type of booleans.
    pub(super) boolean: Option<u32>,
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

impl Module {
    fn size(&self, ty: u32) -> TypeSize {
        self.types.get(&ty).copied().unwrap_or(WORD)
    }

    fn size_of_value(&self, value: u32) -> Option<TypeSize> {
        self.values.get(&value).and_then(|ty| self.types.get(ty)).copied()
    }

    fn bytes_of(&self, value: u32) -> u64 {
        self.size_of_value(value).unwrap_or(WORD).bytes.into()
    }

    /// Takes in what an instruction declares.
    pub(super) fn declare(&mut self, instruction: Instruction<'_>) {
        const BINDING: u32 = Decoration::Binding as u32;
        const STORAGE_BUFFER: u32 = StorageClass::StorageBuffer as u32;
        let Instruction { op, operands, .. } = instruction;
        match (op, operands) {
            (Some(Op::ExtInstImport), [id, ..]) => self.glsl = *id,
            (Some(Op::EntryPoint), [_, id, ..]) => self.entry = *id,
            (Some(Op::Decorate), [id, BINDING, number]) => {
                self.bindings.insert(*id, *number);
            }
            (Some(Op::TypeBool), [id]) => {
                self.boolean = Some(*id);
                self.types.insert(*id, WORD);
            }
            (Some(Op::TypeInt | Op::TypeFloat), [id, bits, ..]) => {
                // Width 32, no sign; a float has no operand for the sign.
                if operands == [*id, 32, 0] {
                    self.uint = Some(*id);
                }
                self.types.insert(*id, TypeSize { components: 1, bytes: bits / 8 });
            }
            (Some(Op::TypeVector | Op::TypeMatrix), [id, part, count]) => {
                let TypeSize { components, bytes } = self.size(*part);
                self.types.insert(*id, TypeSize { components: components * count, bytes: bytes * count });
            }
            (Some(Op::TypeArray), [id, part, length]) => {
                let count = self.constants.get(length).copied().unwrap_or(1);
                self.types.insert(*id, TypeSize { components: 1, bytes: self.size(*part).bytes * count });
            }
            (Some(Op::TypeStruct), [id, members @ ..]) => {
                let bytes = members.iter().map(|member| self.size(*member).bytes).sum();
                self.types.insert(*id, TypeSize { components: 1, bytes });
            }
            (Some(Op::TypeVoid | Op::TypeRuntimeArray | Op::TypePointer | Op::TypeFunction), [id, ..]) => {
                self.types.insert(*id, TypeSize { components: 1, bytes: 0 });
            }
            (Some(Op::Constant), [_, id, value]) => {
                self.constants.insert(*id, *value);
            }
            (Some(Op::Variable), [_, id, STORAGE_BUFFER, ..]) => {
                if let Some(&binding) = self.bindings.get(id) {
                    self.pointers.insert(*id, binding);
                }
            }
            (Some(Op::AccessChain | Op::InBoundsAccessChain), [_, id, base, ..]) => {
                if let Some(&binding) = self.pointers.get(base) {
                    self.pointers.insert(*id, binding);
                }
            }
            _ => {}
        }
        // After the declarations of types, an instruction that begins with a type gives a value of that type.
        if let [ty, value, ..] = operands
            && op.is_none_or(|op| op > Op::TypeFunction)
            && self.types.contains_key(ty)
        {
            self.values.insert(*value, *ty);
        }
    }

    /// The binding of a variable that is a buffer.
    #[cfg(feature = "measure")]
    pub(super) fn binding(&self, variable: u32) -> Option<u32> {
        self.bindings.get(&variable).copied()
    }

    /// Whether a value is known to be an unsigned integer.
    #[cfg(feature = "measure")]
    pub(super) fn is_unsigned(&self, value: u32) -> bool {
        self.uint.is_some_and(|uint| self.values.get(&value) == Some(&uint))
    }

    /// Adds what an instruction does to its block.
    pub(super) fn add(&self, block: &mut Block, instruction: Instruction<'_>) {
        let Instruction { op: Some(op), operands, .. } = instruction else { return };
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
    matches!(
        op,
        Op::AtomicExchange
            | Op::AtomicCompareExchange
            | Op::AtomicCompareExchangeWeak
            | Op::AtomicIIncrement
            | Op::AtomicIDecrement
            | Op::AtomicIAdd
            | Op::AtomicISub
            | Op::AtomicSMin
            | Op::AtomicUMin
            | Op::AtomicSMax
            | Op::AtomicUMax
            | Op::AtomicAnd
            | Op::AtomicOr
            | Op::AtomicXor
    )
}

/// What a function of GLSL.std.450 costs whose result has `n` components, and whose first argument has `argument`.
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
