//! A file of runs of `profile`, a line of JSON for each: the medians of its stages, and the curves they draw.

use std::path::Path;

use serde::{Deserialize, Serialize};

use super::file::{SCHEMA, Saved, Subject};
use crate::error::{Input, Result};
use crate::measure::plot::{Axis, Mark, Panel, Plot, Point, Series};
use crate::measure::rounds::Samples;
use crate::measure::table::{Column, Table};
use crate::view::atomic_file::append;

/// Most bytes of a file.
const MOST: u64 = 1 << 28;

/// A run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Entry {
    /// When it ended: UTC, `2026-01-31T23:59:59Z`.
    pub date: String,
    /// What was timed, by which program, on what, without its samples.
    #[serde(flatten)]
    pub run: Saved,
    /// The times of the first variant: of each stage, of all together, and of the frame.
    pub ms: Vec<Time>,
}

/// The time of a stage.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Time {
    /// The stage, `stages` for the sum of all, or `frame` for the time from call to result.
    pub what: String,
    /// Its median, milliseconds.
    pub median: f64,
    /// The ends of the median's interval of 95 %, where there were samples enough.
    pub ends: Option<[f64; 2]>,
}

impl Entry {
    /// The line of a run that ended at this date.
    #[must_use]
    pub fn of(run: &Saved, date: String) -> Self {
        let time = |(what, found): (&str, crate::measure::statistics::Interval)| Time {
            what: what.into(),
            median: found.value,
            ends: (found.low.is_finite() && found.high.is_finite()).then_some([found.low, found.high]),
        };
        let ms = run.samples.medians().into_iter().map(time).collect();
        Self { date, run: Saved { samples: Samples::default(), ..run.clone() }, ms }
    }

    /// Appends the line to a file, for which [`ready`] has been asked.
    pub fn append(&self, path: &Path) -> Result<()> {
        let line = serde_json::to_string(self).map_err(|error| Input::new(error.to_string()).file(path))?;
        append(path, (line + "\n").as_bytes())
    }

    /// The median of one of its rows.
    fn time(&self, what: &str) -> Option<&Time> {
        self.ms.iter().find(|time| time.what == what)
    }
}

/// An error if a file holds something else than runs, or its last line is not whole: no line may be appended to it.
pub fn ready(path: &Path) -> Result<()> {
    if !std::fs::metadata(path).is_ok_and(|known| known.is_file()) {
        return Ok(());
    }
    let text = text(path)?;
    parse(path, &text)?;
    match text.lines().count() {
        count if count > 0 && !text.ends_with('\n') => {
            Err(fault(path, "the last line has no end".into()).line(count).into())
        }
        _ => Ok(()),
    }
}

/// The runs that a file holds.
pub fn read(path: &Path) -> Result<Vec<Entry>> {
    parse(path, &text(path)?)
}

fn fault(path: &Path, what: String) -> Input {
    Input::new(what).file(path).expected("lines that `milkglass profile --history` writes")
}

fn text(path: &Path) -> Result<String> {
    let unread = |error| fault(path, format!("could not be read: {error}"));
    let known = std::fs::metadata(path).map_err(unread)?;
    if !known.is_file() || known.len() > MOST {
        return Err(fault(path, format!("not a plain file of at most {MOST} bytes")).into());
    }
    Ok(std::fs::read_to_string(path).map_err(unread)?)
}

fn parse(path: &Path, text: &str) -> Result<Vec<Entry>> {
    let entry = |(k, line): (usize, &str)| -> Result<Entry> {
        let entry: Entry = serde_json::from_str(line)
            .map_err(|error| fault(path, format!("not a run: {error}").replace(" at line 1", ",")).line(k + 1))?;
        match entry.run.schema {
            SCHEMA => Ok(entry),
            other => {
                let what = format!("this version of the format is not known, but version {SCHEMA} is");
                Err(fault(path, what).line(k + 1).key("schema").found(other).into())
            }
        }
    };
    text.lines().enumerate().filter(|(_, line)| !line.trim().is_empty()).map(entry).collect()
}

/// Runs that timed the same by the same kernels on the same device, in their order.
pub struct Course<'a> {
    /// What, on which device, and by which kernels in place of built-in ones.
    pub subject: (&'a Subject, &'a str, &'a [String]),
    /// The runs, with their numbers in the file from 1.
    pub runs: Vec<(usize, &'a Entry)>,
}

/// The courses of a file, in the order of their first runs.
#[must_use]
pub fn courses(entries: &[Entry]) -> Vec<Course<'_>> {
    let mut found: Vec<Course<'_>> = Vec::new();
    for (k, entry) in entries.iter().enumerate() {
        let Saved { subject, device, replaced, .. } = &entry.run;
        let subject = (subject, device.as_str(), replaced.as_slice());
        match found.iter_mut().find(|course| course.subject == subject) {
            Some(course) => course.runs.push((k + 1, entry)),
            None => found.push(Course { subject, runs: vec![(k + 1, entry)] }),
        }
    }
    found
}

