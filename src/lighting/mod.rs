//! Light arriving at the surface, and how much of it passes the boundary.

pub mod boundary;
pub mod environment;
pub mod fresnel;
pub mod harmonics;
pub mod irradiance;
pub mod leaving;
pub mod opaque_faces;
pub mod pixel_light;
pub mod shadow;
pub mod sky;
pub mod texture;
pub mod texture_in;

use crate::state::stage::{Cpu, Gpu};
use crate::state::{Carrier, Granularity, Need, Serves, Stage, Update};

/// Defaults of a stage for light that enters faces, which runs again for other light.
const fn stage(cpu: Cpu, gpu: Gpu) -> Stage {
    Stage {
        module: "lighting",
        granularity: Granularity::Object,
        carriers: Carrier::ALL,
        needs: &[Need::Light],
        serves: Serves::LIT_BY_FACE,
        runs: Update::light,
        ..Stage::new(cpu, gpu)
    }
}
