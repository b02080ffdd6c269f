//! Stage `relief`: single scattering in the layers beneath each visible point, by a march along the view ray in
//! texture space (algorithms 1 and 2).
//!
//! From P the ray goes down to M_max (equation 15, with a unit NS_P; at a silhouette it descends at 3 degrees below
//! the plane), in N steps. Map coordinates change by the gradients of the texture coordinates, the depth by NS_P.
//! Light reaches M through a plane between the tangent plane at P and the fitted one (equation 9, correct at M = P).
//! Its optical depth is that of the mean interface depths at M and at its entry (equations 11 and 12, clamped; below
//! its lower interface the last layer continues, but does not scatter). Depth above the plane counts as 0; light
//! fades out at grazing incidence and is 0 from behind.
//!
//! Steps are split where the ray crosses an interface, assuming that interface depths vary linearly within a step.
//! Between two such points falloff times phase and the optical depths of both legs are taken as linear, for which
//! [`segment`](super::beneath::segment) is exact. The result is exact for uniform layers on a plane under a directional
//! light, with one step. Beyond a seam of the texture coordinates the march reads the margins that
//! [`islands`](super::islands) has filled. `integration = "paper"` uses the left rule with its N + 1 samples instead.

mod boundary;
mod full;
mod ray;

use rayon::prelude::*;

use crate::error::Result;
use crate::geometry::trace::UNFINISHED;
pub use crate::layout::GRAZING;
use crate::layout::{BufferId, Hit, MAP_LAYERS, MAPPED_BY_ISLANDS, MAPPED_BY_UVS, MAPPED_NOT, NONE};
use crate::state::{Pass, Role, Scope, Stage, State, Tolerance, narrow, wide};
pub use full::Kept;
use ray::Ray;

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "relief",
    about: "light scattered once in the layers beneath each visible point",
    equation: "Francois et al. 2006, equations 1 to 5, 9 to 13, 15, corrected",
    writes: &[(BufferId::radiance, Role::Update, Tolerance::Float { relative: 1e-4, floor: 2e-5 })],
    reason: "an exponential's depth is off by some roundings of its own size, and a depth from the maps by 1e-7 times \
             their texels and contrast",
    ..super::stage(cpu, gpu)
};

fn cpu(state: &mut State, _at: Scope) {
    let data = &state.data;
    let scale = f64::from(data.camera[0].radiance);
    let of_pixel = |(hit, &before): (&Hit, &[f32; 3])| {
        if hit.face >= UNFINISHED {
            return before;
        }
        let object = state.object_of(hit.face as usize) as u32;
        match data.layerings.iter().find(|layering| layering.object == object) {
            Some(layering) => narrow(wide(before) + scale * Ray::new(state, layering, hit).radiance()),
            None => before,
        }
    };
    state.data.radiance = data.hits.par_iter().zip(&data.radiance).map(of_pixel).collect();
}

/// Radiance of the layered volume itself at a pixel that shows an object with layers, linear, in the scene's units:
/// with `steps` steps along the view ray and `legs` along each part of a light's way in the object. `kept` selects
/// approximations of the march to keep.
#[must_use]
pub fn full(state: &State, pixel: usize, kept: Kept, steps: u32, legs: u32) -> Option<[f64; 3]> {
    let hit = state.data.hits.get(pixel).filter(|hit| hit.face < UNFINISHED)?;
    let object = state.object_of(hit.face as usize) as u32;
    let layering = state.data.layerings.iter().find(|layering| layering.object == object)?;
    let scale = f64::from(state.data.camera[0].radiance);
    Some((scale * Ray::new(state, layering, hit).full(kept, steps, legs)).to_array())
}

/// Most steps of a march in one invocation: half the loop length at which some drivers give up.
const STEPS: usize = 1 << 15;
/// Most steps in one dispatch: about a second on the slowest device.
const DISPATCH: usize = 1 << 27;

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    let data = &pass.state.data;
    let pixels = data.radiance.len();
    for (number, layering) in (0u32..).zip(&data.layerings) {
        let params = &data.object_params[layering.object as usize];
        let mapped = match layering.size {
            _ if layering.first_island != NONE => MAPPED_BY_ISLANDS,
            [1, 1] => MAPPED_NOT,
            _ => MAPPED_BY_UVS,
        };
        let shadows = u32::from(params.shadow_words > 0);
        let constants =
            [shadows, layering.layers.div_ceil(MAP_LAYERS as u32), mapped, layering.henyey, layering.fresnel];
        let kernel = if layering.paper != 0 { "paper" } else { "exact" };
        // Worst case: every step crosses every interface.
        let a_light = (layering.samples as usize + 1) * (layering.layers as usize + 1);
        let (count, most) = (data.layer_lights.len(), (STEPS / a_light).max(1));
        for first in (0..count).step_by(most) {
            let last = count.min(first + most);
            let each = (DISPATCH / (a_light * (last - first))).max(64);
            for pixel in (0..pixels).step_by(each) {
                // Workgroups reach beyond the last pixel, where the next dispatch begins.
                let end = pixels.min(pixel + each);
                let push = [number, first as u32, last as u32, pixel as u32, end as u32];
                pass.dispatch(Some(kernel), &constants, bytemuck::cast_slice(&push), end - pixel)?;
            }
        }
    }
    Ok(())
}
