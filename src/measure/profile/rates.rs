//! Rates of a device, measured by small kernels: copies, fused multiply-adds and exponentials in every profile, and
//! what else bounds a stage where that is asked for.
//!
//! Each kernel's results are checked before its time counts: those of floats against `f64`, all others exactly. Each
//! rate is that of the median of several runs, as a stage's time is: what slows both down is in neither's ratio. The
//! work grows until a run takes long enough to be timed.

use serde::Serialize;

use crate::error::{Error, Result};
use crate::gpu::{Device, SingleKernel, spirv};
use crate::measure::statistics::median;

/// Rates of one device.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rates {
    /// Bytes per second of a copy, reads and writes both counted.
    pub copy: f64,
    /// Fused multiply-adds per second.
    pub fma: f64,
    /// Exponentials per second.
    pub exp: f64,
}

/// Rates of what else a device does.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct FinerRates {
    /// Integer instructions per second: shifts, exclusive ors and additions.
    pub integer: f64,
    /// Quotients of floats per second.
    pub divide: f64,
    /// Bytes per second of loads of 16 bytes, each of which says where the next one is, anywhere in a buffer of so many
    /// bytes.
    pub loads: Vec<(u64, f64)>,
    /// Loads of a word of shared memory per second, each of which says where the next one is.
    pub shared: f64,
    /// Increments of a buffer's words per second; neighbours increment different words.
    pub atomic: f64,
}

/// Bytes that loads are measured in.
const WORKING_SETS: [u64; 4] = [16 << 10, 256 << 10, 4 << 20, 64 << 20];
/// Words of shared memory that loads are measured in.
const SHARED_WORDS: u32 = 1024;
/// The step from place to place of the ring of loads, such that a ring of a power of two is one cycle.
const RING_STEP: [u32; 2] = [1_664_525, 1_013_904_223];
/// Places between two increments of an invocation.
const ATOMIC_STEP: u32 = 64;
/// Instructions of an integer chain's step.
const INTEGER_EACH: f64 = 3.0;

/// Runs per size; the first one creates the pipeline and does not count.
const RUNS: usize = 10;
/// Loop iterations: far below 65,535, the limit after which some drivers end a loop, and such that no ring of places
/// comes back to its first one.
const ROUNDS: u32 = 1000;
/// Operations per loop iteration.
const EACH: f64 = 16.0;
/// Work grows until a run takes as many milliseconds, or reaches its limit.
const LONG: f64 = 5.0;
/// Factor and summand of the multiply-add chains, and step of the exponents; chosen so that a wrong number of
/// iterations shows in the result.
const FACTORS: [f32; 2] = [0.999, 0.01];
const STEP: f32 = 0.002;
/// Summand of the integer chains.
const INTEGER: u32 = 2_654_435_769;

impl Rates {
    /// The rates of two measurements of equal work together; one of 0 was not measured.
    #[must_use]
    pub fn with(self, other: Self) -> Self {
        let both = |one: f64, two: f64| if one.min(two) > 0.0 { 2.0 / (1.0 / one + 1.0 / two) } else { one.max(two) };
        Self { copy: both(self.copy, other.copy), fma: both(self.fma, other.fma), exp: both(self.exp, other.exp) }
    }
}

/// Measures a device; `None` without timestamps.
pub fn rates(device: &Device) -> Result<Option<Rates>> {
    if device.limits().timestamp_period <= 0.0 {
        return Ok(None);
    }
    Ok(Some(Rates {
        copy: copy(device)?,
        fma: operations(device, "measure/fma", bytemuck::cast_slice(&FACTORS), EACH, &Expected::Sum(fma))?,
        exp: operations(device, "measure/exp", bytemuck::cast_slice(&[STEP, 0.0]), EACH, &Expected::Sum(exp))?,
    }))
}

/// The median time of the runs but the first, seconds.
fn usual(device: &Device, alone: &SingleKernel<'_>, buffers: &mut [Vec<u8>], count: u64) -> Result<f64> {
    let times = alone.run(device, buffers, count, RUNS)?;
    Ok(usual_of(times.iter().map(|time| time.milliseconds)) * 1e-3)
}

/// The median of the times but the first; infinite without any. Times of 0 come from a clock too coarse for the run.
fn usual_of(times: impl Iterator<Item = f64>) -> f64 {
    let told: Vec<f64> = times.skip(1).filter(|time| *time > 0.0).collect();
    if told.is_empty() { f64::INFINITY } else { median(told) }
}

