//! `--expect`: failures that are known.

use std::path::Path;

use serde::Deserialize;

use milkglass::error::{Input, Result};
use milkglass::measure::results::{DeviceFacts, Outcome, Results};

/// Most bytes of a file of known failures.
const MOST: u64 = 16 << 20;

/// The file.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct List {
    #[serde(default)]
    known: Vec<Entry>,
}

/// A failure that is known.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    /// The fixture; all if there is none.
    fixture: Option<String>,
    /// The stage; all if there is none.
    stage: Option<String>,
    /// A part of the device's name; any if there is none.
    device: Option<String>,
    /// Whether it fails at times only.
    #[serde(default)]
    flaky: bool,
    /// Why it is known: the number of a bug, say.
    why: String,
}

/// An entry, and whether it has been met.
#[derive(Clone, Debug)]
pub(super) struct Known {
    entry: Entry,
    met: bool,
}

/// The entries of a file; none without one.
pub(super) fn load(path: Option<&Path>) -> Result<Vec<Known>> {
    let Some(path) = path else { return Ok(Vec::new()) };
    let fault = |what: String| Input::new(what).file(path);
    let size = std::fs::metadata(path).map_err(|error| fault(format!("could not be read: {error}")))?.len();
    if size > MOST {
        return Err(fault(format!("it has {size} bytes, at most {MOST} are read")).into());
    }
    let text = std::fs::read_to_string(path).map_err(|error| fault(format!("could not be read: {error}")))?;
    let list: List = toml::from_str(&text).map_err(|error| {
        let line = error.span().map_or(1, |span| 1 + text[..span.start.min(text.len())].matches('\n').count());
        let expected = "entries [[known]] with why, and fixture, stage, device, flaky";
        fault(error.message().to_string()).line(line).expected(expected)
    })?;
    Ok(list.known.into_iter().map(|entry| Known { entry, met: false }).collect())
}

impl Known {
    /// Whether it names this comparison; one that ended before its first stage has every stage.
    fn names(&self, outcome: &Outcome) -> bool {
        let is = |wish: &Option<String>, value: &str| wish.as_deref().is_none_or(|wish| wish == value);
        let device = self.entry.device.as_deref().unwrap_or_default().to_lowercase();
        is(&self.entry.fixture, &outcome.fixture)
            && (is(&self.entry.stage, &outcome.stage) || outcome.stage.is_empty())
            && outcome.device.to_lowercase().contains(&device)
    }

    /// Whether it explains this failure.
    pub(super) fn fits(&self, outcome: &Outcome) -> bool {
        self.names(outcome)
    }

    /// Notes that it has been met; returns the reason.
    pub(super) fn met(&mut self) -> String {
        self.met = true;
        self.entry.why.clone()
    }

    /// What is wrong with it, if a comparison or a probe that it names was made and none of those failed.
    pub(super) fn stale(&self, all: &Results) -> Option<String> {
        let probed = || all.run.devices.iter().flat_map(DeviceFacts::probed);
        let made = all.results.iter().any(|outcome| self.names(outcome)) || probed().any(|probe| self.names(&probe));
        let Entry { fixture, stage, device, why, .. } = &self.entry;
        let part = |key: &str, value: &Option<String>| value.as_ref().map(|value| format!("{key} {value}"));
        let named: Vec<String> =
            [part("fixture", fixture), part("stage", stage), part("device", device)].into_iter().flatten().collect();
        let named = if named.is_empty() { "everything".into() } else { named.join(", ") };
        (made && !self.met && !self.entry.flaky).then(|| format!("{named} ({why}): it conforms now"))
    }
}
