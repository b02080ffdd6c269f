//! Runs a dispatch: group by group, all invocations of a group block by block. Groups run at once on all processors if
//! nothing watches them, and if no result depends on their order.

use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;
use spirq::spirv::BuiltIn;

use super::code::{Access, Act, Atomic, BEYOND, Block, Change, Code, Decoded, Edge, End, Exchange, Pointer, Root};
use super::memory::{Memory, Part, UNDEFINED, UNDEFINED_SHARED, is_undefined};
use super::pointers::rest;
use super::watch::{Touch, Watch};

/// A dispatch.
pub(super) struct Launch<'a> {
    pub(super) code: &'a Code,
    pub(super) groups: [u32; 3],
    /// Push constants: as many words as the kernel takes.
    pub(super) push: &'a [u32],
    /// What is bound for each buffer of the kernel.
    pub(super) bound: &'a [Part],
    pub(super) memory: &'a [&'a Memory],
    /// Invocations of a subgroup.
    pub(super) subgroup: u32,
    /// Most blocks that a group runs: a kernel that takes more is said not to end.
    pub(super) most_blocks: u64,
}

/// A word that an invocation accesses.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) enum Place {
    /// Of a buffer.
    Buffer { memory: usize, word: usize },
    /// Of the group's memory.
    Shared(usize),
    /// Of an invocation's own.
    Register(usize),
}

impl Launch<'_> {
    /// Runs it; returns how many instructions of SPIR-V invocations have executed together.
    pub(super) fn run(&self, watch: Option<&mut Watch<'_>>) -> Decoded<u64> {
        let most = u64::from(u32::MAX / self.code.group.iter().product::<u32>());
        let count = self.groups.iter().try_fold(1u64, |all, count| all.checked_mul(u64::from(*count)));
        let count =
            count.filter(|count| *count <= most).ok_or_else(|| format!("{:?} groups are too many", self.groups))?;
        if watch.is_some() || self.code.ordered || count < 2 {
            let mut group = Group::new(self, watch);
            (0..count).try_for_each(|number| group.run(number))?;
            return Ok(group.executed);
        }
        let executed = AtomicU64::new(0);
        (0..count).into_par_iter().try_for_each_init(
            || Group::new(self, None),
            |group, number| {
                let done = group.run(number);
                executed.fetch_add(std::mem::take(&mut group.executed), Ordering::Relaxed);
                done
            },
        )?;
        Ok(executed.into_inner())
    }
}

/// Invocations of a group that are at the same block, in ascending order.
pub(super) type Lanes = Vec<u16>;

/// A group that runs.
pub(super) struct Group<'a, 'w, 'c> {
    pub(super) launch: &'a Launch<'a>,
    pub(super) watch: Option<&'w mut Watch<'c>>,
    /// How many invocations it has.
    pub(super) lanes: usize,
    /// For each register, a word of each invocation.
    pub(super) registers: Vec<u32>,
    shared: Vec<u32>,
    /// Where invocations are: blocks, each once.
    waiting: Vec<(usize, Lanes)>,
    /// Lists that are no longer in use.
    spare: Vec<Lanes>,
    executed: u64,
}

impl<'a, 'w, 'c> Group<'a, 'w, 'c> {
    fn new(launch: &'a Launch<'a>, watch: Option<&'w mut Watch<'c>>) -> Self {
        let lanes = launch.code.group.iter().product::<u32>() as usize;
        let registers = vec![0; launch.code.registers as usize * lanes];
        let shared = vec![UNDEFINED_SHARED; launch.code.shared as usize];
        let (waiting, spare) = (Vec::new(), Vec::new());
        let mut group = Self { launch, watch, lanes, registers, shared, waiting, spare, executed: 0 };
        group.fill_constants();
        for (register, word) in (launch.code.pushed.0..).zip(launch.push) {
            group.fill(register, |_| *word);
        }
        group
    }

    fn fill_constants(&mut self) {
        for (register, value) in &self.launch.code.constants {
            self.fill(*register, |_| *value);
        }
    }

    /// Gives each invocation a value in this register.
    fn fill(&mut self, register: u32, value: impl Fn(u32) -> u32) {
        let first = register as usize * self.lanes;
        for (lane, word) in (0..).zip(&mut self.registers[first..first + self.lanes]) {
            *word = value(lane);
        }
    }

