//! From a scene to the stages it needs ([`plan`]), and from a plan to frames on the CPU or a device ([`run`]).

mod access;
pub mod aov;
mod apart;
pub mod bake;
pub mod bends;
mod bindings;
mod blocks;
mod blur;
mod changes;
pub mod clusters;
mod fallback;
pub mod frame;
mod holds;
mod incremental;
mod layers;
pub mod lights;
pub mod local;
mod memory;
pub mod needs;
pub mod octree;
pub mod plan;
pub mod prepare;
mod reasons;
pub mod receivers;
pub mod room;
pub mod run;
pub mod samples;
pub mod shape;
mod sharper;
pub mod sizes;
pub mod subdivide;
mod textures;
pub mod units;

pub use reasons::about_mode;
