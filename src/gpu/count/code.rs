//! What a module of SPIR-V is made of, as far as coverage tells it apart: instructions of functions, and what the
//! module declares for all of them.

use spirq::spirv::{Capability, ExecutionMode, GLOp, Op};

use crate::gpu::spirv_module::{Instruction, text};

/// Something that a module has.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Code {
    /// A capability.
    Capability(u32),
    /// An execution mode.
    Mode(u32),
    /// An extension of SPIR-V.
    Extension(String),
    /// An instruction.
    Instruction(u32),
    /// An instruction of GLSL.std.450.
    Extended(u32),
}

/// The instructions of functions that a compute kernel of Vulkan can have, without those of rays, meshes, cooperative
/// matrices and vendors.
const OF_COMPUTE: &[std::ops::RangeInclusive<u32>] = &[
    1..=1,     // OpUndef
    57..=57,   // OpFunctionCall
    59..=63,   // OpVariable to OpCopyMemory
    65..=66,   // OpAccessChain, OpInBoundsAccessChain
    68..=68,   // OpArrayLength
    77..=84,   // vectors and composites
    86..=107,  // images
    109..=116, // conversions
    124..=124, // OpBitcast
    126..=152, // arithmetic
    154..=157, // OpAny to OpIsInf
    164..=191, // logic and comparisons
    194..=205, // bits
    224..=225, // barriers
    227..=242, // atomics
    245..=246, // OpPhi, OpLoopMerge
    247..=255, // control flow
    305..=316, // sparse images
    320..=320, // OpImageSparseRead
    333..=366, // subgroups
    400..=400, // OpCopyLogical
];

/// The instructions of GLSL.std.450, without those of fragments.
const OF_GLSL: &[std::ops::RangeInclusive<u32>] = &[1..=75, 79..=81];

impl Code {
    /// What an instruction of a function is; none of those that mark lines, parameters and the function's end.
    pub(super) fn of(op: Op, operands: &[u32], glsl: u32) -> Option<Self> {
        match (op, operands) {
            (Op::Line | Op::NoLine | Op::FunctionParameter | Op::FunctionEnd, _) => None,
            (Op::ExtInst, [_, _, set, number, ..]) => (*set == glsl).then_some(Self::Extended(*number)),
            _ => Some(Self::Instruction(op as u32)),
        }
    }

    /// What an instruction declares for the whole module.
    pub(super) fn declared(instruction: Instruction<'_>) -> Option<Self> {
        match (instruction.op?, instruction.operands) {
            (Op::Capability, [number, ..]) => Some(Self::Capability(*number)),
            (Op::ExecutionMode | Op::ExecutionModeId, [_, number, ..]) => Some(Self::Mode(*number)),
            (Op::Extension, words) => Some(Self::Extension(text(words))),
            _ => None,
        }
    }

    /// All instructions that a compute kernel can have.
    pub fn of_compute() -> impl Iterator<Item = Self> {
        let core = OF_COMPUTE.iter().cloned().flatten().filter(|number| Op::from_u32(*number).is_some());
        let extended = OF_GLSL.iter().cloned().flatten().filter(|number| GLOp::from_u32(*number).is_some());
        core.map(Self::Instruction).chain(extended.map(Self::Extended))
    }

    /// Its kind in words.
    #[must_use]
    pub fn kind(&self) -> &'static str {
        match self {
            Self::Capability(_) => "capability",
            Self::Mode(_) => "execution mode",
            Self::Extension(_) => "extension of SPIR-V",
            Self::Instruction(_) => "instruction",
            Self::Extended(_) => "instruction of GLSL.std.450",
        }
    }

    /// Its name as disassemblers write it; a number where it is newer than the enumeration.
    #[must_use]
    pub fn name(&self) -> String {
        let known = match self {
            Self::Capability(number) => Capability::from_u32(*number).map(|known| format!("{known:?}")),
            Self::Mode(number) => ExecutionMode::from_u32(*number).map(|known| format!("{known:?}")),
            Self::Extension(name) => Some(name.clone()),
            Self::Instruction(number) => Op::from_u32(*number).map(|known| format!("Op{known:?}")),
            Self::Extended(number) => GLOp::from_u32(*number).map(|known| format!("{known:?}")),
        };
        known.unwrap_or_else(|| format!("{self:?}"))
    }
}
