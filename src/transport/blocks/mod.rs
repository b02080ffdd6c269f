//! Mertens et al. 2003, extended to meet a given error: from the light that enters to the light that leaves, by a
//! hierarchy of clusters with moments, and blocks of receivers.
//!
//! The modules are the stages, in the order of a frame: `pull`, `coarse_solve`, `irradiance_ratio`,
//! `acceptance_radii`, `link`, `gather`, `push`. `estimate` contains the laws by which `gather` and `push` estimate
//! errors.

pub mod acceptance_radii;
pub mod coarse_solve;
pub mod estimate;
pub mod gather;
pub mod irradiance_ratio;
pub mod link;
pub mod pull;
pub mod push;

pub use crate::layout::BLOCK_RECEIVERS;
use crate::state::stage::{Cpu, Gpu};
use crate::state::{Carrier, Granularity, Stage, Update};

/// Defaults of a stage of transport to blocks, which runs once per group of channels.
const fn stage(cpu: Cpu, gpu: Gpu) -> Stage {
    Stage {
        module: "transport/blocks",
        granularity: Granularity::Group,
        carriers: &[Carrier::Blocks],
        runs: Update::transport,
        ..super::stage(cpu, gpu)
    }
}
