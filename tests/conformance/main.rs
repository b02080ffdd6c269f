//! Every device against the reference, and the behaviour of devices, drivers and limits.

#[path = "../devices/mod.rs"]
mod devices;
#[path = "../shell/mod.rs"]
mod shell;

mod driver;
mod exact;
mod faults;
mod features;
mod guards;
mod idle;
mod instrument;
mod limits;
mod pictures;
mod repro;
mod stages;
mod systematic;
mod variants;
