//! Motion: deformations and sequences, and what is kept from frame to frame.

mod animation;
mod budget;
mod edits;
mod incremental;
mod modes;
mod morph;
mod motion;
mod rigid;
