//! Mertens et al. 2003: from the light that enters to the light that leaves, by a hierarchy of clusters.
//!
//! [`blocks`]: made to meet an error; [`links`]: as published; [`brute`]: every face to every face; [`octree`]: an
//! irradiance octree in native code. `average` brings radiosity to vertices; `evaluate` answers single questions.

pub mod average;
pub mod blocks;
pub mod brute;
pub mod evaluate;
pub mod links;
pub mod octree;
