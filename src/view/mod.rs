//! From radiosity to a picture, and files on disk.

pub mod accumulate;
pub mod aov;
pub mod atomic_file;
pub mod backdrop;
pub mod film;
pub mod mirror_ray;
pub mod picture;
pub mod pixel_receivers;
pub mod pixel_shadow;
pub mod reflect;
pub mod shade;
pub mod shade_opaque;
pub mod texture_out;
pub mod tone;
pub mod visibility;

use crate::state::stage::{Cpu, Gpu};
use crate::state::{Carrier, Need, Stage, Update};

/// Defaults of a stage that makes the picture, once for all pixels.
const fn stage(cpu: Cpu, gpu: Gpu) -> Stage {
    Stage {
        module: "view",
        carriers: Carrier::ALL,
        needs: &[Need::Picture],
        runs: Update::picture,
        ..Stage::new(cpu, gpu)
    }
}
