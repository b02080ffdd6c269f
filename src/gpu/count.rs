//! What a kernel really does: its SPIR-V is rewritten so that each block counts how often it runs, and what a block does
//! once is read off its instructions.
//!
//! Additions, subtractions and multiplications of floats count one a component, a fused multiplication and addition two;
//! divisions and square roots are counted apart, and so are exponentials, logarithms and circular functions. Integers,
//! comparisons, minima, maxima and conversions are not counted. Loads and stores count the bytes of buffers that they name.

use std::collections::BTreeMap;

/// The binding of the counters, beyond every buffer of a frame.
pub(super) const BINDING: u32 = 200;
/// SPIR-V's storage class of buffers.
const STORAGE_BUFFER: u32 = 12;

/// What a block does when it runs once.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Block {
    /// Whether the kernel begins with it.
    entry: bool,
    /// Additions and multiplications.
    flops: u32,
    /// Divisions and square roots.
    roots: u32,
    /// Exponentials and the like.
    exps: u32,
    /// Bytes read and written, by binding.
    moved: BTreeMap<u32, [u32; 2]>,
}

/// What a kernel has done.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Tally {
    /// Invocations, whole groups.
    pub invocations: u64,
    /// Additions and multiplications of floats.
    pub flops: u64,
    /// Divisions and square roots.
    pub roots: u64,
    /// Exponentials, logarithms, circular functions.
    pub exps: u64,
    /// Bytes that loads and stores name, by binding: read, written.
    pub moved: BTreeMap<u32, [u64; 2]>,
}

impl Tally {
    pub(super) fn new(blocks: &[Block], counts: &[u64]) -> Self {
        let mut tally = Self::default();
        for (block, &count) in blocks.iter().zip(counts) {
            tally.invocations += if block.entry { count } else { 0 };
            tally.flops += count * u64::from(block.flops);
            tally.roots += count * u64::from(block.roots);
            tally.exps += count * u64::from(block.exps);
            for (&binding, moved) in &block.moved {
                let sum = tally.moved.entry(binding).or_default();
                (sum[0], sum[1]) = (sum[0] + count * u64::from(moved[0]), sum[1] + count * u64::from(moved[1]));
            }
        }
        tally
    }

    /// Adds what another kernel has done.
    pub fn add(&mut self, other: &Self) {
        self.invocations += other.invocations;
        self.flops += other.flops;
        self.roots += other.roots;
        self.exps += other.exps;
        for (&binding, moved) in &other.moved {
            let sum = self.moved.entry(binding).or_default();
            (sum[0], sum[1]) = (sum[0] + moved[0], sum[1] + moved[1]);
        }
    }
}

/// A kernel that counts.
pub(super) struct Counted {
    pub(super) words: Vec<u32>,
    /// Its blocks that count, in the order of their counters.
    pub(super) blocks: Vec<Block>,
}

/// The instructions of a module: opcode and operands.
fn instructions(words: &[u32]) -> impl Iterator<Item = (u32, &[u32])> {
    let mut rest = words.get(5..).unwrap_or_default();
    std::iter::from_fn(move || {
        let length = (rest.first()? >> 16).max(1) as usize;
        let (one, after) = rest.split_at(length.min(rest.len()));
        rest = after;
        Some((one[0] & 0xffff, &one[1..]))
    })
}

/// What is known of a module's ids.
#[derive(Default)]
struct Ids {
    /// Components and bytes of each type; of a pointer none.
    types: BTreeMap<u32, [u32; 2]>,
    constants: BTreeMap<u32, u32>,
    /// The type of each value.
    values: BTreeMap<u32, u32>,
    bindings: BTreeMap<u32, u32>,
    /// The binding behind each pointer into a buffer.
    pointers: BTreeMap<u32, u32>,
    /// The GLSL instructions.
    glsl: u32,
    entry: u32,
    uint: Option<u32>,
    boolean: Option<u32>,
}

impl Ids {
    fn components(&self, ty: u32) -> u32 {
        self.types.get(&ty).map_or(1, |size| size[0])
    }

    fn bytes_of(&self, value: u32) -> u32 {
        self.values.get(&value).and_then(|ty| self.types.get(ty)).map_or(4, |size| size[1])
    }

