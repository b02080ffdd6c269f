//! Adds counters to a copy of a SPIR-V module: the buffer that holds them, and the instructions that increment them.

use spirq::spirv::{Capability, Decoration, MemorySemantics, Op, Scope, StorageClass};

use super::CHAIN;
use crate::gpu::spirv_module::{Declared, Edited, Instruction};

/// The binding of the counters, beyond every buffer of a frame.
pub(crate) const BINDING: u32 = 200;

/// The ids of the types, the variable and the constants that counting needs.
#[derive(Clone, Copy)]
pub(super) struct Counters {
    uint: u32,
    boolean: u32,
    /// The type of a pointer to one word.
    word_pointer: u32,
    /// The buffer.
    variable: u32,
    /// The constant 0; the id `zero + n` is the constant n, up to the largest that was declared.
    zero: u32,
    /// Private variables of an invocation: its longest chain so far, in the order of [`Chain`](super::Chain); how many
    /// instructions its subgroup issued while it was elected; and 1 if it was elected in the first block.
    own: [u32; CHAIN + 2],
    /// Whether the version allows [`Op::GroupNonUniformElect`]: from 1.3 on.
    elects: bool,
    /// Whether the entry point lists all variables that it uses, as from version 1.4 on; before, it lists inputs only.
    listed: bool,
}

impl Counters {
    /// Declares the buffer and the constants 0 to `most`. It comes before anything else is written.
    pub(super) fn declare(out: &mut Edited, module: &Declared<'_>, most: u32, counts_subgroups: bool) -> Self {
        let (class, block) = match out.version() {
            0x10300.. => (StorageClass::StorageBuffer, Decoration::Block),
            _ => (StorageClass::Uniform, Decoration::BufferBlock),
        };
        let [class, private] = [class, StorageClass::Private].map(|class| class as u32);
        let mut scalar = |op: Op, parts: &[u32]| {
            module.type_of(op, parts).unwrap_or_else(|| {
                let id = out.id();
                out.declare(op, &[&[id], parts].concat());
                id
            })
        };
        let (uint, boolean) = (scalar(Op::TypeInt, &[32, 0]), scalar(Op::TypeBool, &[]));
        let [array, record, record_pointer, word_pointer, variable] = std::array::from_fn(|_| out.id());
        let own_pointer = out.id();
        out.decorate(array, Decoration::ArrayStride, &[4]);
        out.decorate(record, block, &[]);
        out.decorate_member(record, 0, Decoration::Offset, 0);
        out.decorate(variable, Decoration::DescriptorSet, &[0]);
        out.decorate(variable, Decoration::Binding, &[BINDING]);
        out.declare(Op::TypeRuntimeArray, &[array, uint]);
        out.declare(Op::TypeStruct, &[record, array]);
        out.declare(Op::TypePointer, &[record_pointer, class, record]);
        out.declare(Op::TypePointer, &[word_pointer, class, uint]);
        out.declare(Op::Variable, &[record_pointer, variable, class]);
        let mut constant = |value: u32| {
            let id = out.id();
            out.declare(Op::Constant, &[uint, id, value]);
            id
        };
        let zero = constant(0);
        for number in 1..=most.max(1) {
            constant(number);
        }
        out.declare(Op::TypePointer, &[own_pointer, private, uint]);
        let own = std::array::from_fn(|_| out.id());
        own.iter().for_each(|id| out.declare(Op::Variable, &[own_pointer, *id, private, zero]));
        let (version, subgroups) = (out.version(), Capability::GroupNonUniform as u32);
        let elects = version >= 0x10300;
        // Capabilities come first in a module, of which nothing is written yet.
        if elects && counts_subgroups && !module.capabilities.contains(&subgroups) {
            out.put(Op::Capability, &[subgroups]);
        }
        Self { uint, boolean, word_pointer, variable, zero, own, elects, listed: version >= 0x10400 }
    }

    /// Copies an instruction; an entry point that lists its variables lists these, too.
    pub(super) fn keep(self, out: &mut Edited, instruction: Instruction<'_>) {
        match instruction.op {
            Some(Op::EntryPoint) if self.listed => {
                out.put(Op::EntryPoint, &[instruction.operands, &[self.variable], &self.own].concat());
            }
            _ => out.keep(instruction),
        }
    }

