//! Stage `shade`: the radiance that leaves towards the eye, equation 3, from radiosity interpolated between vertices,
//! or from that of the pixel's own receiver.
//!
//! Its integral over all directions is (1 - F_ext) B for a smooth surface; with `normalize_exit` the object's factor
//! `exit` makes that B, whatever the surface.

use glam::DVec3;
use rayon::prelude::*;

use crate::error::Result;
use crate::layout::BufferId;
use crate::lighting::fresnel;
use crate::lighting::leaving::seen_cosine;
use crate::state::{Pass, Role, Scope, Size, Stage, State, Tolerance, narrow, wide};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "shade",
    about: "radiance of each pixel: Fresnel transmittance times radiosity over pi",
    equation: "Mertens et al. 2003, equation 3",
    writes: &[(BufferId::radiance, Role::Output, Tolerance::Float { relative: 2e-5, floor: 2e-5 })],
    reason: "a short chain of f32 operations; near the critical angle (eta < 1) transmittance grows like a root, and one \
             rounding of the cosine, 1e-7, changes it by 2e-5 where 1e-5 of the squares are left",
    sizes: &[(BufferId::radiance, Size::Elements(State::pixels))],
    skip,
    ..super::stage(cpu, gpu)
};

fn skip(state: &State) -> Option<&'static str> {
    let by_face = state.objects.iter().any(|object| object.opaque && object.lit_by_face());
    let translucent = state.objects.iter().any(|object| !object.opaque);
    let elsewhere = state.method.local.is_some() && !by_face && state.lit() && translucent;
    elsewhere.then_some("light is evaluated where the pixels are")
}

fn cpu(state: &mut State, _at: Scope) {
    let data = &state.data;
    let camera = data.camera[0];
    let radiance = data
        .hits
        .par_iter()
        .enumerate()
        .map(|(pixel, hit)| {
            let Some(corner) = data.triangles.get(hit.face as usize) else { return camera.background };
            let weight = [1.0 - f64::from(hit.u) - f64::from(hit.v), hit.u.into(), hit.v.into()];
            let mix = |values: &[[f32; 3]]| -> DVec3 {
                corner.iter().zip(weight).map(|(&v, weight)| weight * wide(values[v as usize])).sum()
            };
            let toward = wide(camera.origin) - mix(data.in_scene());
            let places = corner.map(|v| data.in_scene()[v as usize]);
            let cosine = seen_cosine(mix(data.normals_in_scene()), toward, places);
            let params = &data.object_params[state.object_of(hit.face as usize)];
            let (eta, exit) = (params.eta.map(f64::from), wide(params.exit));
            let facets = fresnel::facet_cosine(cosine, params.facet_tilt.into());
            let leaves = eta.map(|eta| fresnel::transmittance(eta, facets));
            let scale = f64::from(camera.radiance) / std::f64::consts::PI;
            let radiosity = match params.by_pixel {
                0 => mix(&data.vertex_radiosity),
                _ => wide(data.radiosity[(params.first_receiver + data.seen[pixel]) as usize]),
            };
            narrow(DVec3::from_array(leaves) * radiosity * scale * exit)
        })
        .collect();
    state.data.radiance = radiance;
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    let pixels = u32::from(pass.state.objects.iter().any(|object| object.by_pixel));
    pass.dispatch(None, &[pass.state.objects.len() as u32, pixels], &[], pass.state.data.radiance.len())
}
