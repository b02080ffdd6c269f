//! An interpreter of kernels: it runs their SPIR-V on the host, by the specification's rules, and can watch what they
//! do with memory and barriers.
//!
//! A group's invocations run together, an instruction at a time, as far as they are at the same block; those that took
//! different branches are together again where the branches meet. Numbers have 32 bits. Floats round to nearest, as
//! `arithmetic` says in full.

mod arithmetic;
mod builder;
mod code;
mod flow;
mod function;
mod instruction;
mod kernel;
mod memory;
mod pointers;
mod run;
pub mod stage;
mod teams;
mod types;
mod watch;

pub use code::Site;
pub use kernel::{Kernel, MOST_BLOCKS};
pub use memory::{Launched, Memory, POISON, Part};
use watch::Suspects;
pub use watch::{Finding, Kind};
