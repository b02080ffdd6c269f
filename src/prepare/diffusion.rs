//! Diffusion on the shape: coefficients at the boundary, the room for a basis, and settings for a tolerance.

use crate::layout::{MOST_STEPS, ObjectParams};
use crate::lighting::boundary::{extrapolation, mean_inner_cosine};
use crate::scene::Scene;

/// Bytes of the smallest binding among devices: a basis fits it.
const BINDING: usize = 1 << 27;

/// Steps of the solver from one start to the next: as many as are asked for, or as there is room for.
pub(crate) fn steps(scene: &Scene) -> u32 {
    let translucent = scene.objects.iter().filter(|object| object.material.opaque.is_none());
    let faces = translucent.map(|object| object.mesh.triangles.len()).max().unwrap_or(1).max(1);
    let most = (BINDING / 12 / faces).saturating_sub(1).clamp(2, MOST_STEPS) as u32;
    scene.transport.steps.unwrap_or(MOST_STEPS as u32).min(most)
}

/// The largest error of a cluster in a product for a tolerance, for a density of 1. Errors of clusters cancel:
/// measured, they add less than a tenth of the tolerance to the solution, from 1e-2 to 1e-4.
pub(crate) fn layer_error(tolerance: f64) -> f64 {
    8.0 * tolerance
}

/// The residual at which the solver ends, as a share of the source term. The operator multiplies even light by a
/// factor, the gain, and halves rough light, so the source term may be much larger than the solution. Measured on
/// balls, a torus, a slab, a stone and a shell, the solution errs by at most 3 times the root of the gain times the
/// residual.
pub(crate) fn residual(tolerance: f64, gain: f64) -> f64 {
    0.1 * tolerance * (2.4 / gain.max(1e-30).sqrt()).clamp(0.02, 1.0)
}

/// Sets the coefficients of diffusion at the boundary, from the dipole's lengths: z_b = 2 A D, and the mean depth of
/// the first collision of light from all around.
pub(super) fn boundary(params: &mut ObjectParams) {
    for c in 0..3 {
        let (eta, path) = (f64::from(params.eta[c]), f64::from(params.z_real[c]));
        params.boundary[c] = (2.0 / 3.0 * extrapolation(eta) * path) as f32;
        params.sky_depth[c] = (mean_inner_cosine(eta) * path) as f32;
    }
}
