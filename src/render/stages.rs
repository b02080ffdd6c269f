//! The table of stages. Conformance, profile, plan and the README go by it; adding a stage adds a line here.

use crate::geometry::refit;
use crate::light::irradiance;
use crate::state::{Schedule, Stage, Step};
use crate::transport::{average, brute, evaluate, form_factor, gather, link, pull, push, radii};
use crate::view::{shade, visibility};

/// Every stage, in the order of a frame; the last two are no part of one: `brute` takes the place of
/// `pull` to `push`, `evaluate` answers `milkglass eval`.
pub static STAGES: &[&Stage] = &[
    &refit::STAGE,
    &irradiance::STAGE,
    &radii::STAGE,
    &pull::STAGE,
    &link::STAGE,
    &form_factor::STAGE,
    &gather::STAGE,
    &push::STAGE,
    &average::STAGE,
    &visibility::STAGE,
    &shade::STAGE,
    &brute::STAGE,
    &evaluate::STAGE,
];

/// A stage by its name.
pub fn stage(name: &str) -> Option<&'static Stage> {
    STAGES.iter().copied().find(|stage| stage.name == name)
}

/// The steps of these stages, in the table's order. Stages that work by chunks take turns, chunk after chunk,
/// because chunks may share their room.
pub fn steps(stages: &[&'static Stage], schedule: &Schedule) -> Vec<Step> {
    let mut steps = Vec::new();
    let mut rest = stages;
    while let Some(first) = rest.first() {
        let length = rest.iter().take_while(|stage| stage.chunked == first.chunked).count();
        let (run, after) = rest.split_at(length);
        if first.chunked {
            for chunk in 0..schedule.chunks.len() {
                steps.extend(run.iter().map(|&stage| Step { stage, chunk }));
            }
        } else {
            steps.extend(run.iter().map(|&stage| Step { stage, chunk: 0 }));
        }
        rest = after;
    }
    steps
}
