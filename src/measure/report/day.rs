//! The section on another device: what `bench/device-day` found there, beside the same here.

use std::path::Path;

use serde::Serialize;

use super::{Bench, Page, Shown};
use crate::error::{Error, Input, Result};
use crate::measure::profile::file::{self, Saved};
use crate::measure::results::{Results, read};
use crate::measure::rounds::Samples;
use crate::measure::statistics::Interval;
use crate::measure::table::Table;

/// Most bytes of a summary or a picture.
const MOST: u64 = 1 << 26;
/// A row that takes less than this share of all stages is left out.
const SHARE: f64 = 1e-3;
/// Most steps of a day.
const STEPS: usize = 100;

/// What a folder of `bench/device-day` holds.
#[derive(Default, Serialize)]
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
        let fault = |what: &str| Input::new(what).file(&summary).expected(EXPECTED);
        let mut steps: Vec<[String; 4]> = Vec::new();
        for (k, line) in text.lines().enumerate() {
            let Some(step) = step(line).map_err(|what| fault(what).line(k + 1))? else { continue };
            if steps.len() == STEPS || steps.iter().any(|known| known[0] == step[0]) {
                let what = format!("a step of an earlier name, or more than {STEPS} steps");
                return Err(fault(&what).line(k + 1).found(&step[0]).into());
            }
            steps.push(step);
        }
        if steps.is_empty() {
            return Err(fault("it names no step that ran").into());
        }
        let there = |name: &str, end: &str| {
            let path = folder.join(format!("{name}{end}"));
            match path.symlink_metadata() {
                Ok(_) => known(&path, FILE).map(|()| Some(path)),
                Err(_) => Ok(None),
            }
        };
        let conform = there("conform", ".jsonl")?.map(|path| read(&path)).transpose()?;
        let picture = there("lotus", ".png")?.map(|path| plain(&path).map(|bytes| (path, bytes))).transpose()?;
        if let Some((path, _)) = picture.as_ref().filter(|(_, bytes)| !bytes.starts_with(PNG)) {
            return Err(Input::new("not a PNG file").file(path).expected(EXPECTED).into());
        }
        let mut profiles = Vec::new();
        // Earlier versions left variants by that name.
        for [name, ..] in steps.iter().filter(|[name, code, ..]| !code.is_empty() && name != "vary") {
            // A step that was stopped has saved nothing.
            if let Some(path) = there(name, ".json")? {
                profiles.push((name.clone(), file::read(&path)?));
            }
        }
        let picture = picture.map(|(_, bytes)| bytes);
        Ok(Self { steps, conform, profiles, picture })
    }
}

/// What a folder has to be.
const EXPECTED: &str = "the folder that day.tar.gz of bench/device-day unpacks to";

/// How a PNG file begins.
const PNG: &[u8] = b"\x89PNG\r\n\x1a\n";
/// Most bytes of a saved profile or of results.
const FILE: u64 = 1 << 30;

/// An error unless this is a file of the folder itself, and no link to another one, with at most so many bytes.
fn known(path: &Path, most: u64) -> Result<()> {
    let fault = |what: String| Error::from(Input::new(what).file(path).expected(EXPECTED));
    let known = path.symlink_metadata().map_err(|error| fault(format!("could not be read: {error}")))?;
    match known.is_file() && known.len() <= most {
        true => Ok(()),
        false => Err(fault(format!("not a plain file of at most {most} bytes"))),
    }
}

/// The bytes of a plain file.
fn plain(path: &Path) -> Result<Vec<u8>> {
    known(path, MOST)?;
    let fault = |error| Input::new(format!("could not be read: {error}")).file(path).expected(EXPECTED);
    Ok(std::fs::read(path).map_err(fault)?)
}

/// A step of a line `NAME exit CODE SECONDS s LAST LINE` or `NAME: no time left`; none if the line is another.
fn step(line: &str) -> std::result::Result<Option<[String; 4]>, &'static str> {
    if let Some((name, why)) = line.split_once(": ").filter(|(name, _)| !name.contains(char::is_whitespace)) {
        return Ok(Some([name, "", "", why].map(String::from)));
    }
    let words: Vec<&str> = line.split_whitespace().collect();
    match words[..] {
        [name, "exit", ..] if name.contains(['/', '\\']) || name.starts_with('.') => {
            Err("a step's name is no name of a file in this folder")
        }
        [name, "exit", code, seconds, "s", ..] => {
            Ok(Some([name.into(), code.into(), seconds.into(), words[5..].join(" ")]))
        }
        [_, "exit", ..] => Err("not NAME exit CODE SECONDS s LAST LINE"),
        _ => Ok(None),
    }
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

