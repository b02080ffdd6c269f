//! Results of conformance as data: what was run, and a record for each stage of each fixture on each device.
//!
//! A file holds them as one JSON object, or as lines of JSON that were written as the comparisons ended.

pub mod changes;
mod facts;
mod read;

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

pub use facts::{DeviceFacts, system};
pub use read::read;

use crate::gpu::Adapter;
use crate::measure::bias::{Bias, farthest};
use crate::measure::conform::Row;
use crate::pipeline::frame::stage;
use crate::state::Tolerance;

/// The version of the format.
pub const SCHEMA: u32 = 1;

/// A run of the program.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Run {
    /// The version of this format.
    pub schema: u32,
    /// The program's version.
    pub version: String,
    /// The commit it was built from, where the build could tell.
    pub commit: Option<String>,
    /// The operating system and the processor.
    #[serde(default)]
    pub system: String,
    /// The version of the validation layer, if it watched.
    #[serde(default)]
    pub layer: Option<String>,
    /// When it began: UTC, `2026-01-31T23:59:59Z`.
    pub date: String,
    /// The command.
    pub command: String,
    /// Upper bounds, in units in the last place, of all but the last number of a histogram.
    pub most_ulp_of_bins: Vec<u64>,
    /// The devices.
    pub devices: Vec<DeviceFacts>,
}

/// What a comparison came to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// Within tolerance.
    #[default]
    Conforms,
    /// Beyond tolerance, or wrong in another way that a comparison finds.
    Differs,
    /// The process took longer than it may.
    Hung,
    /// The process ended by a signal or a panic.
    Crashed,
    /// The device failed.
    DeviceFailed,
}

impl Verdict {
    /// Whether the comparison conforms.
    #[must_use]
    pub fn passes(self) -> bool {
        self == Self::Conforms
    }

    /// Its name in tables: in capitals unless the comparison conforms.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Conforms => "conforms",
            Self::Differs => "DIFFERS",
            Self::Hung => "HUNG",
            Self::Crashed => "CRASHED",
            Self::DeviceFailed => "DEVICE FAILED",
        }
    }
}

/// A stage of a fixture on a device.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Outcome {
    /// The device.
    pub device: String,
    /// The driver's name and version.
    pub driver: String,
    /// The fixture.
    pub fixture: String,
    /// The stage; empty where none had begun.
    pub stage: String,
    /// The verdict.
    pub verdict: Verdict,
    /// Everything found wrong.
    pub faults: Vec<String>,
    /// Why it is known to fail, if it is.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub known: Option<String>,
    /// The command that repeats it.
    pub repeat: String,
    /// Steps: one per object, chunk, group or batch.
    pub steps: usize,
    /// Words compared.
    pub words: usize,
    /// Largest distance in units in the last place; null if a value is not a number.
    pub ulp: Option<u64>,
    /// Number of floats per distance.
    pub histogram: [u64; 8],
    /// Largest relative difference; null if a value is not a number.
    pub relative: Option<f64>,
    /// Largest difference as a share of the allowed one; null if a value is not a number.
    pub of_tolerance: Option<f64>,
    /// The float of the largest distance, where it conforms for another reason than its own size: its values, and what
    /// allows them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub farthest: Option<String>,
    /// The tolerance of each buffer that the stage writes.
    pub tolerance: BTreeMap<String, String>,
    /// A hash of what the device left in each of these buffers.
    pub hashes: BTreeMap<String, String>,
    /// The mean signed relative difference that is farthest from 0, of fields with enough values.
    pub mean: Option<f64>,
    /// The signed relative differences, field by field.
    pub means: Vec<Bias>,
    /// Time of the comparison by the host's clock, seconds.
    pub seconds: f64,
}

/// A line of a file of results.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Line {
    /// The run: the first line.
    Run(Run),
    /// A comparison begins: fixture and stage.
    Begins(String, String),
    /// A comparison has ended.
    Result(Box<Outcome>),
}

/// A whole file of results.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Results {
    /// What was run.
    pub run: Run,
    /// The outcomes of all comparisons, in order.
    pub results: Vec<Outcome>,
}

impl Outcome {
    /// The record of a row on this device.
    #[must_use]
    pub fn new(adapter: &Adapter, row: &Row, repeat: String) -> Self {
        let (stage, distances) = (stage(row.stage), &row.distances);
        let writes = stage.map_or(&[][..], |stage| stage.writes).iter();
        let compared = writes.filter(|(slot, ..)| stage.is_some_and(|stage| !stage.is_scratch(*slot)));
        Self {
            device: adapter.name.clone(),
            driver: adapter.driver.clone(),
            fixture: row.fixture.clone(),
            stage: row.stage.into(),
            verdict: if row.faults.is_empty() { Verdict::Conforms } else { Verdict::Differs },
            faults: row.faults.clone(),
            known: None,
            repeat,
            steps: row.steps,
            words: distances.words,
            ulp: (distances.ulp < u64::MAX).then_some(distances.ulp),
            histogram: distances.histogram,
            relative: distances.relative.is_finite().then_some(distances.relative),
            of_tolerance: distances.used.is_finite().then_some(distances.used),
            farthest: distances.farthest.clone().filter(|_| row.faults.is_empty()),
            tolerance: compared.map(|(slot, _, t)| (slot.spec().name.into(), words(t))).collect(),
            hashes: row.hashes.iter().map(|(name, hash)| ((*name).into(), format!("{hash:016x}"))).collect(),
            mean: farthest(&distances.biases),
            means: distances.biases.iter().filter(|bias| bias.count > 0).cloned().collect(),
            seconds: row.seconds,
        }
    }
}

/// A tolerance in words.
fn words(tolerance: &Tolerance) -> String {
    match tolerance {
        Tolerance::Exact => "the same bits".into(),
        Tolerance::Float { relative, floor } => {
            format!("{relative:e} of the value and {floor:e} of the field's largest")
        }
        Tolerance::Fields(fields) | Tolerance::Rounded(fields, _) => {
            let one = |field: &crate::state::Field| {
                let of = if field.of.is_empty() { String::new() } else { format!(" of {}", field.of) };
                format!("{}: {:e} of the value and {:e}{of}", field.name, field.relative, field.floor)
            };
            let mut text = fields.iter().map(one).collect::<Vec<_>>().join("; ");
            if let Tolerance::Rounded(_, rounding) = tolerance {
                text += &format!("; {} also {}", rounding.fields.join(", "), rounding.about);
            }
            text + "; else the same bits"
        }
    }
}
