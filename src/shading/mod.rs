//! Shading without transport: Kubo et al. 2010, "Curvature-Dependent Reflectance Function for Interactive Rendering
//! of Subsurface Scattering", where reflected light depends on the light, the normal and the curvature at a point
//! alone; and its rivals, Lambert's cosine and blur in texture space.

pub mod bake_irradiance;
pub mod balls;
pub mod blur;
pub mod cdrf;
pub mod cdrf_cells;
pub mod cdrf_table;
pub mod cdrf_values;
pub mod curvature;
pub mod curvature_sums;
pub mod diffuse;
pub mod fit;
pub mod gaussians;
pub mod lambert;
pub mod pack_normals;
pub mod reflectance;
pub mod smooth_curvature;
pub mod texture_blur;

use crate::state::stage::{Cpu, Gpu};
use crate::state::{Carrier, Need, Serves, Stage, Update};

/// Defaults of a stage of shading by curvature, which runs again for another shape.
const fn stage(cpu: Cpu, gpu: Gpu) -> Stage {
    Stage {
        module: "shading",
        carriers: &[Carrier::Cdrf],
        needs: &[Need::Light, Need::Picture],
        serves: Serves::TRANSLUCENT,
        runs: Update::shape,
        ..Stage::new(cpu, gpu)
    }
}