    /// Learns from an instruction what it declares.
    fn learn(&mut self, op: u32, of: &[u32]) {
        let size = |ids: &Self, ty: u32| ids.types.get(&ty).copied().unwrap_or([1, 4]);
        match (op, of) {
            (11, [id, ..]) => self.glsl = *id,
            (15, [_, id, ..]) => self.entry = *id,
            (71, [id, 33, number]) => {
                self.bindings.insert(*id, *number);
            }
            (20, [id]) => {
                self.boolean = Some(*id);
                self.types.insert(*id, [1, 4]);
            }
            (21 | 22, [id, bits, ..]) => {
                if of == [*id, 32, 0] {
                    self.uint = Some(*id);
                }
                self.types.insert(*id, [1, bits / 8]);
            }
            (23 | 24, [id, part, count]) => {
                let [components, bytes] = size(self, *part);
                self.types.insert(*id, [components * count, bytes * count]);
            }
            (28, [id, part, length]) => {
                let count = self.constants.get(length).copied().unwrap_or(1);
                self.types.insert(*id, [1, size(self, *part)[1] * count]);
            }
            (30, [id, members @ ..]) => {
                let bytes = members.iter().map(|member| size(self, *member)[1]).sum();
                self.types.insert(*id, [1, bytes]);
            }
            (19 | 29 | 32 | 33, [id, ..]) => {
                self.types.insert(*id, [1, 0]);
            }
            (43, [_, id, value]) => {
                self.constants.insert(*id, *value);
            }
            (59, [_, id, STORAGE_BUFFER, ..]) => {
                if let Some(&binding) = self.bindings.get(id) {
                    self.pointers.insert(*id, binding);
                }
            }
            (65 | 66, [_, id, base, ..]) => {
                if let Some(&binding) = self.pointers.get(base) {
                    self.pointers.insert(*id, binding);
                }
            }
            _ => {}
        }
        if let [ty, value, ..] = of
            && op > 33
            && self.types.contains_key(ty)
        {
            self.values.insert(*value, *ty);
        }
    }

    /// Adds what an instruction does to its block.
    fn add(&self, block: &mut Block, op: u32, of: &[u32]) {
        let mut moves = |pointer: u32, read: u32, written: u32| {
            if let Some(&binding) = self.pointers.get(&pointer) {
                let sum = block.moved.entry(binding).or_default();
                (sum[0], sum[1]) = (sum[0] + read, sum[1] + written);
            }
        };
        match (op, of) {
            (61, [_, id, pointer, ..]) => return moves(*pointer, self.bytes_of(*id), 0),
            (62, [pointer, value, ..]) => return moves(*pointer, 0, self.bytes_of(*value)),
            (227, [_, _, pointer, ..]) => return moves(*pointer, 4, 0),
            (228, [pointer, ..]) => return moves(*pointer, 0, 4),
            (229..=242, [_, _, pointer, ..]) => return moves(*pointer, 4, 4),
            _ => {}
        }
        let [ty, _, rest @ ..] = of else { return };
        let n = self.components(*ty);
        let operand =
            |k: usize| rest.get(k).and_then(|value| self.values.get(value)).map_or(n, |ty| self.components(*ty));
        match op {
            129 | 131 | 133 | 142 | 143 | 147 => block.flops += n,
            136 | 140 | 141 => block.roots += n,
            144 => block.flops += 2 * operand(1) - n,
            145 => block.flops += 2 * operand(0) - n,
            148 => block.flops += 2 * operand(0) - 1,
            12 if rest.first() == Some(&self.glsl) => {
                let vector = operand(2);
                let [flops, roots, exps] = match rest.get(1) {
                    Some(13..=25 | 27..=30) => [0, 0, n],
                    Some(26) => [0, 0, 2 * n],
                    Some(31 | 32) => [0, n, 0],
                    Some(46) => [3 * n, 0, 0],
                    Some(50) => [2 * n, 0, 0],
                    Some(66) => [2 * vector - 1, 1, 0],
                    Some(67) => [3 * vector - 1, 1, 0],
                    Some(68) => [9, 0, 0],
                    Some(69) => [3 * vector - 1, 1, 0],
                    Some(71) => [4 * vector, 0, 0],
                    _ => [0; 3],
                };
                (block.flops, block.roots, block.exps) = (block.flops + flops, block.roots + roots, block.exps + exps);
            }
            _ => {}
        }
    }
}

