//! The text for a failed comparison, ready to be pasted into a bug report to the driver's vendor.

use super::probe::FIXTURE;
use super::results::{DeviceFacts, Outcome, Verdict, system};
use crate::pipeline::frame::{owner, stage};

/// The commit that a program was built from, as words after its version; empty if it is not known.
#[must_use]
pub fn commit(commit: Option<&str>) -> String {
    commit.map_or_else(String::new, |commit| format!(" of commit {commit}"))
}

/// The version of the validation layer that watched, or that there was none.
#[must_use]
pub fn watched(layer: Option<&str>) -> String {
    layer.map_or_else(|| "no validation layer".into(), |version| format!("validation layer {version}"))
}

/// Describes the device, the driver, the system with the version of its validation `layer`, the stage, the fixture and
/// the differences; `replaced` are kernels that do not come from the build.
#[must_use]
pub fn verdict(outcome: &Outcome, facts: &DeviceFacts, layer: Option<&str>, replaced: &[String]) -> String {
    let replaced: Vec<&str> = replaced
        .iter()
        .map(String::as_str)
        .filter(|name| owner(name).is_some_and(|stage| stage.name == outcome.stage))
        .collect();
    let own = if replaced.is_empty() { String::new() } else { format!(", with a replaced {}", replaced.join(", ")) };
    let probe = outcome.fixture == FIXTURE;
    let none = if probe { "a probe of what kernels rely on" } else { "before its first stage" };
    let about = stage(&outcome.stage).map_or(none, |stage| stage.about);
    let what = match outcome.verdict {
        Verdict::Differs if probe => "the device lacks what kernels rely on",
        Verdict::Conforms | Verdict::Differs => "a stage on the device differs from its reference on the CPU",
        Verdict::Hung => "a stage on the device does not end",
        Verdict::Crashed => "a stage on the device ended the process",
        Verdict::DeviceFailed => "the device failed in a stage",
    };
    let mut lines = vec![
        format!("milkglass {}{}: {what}", env!("CARGO_PKG_VERSION"), commit(option_env!("MILKGLASS_COMMIT"))),
        format!("device:  {}", facts.device()),
        format!("driver:  {}", facts.own_driver()),
        format!("system:  {}; {}", system(), watched(layer)),
        format!("stage:   {} ({about}){own}", outcome.stage),
        format!("on:      {}", outcome.fixture),
    ];
    let head = if outcome.verdict == Verdict::Differs { "differs: " } else { "ended:   " };
    // The first few faults are enough.
    let shown = outcome.faults.iter().take(3);
    lines.extend(shown.enumerate().map(|(k, fault)| format!("{}{fault}", if k == 0 { head } else { "         " })));
    if outcome.faults.len() > 3 {
        lines.push(format!("         and {} more", outcome.faults.len() - 3));
    }
    lines.push(format!("repeat:  {}", outcome.repeat));
    lines.join("\n") + "\n"
}
