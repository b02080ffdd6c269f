//! The measuring: conformance, error norms, references, extreme cases.

pub mod compare;
pub mod conform;
pub mod fixtures;
pub mod norms;
pub mod reference;
pub mod stress;
