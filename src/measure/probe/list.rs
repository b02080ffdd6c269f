//! The probes: what each kernel is given, and its exact answer.

use super::{Inputs, LANES, PUSHED, ROWS};

/// A kernel with a known answer.
pub(super) struct Probe {
    /// Its name in results.
    pub(super) name: &'static str,
    /// What it shows.
    pub(super) what: &'static str,
    /// Whether kernels rely on it.
    pub(super) needed: bool,
    /// The operands of its arithmetic.
    pub(super) terms: [f32; 3],
    /// The answer of each lane, from the numbers and the records.
    pub(super) answer: fn(&Inputs, usize) -> u32,
    /// What a device does that gives another answer, where that can be told.
    pub(super) other: fn(u32) -> Option<&'static str>,
}

const NEAR: f32 = 1.0 + 1.0 / 4096.0;

/// The values that most probes share; each has its own name and answer.
const PLAIN: Probe = Probe { name: "", what: "", needed: true, terms: [0.0; 3], answer: |_, _| 0, other: |_| None };

/// The probe that is needed only where a device promises full subgroups.
pub(super) const FULL: &str = "full-subgroups";

pub(super) const PROBES: [Probe; 15] = [
    Probe {
        name: "nested-loops",
        what: "nested loops, where a variable of the inner one indexes a buffer after it",
        needed: false,
        answer: |inputs, lane| {
            let column = |row: usize| inputs.numbers[row * LANES + lane];
            let (mut row, mut sum) = (0, 0u32);
            while row < ROWS {
                let far = !column(row).is_multiple_of(4);
                if far && column(row) / 4 % 2 == 1 {
                    sum += 7 * row as u32 + 1;
                }
                row += if far { 3 } else { 1 };
            }
            sum
        },
        ..PLAIN
    },
    Probe {
        name: "long-loops",
        what: "loops of 90,000 iterations are run to their end",
        needed: false,
        answer: |_, _| 300 * ROWS as u32,
        other: |found| (found < 300 * ROWS as u32).then_some("ended early"),
        ..PLAIN
    },
    Probe {
        name: "rounding",
        what: "addition rounds to nearest",
        // 1 and three quarters of the step above it.
        terms: [1.0, 0.75 * f32::EPSILON, 0.0],
        answer: |_, _| (1.0 + f32::EPSILON).to_bits(),
        other: |found| (found == 1f32.to_bits()).then_some("towards zero"),
        ..PLAIN
    },
    Probe {
        name: "no-contraction",
        what: "precise products and sums stay apart (NoContraction)",
        // The product is rounded, so the sum is 0; a fused operation leaves 2^-24.
        terms: [NEAR, NEAR, -(1.0 + 1.0 / 2048.0)],
        answer: |_, _| 0,
        other: |found| (found == (1.0f32 / 16_777_216.0).to_bits()).then_some("fused"),
        ..PLAIN
    },
    Probe {
        name: "denormals",
        what: "denormal numbers are kept",
        needed: false,
        terms: [f32::MIN_POSITIVE, 0.5, 0.0],
        answer: |_, _| 0x0040_0000,
        other: |found| (found == 0).then_some("flushed to zero"),
    },
    Probe {
        name: "scalar-layout",
        what: "scalar block layout",
        answer: |inputs, lane| {
            let [before, x, y, z, after] = inputs.uneven[lane];
            (before + 2.0 * x + 4.0 * y + 8.0 * z + 16.0 * after).to_bits()
        },
        ..PLAIN
    },
    Probe {
        name: "shared-memory",
        what: "shared memory and barriers",
        answer: |inputs, lane| {
            let sum = inputs.numbers[..LANES].iter().fold(0u32, |sum, number| sum.wrapping_add(*number));
            sum.wrapping_add(inputs.numbers[LANES - 1 - lane])
        },
        ..PLAIN
    },
    Probe {
        name: "shuffles",
        what: "shuffles among lanes that are left in a loop",
        answer: |inputs, lane| {
            let other = |row: usize| inputs.numbers[row * LANES + (lane ^ 1)];
            (0..=lane / 2 % 5).fold(0, |sum, row| sum.wrapping_add(other(row)))
        },
        ..PLAIN
    },
    Probe {
        name: "inactive-shuffles",
        what: "shuffles read lanes that are not active",
        needed: false,
        answer: |inputs, lane| inputs.numbers[lane | 1],
        other: |found| (found == 0).then_some("zero"),
        ..PLAIN
    },
    Probe {
        name: "push-constants",
        what: "128 bytes of push constants, indexed by a variable",
        needed: false,
        answer: |inputs, lane| PUSHED[inputs.numbers[lane] as usize % PUSHED.len()],
        other: |found| (found == 0).then_some("zero"),
        ..PLAIN
    },
    Probe {
        name: FULL,
        what: "subgroups have as many invocations as they say",
        answer: |_, _| 64,
        other: |found| (found < 64).then_some("partly filled"),
        ..PLAIN
    },
    Probe {
        name: "loop-bounds",
        what: "loops that a counter of 64 bits bounds, which goes up",
        needed: false,
        answer: |inputs, lane| {
            let (last, mut count, mut rounds) = (inputs.numbers[lane] % ROWS as u32, 0, 1);
            while count < last {
                count += 1 + (inputs.numbers[count as usize * LANES + lane] & 1);
                rounds += 1;
            }
            count + rounds
        },
        ..PLAIN
    },
    Probe {
        name: "guarded-reads",
        what: "shared memory is not read at index -1, which a condition keeps off",
        needed: false,
        answer: |inputs, lane| lane.checked_sub(1).map_or(7, |before| inputs.numbers[before]),
        ..PLAIN
    },
    Probe {
        name: "private-arrays",
        what: "1 KiB of each invocation's own memory, indexed by variables",
        needed: false,
        answer: |inputs, lane| {
            let mut kept: Vec<u32> = (0..256).map(|row| inputs.numbers[row * LANES + lane]).collect();
            let mut place = 0;
            for k in 0..1000 {
                let found = kept[place];
                kept[place] = found.wrapping_mul(5).wrapping_add(k);
                place = (found >> 3) as usize % 256;
            }
            kept.into_iter().fold(0, |sum: u32, word| sum.wrapping_mul(31).wrapping_add(word))
        },
        ..PLAIN
    },
    Probe {
        name: "indirect-counts",
        what: "indirect dispatches of 3 groups and of none, as an earlier one writes",
        // The numbers of the groups, from 1 on.
        answer: |_, _| 1 + 2 + 3,
        other: |found| (found == 0).then_some("not run"),
        ..PLAIN
    },
];
