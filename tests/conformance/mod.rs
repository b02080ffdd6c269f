//! Every device against the reference, and the behaviour of devices, drivers and limits.

mod coverage;
mod driver;
mod exact;
mod faults;
mod features;
mod few;
mod fingerprints;
mod guards;
mod idle;
mod instrument;
#[cfg(feature = "shaderc")]
mod interpreter;
mod labels;
mod lanes;
mod limits;
#[cfg(feature = "shaderc")]
mod modules;
mod mutants;
mod pictures;
mod repro;
#[cfg(feature = "shaderc")]
mod sanitize;
mod stages;
mod systematic;
mod variants;
