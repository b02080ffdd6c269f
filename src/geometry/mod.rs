//! From positions to clusters, and rays through the same tree.

pub mod refit;
pub mod trace;
