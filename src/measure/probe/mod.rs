//! Known faults of drivers and what kernels rely on, each as a small kernel with an exact answer: facts about a device.

mod list;

use std::rc::Rc;

use serde::{Deserialize, Serialize};

use self::list::{FULL, PROBES, Probe};
use crate::error::Result;
use crate::gpu::{Binding, Buffer, Device, Kernel, Recorder, Work};
use crate::layout::GROUP_SIZE;

/// The kernel of all probes; a constant picks one.
pub const NAME: &str = "measure/probe";
/// The fixture's name in results of probes.
pub const FIXTURE: &str = "probes";
/// The command that repeats the probes.
pub const REPEAT: &str = "milkglass devices --probe";

/// Invocations of the only group.
const LANES: usize = GROUP_SIZE as usize;
/// Rows of numbers; with 300 iterations each, more than the 65,535 after which one driver ends loops.
const ROWS: usize = 300;
/// As many bytes of push constants as every device takes.
const PUSHED: [u32; 32] = pushed();
/// The number of the kernel whose groups an earlier dispatch counts: the next one after those of the probes.
const COUNTED: u32 = PROBES.len() as u32;

/// A fact about a device.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Fact {
    /// The probe's name.
    pub name: String,
    /// What is probed.
    pub what: String,
    /// What the device does.
    pub found: String,
    /// Whether that is right.
    pub right: bool,
    /// Whether kernels rely on it.
    pub needed: bool,
}

/// What the kernels read.
struct Inputs {
    numbers: Vec<u32>,
    uneven: Vec<[f32; 5]>,
}

const fn pushed() -> [u32; 32] {
    let mut words = [0; 32];
    let mut k = 0;
    while k < words.len() {
        words[k] = 0x9e37_79b9_u32.wrapping_mul(k as u32 + 1);
        k += 1;
    }
    words
}

/// Runs all probes on a device. A message of the validation layer counts as a wrong answer.
pub fn probe(device: &Device) -> Result<Vec<Fact>> {
    let (words, inputs) = (device.words(NAME)?, inputs());
    let _ = device.take_messages();
    let mut facts = Vec::new();
    for (number, probe) in (0..).zip(&PROBES) {
        let mut fact = fact(probe, &inputs, &answers(device, &words, (number, probe), &inputs)?);
        if let Some(message) = device.take_messages().into_iter().next() {
            (fact.right, fact.found) = (false, message);
        }
        // Where a device does not promise full subgroups, kernels do without subgroups.
        fact.needed &= fact.name != FULL || device.subgroup_that_shuffles(GROUP_SIZE) > 1;
        facts.push(fact);
    }
    Ok(facts)
}

/// What the device answers in each lane.
fn answers(device: &Device, words: &[u32], (number, probe): (u32, &Probe), inputs: &Inputs) -> Result<Vec<u32>> {
    let numbers = [&[ROWS as u32], &inputs.numbers[..]].concat();
    let mut left = vec![0xA5A5_A5A5_u32; LANES];
    let contents: [&[u8]; 5] = [
        bytemuck::cast_slice(&numbers),
        bytemuck::cast_slice(&probe.terms),
        bytemuck::cast_slice(&inputs.uneven),
        bytemuck::cast_slice(&left),
        // Two indirect dispatches, of no group before the first probe writes them.
        bytemuck::cast_slice(&[0u32; 6]),
    ];
    let mut buffers = Vec::with_capacity(contents.len());
    for bytes in contents {
        let buffer = Buffer::new(device, NAME, bytes.len() as u64)?;
        buffer.upload(bytes)?;
        buffers.push(buffer);
    }
    let binding = |(number, buffer)| Binding { number, buffer, offset: 0, size: Buffer::size(buffer) };
    let bindings: Vec<_> = (0..).zip(&buffers).map(binding).collect();
    let kernel = |number: u32| Kernel::new(device, NAME, words.to_vec(), &[number]).map(Rc::new);
    let (first, push) = (kernel(number)?, bytemuck::cast_slice(&PUSHED));
    // Only the last probe has more than one dispatch.
    let counted = if number + 1 == COUNTED { Some(kernel(COUNTED)?) } else { None };
    let mut recorder = Recorder::new(device, 0)?;
    recorder.part(NAME, |recorder| {
        recorder.dispatch(&first, &bindings, push, Work::Grid([1; 3]))?;
        counted.iter().flat_map(|kernel| [(kernel, 0), (kernel, 12)]).try_for_each(|(kernel, offset)| {
            recorder.dispatch(kernel, &bindings, push, Work::Groups { buffer: &buffers[4], offset })
        })
    })?;
    recorder.submit()?;
    buffers[3].download(bytemuck::cast_slice_mut(&mut left))?;
    Ok(left)
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
    let (name, what) = (probe.name.into(), probe.what.into());
    Fact { name, what, found, right: wrong.is_empty(), needed: probe.needed }
}

fn inputs() -> Inputs {
    let uneven = (0..LANES).map(|lane| [0, 1, 2, 3, 4].map(|k| (5 * lane + k) as f32)).collect();
    Inputs { numbers: seeded(ROWS * LANES), uneven }
}

/// `count` numbers below 2^24, always the same; they make lanes leave their loops at different times.
#[must_use]
pub fn seeded(count: usize) -> Vec<u32> {
    let mut state = 0x2545_f491u32;
    let mut next = || {
        state ^= state << 13;
        state ^= state >> 17;
        state ^= state << 5;
        state >> 8
    };
    (0..count).map(|_| next()).collect()
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
