//! Mertens et al. 2003: transport from the light that enters to the light that leaves, by a hierarchy of clusters.
//!
//! [`blocks`]: extended to meet a given error; [`links`]: as published; [`brute`]: every face to every face;
//! [`octree`]: an irradiance octree in native code; [`walk`]: a random walk of photons, without approximations.
//! [`diffusion`]: the diffusion equation on the object's own surface, by boundary elements.
//! `average` computes radiosity at vertices; `evaluate` answers single queries.

pub mod average;
pub mod blocks;
pub mod brute;
pub mod diffusion;
pub mod evaluate;
pub mod links;
pub mod octree;
pub mod walk;

use crate::state::stage::{Cpu, Gpu};
use crate::state::{Carrier, Granularity, Need, Serves, Stage, Update};

/// Defaults of a stage that carries light through each object, and runs again wherever radiosity changes.
const fn stage(cpu: Cpu, gpu: Gpu) -> Stage {
    Stage {
        module: "transport",
        granularity: Granularity::Object,
        carriers: Carrier::ALL,
        needs: &[Need::Light],
        serves: Serves::TRANSLUCENT,
        runs: Update::sums,
        ..Stage::new(cpu, gpu)
    }
}
