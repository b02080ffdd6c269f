//! Mertens et al. 2003, made to meet an error: from the light that enters to the light that leaves, by a hierarchy of
//! clusters with moments, and blocks of receivers.
//!
//! The modules are the stages, in the order of a frame: `pull`, `level`, `contrast`, `radii`, `link`, `gather`, `push`, `average`;
//! `evaluate` answers single questions. `estimate` has the laws by which `gather` and `push` estimate errors.

pub mod average;
pub mod contrast;
pub mod estimate;
pub mod evaluate;
pub mod gather;
pub mod level;
pub mod link;
pub mod pull;
pub mod push;
pub mod radii;

pub use crate::layout::BLOCK_RECEIVERS as PLACES;
