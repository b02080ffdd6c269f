//! Stage `texture_blur`: radiance of each pixel from the blurred irradiance at its texture coordinates.
//!
//! L = F_t(w_o) / pi times the sum over the Gaussians of weight times blurred irradiance. The irradiance is
//! interpolated bilinearly among those of the four nearest texels that show a surface.

use glam::{DVec2, DVec3};
use rayon::prelude::*;

use crate::error::Result;
use crate::layout::{BufferId, GAUSSIANS, Hit, Unwrapping};
use crate::lighting::fresnel;
use crate::lighting::leaving::seen_cosine;
use crate::lighting::texture::{place, texel};
use crate::state::{Carrier, Pass, Role, Scope, Stage, State, Tolerance, Update, narrow, wide};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "texture_blur",
    about: "radiance of each pixel from light blurred over the texture (`--transport texture-blur`)",
    equation: "d'Eon et al. 2007, section 5",
    writes: &[(BufferId::radiance, Role::Update, Tolerance::Float { relative: 5e-5, floor: 5e-5 })],
    reason: "a place in the texture is off by about 1e-7, times its texels per unit and their contrast",
    carriers: &[Carrier::TextureBlur],
    runs: Update::picture,
    ..super::stage(cpu, gpu)
};

/// The weighted sum over the Gaussians at texture coordinates whose origin is the texture's upper left corner.
fn blurred(state: &State, number: usize, at: DVec2) -> DVec3 {
    let (data, own): (_, &Unwrapping) = (&state.data, &state.data.unwrappings[number]);
    let at = at * f64::from(own.side) - 0.5;
    let (left, top) = (at.x.floor(), at.y.floor());
    let wrap = own.round.map(|round| if round != 0 { 0 } else { 1 });
    let mut sums = [(DVec3::ZERO, 0.0); GAUSSIANS];
    for (x, y) in [(left, top), (left + 1.0, top), (left, top + 1.0), (left + 1.0, top + 1.0)] {
        let share = (1.0 - (at.x - x).abs()) * (1.0 - (at.y - y).abs());
        let texel = texel(y as i64, own.side, wrap[1]) * own.side + texel(x as i64, own.side, wrap[0]);
        for (k, (light, whole)) in sums.iter_mut().enumerate() {
            let [r, g, b, there] = data.irradiance_maps[(k + 1) * data.texel_hits.len() + (own.first + texel) as usize];
            *light += share * wide([r, g, b]);
            *whole += share * f64::from(there);
        }
    }
    let weight = |k: usize| {
        let [r, g, b, _] = data.gaussians[number * GAUSSIANS + k];
        wide([r, g, b])
    };
    let mean = |(k, (light, whole)): (usize, (DVec3, f64))| weight(k) * light / whole.max(1e-30);
    sums.into_iter().enumerate().map(mean).sum()
}

fn pixel(state: &State, hit: &Hit, before: [f32; 3]) -> [f32; 3] {
    let (data, camera) = (&state.data, &state.data.camera[0]);
    let Some(corners) = data.triangles.get(hit.face as usize) else { return camera.background };
    let params = &data.object_params[state.object_of(hit.face as usize)];
    if params.irradiance_map == 0 {
        return before;
    }
    // Remove whole repetitions; where the texture does not wrap around, a triangle lies within one repetition.
    let [u, v] = [hit.u, hit.v].map(f64::from);
    let middle = place(data, hit.face as usize, 1.0 / 3.0, 1.0 / 3.0).floor();
    let sum = blurred(state, params.irradiance_map as usize - 1, place(data, hit.face as usize, u, v) - middle);
    let weight = [1.0 - u - v, u, v];
    let mix = |values: &[[f32; 3]]| -> DVec3 {
        corners.iter().zip(weight).map(|(&v, weight)| weight * wide(values[v as usize])).sum()
    };
    let places = corners.map(|v| data.in_scene()[v as usize]);
    let cosine = seen_cosine(mix(data.normals_in_scene()), wide(camera.origin) - mix(data.in_scene()), places);
    let cosine = fresnel::facet_cosine(cosine, params.facet_tilt.into());
    let leaves = params.eta.map(|eta| fresnel::transmittance(eta.into(), cosine));
    let scale = f64::from(camera.radiance) / std::f64::consts::PI;
    narrow(DVec3::from_array(leaves) * wide(params.exit) * sum * scale)
}

fn cpu(state: &mut State, _at: Scope) {
    let pixels = state.data.hits.par_iter().zip(&state.data.radiance);
    state.data.radiance = pixels.map(|(hit, &before)| pixel(state, hit, before)).collect();
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    pass.dispatch(None, &[pass.state.objects.len() as u32], &[], pass.state.data.radiance.len())
}
