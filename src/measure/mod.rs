//! The measuring: conformance, profiles, error norms, the worth of an error estimate, references, error against time, extreme cases,
//! the paper's tables, layers.

pub mod balls;
pub mod compare;
pub mod conform;
pub mod estimate;
pub mod fixtures;
pub mod layers;
pub mod norms;
pub mod pareto;
pub mod profile;
pub mod reference;
pub mod replace;
pub mod sample;
pub mod stress;
pub mod tables;
pub mod validity;
pub mod verdict;
