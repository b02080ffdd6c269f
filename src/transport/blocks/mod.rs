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
