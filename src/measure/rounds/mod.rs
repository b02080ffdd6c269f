//! Times variants of a program against each other: rounds of one frame of each, in an order that is drawn anew in each
//! round, until there are enough of them.
//!
//! A [`Variant`] runs a frame and says what its stages took: a session in this process, or another process. [`run`]
//! makes [`Samples`] of it, which know their medians and ratios, and are what a file holds.

mod load;
mod ratios;
mod samples;
#[cfg(test)]
mod tests;

use std::time::Instant;

pub use self::ratios::{CONFIDENCE, Ratio};
pub use self::samples::{Samples, Series, StageTimes};

use self::load::Load;
use super::statistics::Random;
use crate::error::Result;
use crate::gpu::Timing;
use crate::pipeline::plan::Change;
use crate::session::run::Session;

/// Rounds of a comparison, where nothing else is asked for.
pub const ROUNDS: usize = 41;
/// Rounds after which the intervals are looked at first.
const FIRST: usize = 11;
/// Rounds that are measured however long they take.
const FEWEST: usize = 3;

/// A timed frame.
#[derive(Clone, Debug, Default)]
pub struct Frame {
    /// When it began, milliseconds after the first one.
    pub start: f64,
    /// Milliseconds from call to result, by the host's clock.
    pub wall: f64,
    /// Its steps.
    pub steps: Vec<Timing>,
}

/// One of those that are compared, warmed up.
pub trait Variant {
    /// Its name in tables.
    fn name(&self) -> String;

    /// Runs a frame.
    fn frame(&mut self) -> Result<Frame>;

    /// The process that it runs in.
    fn process(&self) -> u32 {
        std::process::id()
    }
}

/// A session of this process as a variant.
pub struct InProcess {
    /// Its name in tables.
    pub name: String,
    /// The session, warmed up.
    pub session: Session,
    /// What changes before each frame.
    pub change: Change,
}

impl Variant for InProcess {
    fn name(&self) -> String {
        self.name.clone()
    }

    fn frame(&mut self) -> Result<Frame> {
        let begin = Instant::now();
        let steps = self.session.frame(self.change)?;
        Ok(Frame { start: 0.0, wall: begin.elapsed().as_secs_f64() * 1e3, steps })
    }
}

/// How many rounds there are.
#[derive(Clone, Copy, Debug)]
pub struct Schedule {
    /// At most so many; at least 1.
    pub rounds: usize,
    /// Ends once every interval that matters ([`Samples::widest`]) is at most this share wide on either side.
    pub until: Option<f64>,
    /// Ends after this many seconds, once three rounds are measured.
    pub budget: f64,
    /// The seed of the order and of the bootstrap.
    pub seed: u64,
}

/// What rounds gave.
#[derive(Clone, Debug, Default)]
pub struct Measured {
    /// The times.
    pub samples: Samples,
    /// All frames of each variant, those of warming up included.
    pub frames: Vec<Vec<Frame>>,
}

/// Runs rounds of these variants.
pub fn run(variants: &mut [&mut dyn Variant], schedule: &Schedule) -> Result<Measured> {
    let processes: Vec<u32> = variants.iter().map(|variant| variant.process()).collect();
    let (before, begin) = (Load::now(&processes), Instant::now());
    let mut random = Random::of(schedule.seed);
    let names: Vec<String> = variants.iter().map(|variant| variant.name()).collect();
    let (mut frames, mut orders) = (vec![Vec::new(); variants.len()], Vec::new());
    let mut look = FIRST;
    loop {
        let order = random.order(variants.len());
        for &which in &order {
            let start = begin.elapsed().as_secs_f64() * 1e3;
            frames[which].push(Frame { start, ..variants[which].frame()? });
        }
        orders.push(order);
        let (rounds, seconds) = (orders.len(), begin.elapsed().as_secs_f64());
        let mut ends = rounds >= schedule.rounds || (rounds >= FEWEST && seconds > schedule.budget);
        if let Some(until) = schedule.until.filter(|_| !ends && rounds >= look) {
            look = rounds + rounds.div_ceil(10);
            ends = Samples::of(&names, &frames, schedule.seed).widest().is_none_or(|(_, width)| width <= until);
        }
        if ends {
            let mut samples = Samples::of(&names, &frames, schedule.seed);
            samples.orders = orders;
            samples.seconds = seconds;
            samples.other_load = before.zip(Load::now(&processes)).map(|(before, now)| now.others(&before));
            return Ok(Measured { samples, frames });
        }
    }
}
