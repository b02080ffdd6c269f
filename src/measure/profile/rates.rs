//! Peak rates of a device, measured by three small kernels: copy, fused multiply-add, and exponential.
//!
//! Each kernel's results are checked against `f64` before its time counts. Each rate is that of the fastest of
//! several runs, and the work grows until a run takes long enough to be timed.

use crate::error::{Error, Result};
use crate::gpu::{Device, SingleKernel, spirv};

/// Peak rates of one device.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rates {
    /// Bytes per second of a copy, reads and writes both counted.
    pub copy: f64,
    /// Fused multiply-adds per second.
    pub fma: f64,
    /// Exponentials per second.
    pub exp: f64,
}

/// Runs per size; the first one creates the pipeline and does not count.
const RUNS: usize = 6;
/// Loop iterations: far below 65,535, the limit after which some drivers end a loop.
const ROUNDS: u32 = 1024;
/// Operations per loop iteration.
const EACH: f64 = 16.0;
/// Minimum time of a run, milliseconds.
const LONG: f64 = 5.0;
/// Factor and summand of the multiply-add chains, and step of the exponents; chosen so that a wrong number of
/// iterations shows in the result.
const FACTORS: [f32; 2] = [0.999, 0.01];
const STEP: f32 = 0.002;

impl Rates {
    /// The better of two measurements: a slowed-down device does not reach its peak.
    #[must_use]
    pub fn best(self, other: Self) -> Self {
        Self { copy: self.copy.max(other.copy), fma: self.fma.max(other.fma), exp: self.exp.max(other.exp) }
    }
}

/// Measures a device; `None` without timestamps.
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

/// Time of the fastest run but the first, seconds.
fn fastest(device: &Device, alone: &SingleKernel<'_>, buffers: &mut [Vec<u8>], count: u64) -> Result<f64> {
    let times = alone.run(device, buffers, count, RUNS)?;
    // Discard times of 0, from a clock too coarse for the run.
    let told = times.iter().skip(1).map(|time| time.milliseconds).filter(|time| *time > 0.0);
    Ok(told.fold(f64::INFINITY, f64::min) * 1e-3)
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

/// Operations per second of a kernel whose invocations must each sum up to `expected`.
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
            // The tolerance covers a thousand roundings, and exponentials accurate to a few ulp.
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
