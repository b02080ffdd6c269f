//! A profile's file: what was timed, on what, and all samples, to be compared with another run.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::error::{Error, Input, Result};
use crate::measure::rounds::Samples;

/// The version of the format.
pub const SCHEMA: u32 = 1;
/// Most bytes of a profile's file.
const MOST: u64 = 1 << 30;

/// What was timed.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Subject {
    /// The scene, as it was named.
    pub scene: String,
    /// The frame of an animation.
    pub frame: f64,
    /// Values of the scene that were set: `KEY=VALUE`.
    pub sets: Vec<String>,
    /// What changes before each frame.
    pub change: String,
    /// What is kept between frames.
    pub mode: String,
    /// How light is transported.
    pub transport: String,
    /// Whether kernels are timed, not stages.
    #[serde(default)]
    pub by_kernel: bool,
    /// Whether each of their dispatches is.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub by_dispatch: bool,
}

impl Subject {
    /// What has times of its own, in a word.
    #[must_use]
    pub fn by(&self) -> &'static str {
        match (self.by_kernel, self.by_dispatch) {
            (_, true) => "dispatch",
            (true, false) => "kernel",
            (false, false) => "stage",
        }
    }
}

/// A run of `profile`.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Saved {
    /// The version of this format.
    pub schema: u32,
    /// The program's version.
    pub version: String,
    /// The commit it was built from, where the build could tell.
    pub commit: Option<String>,
    /// What was timed.
    pub subject: Subject,
    /// The device's name, or `cpu`.
    pub device: String,
    /// The driver's name and version.
    pub driver: String,
    /// Kernels that were replaced, `KERNEL=FILE`, and the file of their constants.
    pub replaced: Vec<String>,
    /// All times; none in a history.
    #[serde(default, skip_serializing_if = "Samples::is_empty")]
    pub samples: Samples,
}

impl Saved {
    /// The program, device and driver in a line.
    #[must_use]
    pub fn origin(&self) -> String {
        let commit =
            self.commit.as_deref().map(|commit| format!(", commit {}", commit.chars().take(12).collect::<String>()));
        let replaced: String = self.replaced.iter().map(|pair| format!(", {pair}")).collect();
        format!("milkglass {}{}, {}, {}{replaced}", self.version, commit.unwrap_or_default(), self.device, self.driver)
    }

    /// Fails if another run did not time the same; `path` is that run's file, or a name in place of one.
    pub fn same_subject(&self, other: &Self, path: &Path) -> Result<()> {
        let (one, two) = (&self.subject, &other.subject);
        let words = |subject: &Subject| {
            let set = |pair: &String| ("--set", pair.clone());
            let rest = [
                ("SCENE", subject.scene.clone()),
                ("--frame", subject.frame.to_string()),
                ("--change", subject.change.clone()),
                ("--mode", subject.mode.clone()),
                ("--transport", subject.transport.clone()),
                ("--by", subject.by().to_string()),
            ];
            [rest.to_vec(), subject.sets.iter().map(set).collect()].concat()
        };
        let (mine, theirs) = (words(one), words(two));
        let count = mine.len().max(theirs.len());
        for k in 0..count {
            let (expected, found) = (mine.get(k), theirs.get(k));
            if expected != found {
                let text = |word: Option<&(&str, String)>| word.map_or("none".into(), |(_, value)| value.clone());
                let key = expected.or(found).map_or("SCENE", |(key, _)| key);
                let fault = Input::new("the two runs timed different things").file(path).key(key);
                return Err(fault.found(text(found)).expected(text(expected)).into());
            }
        }
        Ok(())
    }
}

/// The file that `profile --save` wrote.
pub fn read(path: &Path) -> Result<Saved> {
    let expected = "what `milkglass profile --save` writes";
    let fault = |what: String| Error::from(Input::new(what).file(path).expected(expected));
    let known = std::fs::metadata(path).map_err(|error| fault(format!("could not be read: {error}")))?;
    if !known.is_file() || known.len() > MOST {
        return Err(fault(format!("not a plain file of at most {MOST} bytes")));
    }
    let text = std::fs::read_to_string(path).map_err(|error| fault(format!("could not be read: {error}")))?;
    parse(&text).map_err(|input| input.file(path).expected(expected).into())
}

/// The content of a file.
fn parse(text: &str) -> std::result::Result<Saved, Input> {
    let value: serde_json::Value =
        serde_json::from_str(text).map_err(|error| Input::new(format!("not JSON: {error}")).line(error.line()))?;
    match value.get("schema").and_then(serde_json::Value::as_u64) {
        Some(schema) if schema == u64::from(SCHEMA) => {}
        found => {
            let found = found.map_or("none".into(), |schema| schema.to_string());
            let fault = Input::new(format!("this version of the format is not known, but version {SCHEMA} is"));
            return Err(fault.key("schema").found(found));
        }
    }
    let saved: Saved = serde_json::from_value(value).map_err(|error| Input::new(format!("not a profile: {error}")))?;
    match saved.samples.fault() {
        Some(fault) => Err(Input::new(fault).key("samples")),
        None => Ok(saved),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::rounds::Series;

    fn saved() -> Saved {
        let series = Series { frame_ms: vec![1.0, 2.0], ..Series::default() };
        let samples = Samples { each: 2, variants: vec![series], ..Samples::default() };
        Saved { schema: SCHEMA, version: "1".into(), samples, ..Saved::default() }
    }

    #[test]
    fn files_of_others_are_refused() {
        let text = |saved: &Saved| serde_json::to_string(saved).unwrap();
        assert_eq!(parse(&text(&saved())).unwrap(), saved());
        for (from, to, words) in [
            ("\"schema\":1", "\"schema\":2", "version of the format"),
            ("\"schema\":1", "\"schma\":1", "version of the format"),
            ("\"subject\"", "\"results\"", "missing field `subject`"),
            ("[1.0,2.0]", "[1.0,-2.0]", "frame has a sample of -2 ms"),
            ("\"warm_up\":0", "\"warm_up\":2", "warm_up is 2, of 2 rounds"),
            ("}", "", "not JSON"),
        ] {
            let fault = parse(&text(&saved()).replacen(from, to, 1)).unwrap_err().to_string();
            assert!(fault.contains(words), "{words}: {fault}");
        }
    }

    #[test]
    fn a_commit_may_be_any_text() {
        let commit = Some("aaaaaaaaaaa\u{e9}b".into());
        assert!(Saved { commit, ..saved() }.origin().contains("commit aaaaaaaaaaa\u{e9}, "));
    }

    #[test]
    fn other_scenes_are_told() {
        let (one, mut other) = (saved(), saved());
        assert!(one.same_subject(&other, Path::new("a")).is_ok());
        other.subject.sets.push("camera.samples=4".into());
        let fault = one.same_subject(&other, Path::new("b.json")).unwrap_err().to_string();
        assert!(fault.contains("b.json: --set") && fault.contains("found camera.samples=4; expected none"), "{fault}");
    }
}
