//! From positions to faces and clusters, and rays through the same tree.

pub mod deform;
pub mod exact;
pub mod occlusion;
pub mod placement;
pub mod plane;
pub mod random;
pub mod refit;
pub mod skin;
pub mod trace;
pub mod widen;
