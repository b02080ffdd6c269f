//! The least times that a device takes: for a dispatch that does nothing, a barrier, a submission.
//!
//! Ladders of empty dispatches of several lengths are timed in random order, some with a barrier before each dispatch
//! but the first, some without. The slope over the lengths is the cost of one more dispatch, and the excess slope of
//! ladders with barriers is the cost of a barrier: costs that do not depend on the length drop out. Each round gives
//! one slope of each kind, and the median over the rounds has an interval.

use std::time::Instant;

use serde::Serialize;

use super::statistics::{Interval, Random, median_interval};
use crate::error::Result;
use crate::gpu::{Binding, Buffer, Device, Kernels, Recorder, Work};

/// Dispatches of a ladder.
const LENGTHS: [usize; 4] = [16, 32, 64, 128];
/// Rounds that count; one before them warms up.
const ROUNDS: usize = 15;
/// Confidence of the intervals.
const CONFIDENCE: f64 = 0.95;

/// Costs in microseconds, each a median over rounds with its 95 % interval.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Overheads {
    /// A dispatch by the device's timestamps; not a number without timestamps.
    pub dispatch: Interval,
    /// A barrier by the device's timestamps; an interval around 0 where it costs nothing that shows.
    pub barrier: Interval,
    /// A dispatch by the host's clock, from recording to result.
    pub dispatch_host: Interval,
    /// A barrier by the host's clock.
    pub barrier_host: Interval,
    /// The submission of an empty command buffer and the wait for it, by the host's clock.
    pub submission: Interval,
}

/// Measures a device.
pub fn overheads(device: &Device, seed: u64) -> Result<Overheads> {
    let kernel = Kernels::new(device).get("measure/empty", &[])?;
    let count = 2 * LENGTHS[LENGTHS.len() - 1];
    let buffers = (0..count).map(|_| Buffer::new(device, "empty", 4)).collect::<Result<Vec<_>>>()?;
    let bind = |number: u32, at: usize| Binding { number, buffer: &buffers[at], offset: 0, size: 4 };
    let ladder = |length: usize, dependent: bool| -> Result<[f64; 2]> {
        let begin = Instant::now();
        let mut recorder = Recorder::new(device, 1)?;
        recorder.part("ladder", |recorder| {
            (0..length).try_for_each(|k| {
                // A dependent dispatch shares a buffer with the one before it.
                let at = if dependent { k } else { 2 * k };
                recorder.dispatch(&kernel, &[bind(0, at), bind(1, at + 1)], &[], Work::Grid([1; 3]))
            })
        })?;
        let device = recorder.submit()?[0].milliseconds;
        Ok([device, begin.elapsed().as_secs_f64() * 1e3].map(|ms| 1e3 * ms))
    };
    let mut random = Random::of(seed);
    let mut samples: [Vec<f64>; 5] = Default::default();
    for round in 0..=ROUNDS {
        let mut times = [[[0.0; 2]; LENGTHS.len()]; 2];
        for which in random.order(2 * LENGTHS.len()) {
            let (dependent, at) = (which % 2, which / 2);
            times[dependent][at] = ladder(LENGTHS[at], dependent == 1)?;
        }
        let begin = Instant::now();
        Recorder::new(device, 0)?.submit()?;
        let submission = begin.elapsed().as_secs_f64() * 1e6;
        if round == 0 {
            continue;
        }
        let slopes = |clock: usize| times.map(|ladders| slope(&ladders.map(|time| time[clock])));
        let ([plain, waiting], [plain_host, waiting_host]) = (slopes(0), slopes(1));
        let found = [plain, waiting - plain, plain_host, waiting_host - plain_host, submission];
        samples.iter_mut().zip(found).for_each(|(samples, value)| samples.push(value));
    }
    let [dispatch, barrier, dispatch_host, barrier_host, submission] =
        samples.map(|samples| median_interval(&samples, CONFIDENCE, seed));
    Ok(Overheads { dispatch, barrier, dispatch_host, barrier_host, submission })
}

/// The slope of the line through times of ladders of [`LENGTHS`], by least squares.
fn slope(times: &[f64; LENGTHS.len()]) -> f64 {
    let count = LENGTHS.len() as f64;
    let lengths = LENGTHS.map(|length| length as f64);
    let [x, y] = [&lengths, times].map(|values| values.iter().sum::<f64>() / count);
    let products: f64 = lengths.iter().zip(times).map(|(length, time)| (length - x) * (time - y)).sum();
    products / lengths.iter().map(|length| (length - x) * (length - x)).sum::<f64>()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slope_leaves_out_what_every_ladder_costs() {
        assert!((slope(&LENGTHS.map(|length| 40.0 + 3.0 * length as f64)) - 3.0).abs() < 1e-12);
        assert!(slope(&[7.0; LENGTHS.len()]).abs() < 1e-12);
    }

    #[test]
    fn a_dispatch_costs_something() {
        let Some(device) = Device::best().unwrap() else { panic!("no Vulkan device") };
        let found = overheads(&device, 1).unwrap();
        for cost in [found.dispatch, found.dispatch_host, found.submission] {
            assert!(
                cost.value > 0.0 && cost.value < 1e5 && cost.low <= cost.value && cost.value <= cost.high,
                "{found:?}"
            );
        }
        assert!(found.barrier.value.is_finite() && found.barrier_host.value.is_finite(), "{found:?}");
        assert!(found.dispatch_host.value > 0.5 * found.dispatch.value, "{found:?}");
    }
}
