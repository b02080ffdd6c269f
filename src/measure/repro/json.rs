//! `replay.json`: what a case's files are.

use serde::{Deserialize, Serialize};

/// The version of the file's format.
pub(super) const SCHEMA: u32 = 1;

/// A case.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct CaseFile {
    /// The version of this format; identifies the file.
    pub(super) milkglass_case: u32,
    /// The program that wrote it.
    pub(super) program: String,
    pub(super) stage: String,
    pub(super) does: String,
    pub(super) step: String,
    pub(super) fixture: String,
    pub(super) device: String,
    pub(super) driver: String,
    /// Why the tolerances are what they are.
    pub(super) tolerance: String,
    /// Which dispatches of the step these are.
    pub(super) chosen: String,
    /// Whether the device was beyond tolerance, or did not end.
    pub(super) fails: bool,
    /// If the device did not end: the limit that it exceeded, seconds.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) seconds: Option<f64>,
    pub(super) buffers: Vec<PartFile>,
    pub(super) dispatches: Vec<DispatchFile>,
}

/// A buffer.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PartFile {
    pub(super) name: String,
    pub(super) bytes: u64,
    /// The words of an element: `float` or `uint`, and the path of the word.
    pub(super) element: Vec<String>,
    /// The number of the first element.
    pub(super) first: usize,
    /// The file of its contents before the first dispatch.
    pub(super) before: String,
    /// The file of what it should hold after the last one; without it, it should stay as it is.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) expected: Option<String>,
    /// The file of the largest differences: singles, -1 for words that must agree bit for bit, -2 for words that are
    /// not compared. Without it, all bits must agree.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) allowed: Option<String>,
    /// The file of what the device left, if it ended.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub(super) device: Option<String>,
}

/// The default of `lanes`: no invocations share an item.
fn one_lane() -> u32 {
    1
}

/// Whether no invocations share an item: then the file leaves `lanes` out.
fn alone(lanes: &u32) -> bool {
    *lanes <= 1
}

/// A dispatch.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DispatchFile {
    pub(super) kernel: String,
    /// The file of its SPIR-V.
    pub(super) spirv: String,
    /// Specialization constants 0, 1, ...
    pub(super) constants: Vec<u32>,
    /// Words of push constants.
    pub(super) push_constants: Vec<u32>,
    /// Invocations that share an item.
    #[serde(default = "one_lane", skip_serializing_if = "alone")]
    pub(super) lanes: u32,
    pub(super) groups: [u32; 3],
    /// The number of the first group, across: the SPIR-V was changed to count from it.
    #[serde(default)]
    pub(super) first_group: u32,
    pub(super) bindings: Vec<BindingFile>,
}

/// A binding of set 0.
#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct BindingFile {
    pub(super) binding: u32,
    pub(super) buffer: String,
    /// Bytes bound, from the buffer's first one.
    pub(super) bytes: u64,
    pub(super) writes: bool,
}
