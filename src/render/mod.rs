//! From a scene to the stages it needs ([`plan`]), and a plan run on the CPU or a device ([`run`]).

pub mod aov;
mod blocks;
pub mod lights;
pub mod octree;
pub mod plan;
pub mod prepare;
pub mod receivers;
pub mod room;
pub mod run;
pub mod samples;
pub mod stages;
mod textures;
pub mod units;
