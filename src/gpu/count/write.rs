//! A module of SPIR-V written anew, with counters.

use super::read::Ids;
use super::{BINDING, STORAGE_BUFFER};

/// A module being written anew.
pub(super) struct Rewriter {
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
    pub(super) fn new(words: &[u32], ids: &Ids) -> Option<Self> {
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
    pub(super) fn pass(&mut self, op: u32, of: &[u32], blocks: u32) {
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
    pub(super) fn count(&mut self, block: u32) {
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

    pub(super) fn finish(self) -> Vec<u32> {
        self.words
    }
}
