//! Mertens et al. 2003: from the light that enters to the light that leaves, by a hierarchy of clusters.
//!
//! [`profile`] and [`form_factor`] are the mathematics, [`octree`] is the baseline to compare with; the other modules
//! are the stages, in the order of a frame.

pub mod average;
pub mod brute;
pub mod evaluate;
pub mod form_factor;
pub mod gather;
pub mod link;
pub mod octree;
pub mod profile;
pub mod pull;
pub mod push;
pub mod radii;
