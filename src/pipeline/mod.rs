//! The frame as data: options, the plan, the table of stages, and why stages are skipped.

pub mod buffer_sizes;
pub mod frame;
pub mod plan;
pub(crate) mod skip_reasons;

pub use skip_reasons::about_mode;
