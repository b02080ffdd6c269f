//! Single scattering beneath a surface: in layers, by subsurface texture mapping (Francois et al. 2006), and in the
//! medium of an object.
//!
//! Errors of the paper's formulas are corrected: signs, clamps, normalised normals and dual texture axes.

pub mod beneath;
pub mod islands;
pub mod plane_fit;
pub mod relief;
pub mod single_scattering;
pub mod slab;

use crate::state::stage::{Cpu, Gpu};
use crate::state::{Carrier, Need, Serves, Stage, Update};

/// Defaults of a stage for layers, which adds to the picture.
const fn stage(cpu: Cpu, gpu: Gpu) -> Stage {
    Stage {
        module: "layers",
        carriers: Carrier::ALL,
        needs: &[Need::Light, Need::Picture],
        serves: Serves { object: |object, _| object.layered, none: "no material has layers" },
        runs: Update::picture,
        ..Stage::new(cpu, gpu)
    }
}
