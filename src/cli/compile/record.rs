//! What compilers report.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// A pipeline as a compiler made it.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub(super) struct Pipeline {
    pub(super) kernel: String,
    /// Specialization constants: `CHANNELS = 7, ORDER = 2`.
    pub(super) constants: String,
    pub(super) milliseconds: f64,
    /// What the driver reports, by its names, in its order.
    pub(super) statistics: Vec<(String, f64)>,
}

/// What a compiler made.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Compiled {
    /// The device's name, and the driver's.
    pub(super) device: String,
    pub(super) pipelines: Vec<Pipeline>,
    /// The built-in kernels that others replace, as the compiler made them.
    pub(super) built_in: Vec<Pipeline>,
}

/// What each compiler made, by family.
pub(super) type Sheets = BTreeMap<String, Compiled>;