/// The kernel with counters at [`BINDING`]; none where the SPIR-V is not of the kind that the build makes.
pub(super) fn counted(words: &[u32]) -> Option<Counted> {
    let (mut ids, mut all, mut function) = (Ids::default(), Vec::<Block>::new(), 0);
    for (op, of) in instructions(words) {
        ids.learn(op, of);
        match (op, of) {
            (54, [_, id, ..]) => function = *id,
            (248, _) => {
                let first = function == ids.entry && !all.iter().any(|block| block.entry);
                all.push(Block { entry: first, ..Block::default() });
            }
            _ => {
                if let Some(block) = all.last_mut() {
                    ids.add(block, op, of);
                }
            }
        }
    }
    let counts: Vec<bool> = all.iter().map(|block| *block != Block::default()).collect();
    let mut out = Rewriter::new(words, &ids)?;
    let (mut next, mut waiting, mut number) = (0, None, 0);
    let mut blocks = Vec::new();
    for (op, of) in instructions(words) {
        // Counting comes after the phis and variables of a block.
        if let Some(number) = waiting
            && !matches!(op, 8 | 245 | 59 | 317)
        {
            out.count(number);
            waiting = None;
        }
        out.pass(op, of, counts.iter().filter(|counts| **counts).count() as u32);
        if op == 248 {
            if counts[number] {
                (waiting, next) = (Some(next), next + 1);
                blocks.push(all[number].clone());
            }
            number += 1;
        }
    }
    Some(Counted { words: out.finish(), blocks })
}

/// A module being written anew.
struct Rewriter {
    words: Vec<u32>,
    /// The types of numbers and of truths, and whether they are new.
    uint: (u32, bool),
    boolean: (u32, bool),
    /// Types of the array and its struct, pointers to it and into it, the variable, then constants.
    base: u32,
    decorated: bool,
    declared: bool,
    /// The largest number.
    largest: u32,
}

impl Rewriter {
    fn new(words: &[u32], ids: &Ids) -> Option<Self> {
        let mut bound = *words.get(3)?;
        let mut known = |id: Option<u32>| {
            id.map_or_else(
                || {
                    bound += 1;
                    (bound - 1, true)
                },
                |id| (id, false),
            )
        };
        let (uint, boolean) = (known(ids.uint), known(ids.boolean));
        let words = words.get(..5)?.to_vec();
        Some(Self { words, uint, boolean, base: bound, decorated: false, declared: false, largest: 0 })
    }

    fn put(&mut self, op: u32, of: &[u32]) {
        self.words.push(((of.len() as u32 + 1) << 16) | op);
        self.words.extend(of);
    }

    fn id(&mut self) -> u32 {
        self.words[3] += 1;
        self.words[3] - 1
    }

    /// Copies an instruction, with what has to come before it or belongs to it.
    fn pass(&mut self, op: u32, of: &[u32], blocks: u32) {
        let [array, record, whole, word, variable] = std::array::from_fn(|k| self.base + k as u32);
        if matches!(op, 71 | 72) && !self.decorated {
            self.decorated = true;
            self.put(71, &[array, 6, 4]);
            self.put(71, &[record, 2]);
            self.put(72, &[record, 0, 35, 0]);
            self.put(71, &[variable, 34, 0]);
            self.put(71, &[variable, 33, BINDING]);
        }
        if op == 54 && !self.declared {
            self.declared = true;
            let (uint, boolean) = (self.uint, self.boolean);
            if uint.1 {
                self.put(21, &[uint.0, 32, 0]);
            }
            if boolean.1 {
                self.put(20, &[boolean.0]);
            }
            self.put(29, &[array, uint.0]);
            self.put(30, &[record, array]);
            self.put(32, &[whole, STORAGE_BUFFER, record]);
            self.put(32, &[word, STORAGE_BUFFER, uint.0]);
            self.put(59, &[whole, variable, STORAGE_BUFFER]);
            // The numbers 0, 1, ..., and the largest one.
            let numbers = self.base + 5;
            for number in 0..2 * blocks.max(1) {
                self.put(43, &[uint.0, numbers + number, number]);
            }
            self.largest = numbers + 2 * blocks.max(1);
            self.put(43, &[uint.0, self.largest, u32::MAX]);
            self.words[3] = self.largest + 1;
        }
        if op == 15 {
            return self.put(op, &[of, &[variable]].concat());
        }
        self.put(op, of);
    }

    /// One more run of this block: the lower word, and the upper one where it overflows.
    fn count(&mut self, block: u32) {
        let [_, _, _, word, variable, numbers, one] = std::array::from_fn(|k| self.base + k as u32);
        let zero = numbers;
        let (uint, boolean) = (self.uint.0, self.boolean.0);
        let [low, high, before, full, carry, after] = std::array::from_fn(|_| self.id());
        self.put(65, &[word, low, variable, zero, numbers + 2 * block]);
        self.put(65, &[word, high, variable, zero, numbers + 2 * block + 1]);
        self.put(234, &[uint, before, low, one, zero, one]);
        self.put(170, &[boolean, full, before, self.largest]);
        self.put(169, &[uint, carry, full, one, zero]);
        self.put(234, &[uint, after, high, one, zero, carry]);
    }

    fn finish(self) -> Vec<u32> {
        self.words
    }
}
