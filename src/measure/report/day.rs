//! The section on another device: what `bench/device-day` found there, beside the same here.

use std::path::Path;

use super::{Bench, Page, Shown};
use crate::error::{Error, Input, Result};
use crate::measure::profile::file::{self, Saved};
use crate::measure::results::{Results, Verdict, read};
use crate::measure::rounds::Samples;
use crate::measure::statistics::Interval;
use crate::measure::table::Table;

/// Most bytes of a summary or a picture.
const MOST: u64 = 1 << 26;
/// Rows of a table that together take less than this share of the frame are left out.
const SHARE: f64 = 1e-3;

/// What a folder of `bench/device-day` holds.
#[derive(Default)]
pub struct Day {
    /// Name, exit code, seconds and last line of each step.
    steps: Vec<[String; 4]>,
    conform: Option<Results>,
    /// Saved profiles by the names of their steps.
    profiles: Vec<(String, Saved)>,
    picture: Option<Vec<u8>>,
}

impl Day {
    /// Reads the unpacked folder.
    pub fn read(folder: &Path) -> Result<Self> {
        let summary = folder.join("summary.txt");
        let text = String::from_utf8_lossy(&plain(&summary)?).into_owned();
        let steps: Vec<[String; 4]> = text.lines().filter_map(step).collect();
        if steps.is_empty() {
            return Err(Input::new("it names no step that ran").file(&summary).expected(EXPECTED).into());
        }
        let there = |name: &str, end: &str| Some(folder.join(format!("{name}{end}"))).filter(|path| path.exists());
        let conform = there("conform", ".jsonl").map(|path| read(&path)).transpose()?;
        let picture = there("lotus", ".png").map(|path| plain(&path)).transpose()?;
        let mut profiles = Vec::new();
        for [name, ..] in steps.iter().filter(|[_, code, ..]| !code.is_empty()) {
            // A step that was stopped has saved nothing.
            if let Some(path) = there(name, ".json") {
                profiles.push((name.clone(), file::read(&path)?));
            }
        }
        Ok(Self { steps, conform, profiles, picture })
    }
}

/// What a folder has to be.
const EXPECTED: &str = "the folder that day.tar.gz of bench/device-day unpacks to";

/// The bytes of a plain file.
fn plain(path: &Path) -> Result<Vec<u8>> {
    let fault = |what: String| Error::from(Input::new(what).file(path).expected(EXPECTED));
    let known = std::fs::metadata(path).map_err(|error| fault(format!("could not be read: {error}")))?;
    if !known.is_file() || known.len() > MOST {
        return Err(fault(format!("not a plain file of at most {MOST} bytes")));
    }
    std::fs::read(path).map_err(|error| fault(format!("could not be read: {error}")))
}

/// A step of a line `NAME exit CODE SECONDS s LAST LINE` or `NAME: no time left`; none if the line is another.
fn step(line: &str) -> Option<[String; 4]> {
    if let Some((name, why)) = line.split_once(": ").filter(|(name, _)| !name.contains(char::is_whitespace)) {
        return Some([name, "", "", why].map(String::from));
    }
    let mut words = line.split_whitespace();
    let (name, exit, code, seconds) = (words.next()?, words.next()?, words.next()?, words.next()?);
    let whole =
        exit == "exit" && words.next()? == "s" && name.chars().all(|c| c.is_alphanumeric() || "-_.".contains(c));
    whole.then(|| [name.into(), code.into(), seconds.into(), words.collect::<Vec<_>>().join(" ")])
}

/// Shows what was found there, and times the same scenes here.
pub fn day(bench: &Bench<'_>, page: &mut Page) -> Result<()> {
    let Some(day) = bench.day else {
        page.say("No results of bench/device-day were given.");
        return Ok(());
    };
    if let Some((_, saved)) = day.profiles.first() {
        page.say(&format!("There: {}.", saved.origin()));
    }
    page.small_table(&Table::plain(
        ["step", "exit code", "s", "its last line"],
        day.steps.iter().map(|step| step.to_vec()).collect(),
    ));
    conformed(day, page);
    if let Some(png) = &day.picture {
        page.pictures(&[Shown { label: "lotus, rendered there".into(), width: 640, png: png.clone() }]);
    }
    if !day.profiles.is_empty() {
        page.say("Medians of a few frames, there and here, and how many times as long it takes here.");
    }
    for (name, saved) in &day.profiles {
        let subject = &saved.subject;
        page.head(&format!("{name}: {}, {} changes, by {}", subject.scene, subject.change, subject.by()));
        let here = match bench.timed.map(|timed| timed(subject, bench.device)) {
            Some(Ok(samples)) => samples,
            Some(Err(error)) => {
                page.say(&format!("Not timed here: {error}"));
                Samples::default()
            }
            None => Samples::default(),
        };
        page.table(&format!("day-{name}"), &beside(&saved.samples, &here))?;
    }
    Ok(())
}

/// Says how many comparisons conform there; those that do not are faults.
fn conformed(day: &Day, page: &mut Page) {
    let Some(found) = &day.conform else { return };
    for outcome in found.results.iter().filter(|outcome| outcome.verdict != Verdict::Conforms) {
        let why = outcome.faults.first().map_or_else(|| format!("{:?}", outcome.verdict), String::clone);
        page.fail(&format!("{}, {}, {}: {why}", outcome.device, outcome.fixture, outcome.stage));
    }
    let words: usize = found.results.iter().map(|outcome| outcome.words).sum();
    page.checked = true;
    page.say(&format!("conform there: {} comparisons, {words} words.", found.results.len()));
}

/// The medians of two devices' samples, for all that takes time there.
fn beside(there: &Samples, here: &Samples) -> Table {
    let (there, here) = (there.medians(), here.medians());
    let whole = there.iter().find(|(what, _)| *what == "stages").map_or(0.0, |(_, time)| time.value);
    let shown = there.iter().filter(|(_, time)| time.value >= SHARE * whole);
    let row = |(what, time): &(&str, Interval)| {
        let own = here.iter().find(|(known, _)| known == what).map(|(_, time)| time.value);
        let text =
            |value: Option<f64>, places: usize| value.map_or_else(String::new, |value| format!("{value:.places$}"));
        vec![(*what).to_string(), text(Some(time.value), 3), text(own, 3), text(own.map(|own| own / time.value), 1)]
    };
    let columns =
        [("what", ""), ("there, ms", "median"), ("here, ms", "median"), ("here / there", "how many times as long")];
    Table::new(columns, shown.map(row).collect())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::rounds::Series;

    #[test]
    fn lines_of_a_summary_are_steps() {
        let found = step("light-1e-2         exit 124   30 s  frame 1.2 ms").unwrap();
        assert_eq!(found, ["light-1e-2", "124", "30", "frame 1.2 ms"]);
        assert_eq!(step("vary: no time left").unwrap(), ["vary", "", "", "no time left"]);
        assert_eq!(step("../x exit 0 1 s"), None);
        assert_eq!(step("devices exit 0 1 s").unwrap()[3], "");
    }

    #[test]
    fn times_stand_side_by_side() {
        let samples = |ms: f64| {
            let variants = vec![Series { frame_ms: vec![ms; 12], ..Series::default() }];
            Samples { each: 12, variants, ..Samples::default() }
        };
        assert_eq!(beside(&samples(2.0), &samples(5.0)).rows, [["frame", "2.000", "5.000", "2.5"]]);
        assert_eq!(beside(&samples(2.0), &Samples::default()).rows, [["frame", "2.000", "", ""]]);
    }
}
