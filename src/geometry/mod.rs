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

use crate::state::stage::{Cpu, Gpu};
use crate::state::{Carrier, Granularity, Stage, Update};

/// Defaults of a stage for the shape of each object, which runs again for another shape.
const fn stage(cpu: Cpu, gpu: Gpu) -> Stage {
    Stage {
        module: "geometry",
        granularity: Granularity::Object,
        carriers: Carrier::ALL,
        runs: Update::shape,
        ..Stage::new(cpu, gpu)
    }
}