    /// Adds these numbers to the invocation's chain.
    pub(super) fn add(self, out: &mut Edited, numbers: [u32; CHAIN]) {
        for (own, number) in self.own.into_iter().zip(numbers).filter(|(_, number)| *number > 0) {
            let [before, after] = std::array::from_fn(|_| out.id());
            out.put(Op::Load, &[self.uint, before, own]);
            out.put(Op::IAdd, &[self.uint, after, before, self.zero + number]);
            out.put(Op::Store, &[own, after]);
        }
    }

    /// Counts a block's instructions once for each subgroup: its elected invocation adds them. Where the kernel
    /// `begins`, it counts the subgroup, too.
    pub(super) fn issue(self, out: &mut Edited, instructions: u32, begins: bool) {
        let Self { uint, boolean, zero, own, .. } = self;
        if !self.elects {
            return;
        }
        let [elected, once, one, before, after] = std::array::from_fn(|_| out.id());
        out.put(Op::GroupNonUniformElect, &[boolean, elected, zero + Scope::Subgroup as u32]);
        out.put(Op::Select, &[uint, once, elected, zero + instructions, zero]);
        out.put(Op::Load, &[uint, before, own[CHAIN]]);
        out.put(Op::IAdd, &[uint, after, before, once]);
        out.put(Op::Store, &[own[CHAIN], after]);
        if begins {
            out.put(Op::Select, &[uint, one, elected, zero + 1, zero]);
            out.put(Op::Store, &[own[CHAIN + 1], one]);
        }
    }

    /// Stores what an invocation has counted, where it ends: raises the words from `first` on to its chain where that
    /// is longer, and adds to the sums behind them, of instructions that subgroups issued and of subgroups.
    pub(super) fn end(self, out: &mut Edited, first: u32) {
        let Self { uint, word_pointer, variable, zero, own, .. } = self;
        let (scope, semantics) = (zero + Scope::Device as u32, zero + MemorySemantics::RELAXED.bits());
        for (own, word) in own[..CHAIN].iter().zip(first..) {
            let [place, done, before] = std::array::from_fn(|_| out.id());
            out.put(Op::AccessChain, &[word_pointer, place, variable, zero, zero + word]);
            out.put(Op::Load, &[uint, done, *own]);
            out.put(Op::AtomicUMax, &[uint, before, place, scope, semantics, done]);
        }
        for (own, word) in own[CHAIN..].iter().zip((first + CHAIN as u32..).step_by(2)) {
            let sum = out.id();
            out.put(Op::Load, &[uint, sum, *own]);
            self.increase(out, word, sum);
        }
    }

    /// Increments the counter of a block, where the block runs.
    pub(super) fn count(self, out: &mut Edited, counter: u32) {
        self.increase(out, 2 * counter, self.zero + 1);
    }

    /// Adds to a number of 64 bits: to its lower word, and the carry to its upper one.
    fn increase(self, out: &mut Edited, word: u32, by: u32) {
        let Self { uint, boolean, word_pointer, variable, zero, .. } = self;
        let (scope, semantics) = (zero + Scope::Device as u32, zero + MemorySemantics::RELAXED.bits());
        let [low, high, before, after, over, carry, upper] = std::array::from_fn(|_| out.id());
        out.put(Op::AccessChain, &[word_pointer, low, variable, zero, zero + word]);
        out.put(Op::AccessChain, &[word_pointer, high, variable, zero, zero + word + 1]);
        out.put(Op::AtomicIAdd, &[uint, before, low, scope, semantics, by]);
        out.put(Op::IAdd, &[uint, after, before, by]);
        out.put(Op::ULessThan, &[boolean, over, after, before]);
        out.put(Op::Select, &[uint, carry, over, zero + 1, zero]);
        out.put(Op::AtomicIAdd, &[uint, upper, high, scope, semantics, carry]);
    }

    /// Records that this element is accessed: raises the number at `note` to one more than the element's.
    #[cfg(feature = "measure")]
    pub(super) fn note(self, out: &mut Edited, note: u32, element: u32, unsigned: bool) {
        let Self { uint, word_pointer, variable, zero, .. } = self;
        let constant = |number: u32| zero + number;
        let (one, scope) = (constant(1), constant(Scope::Device as u32));
        let semantics = constant(MemorySemantics::RELAXED.bits());
        let [cast, place, after, before] = std::array::from_fn(|_| out.id());
        if !unsigned {
            out.put(Op::Bitcast, &[uint, cast, element]);
        }
        let element = if unsigned { element } else { cast };
        out.put(Op::AccessChain, &[word_pointer, place, variable, zero, constant(note)]);
        out.put(Op::IAdd, &[uint, after, element, one]);
        out.put(Op::AtomicUMax, &[uint, before, place, scope, semantics, after]);
    }
}