/// Says how many comparisons conform there; those that do not are faults, and so are steps that failed. Whether all
/// conform is known only if that step ended by itself.
fn conformed(day: &Day, page: &mut Page) {
    let results = day.conform.iter().flat_map(|found| &found.results);
    for outcome in results.clone().filter(|outcome| !outcome.verdict.passes()) {
        let why = outcome.faults.first().map_or_else(|| format!("{:?}", outcome.verdict), String::clone);
        page.fail(&format!("{}, {}, {}: {why}", outcome.device, outcome.fixture, outcome.stage));
    }
    let differs = results.clone().any(|outcome| !outcome.verdict.passes());
    for [name, code, _, last] in &day.steps {
        match (name.as_str(), code.as_str()) {
            (_, "" | "0") => {}
            // The script stops what takes too long.
            (_, "124") => page.say(&format!("{name} was stopped before its end: what it has is incomplete.")),
            ("conform", "1") if differs => {}
            _ => page.fail(&format!("{name} ended with exit code {code}: {last}")),
        }
    }
    let (count, words) = (results.clone().count(), results.map(|outcome| outcome.words).sum::<usize>());
    page.checked |= count > 0 && day.steps.iter().any(|[name, code, ..]| name == "conform" && code == "0");
    page.say(&format!("conform there: {count} comparisons, {words} words."));
}

/// The medians of two devices' samples, for all that takes time there.
fn beside(there: &Samples, here: &Samples) -> Table {
    let (there, here) = (there.medians(), here.medians());
    let whole = there.iter().find(|(what, _)| *what == "stages").map_or(0.0, |(_, time)| time.value);
    let shown = there.iter().filter(|(_, time)| time.value >= SHARE * whole);
    let row = |(what, time): &(&str, Interval)| {
        let own = here.iter().find(|(known, _)| known == what).map(|(_, time)| time.value);
        let ratio = own.filter(|_| time.value > 0.0).map(|own| own / time.value);
        let text =
            |value: Option<f64>, places: usize| value.map_or_else(String::new, |value| format!("{value:.places$}"));
        vec![(*what).to_string(), text(Some(time.value), 3), text(own, 3), text(ratio, 1)]
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
        let found = |line: &str| step(line).unwrap().unwrap();
        assert_eq!(
            found("light-1e-2         exit 124   30 s  frame 1.2 ms"),
            ["light-1e-2", "124", "30", "frame 1.2 ms"]
        );
        assert_eq!(found("vary: no time left"), ["vary", "", "", "no time left"]);
        assert_eq!(found("my+mesh exit 0 1 s")[3], "");
        assert_eq!(step("results: x y"), Ok(Some(["results", "", "", "x y"].map(String::from))));
        assert_eq!(step("a line"), Ok(None));
        assert!(step("../x exit 0 1 s").unwrap_err().contains("name of a file"));
        assert!(step("x exit 0").unwrap_err().contains("not NAME exit"));
    }

    /// The faults of a day with these steps, and whether it was checked.
    fn faults(steps: &[(&str, &str)], results: usize) -> (Vec<String>, bool) {
        let steps = steps.iter().map(|(name, code)| [name, code, "1", "x"].map(String::from)).collect();
        let outcome = crate::measure::results::Outcome { words: 1, ..Default::default() };
        let conform = Some(Results { results: vec![outcome; results], ..Results::default() });
        let mut page = Page::default();
        conformed(&Day { steps, conform, ..Day::default() }, &mut page);
        (page.faults, page.checked)
    }

    #[test]
    fn what_did_not_end_well_is_no_pass() {
        assert_eq!(faults(&[("conform", "0")], 1), (vec![], true));
        assert_eq!(faults(&[("conform", "0")], 0), (vec![], false));
        assert_eq!(faults(&[("conform", "124")], 1), (vec![], false));
        let (told, checked) = faults(&[("conform", "0"), ("stress", "1")], 1);
        assert_eq!((told, checked), (vec!["stress ended with exit code 1: x".to_string()], true));
        assert_eq!(faults(&[("conform", "3")], 1).0, ["conform ended with exit code 3: x"]);
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
