//! The measuring: conformance, profiles, error norms, the worth of an error estimate, references, error against time,
//! extreme cases, the papers' tables, layers, local shading, modes, numerical error beside the model's; and the report
//! of it all.

pub mod accuracy;
pub mod balls;
pub mod compare;
pub mod conform;
pub mod estimate;
pub mod eval;
pub mod fixtures;
pub mod flat;
pub mod layers;
pub mod local;
pub mod modes;
pub mod norms;
pub mod pareto;
pub mod profile;
pub mod progress;
pub mod reference;
pub mod replace;
pub mod report;
pub mod sample;
pub mod stress;
pub mod tables;
pub mod validity;
pub mod verdict;
pub mod walk;

/// The value in the middle, the upper one of two; no number where there is none.
fn median(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(f64::NAN)
}
