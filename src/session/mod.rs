//! A session: frames run on the CPU or a device, with capacities, changes and kept links.

pub(crate) mod accessors;
pub mod antialiasing;
pub mod aov;
pub mod bake;
pub(crate) mod buffer_limits;
mod buffer_sizes;
pub mod capacity;
pub(crate) mod changes;
pub mod cluster_view;
pub mod curvature_view;
pub(crate) mod device_limits;
pub mod faces;
pub(crate) mod front;
pub(crate) mod incremental;
pub(crate) mod isolated_timing;
pub(crate) mod memory_estimate;
pub mod octree;
mod open;
pub mod patches;
pub(crate) mod recovery;
pub(crate) mod refined_estimate;
pub mod requirements;
pub mod run;
pub mod shadow_borders;
pub mod subdivide;
pub mod walk;
pub mod workload;
