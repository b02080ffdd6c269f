//! What a device can do at best, by three small kernels of our own: copy, multiply and add, take exponentials.
//!
//! Each kernel's results are checked against `f64` before its time counts, and each rate is that of the fastest of
//! several runs; a run is made longer until it takes long enough to be timed.

use crate::error::{Error, Result};
use crate::gpu::{Device, SingleKernel, spirv};

/// Rates of one device.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rates {
    /// Bytes read and written by a copy, a second: both count.
    pub copy: f64,
    /// Fused multiplications and additions, a second.
    pub fma: f64,
    /// Exponentials, a second.
    pub exp: f64,
}

/// Runs of each size; the first one prepares the pipeline.
const RUNS: usize = 6;
/// Rounds of the loops: far fewer than the 65,535 after which some drivers end one.
const ROUNDS: u32 = 1024;
/// Operations of a round.
const EACH: f64 = 16.0;
/// What is long enough, milliseconds.
const LONG: f64 = 5.0;
/// Factor and summand of the chains, and the step of the exponents: such that another number of rounds shows.
const FACTORS: [f32; 2] = [0.999, 0.01];
const STEP: f32 = 0.002;

impl Rates {
    /// The better of two measurements: what slows a device makes no rate of it.
    #[must_use]
    pub fn best(self, other: Self) -> Self {
        Self { copy: self.copy.max(other.copy), fma: self.fma.max(other.fma), exp: self.exp.max(other.exp) }
    }
}

/// Measures a device; none without timestamps.
pub fn rates(device: &Device) -> Result<Option<Rates>> {
    if device.limits().timestamp_period <= 0.0 {
        return Ok(None);
    }
    Ok(Some(Rates {
        copy: copy(device)?,
        fma: sums(device, "measure/fma", FACTORS, fma)?,
        exp: sums(device, "measure/exp", [STEP, 0.0], exp)?,
    }))
}

/// Fastest run but for the first, seconds.
fn fastest(device: &Device, alone: &SingleKernel<'_>, buffers: &mut [Vec<u8>], count: u64) -> Result<f64> {
    let times = alone.run(device, buffers, count, RUNS)?;
    // A clock too coarse for a run shows no time at all: that is no rate.
    let told = times.iter().skip(1).map(|time| time.milliseconds).filter(|time| *time > 0.0);
    Ok(told.fold(f64::INFINITY, f64::min) * 1e-3)
}

fn kernel<'a>(name: &'a str, constants: &'a [u32]) -> Result<SingleKernel<'a>> {
    let doing = || format!("measuring the device with kernel {name}");
    let spirv = spirv(name).ok_or_else(|| Error::device(doing(), "it is not in the program"))?;
    Ok(SingleKernel { name, spirv, constants })
}

/// Bytes a second, of the largest buffers that are allowed, up to 256 MiB, or 64 MiB on a device that is slow.
fn copy(device: &Device) -> Result<f64> {
    let alone = kernel("measure/copy", &[])?;
    let most = device.limits().binding_bytes.min(device.limits().allocation_bytes).min(256 << 20) >> 12 << 12;
    let mut bytes = most.min(16 << 20);
    loop {
        let from: Vec<u8> =
            (0..bytes / 4).flat_map(|word| (word as u32).wrapping_mul(2_654_435_761).to_ne_bytes()).collect();
        let mut buffers = [from, vec![0; bytes as usize]];
        let seconds = fastest(device, &alone, &mut buffers, bytes / 64)?;
        if buffers[0] != buffers[1] {
            return Err(Error::device("measuring how fast the device copies", "the copy differs from what was copied"));
        }
        if bytes == most || seconds * 1e3 >= LONG {
            return Ok(2.0 * bytes as f64 / seconds);
        }
        bytes = (4 * bytes).min(most);
    }
}

/// Operations a second of a kernel that sums up `expected` for each invocation.
fn sums(device: &Device, name: &str, input: [f32; 2], expected: fn(u32) -> f64) -> Result<f64> {
    let constants = [ROUNDS];
    let alone = kernel(name, &constants)?;
    let mut count = 1u64 << 12;
    loop {
        let mut buffers = [bytemuck::cast_slice(&input).to_vec(), vec![0; 4 * count as usize]];
        let seconds = fastest(device, &alone, &mut buffers, count)?;
        let sums: &[f32] = bytemuck::cast_slice(&buffers[1]);
        for place in (0..count as usize).step_by(count as usize / 64 + 1) {
            let (found, right) = (f64::from(sums[place]), expected(place as u32));
            // Sums of a thousand roundings, and exponentials good to some ulp.
            if (found - right).abs().is_nan() || (found - right).abs() > 1e-3 * right.abs() {
                let what = format!("invocation {place} gave {found}, {right} is right");
                return Err(Error::device(format!("measuring the device with kernel {name}"), what));
            }
        }
        if count >= 1 << 23 || seconds * 1e3 >= LONG {
            return Ok(count as f64 * f64::from(ROUNDS) * EACH / seconds);
        }
        count *= 8;
    }
}

/// The sum of an invocation's sixteen chains.
fn fma(invocation: u32) -> f64 {
    let [a, b] = FACTORS.map(f64::from);
    let power = a.powi(ROUNDS as i32);
    (0..16).map(|k| power * (f64::from(invocation % 64) + f64::from(k)) + b * (1.0 - power) / (1.0 - a)).sum()
}

/// The sum of an invocation's exponentials.
fn exp(invocation: u32) -> f64 {
    let step = f64::from(STEP);
    let series = (1.0 - (-step * f64::from(ROUNDS)).exp()) / (1.0 - (-step).exp());
    (0..16).map(|k| (-0.01 * (f64::from(invocation % 64) + f64::from(k))).exp() * series).sum()
}
