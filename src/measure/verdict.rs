//! The text for a failed comparison, ready to be pasted into a bug report to the driver's vendor.

use super::probe::FIXTURE;
use super::results::{Outcome, Verdict};
use crate::pipeline::frame::{owner, stage};

/// Describes the device, the driver, the stage, the fixture and the differences; `replaced` are kernels that do not
/// come from the build.
#[must_use]
pub fn verdict(outcome: &Outcome, subgroup: u64, replaced: &[String]) -> String {
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
        format!("milkglass {}: {what}", env!("CARGO_PKG_VERSION")),
        format!("device:  {}, subgroups of {subgroup}", outcome.device),
        format!("driver:  {}", outcome.driver),
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
