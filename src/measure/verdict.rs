//! The text for a failed comparison, ready to be pasted into a bug report to the driver's vendor.

use super::conform::Row;
use crate::gpu::Device;
use crate::pipeline::frame::{owner, stage};

/// Describes the device, the driver, the stage, the fixture and the differences; `repeat` is the command that
/// reproduces it.
pub fn verdict(device: &Device, row: &Row, repeat: &str) -> String {
    let replaced: Vec<_> =
        device.replaced().filter(|name| owner(name).is_some_and(|stage| stage.name == row.stage)).collect();
    let own = if replaced.is_empty() { String::new() } else { format!(", with a replaced {}", replaced.join(", ")) };
    let limits = device.limits();
    let about = stage(row.stage).map_or("", |stage| stage.about);
    let mut lines = vec![
        format!("milkglass {}: a stage on the device differs from its reference on the CPU", env!("CARGO_PKG_VERSION")),
        format!("device:  {}, subgroups of {}", device.name(), limits.subgroup_size),
        format!("driver:  {}", device.driver()),
        format!("stage:   {} ({about}){own}", row.stage),
        format!("on:      {}", row.fixture),
    ];
    // The first few faults are enough.
    let shown = row.faults.iter().take(3);
    lines.extend(
        shown.enumerate().map(|(k, fault)| format!("{}{fault}", if k == 0 { "differs: " } else { "         " })),
    );
    if row.faults.len() > 3 {
        lines.push(format!("         and {} more", row.faults.len() - 3));
    }
    lines.push(format!("repeat:  {repeat}"));
    lines.join("\n") + "\n"
}
