//! Stage `bake_irradiance`: the irradiance at each texel of an object's texture coordinates, and how far the texture
//! is stretched over the surface there.
//!
//! E of equation 5 of Mertens et al. 2003 at the surface point of the texel's centre, with the interpolated vertex
//! normal, times the entry texture. A texel's extents along its row and its column, lengths on the surface, follow
//! from its triangle. A texel that shows no surface has zero light and zero extents.

use glam::DVec3;
use rayon::prelude::*;

use super::gaussians::GAUSSIANS;
use crate::error::Result;
use crate::layout::{BufferId, LONGEST_STRETCH, TEXTURE_ENTERS, TexelHit, Unwrapping};
use crate::lighting::irradiance::{SkyRays, entering, reaches};
use crate::lighting::texture::{factor, place};
use crate::state::{Carrier, Pass, Role, Scope, Size, Stage, State, Tolerance, Update, wide};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "bake_irradiance",
    about: "irradiance and stretch at each texel of the texture coordinates (`--transport texture-blur`)",
    equation: "d'Eon et al. 2007, section 5; Mertens et al. 2003, equation 5",
    writes: &[
        (BufferId::irradiance_maps, Role::Update, Tolerance::Float { relative: 2e-5, floor: 1e-5 }),
        (BufferId::stretch, Role::Output, Tolerance::Float { relative: 1e-4, floor: 1e-5 }),
    ],
    reason: "sums of products; a cosine cancels where light grazes, and edges do where texture coordinates are large",
    sizes: &[
        (BufferId::irradiance_maps, Size::Elements(|state| (1 + GAUSSIANS) * state.data.texel_hits.len())),
        (BufferId::stretch, Size::Elements(|state| state.data.texel_hits.len())),
    ],
    carriers: &[Carrier::TextureBlur],
    runs: Update::light,
    ..super::stage(cpu, gpu)
};

/// Irradiance and extents of one texel.
fn texel(state: &State, own: &Unwrapping, chart: &TexelHit) -> ([f32; 4], [f32; 2]) {
    let (data, face) = (&state.data, chart.face as usize);
    let Some(corners) = data.triangles.get(face) else { return ([0.0; 4], [0.0; 2]) };
    let params = &data.object_params[own.object as usize];
    let weight = [1.0 - f64::from(chart.u) - f64::from(chart.v), chart.u.into(), chart.v.into()];
    let mix = |values: &[[f32; 3]]| -> DVec3 {
        corners.iter().zip(weight).map(|(&v, weight)| weight * wide(values[v as usize])).sum()
    };
    let place_of = [mix(data.in_scene()), mix(data.normals_in_scene()).normalize_or_zero()];
    let mut light =
        entering(data, params, place_of, (&data.lights, SkyRays::Evenly), &|light| reaches(data, light, face));
    if params.texture_side & TEXTURE_ENTERS != 0 {
        light *= factor(params, &data.texels, place(data, face, chart.u.into(), chart.v.into()));
    }

    // Position is linear in the texture coordinates: its derivatives along a row and down a column.
    let [a, b, c] = corners.map(|v| wide(data.in_scene()[v as usize]));
    let uvs = &data.corner_uvs[face];
    let [p, q] = [uvs.b, uvs.c].map(|end| [0, 1].map(|k| f64::from(end[k]) - f64::from(uvs.a[k])));
    let turned = p[0] * q[1] - p[1] * q[0];
    let along = ((b - a) * q[1] - (c - a) * p[1]) / turned;
    let down = ((c - a) * p[0] - (b - a) * q[0]) / turned;
    let length = |way: DVec3| {
        if turned == 0.0 { LONGEST_STRETCH } else { (way.length() / f64::from(own.side)).min(LONGEST_STRETCH) }
    };
    ([light.x as f32, light.y as f32, light.z as f32, 1.0], [length(along) as f32, length(down) as f32])
}

fn cpu(state: &mut State, _at: Scope) {
    for own in state.data.unwrappings.clone() {
        let (first, count) = (own.first as usize, (own.side * own.side) as usize);
        let all: Vec<_> =
            state.data.texel_hits[first..first + count].par_iter().map(|chart| texel(state, &own, chart)).collect();
        for (k, (light, lengths)) in all.into_iter().enumerate() {
            state.data.irradiance_maps[first + k] = light;
            state.data.stretch[first + k] = lengths;
        }
    }
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    let data = &pass.state.data;
    let shadows = u32::from(data.object_params.iter().any(|params| params.shadow_words > 0));
    let textured = u32::from(data.object_params.iter().any(|params| params.texture_side & TEXTURE_ENTERS != 0));
    let constants = [shadows, u32::from(!data.sky.is_empty()), textured];
    for (number, own) in (0u32..).zip(&data.unwrappings) {
        pass.dispatch(None, &constants, bytemuck::bytes_of(&number), (own.side * own.side) as usize)?;
    }
    Ok(())
}
