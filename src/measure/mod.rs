//! The measuring: conformance, error norms, references.

pub mod compare;
pub mod conform;
pub mod fixtures;
pub mod norms;
pub mod reference;
