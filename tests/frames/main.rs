//! Motion: deformations and sequences, and what is kept from frame to frame.

#[path = "../devices/mod.rs"]
mod devices;
#[path = "../shell/mod.rs"]
mod shell;

mod animation;
mod budget;
mod edits;
mod incremental;
mod modes;
mod morph;
mod motion;
mod rigid;
