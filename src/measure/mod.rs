//! Measurements: conformance, profiles, times of variants and their statistics, error norms, quality of the error
//! estimate, reference solutions, error against run time, extreme cases, the papers' tables, layers, shading by
//! curvature, modes, numerical error beside the model's error; and a report of them all.

pub mod accuracy;
pub mod balls;
pub mod bias;
pub mod bodies;
pub mod compare;
pub mod conform;
pub mod constants;
pub mod coverage;
pub mod estimate;
pub mod eval;
pub mod fixtures;
pub mod flat;
pub mod folder;
pub mod interval;
pub mod layers;
pub mod leaning;
pub mod links;
pub mod local;
pub mod modes;
pub mod norms;
pub mod overheads;
pub mod pareto;
pub mod pattern;
pub mod plot;
pub mod probe;
pub mod profile;
pub mod progress;
pub mod reference;
pub mod replace;
pub mod report;
pub mod repro;
pub mod results;
pub mod rounds;
pub mod rules;
pub mod sample;
pub mod statistics;
pub mod stress;
pub mod table;
pub mod tables;
pub mod truth;
pub mod validity;
pub mod vary;
pub mod verdict;
