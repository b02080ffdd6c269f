//! Runs a dispatch: group by group, all invocations of a group block by block. Groups run at once on all processors if
//! nothing watches them, and if no result depends on their order.

use std::sync::atomic::{AtomicU64, Ordering};

use rayon::prelude::*;
use spirq::spirv::BuiltIn;

use super::code::{
    Access, Act, Atomic, BEYOND, Block, Change, Code, Decoded, Edge, End, Exchange, Function, Pointer, Root,
};
use super::memory::{Launched, Part, UNDEFINED, UNDEFINED_SHARED, is_undefined};
use super::pointers::rest;
use super::watch::{Touch, Watch};

/// A dispatch of a kernel.
pub(super) struct Launch<'a> {
    pub(super) code: &'a Code,
    pub(super) asked: &'a Launched<'a>,
    /// Push constants: as many words as the kernel takes.
    pub(super) push: &'a [u32],
    /// What is bound for each buffer of the kernel.
    pub(super) bound: &'a [Part],
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
        let count = self.asked.groups.iter().try_fold(1u64, |all, count| all.checked_mul(u64::from(*count)));
        let count = count
            .filter(|count| *count <= most)
            .ok_or_else(|| format!("{:?} groups are too many", self.asked.groups))?;
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
        let (code, Launched { groups, subgroup, .. }) = (self.launch.code, *self.launch.asked);
        let [x, y] = [groups[0], groups[1]].map(u64::from);
        let group = [number % x, number / x % y, number / (x * y)].map(|k| k as u32);
        let (size, lanes) = (code.group, self.lanes as u32);
        let local = |lane: u32| [lane % size[0], lane / size[0] % size[1], lane / (size[0] * size[1])];
        for (input, first, count) in &code.inputs {
            for (to, k) in (*first..).zip(0..*count as usize) {
                self.fill(to, |lane| match input {
                    BuiltIn::WorkgroupId => group[k],
                    BuiltIn::NumWorkgroups => groups[k],
                    BuiltIn::LocalInvocationId => local(lane)[k],
                    BuiltIn::GlobalInvocationId => group[k] * size[k] + local(lane)[k],
                    BuiltIn::LocalInvocationIndex => lane,
                    BuiltIn::SubgroupId => lane / subgroup,
                    BuiltIn::SubgroupLocalInvocationId => lane % subgroup,
                    BuiltIn::SubgroupSize => subgroup,
                    BuiltIn::NumSubgroups => lanes.div_ceil(subgroup),
                    // What is left are masks of a subgroup, of which the kernel was checked to have no others.
                    mask => mask_word(*mask, lane % subgroup, subgroup, k as u32),
                });
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
                    self.inspect(act, *at, &lanes);
                }
                self.execute(act, *at, &lanes);
                if self.watch.is_some() {
                    self.spread(act, &lanes);
                }
            }
            self.end(block, lanes);
            blocks += 1;
            if blocks == self.launch.asked.most_blocks {
                self.waiting.clear();
                return Err(format!("group {number} did not end within {blocks} blocks"));
            }
        }
        Ok(())
    }

    /// Sends invocations to the blocks where they go on.
    fn end(&mut self, block: &Block, mut lanes: Lanes) {
        let End { on, cases, otherwise } = &block.end;
        if !cases.is_empty() {
            self.check(*on, block.at.last().copied().unwrap_or_default(), &lanes);
        }
        for (value, edge) in cases {
            let mut taken = self.list();
            lanes.retain(|lane| {
                let takes = self.registers[*on as usize * self.lanes + *lane as usize] == *value;
                if takes {
                    taken.push(*lane);
                }
                !takes
            });
            self.go(edge, taken);
        }
        match otherwise {
            Some(edge) => self.go(edge, lanes),
            None => self.spare.push(lanes),
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
        let a = a as usize * self.lanes;
        self.put(d, lanes, |own, lane| own[a + lane]);
    }

    /// Gives these invocations a value in this register, which depends on all registers and the invocation.
    fn put(&mut self, d: u32, lanes: &[u16], value: impl Fn(&[u32], usize) -> u32) {
        let d = d as usize * self.lanes;
        for lane in lanes.iter().map(|lane| *lane as usize) {
            self.registers[d + lane] = value(&self.registers, lane);
        }
    }

    /// Executes an instruction for these invocations.
    fn execute(&mut self, act: &Act, at: u32, lanes: &[u16]) {
        match *act {
            Act::Compute(f, d, of) => {
                let [a, b, c] = of.map(|register| register as usize * self.lanes);
                match f {
                    Function::One(f) => self.put(d, lanes, |own, lane| f(own[a + lane])),
                    Function::Two(f) => self.put(d, lanes, |own, lane| f(own[a + lane], own[b + lane])),
                    Function::Three(f) => self.put(d, lanes, |own, k| f(own[a + k], own[b + k], own[c + k])),
                    Function::Select => self.put(d, lanes, |own, k| own[if own[a + k] == 0 { c } else { b } + k]),
                }
            }
            Act::Move(d, a) => self.copy(d, a, lanes),
            Act::Chain(ref chain) => {
                for lane in lanes {
                    let base = chain.base.map_or(0, |base| self.get(base, *lane));
                    let terms =
                        chain.terms.iter().map(|(index, stride, count)| (self.get(*index, *lane), *stride, *count));
                    let found = rest(base, terms);
                    self.set(chain.d, *lane, found);
                }
            }
            Act::Load(ref access) => self.load(access, at, lanes),
            Act::Store(ref access) => self.store(access, at, lanes),
            Act::Atomic(ref atomic) => self.atomic(atomic, at, lanes),
            Act::Length(d, buffer, [first, stride]) => {
                let words = self.launch.bound[buffer as usize].count as u32;
                lanes.iter().for_each(|lane| self.set(d, *lane, words.saturating_sub(first) / stride));
            }
            Act::Barrier(scope, semantics) => {
                self.watch.iter_mut().for_each(|watch| watch.barrier(scope, semantics, lanes, at));
            }
            Act::Fence(scope, semantics) => {
                self.watch.iter_mut().for_each(|watch| watch.fence(scope, semantics, lanes));
            }
            Act::Team(ref team) => self.exchange(team, at, lanes),
            Act::Begin(first, count) => {
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
                let within = word < count && first + word < self.launch.asked.memory[memory].len();
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
            Place::Buffer { memory, word } => self.launch.asked.memory[memory].get(word),
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
                        self.launch.asked.memory[memory].set(word, value);
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
            let new = |old: u32| match atomic.change {
                Change::Store => operand,
                Change::Apply(f) => f(old, operand),
                Change::Compare { .. } if old == compared => operand,
                Change::Load | Change::Compare { .. } => old,
            };
            let old = match place {
                Place::Buffer { memory, word } => self.launch.asked.memory[memory].change(word, new),
                Place::Shared(at) => changed(&mut self.shared[at], new),
                Place::Register(at) => changed(&mut self.registers[at], new),
            };
            self.set(atomic.d, *lane, old);
            if let (Some(watch), Touch::Atomic { reads: true, .. }) = (&mut self.watch, touch) {
                watch.loaded(old, &atomic.pointer, (*lane, at), Some(place));
                self.check(atomic.d, at, &[*lane]);
            }
        }
    }

    /// Tells the watch of values that nothing wrote which an instruction is about to store or to go by.
    fn inspect(&mut self, act: &Act, at: u32, lanes: &[u16]) {
        match act {
            Act::Chain(chain) => {
                chain.terms.iter().for_each(|(index, ..)| self.check(*index, at, lanes));
            }
            Act::Store(access) if access.plain => {
                access.registers.iter().for_each(|own| self.check(*own, at, lanes));
            }
            Act::Atomic(atomic) => {
                self.check(atomic.a, at, lanes);
                if let Change::Compare { with, .. } = atomic.change {
                    self.check(with, at, lanes);
                }
            }
            Act::Team(team) => {
                // What is taken, or becomes a part of a sum, is none in the result.
                let carried = matches!(team.kind, Exchange::Take(_) | Exchange::First | Exchange::Fold(..));
                let decides = team.a.iter().filter(|_| !carried);
                decides.chain(&team.b).for_each(|own| self.check(*own, at, lanes));
            }
            _ => {}
        }
    }

    /// What is computed from a value that nothing wrote is none either.
    fn spread(&mut self, act: &Act, lanes: &[u16]) {
        let Act::Compute(f, d, of) = *act else { return };
        for lane in lanes {
            let none = of[..f.depends()].iter().map(|own| self.get(*own, *lane)).find(|word| is_undefined(*word));
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

/// Changes a word; returns the old one.
fn changed(word: &mut u32, new: impl Fn(u32) -> u32) -> u32 {
    let new = new(*word);
    std::mem::replace(word, new)
}

/// A word of a mask of the invocations of a subgroup that are, seen from one of them, before or after it.
fn mask_word(input: BuiltIn, own: u32, size: u32, word: u32) -> u32 {
    let fits = |bit: u32| match input {
        BuiltIn::SubgroupEqMask => bit == own,
        BuiltIn::SubgroupGeMask => bit >= own,
        BuiltIn::SubgroupGtMask => bit > own,
        BuiltIn::SubgroupLeMask => bit <= own,
        _ => bit < own,
    };
    (0..32).filter(|k| 32 * word + k < size && fits(32 * word + k)).fold(0, |mask, k| mask | 1 << k)
}
