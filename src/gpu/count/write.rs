//! A copy of a SPIR-V module, with a buffer of counters and the instructions that increment them.

use spirq::spirv::{Decoration, MemorySemantics, Op, Scope, StorageClass};

use super::read::Module;
use crate::gpu::spirv_module::{BOUND, HEADER_WORDS, Instruction, append};

/// The binding of the counters, beyond every buffer of a frame.
pub(crate) const BINDING: u32 = 200;

/// A module being copied.
pub(super) struct Rewriter {
    words: Vec<u32>,
    uint: ScalarType,
    boolean: ScalarType,
    ids: Ids,
    /// Blocks that count.
    counters: u32,
    decorated: bool,
    declared: bool,
}

/// A scalar type that the counting code needs.
struct ScalarType {
    id: u32,
    /// Whether the module lacks it, so that it has to be declared.
    added: bool,
}

/// The ids of what is added to a module, one after the other.
struct Ids {
    /// The type of the array of counters.
    array: u32,
    /// The type of the struct around it.
    record: u32,
    /// The type of a pointer to the struct.
    record_pointer: u32,
    /// The type of a pointer to one word.
    word_pointer: u32,
    /// The buffer.
    variable: u32,
    /// The constant 0; `zero + n` is the constant n, up to twice the number of counters.
    zero: u32,
    /// The constant of all ones.
    largest: u32,
}

impl Rewriter {
    pub(super) fn new(words: &[u32], module: &Module, counters: u32) -> Option<Self> {
        let mut bound = *words.get(BOUND)?;
        let mut scalar = |known: Option<u32>| match known {
            Some(id) => ScalarType { id, added: false },
            None => {
                bound += 1;
                ScalarType { id: bound - 1, added: true }
            }
        };
        let (uint, boolean) = (scalar(module.uint), scalar(module.boolean));
        let [array, record, record_pointer, word_pointer, variable, zero] = std::array::from_fn(|k| bound + k as u32);
        let largest = zero + 2 * counters.max(1);
        let ids = Ids { array, record, record_pointer, word_pointer, variable, zero, largest };
        let words = words.get(..HEADER_WORDS)?.to_vec();
        Some(Self { words, uint, boolean, ids, counters, decorated: false, declared: false })
    }

    fn put(&mut self, op: Op, operands: &[u32]) {
        append(&mut self.words, op, operands);
    }

    /// An id that is not in use.
    fn next_id(&mut self) -> u32 {
        self.words[BOUND] += 1;
        self.words[BOUND] - 1
    }

    /// Copies an instruction, with what has to come before it or belongs to it.
    pub(super) fn pass(&mut self, instruction: Instruction<'_>) {
        match instruction.op {
            Some(Op::Decorate | Op::MemberDecorate) if !self.decorated => self.decorate(),
            Some(Op::Function) if !self.declared => self.declare(),
            // The entry point lists the variables that it uses.
            Some(Op::EntryPoint) => {
                let operands = [instruction.operands, &[self.ids.variable]].concat();
                return self.put(Op::EntryPoint, &operands);
            }
            _ => {}
        }
        self.words.extend(instruction.words);
    }

    /// The layout and the binding of the counters.
    fn decorate(&mut self) {
        self.decorated = true;
        let Ids { array, record, variable, .. } = self.ids;
        self.put(Op::Decorate, &[array, Decoration::ArrayStride as u32, 4]);
        self.put(Op::Decorate, &[record, Decoration::Block as u32]);
        self.put(Op::MemberDecorate, &[record, 0, Decoration::Offset as u32, 0]);
        self.put(Op::Decorate, &[variable, Decoration::DescriptorSet as u32, 0]);
        self.put(Op::Decorate, &[variable, Decoration::Binding as u32, BINDING]);
    }

    /// The types, the buffer of counters and the constants.
    fn declare(&mut self) {
        self.declared = true;
        let Ids { array, record, record_pointer, word_pointer, variable, zero, largest } = self.ids;
        let (uint, boolean) = (self.uint.id, self.boolean.id);
        let class = StorageClass::StorageBuffer as u32;
        if self.uint.added {
            self.put(Op::TypeInt, &[uint, 32, 0]);
        }
        if self.boolean.added {
            self.put(Op::TypeBool, &[boolean]);
        }
        self.put(Op::TypeRuntimeArray, &[array, uint]);
        self.put(Op::TypeStruct, &[record, array]);
        self.put(Op::TypePointer, &[record_pointer, class, record]);
        self.put(Op::TypePointer, &[word_pointer, class, uint]);
        self.put(Op::Variable, &[record_pointer, variable, class]);
        for number in 0..2 * self.counters.max(1) {
            self.put(Op::Constant, &[uint, zero + number, number]);
        }
        self.put(Op::Constant, &[uint, largest, u32::MAX]);
        self.words[BOUND] = largest + 1;
    }

    /// Adds one to a counter of 64 bits: to its lower word, and to its upper one where the lower one overflows.
    pub(super) fn count(&mut self, counter: u32) {
        let Ids { word_pointer, variable, zero, largest, .. } = self.ids;
        let (uint, boolean) = (self.uint.id, self.boolean.id);
        let constant = |number: u32| zero + number;
        let (one, scope) = (constant(1), constant(Scope::Device as u32));
        let semantics = constant(MemorySemantics::RELAXED.bits());
        let [low, high, before, full, carry, after] = std::array::from_fn(|_| self.next_id());
        self.put(Op::AccessChain, &[word_pointer, low, variable, zero, constant(2 * counter)]);
        self.put(Op::AccessChain, &[word_pointer, high, variable, zero, constant(2 * counter + 1)]);
        self.put(Op::AtomicIAdd, &[uint, before, low, scope, semantics, one]);
        self.put(Op::IEqual, &[boolean, full, before, largest]);
        self.put(Op::Select, &[uint, carry, full, one, zero]);
        self.put(Op::AtomicIAdd, &[uint, after, high, scope, semantics, carry]);
    }

    /// Notes that this element is named: the number at `note` becomes at least one more.
    #[cfg(feature = "measure")]
    pub(super) fn note(&mut self, note: u32, element: u32, unsigned: bool) {
        let Ids { word_pointer, variable, zero, .. } = self.ids;
        let uint = self.uint.id;
        let constant = |number: u32| zero + number;
        let (one, scope) = (constant(1), constant(Scope::Device as u32));
        let semantics = constant(MemorySemantics::RELAXED.bits());
        let [cast, place, after, before] = std::array::from_fn(|_| self.next_id());
        if !unsigned {
            self.put(Op::Bitcast, &[uint, cast, element]);
        }
        let element = if unsigned { element } else { cast };
        self.put(Op::AccessChain, &[word_pointer, place, variable, zero, constant(note)]);
        self.put(Op::IAdd, &[uint, after, element, one]);
        self.put(Op::AtomicUMax, &[uint, before, place, scope, semantics, after]);
    }

    pub(super) fn finish(self) -> Vec<u32> {
        self.words
    }
}
