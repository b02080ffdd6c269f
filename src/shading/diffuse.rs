//! Diffuse reflection without transport, at each pixel that shows a translucent object: the reference of the stages
//! `cdrf` and `lambert`, which differ in one function of cosine and sigma.
//!
//! L = F_t(w_o) k_d / pi times the sum over the lights of f(cos, sigma) E, with E the irradiance on a plane that
//! faces the light (equation 5 of Kubo et al. 2010, with the 1 / pi that it lacks). k_d is the diffuse reflectance of
//! a flat surface, (1 - F_ext) times the dipole's total reflectance; with a refractive index of 1 it is the paper's.
//!
//! An object does not shadow itself: its shadow would cut off the glow that f has beyond 90 degrees. Other objects
//! do. The environment comes as nine spherical harmonics, each degree times a factor of f.

use glam::DVec3;
use rayon::prelude::*;

use super::pack_normals::unpack;
use super::reflectance;
use crate::error::Result;
use crate::layout::{Buffers, Hit, LIGHT_SKY_RAY, OPAQUE_NOT, ObjectParams};
use crate::lighting::irradiance::{arrival, reaches};
use crate::lighting::leaving::seen_cosine;
use crate::lighting::texture::{look, place};
use crate::lighting::{fresnel, harmonics};
use crate::state::{Pass, State, narrow, wide};

/// The function f of the cosine at the surface and sigma: the share of the arriving light that is reflected.
pub type Response<'a> = dyn Fn(f64, f64) -> f64 + Sync + 'a;

/// Light received at a point with a normal, `at`, on a triangle, before k_d and the transmittance towards the eye.
#[must_use]
pub fn received(state: &State, face: usize, at: [DVec3; 2], sigma: DVec3, response: &Response<'_>) -> DVec3 {
    let data = &state.data;
    let [point, normal] = at;
    let respond = |cosine: f64| DVec3::from_array([0, 1, 2].map(|c| response(cosine, sigma[c])));
    let sky: Vec<DVec3> = data.harmonics.iter().take(9).map(|&c| wide(c)).collect();
    let (mut sum, mut all, mut free) = (DVec3::ZERO, DVec3::ZERO, DVec3::ZERO);
    for light in &data.lights {
        let (toward, falloff) = arrival(light, point);
        let arrives = reaches(data, light, face);
        if light.kind == LIGHT_SKY_RAY {
            let weight = harmonics::radiance(&sky, toward) * respond(normal.dot(toward));
            all += weight;
            free += if arrives { weight } else { DVec3::ZERO };
        } else if arrives {
            sum += wide(light.color) * respond(normal.dot(toward)) * falloff;
        }
    }
    if sky.is_empty() {
        return sum;
    }
    // Factors per degree and channel.
    let zonal = [0, 1, 2].map(|c| reflectance::zonal(sigma[c]));
    let factors = [0, 1, 2].map(|degree| DVec3::from_array([0, 1, 2].map(|c| zonal[c][degree])));
    let share = |k: usize| if free[k] == all[k] { 1.0 } else { free[k] / all[k] };
    sum + harmonics::irradiance(&sky, factors, normal) * DVec3::new(share(0), share(1), share(2))
}

/// sigma_0 at a point of a triangle, given by the weights of its corners: the object's, times the square of the map's
/// d where it has one (equation 6, which leaves the factor out).
#[must_use]
pub fn sigma_0(data: &Buffers, params: &ObjectParams, face: usize, weight: [f64; 3]) -> DVec3 {
    let whole = wide(params.sigma_0);
    if params.sigma_0_size == [0; 2] {
        return whole;
    }
    let at = place(data, face, weight[1], weight[2]);
    let d = look(&data.texels, params.sigma_0_first, params.sigma_0_size, params.texture_wrap, at);
    whole * d * d
}

/// Radiance of one pixel.
fn pixel(state: &State, hit: &Hit, before: [f32; 3], response: &Response<'_>, bends: bool) -> [f32; 3] {
    let (data, camera) = (&state.data, &state.data.camera[0]);
    let Some(corners) = data.triangles.get(hit.face as usize) else { return camera.background };
    let params: &ObjectParams = &data.object_params[state.object_of(hit.face as usize)];
    if params.opaque != OPAQUE_NOT {
        return before;
    }
    let weight = [1.0 - f64::from(hit.u) - f64::from(hit.v), hit.u.into(), hit.v.into()];
    let (mut point, mut normal, mut kappa) = (DVec3::ZERO, DVec3::ZERO, 0.0);
    for (&vertex, weight) in corners.iter().zip(weight) {
        let (own, bend) = unpack(data.packed_normals[vertex as usize]);
        point += weight * wide(data.in_scene()[vertex as usize]);
        normal += weight * own;
        kappa += weight * bend;
    }
    let normal = normal.normalize_or_zero();
    let sigma = if bends { kappa * sigma_0(data, params, hit.face as usize, weight) } else { DVec3::ZERO };
    let sum = received(state, hit.face as usize, [point, normal], sigma, response);
    let cosine = seen_cosine(normal, wide(camera.origin) - point, corners.map(|v| data.in_scene()[v as usize]));
    let cosine = fresnel::facet_cosine(cosine, params.facet_tilt.into());
    let leaves = params.eta.map(|eta| fresnel::transmittance(eta.into(), cosine));
    let scale = f64::from(camera.radiance) / std::f64::consts::PI;
    narrow(DVec3::from_array(leaves) * wide(params.exit) * wide(params.diffuse) * sum * scale)
}

/// Radiance of each pixel that shows no opaque object, with this response; sigma is 0 unless `bends`.
pub fn shade(state: &mut State, response: &Response<'_>, bends: bool) {
    let pixels = state.data.hits.par_iter().zip(&state.data.radiance);
    let radiance = pixels.map(|(hit, &before)| pixel(state, hit, before, response, bends)).collect();
    state.data.radiance = radiance;
}

/// Records the kernel `part`, with its own constants after the common ones.
pub fn record(pass: &mut Pass<'_>, part: Option<&str>, own: &[u32]) -> Result<()> {
    let data = &pass.state.data;
    let shadows = u32::from(data.object_params.iter().any(|params| params.shadow_words > 0));
    let all = [pass.state.objects.len() as u32, shadows, u32::from(!data.sky.is_empty())];
    pass.dispatch(part, &[&all, own].concat(), &[], data.radiance.len())
}
