//! Times variants of a program against each other: rounds of one frame of each, in an order that is drawn anew in each
//! round, until there are enough of them.
//!
//! A [`Variant`] runs a frame and says what its stages took: a session in this process, or another process. The same
//! program started twice has times that differ by a percent for as long as both run, because memory and code lie
//! elsewhere. So [`compare`] starts all variants anew after a few rounds, and a start counts as one piece of evidence.
//! The results are [`Samples`], which know their medians and ratios, and which a file holds.

mod load;
mod ratios;
mod samples;
#[cfg(test)]
mod tests;

use std::time::Instant;

pub use self::ratios::{CONFIDENCE, Ratio};
pub use self::samples::{Samples, Series, StageTimes};

use self::load::Load;
use super::links::links;
use super::statistics::Random;
use crate::error::Result;
use crate::gpu::Timing;
use crate::pipeline::plan::Change;
use crate::session::run::Session;

/// Rounds of a comparison by default.
pub const ROUNDS: usize = 16 * EACH;
/// Most rounds after each start of the variants.
pub const EACH: usize = 8;
/// The same where both variants' runs alternate in one submission.
const MOST_IN_TURN: usize = 32;
/// Rounds of such a comparison by default.
pub const IN_TURN: usize = STARTS * MOST_IN_TURN;
/// Fewest starts of a comparison, unless the budget ends it.
pub const STARTS: usize = 9;
/// Rounds, or starts, after which the intervals are looked at first.
const FIRST: usize = 11;
/// Rounds of a single variant that are measured however long they take.
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
    /// If the device's clock was read: how far its steps' starts, in milliseconds after the frame's, may be off, in
    /// milliseconds, too. Otherwise they count from the first step of their submission.
    pub aligned: Option<f64>,
    /// Bytes of device memory after it, on the CPU of all buffers; 0 where it is not known.
    pub memory: u64,
    /// The links of light that it used, if they were counted.
    pub links: Option<u64>,
}

impl Frame {
    /// A frame that began at this moment and has just ended.
    #[must_use]
    pub fn since(begin: Instant, mut steps: Vec<Timing>) -> Self {
        let wall = begin.elapsed().as_secs_f64() * 1e3;
        let timed = || steps.iter().filter(|step| step.milliseconds.is_finite());
        let offs: Option<Vec<f64>> = timed().map(|step| Some(step.began?.1.as_secs_f64() * 1e3)).collect();
        let aligned = offs.filter(|offs| !offs.is_empty()).map(|offs| offs.into_iter().fold(0.0, f64::max));
        for step in steps.iter_mut().filter(|_| aligned.is_some()) {
            let began = step.began.map(|(began, _)| began.saturating_duration_since(begin));
            step.start = began.map_or(f64::NAN, |began| began.as_secs_f64() * 1e3);
        }
        Self { wall, steps, aligned, ..Self::default() }
    }
}

/// A variant that is timed, warmed up.
pub trait Variant {
    /// Runs a frame.
    fn frame(&mut self) -> Result<Frame>;

    /// The process that it runs in.
    fn process(&self) -> u32 {
        std::process::id()
    }
}

/// A session of this process as a variant.
pub struct InProcess {
    /// The session, warmed up.
    pub session: Session,
    /// What changes before each frame.
    pub change: Change,
    /// Whether links are counted after each frame, which takes a copy from the device.
    pub counts_links: bool,
}

impl Variant for InProcess {
    fn frame(&mut self) -> Result<Frame> {
        let begin = Instant::now();
        let steps = self.session.frame(self.change)?;
        let frame = Frame::since(begin, steps);
        let memory = self.session.device().map_or_else(|| self.session.bytes(), |device| device.memory().allocated);
        let links = if self.counts_links { links(&mut self.session)? } else { None };
        Ok(Frame { memory, links, ..frame })
    }
}

/// How many rounds are timed, and for how long.
#[derive(Clone, Copy, Debug)]
pub struct Schedule {
    /// Most rounds, at least 1; [`compare`] runs more where its fewest starts take more.
    pub rounds: usize,
    /// Ends once every interval that matters ([`Samples::widest`]) is at most this share wide on either side.
    pub until: Option<f64>,
    /// Ends after this many seconds, once three rounds, or one start of a comparison, are measured.
    pub budget: f64,
    /// The seed of the order and of the bootstrap.
    pub seed: u64,
}