fn kernel<'a>(name: &'a str, constants: &'a [u32]) -> Result<SingleKernel<'a>> {
    let doing = || format!("measuring the device with kernel {name}");
    let spirv = spirv(name).ok_or_else(|| Error::device(doing(), "it is not in the program"))?;
    Ok(SingleKernel { name, spirv, constants })
}

/// Copy rate in bytes per second. The buffers grow until a run is long enough, up to the device's limits and 256 MiB.
fn copy(device: &Device) -> Result<f64> {
    let alone = kernel("measure/copy", &[])?;
    let most = device.limits().binding_bytes.min(device.limits().allocation_bytes).min(256 << 20) >> 12 << 12;
    let mut bytes = most.min(16 << 20);
    loop {
        let from: Vec<u8> =
            (0..bytes / 4).flat_map(|word| (word as u32).wrapping_mul(2_654_435_761).to_ne_bytes()).collect();
        let mut buffers = [from, vec![0; bytes as usize]];
        let seconds = usual(device, &alone, &mut buffers, bytes / 64)?;
        if buffers[0] != buffers[1] {
            return Err(Error::device("measuring how fast the device copies", "the copy differs from what was copied"));
        }
        if bytes == most || seconds * 1e3 >= LONG {
            return Ok(2.0 * bytes as f64 / seconds);
        }
        bytes = (4 * bytes).min(most);
    }
}

/// What an invocation of a kernel must leave behind.
enum Expected<'a> {
    /// About this number.
    Sum(fn(u32) -> f64),
    /// Exactly this word.
    Word(&'a dyn Fn(u32) -> u32),
}

impl Expected<'_> {
    /// What is wrong with the word that an invocation left behind.
    fn fault(&self, place: u32, found: u32) -> Option<String> {
        let (found, right, off) = match self {
            Self::Sum(right) => (f64::from(f32::from_bits(found)), right(place), 1e-3),
            Self::Word(right) => (found.into(), right(place).into(), 0.0),
        };
        // The tolerance covers a thousand roundings, and exponentials accurate to a few ulp.
        let wrong = (found - right).abs().is_nan() || (found - right).abs() > off * right.abs();
        wrong.then(|| format!("invocation {place} gave {found}, {right} is right"))
    }
}

/// Operations per second of a kernel that has so many in a round.
fn operations(device: &Device, name: &str, input: &[u8], each: f64, expected: &Expected<'_>) -> Result<f64> {
    let constants = [ROUNDS];
    let alone = kernel(name, &constants)?;
    let mut count = 1u64 << 12;
    loop {
        let mut buffers = [input.to_vec(), vec![0; 4 * count as usize]];
        let seconds = usual(device, &alone, &mut buffers, count)?;
        let words: &[u32] = bytemuck::cast_slice(&buffers[1]);
        for place in (0..count as usize).step_by(count as usize / 64 + 1) {
            if let Some(what) = expected.fault(place as u32, words[place]) {
                return Err(Error::device(format!("measuring the device with kernel {name}"), what));
            }
        }
        if count >= 1 << 23 || seconds * 1e3 >= LONG {
            return Ok(count as f64 * f64::from(ROUNDS) * each / seconds);
        }
        count *= 8;
    }
}

/// Measures what else a device does; `None` without timestamps.
pub fn finer_rates(device: &Device) -> Result<Option<FinerRates>> {
    if device.limits().timestamp_period <= 0.0 {
        return Ok(None);
    }
    let words = bytemuck::cast_slice::<u32, u8>;
    let run =
        |name: &str, input: &[u8], each: f64, expected: Expected<'_>| operations(device, name, input, each, &expected);
    let ring = |length: u32| (0..length).map(move |at| ring_next(at, length));
    let mut loads = Vec::new();
    for bytes in WORKING_SETS.into_iter().filter(|bytes| *bytes <= device.limits().binding_bytes) {
        let length = (bytes / 16) as u32;
        let input: Vec<u32> = ring(length).flat_map(|next| [next, 0, 0, 0]).collect();
        let last = |invocation: u32| hop(invocation % length, length);
        loads.push((bytes, run("measure/chase", words(&input), 16.0, Expected::Word(&last))?));
    }
    let near: Vec<u32> = ring(SHARED_WORDS).collect();
    let last = |invocation: u32| hop(invocation % SHARED_WORDS, SHARED_WORDS);
    let increments = |_| ROUNDS * RUNS as u32;
    Ok(Some(FinerRates {
        integer: run("measure/integer", words(&[INTEGER]), INTEGER_EACH * EACH, Expected::Word(&integer))?,
        divide: run("measure/divide", bytemuck::cast_slice(&[STEP, 1.0]), EACH, Expected::Sum(divide))?,
        loads,
        shared: run("measure/shared", words(&near), 1.0, Expected::Word(&last))?,
        atomic: run("measure/atomic", words(&[ATOMIC_STEP]), 1.0, Expected::Word(&increments))?,
    }))
}