    pub(super) fn get(&self, register: u32, lane: u16) -> u32 {
        self.registers[register as usize * self.lanes + lane as usize]
    }

    pub(super) fn set(&mut self, register: u32, lane: u16, value: u32) {
        self.registers[register as usize * self.lanes + lane as usize] = value;
    }

    /// Gives the built-in values of the group of this number.
    fn inputs(&mut self, number: u64) {
        let Launch { code, groups, subgroup, .. } = self.launch;
        let (groups, subgroup, size) = (*groups, *subgroup, code.group);
        let [x, y] = [groups[0], groups[1]].map(u64::from);
        let group = [number % x, number / x % y, number / (x * y)].map(|k| k as u32);
        let local = move |lane: u32, k: usize| match k {
            0 => lane % size[0],
            1 => lane / size[0] % size[1],
            _ => lane / (size[0] * size[1]),
        };
        let lanes = self.lanes as u32;
        for (input, first) in &code.inputs {
            let [first, second, third] = [*first, first + 1, first + 2];
            let three = [first, second, third].into_iter().zip(0..3);
            match BuiltIn::from_u32(*input) {
                Some(BuiltIn::WorkgroupId) => three.for_each(|(to, k)| self.fill(to, |_| group[k])),
                Some(BuiltIn::NumWorkgroups) => three.for_each(|(to, k)| self.fill(to, |_| groups[k])),
                Some(BuiltIn::LocalInvocationId) => three.for_each(|(to, k)| self.fill(to, |lane| local(lane, k))),
                Some(BuiltIn::GlobalInvocationId) => {
                    three.for_each(|(to, k)| self.fill(to, |lane| group[k] * size[k] + local(lane, k)));
                }
                Some(BuiltIn::LocalInvocationIndex) => self.fill(first, |lane| lane),
                Some(BuiltIn::SubgroupId) => self.fill(first, |lane| lane / subgroup),
                Some(BuiltIn::SubgroupLocalInvocationId) => self.fill(first, |lane| lane % subgroup),
                Some(BuiltIn::SubgroupSize) => self.fill(first, |_| subgroup),
                Some(BuiltIn::NumSubgroups) => self.fill(first, |_| lanes.div_ceil(subgroup)),
                // What is left are masks of a subgroup, of which the kernel was checked to have no others.
                other => (first..first + 4).zip(0..).for_each(|(to, word)| {
                    self.fill(to, |lane| mask(other, lane % subgroup, subgroup, word));
                }),
            }
        }
    }

    /// Runs the group of this number.
    fn run(&mut self, number: u64) -> Decoded<()> {
        self.inputs(number);
        self.shared.fill(UNDEFINED_SHARED);
        if let Some(watch) = &mut self.watch {
            watch.begin(number as u32);
            self.fill_constants();
        }
        let code = self.launch.code;
        let mut blocks = 0u64;
        self.waiting.push((0, (0..self.lanes as u16).collect()));
        while let Some(next) = (0..self.waiting.len()).min_by_key(|k| self.waiting[*k].0) {
            let (at, lanes) = self.waiting.swap_remove(next);
            let block = &code.blocks[at];
            self.executed += block.length * lanes.len() as u64;
            for (act, at) in block.acts.iter().zip(&block.at) {
                if self.watch.is_some() {
                    self.inspect(*act, *at, &lanes);
                }
                self.execute(*act, *at, &lanes);
                if self.watch.is_some() {
                    self.spread(*act, &lanes);
                }
            }
            self.end(block, lanes);
            blocks += 1;
            if blocks == self.launch.most_blocks {
                self.waiting.clear();
                return Err(format!("group {number} did not end within {blocks} blocks"));
            }
        }
        Ok(())
    }

