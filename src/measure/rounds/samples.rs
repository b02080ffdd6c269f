//! The times of all rounds, as a file holds them, and what is known about the run itself.

use serde::{Deserialize, Serialize};

use super::Frame;
use crate::measure::statistics::{drift, median, warm_up};

/// The times of each variant in each round, those of warming up included.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Samples {
    /// The seed of the order and of the bootstrap.
    pub seed: u64,
    /// How long all rounds took, seconds.
    pub seconds: f64,
    /// Rounds after each start of the variants; all rounds where they were started once.
    pub each: usize,
    /// The first rounds after each start, which belong to warming up: their times are listed, and not used.
    pub warm_up: usize,
    /// The change of a frame's time from the first to the last third of the other rounds, as a share, where there is
    /// a trend.
    pub drift: Option<f64>,
    /// How many processors other programs kept busy on average, where the system tells.
    pub other_load: Option<f64>,
    /// The order in which each round ran the variants, by their numbers.
    pub orders: Vec<Vec<usize>>,
    /// The variants; others are compared with the first.
    pub variants: Vec<Series>,
    /// The stages that were edited: what they show is judged by itself, apart from all other rows.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub edited: Vec<String>,
}

/// The times of one variant.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Series {
    /// Its name.
    pub name: String,
    /// Milliseconds of each round's frame from call to result.
    pub frame_ms: Vec<f64>,
    /// The stages in the order of the frame; only those whose times are known.
    pub stages: Vec<StageTimes>,
}

/// The times of one stage.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct StageTimes {
    /// Its name.
    pub stage: String,
    /// Milliseconds in each round's frame, all its steps together: by device timestamps, or the host's clock for what
    /// runs on the host.
    pub ms: Vec<f64>,
}

/// The name of the sum of all stages among what is compared.
pub(super) const STAGES: &str = "stages";
/// The name of the time from call to result.
pub(super) const FRAME: &str = "frame";

impl Series {
    /// The times of a variant's frames.
    fn of(name: &str, frames: &[Frame]) -> Self {
        let mut stages: Vec<StageTimes> = Vec::new();
        for (round, frame) in frames.iter().enumerate() {
            for step in &frame.steps {
                let at = stages.iter().position(|known| known.stage == step.name).unwrap_or_else(|| {
                    stages.push(StageTimes { stage: step.name.clone(), ms: vec![0.0; frames.len()] });
                    stages.len() - 1
                });
                stages[at].ms[round] += step.milliseconds;
            }
        }
        stages.retain(|times| times.ms.iter().all(|ms| ms.is_finite()));
        Self { name: name.into(), frame_ms: frames.iter().map(|frame| frame.wall).collect(), stages }
    }

    /// The names of what has times: the stages, and unless frames were not timed, their sum if there are any, and the
    /// frame.
    pub(super) fn names(&self) -> impl Iterator<Item = &str> {
        let whole = self.frame_ms.iter().all(|ms| ms.is_finite());
        let sum = (whole && !self.stages.is_empty()).then_some(STAGES);
        let frame = whole.then_some(FRAME);
        self.stages.iter().map(|times| times.stage.as_str()).chain(sum).chain(frame)
    }

    /// All times of one of [`Self::names`].
    pub(super) fn times(&self, what: &str) -> Option<Vec<f64>> {
        if let Some(times) = self.stages.iter().find(|times| times.stage == what) {
            return Some(times.ms.clone());
        }
        let sum = |round: usize| self.stages.iter().map(|times| times.ms[round]).sum();
        match what {
            STAGES if !self.stages.is_empty() => Some((0..self.frame_ms.len()).map(sum).collect()),
            FRAME => Some(self.frame_ms.clone()),
            _ => None,
        }
    }

    /// The stages that take at least 2 % of all, and their sum; the frame where no stage has a time.
    pub(super) fn that_matter(&self) -> Vec<String> {
        let time = |what: &str| median(self.times(what).unwrap_or_default());
        let whole = time(STAGES);
        let large = self.stages.iter().map(|times| &times.stage).filter(|stage| time(stage) >= 0.02 * whole);
        let rest = if self.stages.is_empty() { FRAME } else { STAGES };
        large.cloned().chain([rest.to_string()]).collect()
    }
}

