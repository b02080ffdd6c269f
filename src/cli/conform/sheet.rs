//! The tables that `conform` prints: a row as each comparison ends, then the histogram of distances.

use super::choose::Choice;
use crate::cli::table;
use milkglass::internals::pipeline::frame::STAGES;
use milkglass::measure::bias::{add, farthest};
use milkglass::measure::conform::BINS;
use milkglass::measure::results::{DeviceFacts, Outcome};

/// The headings, and the least widths of their columns.
const COLUMNS: [(&str, usize); 8] = [
    ("device", 0),
    ("fixture", 0),
    ("stage", 0),
    ("words", 9),
    ("ulp", 7),
    ("relative", 8),
    ("of tolerance", 12),
    ("verdict", 0),
];

/// A table whose rows come one by one.
pub(super) struct Sheet {
    widths: [usize; 8],
    begun: bool,
}

impl Sheet {
    /// A table with columns wide enough for these devices and fixtures.
    pub(super) fn new(devices: &[DeviceFacts], choices: &[Choice]) -> Self {
        let count = |text: &str| text.chars().count();
        let mut widths = COLUMNS.map(|(name, least)| count(name).max(least));
        widths[0] = devices.iter().map(|device| count(&device.name)).fold(widths[0], usize::max);
        widths[1] = choices.iter().map(|choice| count(choice.name())).fold(widths[1], usize::max);
        widths[2] = STAGES.iter().map(|stage| count(stage.name)).fold(widths[2], usize::max);
        Self { widths, begun: false }
    }

    /// A row, after the headings if it is the first one.
    pub(super) fn row(&mut self, outcome: &Outcome) -> String {
        let heading = if std::mem::replace(&mut self.begun, true) {
            String::new()
        } else {
            self.line(&COLUMNS.map(|(name, _)| name.to_string()))
        };
        let star = if outcome.farthest.is_some() { "*" } else { "" };
        let ulp = match outcome.ulp {
            None => "NaN".to_string(),
            Some(1_000_001..) => format!(">1e6{star}"),
            Some(ulp) => format!("{ulp}{star}"),
        };
        let relative = outcome.relative.map_or("inf".into(), |relative| format!("{relative:.1e}"));
        let known = if outcome.known.is_some() { " (known)" } else { "" };
        let mut cells = [outcome.device.clone(), outcome.fixture.clone(), outcome.stage.clone()].to_vec();
        cells.extend([outcome.words.to_string(), ulp, relative, of_tolerance(outcome.of_tolerance)]);
        if outcome.words == 0 && !outcome.verdict.passes() {
            cells[3..].fill("-".into());
        }
        cells.push(format!("{}{known}", outcome.verdict.name()));
        heading + &self.line(&cells)
    }

    fn line(&self, cells: &[String]) -> String {
        let padded: Vec<String> = cells
            .iter()
            .zip(self.widths)
            .enumerate()
            .map(|(k, (cell, width))| {
                let gap = " ".repeat(width.saturating_sub(cell.chars().count()));
                if (3..7).contains(&k) { format!("{gap}{cell}") } else { format!("{cell}{gap}") }
            })
            .collect();
        format!("{}\n", padded.join("  ").trim_end())
    }
}

/// A difference in per cent of what the tolerance allows.
pub(super) fn of_tolerance(used: Option<f64>) -> String {
    match used.map(|used| 100.0 * used) {
        Some(0.0) => "0 %".into(),
        Some(percent) if percent < 1.0 => "<1 %".into(),
        Some(percent) => format!("{percent:.0} %"),
        None => "NaN".into(),
    }
}

/// The histogram of distances, over all fixtures.
pub(super) fn histogram(outcomes: &[Outcome]) -> String {
    let mut sums: Vec<(&str, &str, [u64; 8])> = Vec::new();
    for outcome in outcomes {
        match sums.iter_mut().find(|sum| sum.0 == outcome.device && sum.1 == outcome.stage) {
            Some(sum) => sum.2.iter_mut().zip(outcome.histogram).for_each(|(sum, count)| *sum += count),
            None => sums.push((&outcome.device, &outcome.stage, outcome.histogram)),
        }
    }
    let share = |count: u64, all: u64| match 100.0 * count as f64 / all as f64 {
        _ if count == 0 => ".".to_string(),
        percent if percent < 0.01 => "<0.01".to_string(),
        percent => format!("{percent:.2}"),
    };
    let row = |(device, stage, counts): &(&str, &str, [u64; 8])| {
        let all: u64 = counts.iter().sum();
        let shares = counts.iter().map(|&count| share(count, all));
        let mut means = Vec::new();
        for own in outcomes.iter().filter(|own| own.device == *device && own.stage == *stage) {
            add(&mut means, &own.means);
        }
        let mean = farthest(&means).map_or("-".into(), |mean| format!("{mean:+.0e}"));
        [device.to_string(), stage.to_string(), all.to_string()].into_iter().chain(shares).chain([mean]).collect()
    };
    let cells: Vec<Vec<String>> = sums.iter().filter(|sum| sum.2.iter().any(|&count| count > 0)).map(row).collect();
    let up_to = BINS.map(|most| format!("<={most}"));
    let beyond = format!(">{}", BINS[BINS.len() - 1]);
    let header: Vec<&str> = ["device", "stage", "floats"]
        .into_iter()
        .chain(up_to.iter().map(String::as_str))
        .chain([beyond.as_str(), "mean"])
        .collect();
    let note = explained(outcomes);
    let text = "\nfloats by their distance from the reference in units in the last place, per cent of all; `mean`: of the \
                signed relative differences, of the buffer that is farthest off\n";
    format!("{note}{text}{}\n", table(header, cells))
}

/// Why distances that are marked with a star are no failures, with the largest one of each device and stage.
fn explained(outcomes: &[Outcome]) -> String {
    let mut largest: Vec<(&Outcome, &str)> = Vec::new();
    for outcome in outcomes {
        let Some(why) = outcome.farthest.as_deref() else { continue };
        match largest.iter_mut().find(|(known, _)| known.device == outcome.device && known.stage == outcome.stage) {
            Some(known) if known.0.ulp < outcome.ulp => *known = (outcome, why),
            Some(_) => {}
            None => largest.push((outcome, why)),
        }
    }
    if largest.is_empty() {
        return String::new();
    }
    let row = |(outcome, why): &(&Outcome, &str)| {
        let Outcome { device, fixture, stage, .. } = outcome;
        [device, fixture, stage, *why].map(str::to_string).to_vec()
    };
    let rows: Vec<_> = largest.iter().map(row).collect();
    let text = "\n* far off in units in the last place and right: the value is small beside what it is computed from. \
                `relative` and `of tolerance` go by what is allowed. The farthest of each stage:\n";
    format!("{text}{}", table(["device", "fixture", "stage", "farthest"], rows))
}