    /// Sends invocations to the blocks where they go on.
    fn end(&mut self, block: &Block, lanes: Lanes) {
        let end_at = block.at.last().copied().unwrap_or_default();
        match &block.end {
            End::Return => self.spare.push(lanes),
            End::Jump(edge) => self.go(edge, lanes),
            End::Branch { on, yes, no } => {
                self.check(*on, end_at, &lanes);
                let (mut taken, mut rest) = (self.list(), lanes);
                rest.retain(|lane| {
                    let stays = self.registers[*on as usize * self.lanes + *lane as usize] == 0;
                    if !stays {
                        taken.push(*lane);
                    }
                    stays
                });
                self.go(yes, taken);
                self.go(no, rest);
            }
            End::Switch { on, cases, otherwise } => {
                self.check(*on, end_at, &lanes);
                let mut rest = lanes;
                for (value, edge) in cases {
                    let mut taken = self.list();
                    rest.retain(|lane| {
                        let takes = self.registers[*on as usize * self.lanes + *lane as usize] == *value;
                        if takes {
                            taken.push(*lane);
                        }
                        !takes
                    });
                    self.go(edge, taken);
                }
                self.go(otherwise, rest);
            }
        }
    }

    fn list(&mut self) -> Lanes {
        let mut list = self.spare.pop().unwrap_or_default();
        list.clear();
        list
    }

    /// Sends invocations along an edge.
    fn go(&mut self, edge: &Edge, lanes: Lanes) {
        if lanes.is_empty() {
            self.spare.push(lanes);
            return;
        }
        for (d, a) in &edge.moves {
            self.copy(*d, *a, &lanes);
        }
        match self.waiting.iter_mut().find(|(block, _)| *block == edge.to) {
            Some((_, there)) => {
                there.extend(&lanes);
                there.sort_unstable();
                self.spare.push(lanes);
            }
            None => self.waiting.push((edge.to, lanes)),
        }
    }

    fn copy(&mut self, d: u32, a: u32, lanes: &[u16]) {
        let (d, a) = (d as usize * self.lanes, a as usize * self.lanes);
        for lane in lanes {
            self.registers[d + *lane as usize] = self.registers[a + *lane as usize];
        }
    }

    /// Executes an instruction for these invocations.
    fn execute(&mut self, act: Act, at: u32, lanes: &[u16]) {
        let code = self.launch.code;
        let first = |register: u32| register as usize * self.lanes;
        match act {
            Act::One { f, d, a } => {
                let (d, a) = (first(d), first(a));
                for lane in lanes.iter().map(|lane| *lane as usize) {
                    self.registers[d + lane] = f(self.registers[a + lane]);
                }
            }
            Act::Two { f, d, a, b } => {
                let (d, a, b) = (first(d), first(a), first(b));
                for lane in lanes.iter().map(|lane| *lane as usize) {
                    self.registers[d + lane] = f(self.registers[a + lane], self.registers[b + lane]);
                }
            }
            Act::Three { f, d, a, b, c } => {
                let (d, a, b, c) = (first(d), first(a), first(b), first(c));
                for lane in lanes.iter().map(|lane| *lane as usize) {
                    let own = |from: usize| self.registers[from + lane];
                    self.registers[d + lane] = f(own(a), own(b), own(c));
                }
            }
            Act::Move { d, a } => self.copy(d, a, lanes),
            Act::Select { d, on, yes, no } => {
                for lane in lanes {
                    let from = if self.get(on, *lane) == 0 { no } else { yes };
                    self.set(d, *lane, self.get(from, *lane));
                }
            }
            Act::Chain(chain) => {
                let chain = &code.chains[chain as usize];
                for lane in lanes {
                    let base = chain.base.map_or(0, |base| self.get(base, *lane));
                    let terms =
                        chain.terms.iter().map(|(index, stride, count)| (self.get(*index, *lane), *stride, *count));
                    let found = rest(base, terms);
                    self.set(chain.d, *lane, found);
                }
            }
            Act::Load(access) => self.load(&code.accesses[access as usize], at, lanes),
            Act::Store(access) => self.store(&code.accesses[access as usize], at, lanes),
            Act::Atomic(atomic) => self.atomic(&code.atomics[atomic as usize], at, lanes),
            Act::Length { d, buffer, first, stride } => {
                let words = self.launch.bound[buffer as usize].count as u32;
                lanes.iter().for_each(|lane| self.set(d, *lane, words.saturating_sub(first) / stride));
            }
            Act::Barrier { scope, semantics } => {
                self.watch.iter_mut().for_each(|watch| watch.barrier(scope, semantics, lanes, at));
            }
            Act::Fence { scope, semantics } => {
                self.watch.iter_mut().for_each(|watch| watch.fence(scope, semantics, lanes));
            }
            Act::Team(team) => self.exchange(&code.teams[team as usize], at, lanes),
            Act::Begin { first, count } => {
                for register in first..first + count {
                    lanes.iter().for_each(|lane| self.set(register, *lane, UNDEFINED));
                }
            }
        }
    }

