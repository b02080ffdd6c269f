//! Vulkan devices: conformance, faults, limits, and equal bits in two runs.

mod devices;
mod shell;

mod conformance;