impl Course<'_> {
    /// The subject in a line.
    #[must_use]
    pub fn title(&self) -> String {
        let (subject, device, replaced) = self.subject;
        let replaced: String = replaced.iter().map(|pair| format!(", {pair}")).collect();
        let sets: String = subject.sets.iter().map(|set| format!(" {set}")).collect();
        let Subject { scene, change, mode, transport, .. } = subject;
        let by = subject.by();
        format!("{scene}{sets}, {transport}, {mode}, change {change}, by {by}, on {device}{replaced}")
    }

    /// The rows to draw: the sum of all and the frame, and stages that once took 5 % of the sum or more.
    fn rows(&self) -> Vec<&str> {
        let mut names: Vec<&str> = Vec::new();
        for (_, entry) in &self.runs {
            let sum: f64 = entry.time("stages").map_or(0.0, |time| time.median);
            let large = entry.ms.iter().filter(|time| time.median >= 0.05 * sum).map(|time| time.what.as_str());
            names.extend(large.filter(|name| !names.contains(name)).collect::<Vec<_>>());
        }
        names
    }

    /// A curve for each row, over the runs' numbers.
    pub fn svg(&self) -> Result<String> {
        let curve = |name: &&str| {
            let point = |(k, entry): &(usize, &Entry)| {
                let (time, x) = (entry.time(name)?, *k as f64);
                let ends = time.ends.map(|ends| ends.map(|ms| [x, ms]));
                Some(Point { place: [x, time.median], ends, ..Point::default() })
            };
            let points = self.runs.iter().filter_map(point).collect();
            Series { points, ..Series::new(*name, Mark::Curve, []) }
        };
        let series: Vec<Series> = self.rows().iter().map(curve).collect();
        let last = self.runs.last().map_or(1, |(k, _)| *k) as f64;
        let first = self.runs.first().map_or(1, |(k, _)| *k) as f64;
        let axes = [Axis::linear("run").within([first - 0.5, last + 0.5]), Axis::log("median, ms")];
        Plot { title: vec![self.title()], panels: vec![Panel::new("", axes, series)], ..Plot::default() }.svg()
    }

    /// A row for each run.
    #[must_use]
    pub fn table(&self) -> Table {
        let names = self.rows();
        let cells: Vec<_> = names
            .iter()
            .map(|name| {
                move |(_, entry): &(usize, &Entry)| {
                    entry.time(name).map_or_else(String::new, |time| format!("{:.3}", time.median))
                }
            })
            .collect();
        let commit = |(_, entry): &(usize, &Entry)| entry.run.commit.clone().unwrap_or_default();
        let before: [Column<'_, (usize, &Entry)>; 4] = [
            ("run", "its line in the file", &|(k, _)| k.to_string()),
            ("date", "when it ended, UTC", &|(_, entry)| entry.date.clone()),
            ("commit", "of the program; with a plus sign, changed since", &commit),
            ("driver", "", &|(_, entry)| entry.run.driver.clone()),
        ];
        let times = names.iter().zip(&cells).map(|(name, cell)| (*name, "median, ms", cell as _));
        Table::of(&self.runs, &before.into_iter().chain(times).collect::<Vec<_>>())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn entry(scene: &str, gather: f64) -> Entry {
        let time = |what: &str, median: f64| Time { what: what.into(), median, ends: Some([median, 1.5 * median]) };
        let subject = Subject { scene: scene.into(), ..Subject::default() };
        let ms =
            vec![time("gather", gather), time("push", 0.03125), time("stages", gather + 0.03125), time("frame", 9.0)];
        Entry { date: "d".into(), run: Saved { schema: SCHEMA, subject, ..Saved::default() }, ms }
    }

    #[test]
    fn runs_are_appended_and_come_back_by_subject() {
        let here = tempfile::tempdir().unwrap();
        let path = here.path().join("history.jsonl");
        let mut own = entry("a", 9.0);
        own.run.replaced = vec!["push=my.comp".into()];
        let all = [entry("a", 1.0), entry("b", 2.0), entry("a", 1.5), own];
        all.iter().for_each(|entry| entry.append(&path).unwrap());
        let found = read(&path).unwrap();
        assert_eq!(found, all);
        let found = courses(&found);
        assert_eq!(found.iter().map(|course| course.runs.len()).collect::<Vec<_>>(), [2, 1, 1]);
        assert!(found[2].title().ends_with(", push=my.comp") && !found[0].title().contains("push"));
        // `push` takes less than 5 % of all.
        assert_eq!(found[0].rows(), ["gather", "stages", "frame"]);
        let table = found[0].table();
        assert_eq!(
            table.rows.iter().map(|row| (&row[0][..], &row[4][..])).collect::<Vec<_>>(),
            [("1", "1.000"), ("3", "1.500")]
        );
        let svg = found[0].svg().unwrap();
        assert!(svg.contains("gather") && svg.contains("median, ms") && !svg.contains("push"), "{svg}");
    }

    #[test]
    fn a_file_of_others_takes_no_line() {
        let here = tempfile::tempdir().unwrap();
        let path = here.path().join("h");
        ready(&path).unwrap();
        entry("a", 1.0).append(&path).unwrap();
        ready(&path).unwrap();
        let good = std::fs::read_to_string(&path).unwrap();
        let torn = format!("{good}{}", good.trim_end());
        for (text, words) in [(torn.as_str(), "h:2: the last line has no end"), ("a = 1\n", "h:1: not a run")] {
            std::fs::write(&path, text).unwrap();
            let fault = ready(&path).unwrap_err();
            assert!(fault.to_string().contains(words) && fault.exit_code() == 2, "{words}: {fault}");
        }
        std::fs::write(&path, "").unwrap();
        ready(&path).unwrap();
    }

    #[test]
    fn lines_of_others_are_refused_with_their_number() {
        let here = tempfile::tempdir().unwrap();
        let path = here.path().join("h");
        entry("a", 1.0).append(&path).unwrap();
        let good = std::fs::read_to_string(&path).unwrap();
        for (text, words) in [
            (format!("{good}{{}}\n"), "h:2: not a run: missing field"),
            (format!("{good}\n{}", &good[..40]), "h:3: not a run: EOF"),
            (good.replace("\"schema\":1", "\"schema\":7"), "h:1: schema: this version"),
        ] {
            std::fs::write(&path, text).unwrap();
            let fault = read(&path).unwrap_err();
            assert!(fault.to_string().contains(words) && fault.exit_code() == 2, "{words}: {fault}");
        }
    }
}