    /// Where a pointer leads: a word of its variable, and whether an index is beyond the end of its array.
    fn word(&self, pointer: &Pointer, lane: u16) -> (usize, bool) {
        let rest = pointer.rest.map_or(0, |rest| self.get(rest, lane));
        (pointer.fixed as usize + (rest & !BEYOND) as usize, rest & BEYOND != 0)
    }

    /// The place of a word of a variable; none beyond its end.
    fn place(&self, pointer: &Pointer, (word, beyond): (usize, bool), lane: u16) -> Option<Place> {
        if beyond {
            return None;
        }
        match pointer.root {
            Root::Buffer(buffer) => {
                let Part { memory, first, count } = self.launch.bound[buffer as usize];
                let within = word < count && first + word < self.launch.memory[memory].len();
                within.then_some(Place::Buffer { memory, word: first + word })
            }
            Root::Shared(first) => {
                Some(first as usize + word).filter(|word| *word < self.shared.len()).map(Place::Shared)
            }
            Root::Registers(first) => {
                let register = (first as usize + word) * self.lanes + lane as usize;
                (register < self.registers.len()).then_some(Place::Register(register))
            }
        }
    }

    /// The place that an invocation accesses, of which the watch is told.
    fn touched(&mut self, pointer: &Pointer, (offset, touch): (u32, Touch), at: u32, lane: u16) -> Option<Place> {
        let (word, beyond) = self.word(pointer, lane);
        let word = word + offset as usize;
        let place = self.place(pointer, (word, beyond), lane);
        if let Some(watch) = &mut self.watch {
            match place {
                Some(place) => watch.touch(place, pointer.variable, word, (lane, touch, at)),
                None => watch.beyond(pointer, word, beyond, (lane, touch, at)),
            }
        }
        place
    }

    fn read(&self, place: Place) -> u32 {
        match place {
            Place::Buffer { memory, word } => self.launch.memory[memory].get(word),
            Place::Shared(word) => self.shared[word],
            Place::Register(register) => self.registers[register],
        }
    }

    fn load(&mut self, access: &Access, at: u32, lanes: &[u16]) {
        for lane in lanes {
            for (register, offset) in access.registers.iter().zip(&access.words) {
                let place = self.touched(&access.pointer, (*offset, Touch::Read), at, *lane);
                let value = place.map_or(0, |place| self.read(place));
                self.set(*register, *lane, value);
                if let Some(watch) = &mut self.watch {
                    watch.loaded(value, &access.pointer, (*lane, at), place);
                }
            }
        }
    }

    fn store(&mut self, access: &Access, at: u32, lanes: &[u16]) {
        for lane in lanes {
            for (register, offset) in access.registers.iter().zip(&access.words) {
                let value = self.get(*register, *lane);
                match self.touched(&access.pointer, (*offset, Touch::Write), at, *lane) {
                    Some(Place::Buffer { memory, word }) => {
                        self.launch.memory[memory].set(word, value);
                        if let Some(watch) = &mut self.watch {
                            watch.stored(value, access.floats, (memory, word), (*lane, at));
                        }
                    }
                    Some(Place::Shared(word)) => self.shared[word] = value,
                    Some(Place::Register(register)) => self.registers[register] = value,
                    None => {}
                }
            }
        }
    }