/// A variant that is compared, and how it is started.
pub struct Starter<'a> {
    /// Its name in tables.
    pub name: String,
    /// Starts it and warms it up.
    pub start: Box<dyn FnMut() -> Result<Box<dyn Variant + 'a>> + 'a>,
}

/// Opens two variants and times them in rounds, each of which says which of them comes first and second; returns the
/// frames of each.
pub type InTurn<'a> = dyn FnMut(&[[usize; 2]]) -> Result<[Vec<Frame>; 2]> + 'a;

/// How long a comparison is going to take, as its first start shows.
#[derive(Clone, Copy, Debug)]
pub struct Forecast {
    /// Starts, if neither the budget nor a narrow interval ends it.
    pub starts: usize,
    /// Rounds after each start.
    pub each: usize,
    /// Seconds of the first start.
    pub seconds: f64,
    /// Starts with which the edited stages, and all other rows, have intervals: [`Samples::fewest_starts`].
    pub fewest: [usize; 2],
}

/// The result of rounds.
#[derive(Clone, Debug, Default)]
pub struct Measured {
    /// The times.
    pub samples: Samples,
    /// All frames of each variant, those of warming up included.
    pub frames: Vec<Vec<Frame>>,
}

/// Rounds under way.
struct Rounds {
    schedule: Schedule,
    begin: Instant,
    names: Vec<String>,
    edited: Vec<String>,
    each: usize,
    look: usize,
    random: Random,
    load: Option<Load>,
    orders: Vec<Vec<usize>>,
    frames: Vec<Vec<Frame>>,
}

impl Rounds {
    fn new(names: Vec<String>, each: usize, schedule: &Schedule) -> Self {
        Self {
            edited: Vec::new(),
            schedule: *schedule,
            begin: Instant::now(),
            each,
            look: FIRST,
            random: Random::of(schedule.seed),
            load: Some(Load::default()),
            orders: Vec::new(),
            frames: vec![Vec::new(); names.len()],
            names,
        }
    }

    /// Runs rounds of these variants until `enough` holds.
    fn run(&mut self, variants: &mut [&mut dyn Variant], enough: &mut dyn FnMut(&mut Self) -> bool) -> Result<()> {
        let processes: Vec<u32> = variants.iter().map(|variant| variant.process()).collect();
        let before = Load::now(&processes);
        loop {
            let order = self.random.order(variants.len());
            for &which in &order {
                let start = self.begin.elapsed().as_secs_f64() * 1e3;
                self.frames[which].push(Frame { start, ..variants[which].frame()? });
            }
            self.orders.push(order);
            if enough(self) {
                self.note(before, &processes);
                return Ok(());
            }
        }
    }

