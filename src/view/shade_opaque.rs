//! Stage `shade_opaque`: the radiance of opaque objects, from the light that arrives at the points that the pixels
//! show.
//!
//! L = F_t(w_o) albedo E / pi, with E of equation 5 for the interpolated vertex normal. Which lights the surface
//! faces is decided by the triangle's own normal.

use glam::DVec3;
use rayon::prelude::*;

use super::pixel_receivers::place;
use crate::error::Result;
use crate::layout::{BufferId, Hit, Light};
use crate::lighting::fresnel;
use crate::lighting::irradiance::{SkyRays, entering, reaches_pixel};
use crate::lighting::pixel_light::pixel_light;
use crate::state::{Need, Pass, Role, Scope, Serves, Stage, State, Tolerance, narrow, wide};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "shade_opaque",
    about: "radiance of each pixel that shows an opaque object: albedo times irradiance at that point over pi",
    equation: "Lambert: L = F_t albedo E / pi; E of Mertens et al. 2003, equation 5",
    writes: &[(BufferId::radiance, Role::Update, Tolerance::Float { relative: 2e-5, floor: 2e-5 })],
    reason: "a short sum of products; a cosine cancels where light grazes",
    needs: &[Need::Light, Need::Picture],
    serves: Serves { object: |object, _| object.plain(), none: "no opaque object is lit where the pixels show it" },
    ..super::stage(cpu, gpu)
};

/// Radiance of one pixel; none unless it shows an opaque object lit per pixel.
fn radiance(state: &State, pixel: usize, hit: &Hit) -> Option<[f32; 3]> {
    let (data, camera) = (&state.data, &state.data.camera[0]);
    let corners = data.triangles.get(hit.face as usize)?;
    let object = state.object_of(hit.face as usize);
    let params = &data.object_params[object];
    if !state.objects[object].plain() {
        return None;
    }
    let point = wide(place(hit, corners.map(|v| data.in_scene()[v as usize])));
    let weight = [1.0 - f64::from(hit.u) - f64::from(hit.v), hit.u.into(), hit.v.into()];
    let normal: DVec3 =
        corners.iter().zip(weight).map(|(&v, weight)| weight * wide(data.normals_in_scene()[v as usize])).sum();
    let normal = normal.normalize_or_zero();
    let blended = place(hit, corners.map(|v| data.normals_in_scene()[v as usize]));
    let lights: Vec<Light> =
        (0..camera.lights as usize).map(|number| pixel_light(data, number, pixel, blended)).collect();
    let reaches = |light: &Light| reaches_pixel(data, light, pixel);
    let arrives = entering(data, params, [point, normal], (&lights, SkyRays::ByCosine), &reaches);
    let toward = (wide(camera.origin) - point).normalize_or_zero();
    let cosine = fresnel::facet_cosine(normal.dot(toward).abs(), params.facet_tilt.into());
    let leaves = params.eta.map(|eta| fresnel::transmittance(eta.into(), cosine));
    let scale = f64::from(camera.radiance) / std::f64::consts::PI;
    Some(narrow(DVec3::from_array(leaves) * wide(params.albedo) * arrives * scale * wide(params.exit)))
}

fn cpu(state: &mut State, _at: Scope) {
    let data = &state.data;
    let pixels = data.hits.par_iter().zip(&data.radiance).enumerate();
    let shaded = pixels.map(|(pixel, (hit, &before))| radiance(state, pixel, hit).unwrap_or(before)).collect();
    state.data.radiance = shaded;
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    let data = &pass.state.data;
    let shadows = u32::from(data.camera[0].shadow_words > 0);
    let constants = [pass.state.objects.len() as u32, shadows, u32::from(!data.sky.is_empty())];
    pass.dispatch(None, &constants, &[], data.radiance.len())
}
