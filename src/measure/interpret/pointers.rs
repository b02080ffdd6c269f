//! Instructions that have to do with memory, and those of a group or a subgroup.

use spirq::spirv::Op;

use super::arithmetic::{atomic, folded};
use super::builder::{Builder, Value};
use super::code::{Access, Act, Among, Atomic, BEYOND, Chain, Change, Decoded, Exchange, Pointer, Root, Team};
use super::types::Type;

impl Builder<'_> {
    /// Decodes an instruction of memory; false if it is another one.
    pub(super) fn memory_instruction(&mut self, op: Op, operands: &[u32]) -> Decoded<bool> {
        match (op, operands) {
            (Op::Variable, [ty, id, _, initial @ ..]) => {
                let (_, to) = self.types.pointee(*ty)?;
                let count = self.types.count(to)?;
                let first = self.registers(count);
                self.act(Act::Begin(first, count));
                let pointer = self.pointer(*id, Root::Registers(first), to)?;
                for value in initial {
                    for (d, a) in (first..).zip(self.numbers(*value)?) {
                        self.act(Act::Move(d, a));
                    }
                }
                self.set(*id, Value::Pointer(pointer));
            }
            (Op::AccessChain | Op::InBoundsAccessChain | Op::CopyObject, [_, id, base, path @ ..])
                if op != Op::CopyObject || self.pointing(*base).is_ok() =>
            {
                let pointer = self.chain(*base, path)?;
                self.set(*id, Value::Pointer(pointer));
            }
            (Op::Load, [ty, id, from, ..]) => {
                let from = self.pointing(*from)?;
                let numbers = self.load(from)?;
                self.set(*id, Value::Numbers(*ty, numbers));
            }
            (Op::Store, [to, value, ..]) => {
                let (to, numbers) = (self.pointing(*to)?, self.numbers(*value)?);
                self.store(to, numbers)?;
            }
            (Op::CopyMemory, [to, from, ..]) => {
                let (to, from) = (self.pointing(*to)?, self.pointing(*from)?);
                let numbers = self.load(from)?;
                self.store(to, numbers)?;
            }
            (Op::ArrayLength, [ty, id, of, member]) => {
                let of = self.pointing(*of)?;
                let (array, first) = self.types.member_at(of.ty, *member, true)?;
                let (stride, ..) = self.types.stride(array, true)?;
                let Root::Buffer(buffer) = of.root else { return Err("it asks for the length of no buffer".into()) };
                let d = self.registers(1);
                self.act(Act::Length(d, buffer, [first, stride.max(1)]));
                self.set(*id, Value::Numbers(*ty, vec![d]));
            }
            _ => return self.atomic_instruction(op, operands),
        }
        Ok(true)
    }

    fn atomic_instruction(&mut self, op: Op, operands: &[u32]) -> Decoded<bool> {
        // The result's type and id, the pointer, the semantics, and other operands.
        let (result, [pointer, _, semantics, of @ ..]) = (match (op, operands) {
            (Op::AtomicStore, rest) => (None, rest),
            (_, [ty, id, rest @ ..]) => (Some((*ty, *id)), rest),
            _ => return Ok(false),
        }) else {
            return Ok(false);
        };
        let (change, operand) = match (op, of) {
            (Op::AtomicStore, [value]) => (Change::Store, Some(value)),
            (Op::AtomicLoad, []) => (Change::Load, None),
            (Op::AtomicCompareExchange, [unequal, value, compared]) => {
                let (with, unequal) = (self.single(*compared)?, self.known_number(*unequal)?);
                (Change::Compare { with, unequal }, Some(value))
            }
            (op, of) => match atomic(op) {
                Some(f) => (Change::Apply(f), of.first()),
                None => return Ok(false),
            },
        };
        let operand = match operand {
            Some(value) => self.single(*value)?,
            None => self.number(1),
        };
        let d = self.registers(1);
        let semantics = self.known_number(*semantics)?;
        if let Some((ty, id)) = result {
            self.code.ordered |= self.taken.contains(&id);
            self.set(id, Value::Numbers(ty, vec![d]));
        }
        let pointer = self.pointing(*pointer)?;
        if !matches!(self.types.get(pointer.ty)?, Type::Int | Type::Float) {
            return Err(format!("it has Op{op:?} on what is no number"));
        }
        self.act(Act::Atomic(Box::new(Atomic { pointer, d, a: operand, change, semantics })));
        Ok(true)
    }

    /// A number that is known before the kernel runs.
    fn known_number(&self, id: u32) -> Decoded<u32> {
        self.constant(self.single(id)?).ok_or_else(|| "a scope or its semantics are no constant".into())
    }

    /// The pointer to a part of what another one points to.
    fn chain(&mut self, base: u32, path: &[u32]) -> Decoded<Pointer> {
        let mut pointer = self.pointing(base)?;
        // Push constants have registers for all words of their memory.
        let laid = self.is_laid(&pointer);
        self.made += path.len();
        let mut terms = Vec::new();
        for index in path {
            let register = self.single(*index)?;
            let known = self.constant(register);
            if matches!(self.types.get(pointer.ty)?, Type::Struct(_)) {
                let member = known.ok_or("the number of a member is no constant")?;
                let (ty, first) = self.types.member_at(pointer.ty, member, laid)?;
                (pointer.ty, pointer.fixed) = (ty, pointer.fixed.saturating_add(first));
                continue;
            }
            let (stride, of, count) = self.types.stride(pointer.ty, laid)?;
            pointer.ty = of;
            let within = known.filter(|index| *index < count && count < u32::MAX);
            match within.and_then(|index| index.checked_mul(stride)) {
                Some(words) => pointer.fixed = pointer.fixed.saturating_add(words),
                None => terms.push((register, stride, count)),
            }
        }
        if !terms.is_empty() {
            let d = self.registers(1);
            self.act(Act::Chain(Box::new(Chain { d, base: pointer.rest, terms })));
            pointer.rest = Some(d);
        }
        Ok(pointer)
    }

    /// Whether decorations say where the parts of a variable are.
    fn is_laid(&self, pointer: &Pointer) -> bool {
        matches!(pointer.root, Root::Buffer(_)) || self.is_pushed(pointer)
    }

    fn is_pushed(&self, pointer: &Pointer) -> bool {
        let (first, count) = self.code.pushed;
        matches!(pointer.root, Root::Registers(own) if own == first && count > 0)
    }

    fn is_input(&self, pointer: &Pointer) -> bool {
        self.code.inputs.iter().any(|(_, first, _)| pointer.root == Root::Registers(*first))
    }

    /// The registers of what a pointer points to, once that is loaded.
    fn load(&mut self, pointer: Pointer) -> Decoded<Vec<u32>> {
        let words = self.types.words(pointer.ty, self.is_laid(&pointer))?;
        if let (Root::Registers(first), None) = (pointer.root, pointer.rest) {
            let own: Vec<u32> = words.iter().map(|word| first + pointer.fixed + word).collect();
            // These never change.
            if self.is_pushed(&pointer) || self.is_input(&pointer) {
                return Ok(own);
            }
            let moved = |a: u32| {
                let d = self.registers(1);
                self.act(Act::Move(d, a));
                d
            };
            return Ok(own.into_iter().map(moved).collect());
        }
        let first = self.registers(words.len() as u32);
        let registers: Vec<u32> = (first..).take(words.len()).collect();
        let access = self.access(pointer, registers.clone(), words);
        self.act(Act::Load(access));
        Ok(registers)
    }

    fn store(&mut self, pointer: Pointer, numbers: Vec<u32>) -> Decoded<()> {
        let words = self.types.words(pointer.ty, self.is_laid(&pointer))?;
        if let (Root::Registers(first), None) = (pointer.root, pointer.rest) {
            for (word, a) in words.iter().zip(numbers) {
                self.act(Act::Move(first + pointer.fixed + word, a));
            }
            return Ok(());
        }
        let access = self.access(pointer, numbers, words);
        self.act(Act::Store(access));
        Ok(())
    }

    fn access(&mut self, pointer: Pointer, registers: Vec<u32>, words: Vec<u32>) -> Box<Access> {
        self.made += words.len();
        let (plain, floats) = (!self.types.is_composite(pointer.ty), self.types.is_float(pointer.ty));
        Box::new(Access { pointer, registers, words, plain, floats })
    }

    /// Decodes an instruction of a group or a subgroup; false if it is another one.
    pub(super) fn group_instruction(&mut self, op: Op, operands: &[u32]) -> Decoded<bool> {
        match (op, operands) {
            (Op::ControlBarrier, [scope, .., semantics]) | (Op::MemoryBarrier, [scope, semantics]) => {
                let (scope, semantics) = (self.known_number(*scope)?, self.known_number(*semantics)?);
                let waits = op == Op::ControlBarrier;
                self.act(if waits { Act::Barrier(scope, semantics) } else { Act::Fence(scope, semantics) });
                return Ok(true);
            }
            _ => {}
        }
        let (Some((kind, whole)), [ty, id, _, of @ ..]) = (self.exchange(op, operands)?, operands) else {
            return Ok(false);
        };
        // After the scope, some have a literal that says how they fold.
        let counts = matches!(kind, Exchange::Fold(..) | Exchange::Count(_));
        let of = of.get(usize::from(counts)..).unwrap_or_default();
        let value = of.first().map_or(Ok(Vec::new()), |id| self.numbers(*id))?;
        let takes = matches!(kind, Exchange::Take(_) | Exchange::Bit);
        let operand = of.get(1).filter(|_| takes).map(|id| self.single(*id)).transpose()?;
        if value.is_empty() && !matches!(kind, Exchange::Elect) {
            return Err(format!("it has Op{op:?} without a value"));
        }
        let d = self.new_value(*ty)?;
        let teams = match whole {
            true => vec![(d.clone(), value)],
            false => d.iter().zip(value).map(|(d, a)| (vec![*d], vec![a])).collect(),
        };
        for (d, a) in teams {
            self.act(Act::Team(Box::new(Team { kind, d, a, b: operand })));
        }
        self.set(*id, Value::Numbers(*ty, d));
        Ok(true)
    }

    /// What an operation of a subgroup does, and whether it takes all numbers of its value together.
    fn exchange(&self, op: Op, operands: &[u32]) -> Decoded<Option<(Exchange, bool)>> {
        let how = |at: usize| {
            Ok(match (operands.get(at), operands.last()) {
                (Some(0), _) => Among::All,
                (Some(1), _) => Among::UpToOwn,
                (Some(2), _) => Among::BeforeOwn,
                (Some(3), Some(size)) => Among::Run(self.known_number(*size)?.max(1)),
                _ => return Err("it folds a subgroup in a way that is not known".to_string()),
            })
        };
        Ok(Some(match op {
            Op::GroupNonUniformElect => (Exchange::Elect, true),
            Op::GroupNonUniformAll => (Exchange::All, true),
            Op::GroupNonUniformAny => (Exchange::Any, true),
            Op::GroupNonUniformAllEqual => (Exchange::Equal, true),
            Op::GroupNonUniformBroadcast | Op::GroupNonUniformShuffle => (Exchange::Take(|_, from| from), false),
            Op::GroupNonUniformBroadcastFirst => (Exchange::First, false),
            Op::GroupNonUniformShuffleXor => (Exchange::Take(|own, mask| own ^ mask), false),
            Op::GroupNonUniformShuffleUp => (Exchange::Take(u32::wrapping_sub), false),
            Op::GroupNonUniformShuffleDown => (Exchange::Take(u32::wrapping_add), false),
            Op::GroupNonUniformQuadBroadcast => (Exchange::Take(|own, from| own & !3 | from & 3), false),
            Op::GroupNonUniformQuadSwap => (Exchange::Take(|own, way| own ^ way.wrapping_add(1)), false),
            Op::GroupNonUniformBallot => (Exchange::Ballot, true),
            Op::GroupNonUniformInverseBallot | Op::GroupNonUniformBallotBitExtract => (Exchange::Bit, true),
            Op::GroupNonUniformBallotBitCount => (Exchange::Count(how(3)?), true),
            Op::GroupNonUniformBallotFindLSB => (Exchange::Lowest, true),
            Op::GroupNonUniformBallotFindMSB => (Exchange::Highest, true),
            other => match folded(other) {
                Some((f, first)) => (Exchange::Fold(f, first, how(3)?), false),
                None => return Ok(None),
            },
        }))
    }
}

/// Where the rest of a pointer leads, from indices and the words between their elements.
pub(super) fn rest(base: u32, terms: impl Iterator<Item = (u32, u32, u32)>) -> u32 {
    let (mut sum, mut beyond) = (u64::from(base & !BEYOND), base & BEYOND);
    for (index, stride, count) in terms {
        sum = sum.saturating_add(u64::from(index) * u64::from(stride));
        if index >= count {
            beyond = BEYOND;
        }
    }
    (sum.min(u64::from(BEYOND - 1)) as u32) | beyond
}