    fn atomic(&mut self, atomic: &Atomic, at: u32, lanes: &[u16]) {
        for lane in lanes {
            let operand = self.get(atomic.a, *lane);
            let compared = if let Change::Compare { with, .. } = atomic.change { self.get(with, *lane) } else { 0 };
            // One that finds another word only loads it.
            let (semantics, writes) = match atomic.change {
                Change::Load => (atomic.semantics, false),
                Change::Compare { unequal, .. } => {
                    let place = self.place(&atomic.pointer, self.word(&atomic.pointer, *lane), *lane);
                    let equal = place.is_none_or(|place| self.read(place) == compared);
                    (if equal { atomic.semantics } else { unequal }, equal)
                }
                Change::Store | Change::Apply(_) => (atomic.semantics, true),
            };
            let touch = Touch::Atomic { semantics, reads: !matches!(atomic.change, Change::Store), writes };
            let Some(place) = self.touched(&atomic.pointer, (0, touch), at, *lane) else {
                self.set(atomic.d, *lane, 0);
                continue;
            };
            let old = match place {
                Place::Buffer { memory, word } => {
                    let memory = self.launch.memory[memory];
                    match atomic.change {
                        Change::Load => memory.get(word),
                        Change::Store => memory.apply(word, |_, new| new, operand),
                        Change::Apply(f) => memory.apply(word, f, operand),
                        Change::Compare { .. } => memory.exchange(word, compared, operand),
                    }
                }
                Place::Shared(at) | Place::Register(at) => {
                    let words = if matches!(place, Place::Shared(_)) { &mut self.shared } else { &mut self.registers };
                    let old = words[at];
                    words[at] = match atomic.change {
                        Change::Load => old,
                        Change::Store => operand,
                        Change::Apply(f) => f(old, operand),
                        Change::Compare { .. } => {
                            if old == compared {
                                operand
                            } else {
                                old
                            }
                        }
                    };
                    old
                }
            };
            self.set(atomic.d, *lane, old);
            if let (Some(watch), Touch::Atomic { reads: true, .. }) = (&mut self.watch, touch) {
                watch.loaded(old, &atomic.pointer, (*lane, at), Some(place));
                self.check(atomic.d, at, &[*lane]);
            }
        }
    }

    /// Tells the watch of values that nothing wrote which an instruction is about to store or to go by.
    fn inspect(&mut self, act: Act, at: u32, lanes: &[u16]) {
        let code = self.launch.code;
        match act {
            Act::Chain(chain) => {
                code.chains[chain as usize].terms.iter().for_each(|(index, ..)| self.check(*index, at, lanes));
            }
            Act::Store(access) if code.accesses[access as usize].plain => {
                code.accesses[access as usize].registers.iter().for_each(|own| self.check(*own, at, lanes));
            }
            Act::Atomic(atomic) => {
                let atomic = &code.atomics[atomic as usize];
                self.check(atomic.a, at, lanes);
                if let Change::Compare { with, .. } = atomic.change {
                    self.check(with, at, lanes);
                }
            }
            Act::Team(team) => {
                let team = &code.teams[team as usize];
                // What is taken, or becomes a part of a sum, is none in the result.
                let carried = matches!(team.kind, Exchange::Take(_) | Exchange::First | Exchange::Fold(..));
                let decides = team.a.iter().filter(|_| !carried);
                decides.chain(&team.b).for_each(|own| self.check(*own, at, lanes));
            }
            _ => {}
        }
    }

    /// What is computed from a value that nothing wrote is none either.
    fn spread(&mut self, act: Act, lanes: &[u16]) {
        let (d, from) = match act {
            Act::One { d, a, .. } | Act::Select { d, on: a, .. } => (d, [a; 3]),
            Act::Two { d, a, b, .. } => (d, [a, b, b]),
            Act::Three { d, a, b, c, .. } => (d, [a, b, c]),
            _ => return,
        };
        for lane in lanes {
            let none = from.map(|register| self.get(register, *lane)).into_iter().find(|word| is_undefined(*word));
            none.into_iter().for_each(|word| self.set(d, *lane, word));
        }
    }

    /// Tells the watch where a register has no value; there it becomes 0, so that this is told once.
    fn check(&mut self, register: u32, at: u32, lanes: &[u16]) {
        let Some(watch) = &mut self.watch else { return };
        for lane in lanes {
            let value = &mut self.registers[register as usize * self.lanes + *lane as usize];
            if watch.undefined(*value, *lane, at) {
                *value = 0;
            }
        }
    }
}

/// A word of a mask of the invocations of a subgroup that are, seen from one of them, before or after it.
fn mask(input: Option<BuiltIn>, own: u32, size: u32, word: u32) -> u32 {
    let fits = |bit: u32| match input {
        Some(BuiltIn::SubgroupEqMask) => bit == own,
        Some(BuiltIn::SubgroupGeMask) => bit >= own,
        Some(BuiltIn::SubgroupGtMask) => bit > own,
        Some(BuiltIn::SubgroupLeMask) => bit <= own,
        _ => bit < own,
    };
    (0..32).filter(|k| 32 * word + k < size && fits(32 * word + k)).fold(0, |mask, k| mask | 1 << k)
}