impl FinerRates {
    /// The rate of loads in a buffer of so many bytes: that of the smallest measured one that is as large,
    /// or of the largest one.
    #[must_use]
    pub fn loads_in(&self, bytes: u64) -> Option<f64> {
        let enough = self.loads.iter().find(|(size, _)| *size >= bytes);
        enough.or(self.loads.last()).map(|(_, rate)| *rate)
    }
}

/// The place after this one in a ring of a power of two.
fn ring_next(at: u32, length: u32) -> u32 {
    at.wrapping_mul(RING_STEP[0]).wrapping_add(RING_STEP[1]) % length
}

/// The place that an invocation comes to.
fn hop(first: u32, length: u32) -> u32 {
    (0..ROUNDS).fold(first, |at, _| ring_next(at, length))
}

/// The expected word of an invocation's sixteen integer chains.
fn integer(invocation: u32) -> u32 {
    let chain = |k: u32| (0..ROUNDS).fold(invocation % 64 + k, |x, _| (x ^ (x << 5)).wrapping_add(INTEGER));
    (0..16).fold(0, |all, k| all ^ chain(k))
}

/// The expected sum of an invocation's quotients.
fn divide(invocation: u32) -> f64 {
    let first = |k: u32| 1.0 + 0.01 * (f64::from(invocation % 64) + f64::from(k));
    let sum = |k: u32| (0..ROUNDS).map(|n| 1.0 / (first(k) + f64::from(n) * f64::from(STEP))).sum::<f64>();
    (0..16).map(sum).sum()
}

/// The expected sum of an invocation's sixteen multiply-add chains.
fn fma(invocation: u32) -> f64 {
    let [a, b] = FACTORS.map(f64::from);
    let power = a.powi(ROUNDS as i32);
    (0..16).map(|k| power * (f64::from(invocation % 64) + f64::from(k)) + b * (1.0 - power) / (1.0 - a)).sum()
}

/// The expected sum of an invocation's exponentials.
fn exp(invocation: u32) -> f64 {
    let step = f64::from(STEP);
    let series = (1.0 - (-step * f64::from(ROUNDS)).exp()) / (1.0 - (-step).exp());
    (0..16).map(|k| (-0.01 * (f64::from(invocation % 64) + f64::from(k))).exp() * series).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rate_is_that_of_the_median_run() {
        assert_eq!(usual_of([900.0, 4.0, 0.0, 2.0, 30.0].into_iter()), 4.0);
        assert_eq!(usual_of([900.0, 0.0].into_iter()), f64::INFINITY);
        let [one, two] = [10.0, 30.0].map(|rate| Rates { copy: rate, fma: 2.0 * rate, exp: 20.0 });
        assert_eq!(one.with(two), Rates { copy: 15.0, fma: 30.0, exp: 20.0 });
        assert_eq!(one.with(Rates { copy: 0.0, ..two }).copy, 10.0);
    }

    #[test]
    fn a_ring_is_one_cycle_and_a_chase_ends_elsewhere() {
        for bytes in WORKING_SETS {
            let length = (bytes / 16) as u32;
            assert!((0..64).all(|at| hop(at, length) != at), "{length}");
        }
        let ring: Vec<u32> =
            std::iter::successors(Some(0), |at| Some(ring_next(*at, SHARED_WORDS))).take(1025).collect();
        let places: std::collections::BTreeSet<&u32> = ring.iter().collect();
        assert_eq!((places.len(), ring[1024]), (SHARED_WORDS as usize, 0));
        assert!((0..64).all(|at| hop(at, SHARED_WORDS) != at));
    }
}