impl Samples {
    /// The times of these frames, a list for each variant, which were started anew after `each` rounds.
    pub(super) fn of(names: &[String], frames: &[Vec<Frame>], each: usize, seed: u64) -> Self {
        let variants: Vec<Series> = names.iter().zip(frames).map(|(name, frames)| Series::of(name, frames)).collect();
        let rounds = frames.first().map_or(0, Vec::len);
        let each = each.clamp(1, rounds.max(1));
        // A round's time is the geometric mean of its variants' times, in which none counts more: a round is dropped
        // for all variants together.
        let known: Vec<Vec<f64>> =
            variants.iter().filter_map(|variant| variant.times(STAGES).or_else(|| variant.times(FRAME))).collect();
        let whole = |round: usize| known.iter().map(|times| times[round].ln()).sum::<f64>();
        let mean = |round: usize| (whole(round) / known.len() as f64).exp();
        let whole: Vec<f64> = (0..rounds).map(mean).collect();
        // The first, second and further rounds of all starts.
        let places: Vec<f64> =
            (0..each).map(|place| median(whole.iter().skip(place).step_by(each).copied().collect())).collect();
        let mut found = Self { seed, each, warm_up: warm_up(&places), variants, ..Self::default() };
        let starts = found.starts(&whole);
        found.drift = if starts.len() > 1 {
            drift(&starts.iter().map(|start| median(start.to_vec())).collect::<Vec<_>>())
        } else {
            drift(&whole[found.warm_up..])
        };
        found
    }

    /// Whether there is no variant.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.variants.is_empty()
    }

    /// Number of rounds that count.
    #[must_use]
    pub fn rounds(&self) -> usize {
        self.variants.first().map_or(0, |variant| self.starts(&variant.frame_ms).iter().map(|start| start.len()).sum())
    }

    /// The values of the rounds that count, a list for each start.
    pub(super) fn starts<'a>(&self, values: &'a [f64]) -> Vec<&'a [f64]> {
        values.chunks(self.each.max(1)).filter_map(|start| start.get(self.warm_up..)).collect()
    }

    /// The times of a variant in the rounds that count.
    pub(super) fn kept(&self, variant: &Series, what: &str) -> Option<Vec<f64>> {
        Some(self.starts(&variant.times(what)?).concat())
    }

    /// What a reader must know of the run: other load, and drift.
    #[must_use]
    pub fn doubts(&self) -> Vec<String> {
        let load = self.other_load.filter(|load| *load >= 0.1);
        let load = load.map(|load| format!("other programs kept {load:.1} processors busy while this was timed"));
        let drift = self.drift.map(|drift| {
            let rose = if drift > 0.0 { "rose" } else { "fell" };
            format!(
                "drift: a frame's time {rose} by {:.1} % from the first to the last third of the rounds",
                drift.abs() * 100.0
            )
        });
        let unknown =
            self.other_load.is_none().then(|| "this system does not tell what other programs ran".to_string());
        load.into_iter().chain(unknown).chain(drift).collect()
    }

    /// The first fault of samples that come from a file, if there is one.
    #[must_use]
    pub fn fault(&self) -> Option<String> {
        let Some(first) = self.variants.first() else { return Some("there are no variants".into()) };
        let rounds = first.frame_ms.len();
        let lists = self.variants.iter().flat_map(|variant| {
            let stages = variant.stages.iter().map(|times| (times.stage.as_str(), &times.ms));
            stages.chain([(FRAME, &variant.frame_ms)])
        });
        for (what, times) in lists {
            if times.len() != rounds {
                return Some(format!("{what} has {} samples, not {rounds}", times.len()));
            }
            if let Some(time) = times.iter().find(|time| !(time.is_finite() && **time >= 0.0)) {
                return Some(format!("{what} has a sample of {time} ms"));
            }
        }
        let each = self.each.min(rounds);
        (self.warm_up >= each).then(|| format!("warm_up is {}, of {each} rounds", self.warm_up))
    }
}
