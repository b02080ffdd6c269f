//! Known faults of drivers and what kernels rely on, each as a small kernel with an exact answer: facts about a device.

use crate::error::{Error, Result};
use crate::gpu::{Device, SingleKernel, spirv};
use crate::layout::GROUP_SIZE;

/// Invocations of the only group.
const LANES: usize = GROUP_SIZE as usize;
/// Rows of numbers; with 300 iterations each, more than the 65,535 after which one driver ends loops.
const ROWS: usize = 300;

/// A fact about a device.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fact {
    /// What is probed.
    pub what: &'static str,
    /// What the device does.
    pub found: String,
    /// Whether that is right.
    pub right: bool,
    /// Whether kernels rely on it.
    pub needed: bool,
}

/// A kernel with a known answer.
struct Probe {
    what: &'static str,
    needed: bool,
    /// Two terms and a third one.
    terms: [f32; 3],
    /// The answer of each lane, from the numbers and the records.
    answer: fn(&Inputs, usize) -> u32,
    /// What a device does that gives another answer, where that can be told.
    other: fn(u32) -> Option<&'static str>,
}

/// What the kernels read.
struct Inputs {
    numbers: Vec<u32>,
    uneven: Vec<[f32; 5]>,
}

const NEAR: f32 = 1.0 + 1.0 / 4096.0;

const PROBES: [Probe; 7] = [
    Probe {
        what: "nested loops, where a variable of the inner one indexes a buffer after it",
        needed: false,
        terms: [0.0; 3],
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
        other: |_| None,
    },
    Probe {
        what: "loops of 90,000 iterations",
        needed: false,
        terms: [0.0; 3],
        answer: |_, _| 300 * ROWS as u32,
        other: |found| (found < 300 * ROWS as u32).then_some("ended early"),
    },
    Probe {
        what: "addition rounds to nearest",
        needed: true,
        // 1 and three quarters of the step above it.
        terms: [1.0, 0.75 * f32::EPSILON, 0.0],
        answer: |_, _| (1.0 + f32::EPSILON).to_bits(),
        other: |found| (found == 1f32.to_bits()).then_some("towards zero"),
    },
    Probe {
        what: "precise products and sums stay apart (NoContraction)",
        needed: true,
        // The product is rounded, so the sum is 0; a fused operation leaves 2^-24.
        terms: [NEAR, NEAR, -(1.0 + 1.0 / 2048.0)],
        answer: |_, _| 0,
        other: |found| (found == (1.0f32 / 16_777_216.0).to_bits()).then_some("fused"),
    },
    Probe {
        what: "denormal numbers are kept",
        needed: false,
        terms: [f32::MIN_POSITIVE, 0.5, 0.0],
        answer: |_, _| 0x0040_0000,
        other: |found| (found == 0).then_some("flushed to zero"),
    },
    Probe {
        what: "scalar block layout",
        needed: true,
        terms: [0.0; 3],
        answer: |inputs, lane| {
            let [before, x, y, z, after] = inputs.uneven[lane];
            (before + 2.0 * x + 4.0 * y + 8.0 * z + 16.0 * after).to_bits()
        },
        other: |_| None,
    },
    Probe {
        what: "shared memory and barriers",
        needed: true,
        terms: [0.0; 3],
        answer: |inputs, lane| {
            let sum = inputs.numbers[..LANES].iter().fold(0u32, |sum, number| sum.wrapping_add(*number));
            sum.wrapping_add(inputs.numbers[LANES - 1 - lane])
        },
        other: |_| None,
    },
];

/// Runs all probes on a device.
pub fn probe(device: &Device) -> Result<Vec<Fact>> {
    let name = "measure/probe";
    let doing = || format!("probing the device with kernel {name}");
    let spirv = spirv(name).ok_or_else(|| Error::device(doing(), "it is not in the program"))?;
    let inputs = inputs();
    let mut facts = Vec::new();
    for (number, probe) in (0..).zip(&PROBES) {
        let numbers = [&[ROWS as u32], &inputs.numbers[..]].concat();
        let mut buffers = [
            bytemuck::cast_slice(&numbers).to_vec(),
            bytemuck::cast_slice(&probe.terms).to_vec(),
            bytemuck::cast_slice(&inputs.uneven).to_vec(),
            vec![0xA5; 4 * LANES],
        ];
        SingleKernel { name, spirv, constants: &[number] }.run(device, &mut buffers, LANES as u64, 1)?;
        let found: Vec<u32> = bytemuck::pod_collect_to_vec(&buffers[3]);
        facts.push(fact(probe, &inputs, &found));
    }
    Ok(facts)
}

/// What the answers of all lanes say.
fn fact(probe: &Probe, inputs: &Inputs, found: &[u32]) -> Fact {
    let wrong: Vec<usize> = (0..LANES).filter(|&lane| found[lane] != (probe.answer)(inputs, lane)).collect();
    let found = match wrong.first() {
        None => "right".into(),
        Some(&lane) => {
            let how = (probe.other)(found[lane]).map_or("wrong".to_string(), str::to_string);
            let (is, should) = (found[lane], (probe.answer)(inputs, lane));
            format!("{how} in {} of {LANES} lanes: lane {lane} has {is:#x}, not {should:#x}", wrong.len())
        }
    };
    Fact { what: probe.what, found, right: wrong.is_empty(), needed: probe.needed }
}

/// Seeded, so that lanes leave their loops at different times.
fn inputs() -> Inputs {
    let mut state = 0x2545_f491u32;
    let mut next = || {
        state ^= state << 13;
        state ^= state >> 17;
        state ^= state << 5;
        state >> 8
    };
    let numbers = (0..ROWS * LANES).map(|_| next()).collect();
    let uneven = (0..LANES).map(|lane| [0, 1, 2, 3, 4].map(|k| (5 * lane + k) as f32)).collect();
    Inputs { numbers, uneven }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_wrong_answer_is_told_by_what_it_is() {
        let inputs = inputs();
        for probe in &PROBES {
            let mut answers: Vec<u32> = (0..LANES).map(|lane| (probe.answer)(&inputs, lane)).collect();
            assert!(fact(probe, &inputs, &answers).right, "{}", probe.what);
            answers[5] ^= 1;
            let fact = fact(probe, &inputs, &answers);
            assert!(!fact.right && fact.found.contains("in 1 of 64 lanes: lane 5"), "{fact:?}");
        }
        let same = |value: u32| vec![value; LANES];
        assert!(fact(&PROBES[2], &inputs, &same(1f32.to_bits())).found.starts_with("towards zero in 64"));
        assert!(fact(&PROBES[3], &inputs, &same(0x3380_0000)).found.starts_with("fused in 64"));
        assert!(fact(&PROBES[4], &inputs, &same(0)).found.starts_with("flushed to zero in 64"));
        assert!(fact(&PROBES[1], &inputs, &same(65_535)).found.starts_with("ended early in 64"));
    }
}