    /// Starts all variants anew, in random order, and runs their rounds.
    fn start(&mut self, starters: &mut [Starter<'_>]) -> Result<()> {
        let mut variants = Vec::new();
        for which in self.random.order(starters.len()) {
            variants.push((which, (starters[which].start)()?));
        }
        variants.sort_by_key(|(which, _)| *which);
        let mut ready: Vec<&mut dyn Variant> = variants.iter_mut().map(|(_, variant)| &mut **variant as _).collect();
        self.run(&mut ready, &mut |rounds| rounds.orders.len().is_multiple_of(rounds.each))
    }

    /// Starts the variants until there are enough rounds; after the first start it tells how long the others take.
    fn all(
        mut self,
        start: &mut dyn FnMut(&mut Self) -> Result<()>,
        told: &mut dyn FnMut(&Forecast),
    ) -> Result<Measured> {
        start(&mut self)?;
        let samples = self.samples();
        let (fewest, rounds) = (samples.fewest_starts(), self.schedule.rounds);
        let most = fewest.into_iter().fold(rounds.div_ceil(self.each).max(STARTS), usize::max);
        told(&Forecast { starts: most, each: self.each, seconds: samples.seconds, fewest });
        let mut starts = 1;
        while !self.ends(starts, most, 1) {
            start(&mut self)?;
            starts += 1;
        }
        Ok(self.measured())
    }

    /// Has two variants opened and timed in rounds of drawn order.
    fn in_turn(&mut self, start: &mut InTurn<'_>) -> Result<()> {
        let before = Load::now(&[]);
        let orders: Vec<Vec<usize>> = (0..self.each).map(|_| self.random.order(2)).collect();
        let rounds: Vec<[usize; 2]> = orders.iter().map(|order| [order[0], order[1]]).collect();
        for (all, own) in self.frames.iter_mut().zip(start(&rounds)?) {
            all.extend(own);
        }
        self.orders.extend(orders);
        self.note(before, &[]);
        Ok(())
    }

    /// Adds the load since then.
    fn note(&mut self, before: Option<Load>, processes: &[u32]) {
        let passed = before.zip(Load::now(processes)).map(|(before, now)| now.since(&before));
        self.load = self.load.zip(passed).map(|(all, passed)| all.plus(&passed));
    }

    /// Whether this is the end, after `done` rounds or starts of at most `most`, but not before `fewest`.
    fn ends(&mut self, done: usize, most: usize, fewest: usize) -> bool {
        let spent = self.begin.elapsed().as_secs_f64() > self.schedule.budget;
        if done >= most || (done >= fewest && spent) {
            return true;
        }
        let Some(until) = self.schedule.until.filter(|_| done >= self.look) else { return false };
        self.look = done + done.div_ceil(10);
        self.samples().widest().is_none_or(|(_, width)| width <= until)
    }

    fn samples(&self) -> Samples {
        Samples {
            orders: self.orders.clone(),
            seconds: self.begin.elapsed().as_secs_f64(),
            other_load: self.load.as_ref().map(Load::others),
            edited: self.edited.clone(),
            ..Samples::of(&self.names, &self.frames, self.each, self.schedule.seed)
        }
    }

    fn measured(self) -> Measured {
        Measured { samples: self.samples(), frames: self.frames }
    }
}

/// Runs frames of a single variant that is ready: rounds without a comparison.
pub fn run(variant: &mut dyn Variant, schedule: &Schedule) -> Result<Measured> {
    let mut rounds = Rounds::new(vec![String::new()], usize::MAX, schedule);
    rounds.run(&mut [variant], &mut |rounds| rounds.ends(rounds.orders.len(), rounds.schedule.rounds, FEWEST))?;
    Ok(rounds.measured())
}

/// Runs rounds of variants that are started anew at least [`STARTS`] times, and so often that all ratios have
/// intervals: a ninth of the schedule's rounds after each start, [`EACH`] at most. What `edited` stages show is judged
/// by itself. After the first start it tells how long the others will take.
pub fn compare(
    starters: &mut [Starter<'_>],
    schedule: &Schedule,
    edited: &[String],
    told: &mut dyn FnMut(&Forecast),
) -> Result<Measured> {
    let mut rounds = Rounds::new(names(starters), schedule.rounds.div_ceil(STARTS).clamp(1, EACH), schedule);
    rounds.edited = edited.to_vec();
    rounds.all(&mut |rounds| rounds.start(starters), told)
}

/// The same for two variants that each start opens and times in the rounds that it is given.
pub fn alternate(
    names: [&str; 2],
    schedule: &Schedule,
    edited: &str,
    start: &mut InTurn<'_>,
    told: &mut dyn FnMut(&Forecast),
) -> Result<Measured> {
    let each = schedule.rounds.div_ceil(STARTS).clamp(1, MOST_IN_TURN);
    let mut rounds = Rounds::new(names.map(String::from).to_vec(), each, schedule);
    rounds.edited = vec![edited.to_string()];
    rounds.all(&mut |rounds| rounds.in_turn(start), told)
}

/// Runs the schedule's rounds of variants, which are started anew after every `each` rounds.
pub fn compare_each(starters: &mut [Starter<'_>], schedule: &Schedule, each: usize) -> Result<Measured> {
    let mut rounds = Rounds::new(names(starters), each, schedule);
    for starts in 1.. {
        rounds.start(starters)?;
        if rounds.ends(starts, schedule.rounds.div_ceil(each), 1) {
            break;
        }
    }
    Ok(rounds.measured())
}

fn names(starters: &[Starter<'_>]) -> Vec<String> {
    starters.iter().map(|starter| starter.name.clone()).collect()
}
