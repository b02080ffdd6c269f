//! Stage `irradiance`: the light that enters each face, E of equation 5, from every light that reaches it and from the
//! environment.
//!
//! For an index below 1, transmittance rises from the critical angle like a square root, which amplifies the rounding
//! of the cosine: where the squared cosine is within 0.01 of the critical one, a device in `f32` may miss the stage's
//! tolerance, by up to 2e-3 of the light right at it. The fixture of such indices has no face there.

use glam::DVec3;
use rayon::prelude::*;

use super::{fresnel, harmonics};
use crate::error::Result;
use crate::geometry::placement::{placed, turned};
use crate::layout::{
    BufferId, Buffers, LIGHT_AREA, LIGHT_AREA_BOTH, LIGHT_DIRECTIONAL, LIGHT_SKY_RAY, LIGHT_SPOT, Light, NONE,
    ObjectParams, SKY_HARMONICS,
};
use crate::state::{Pass, Role, Scope, Stage, State, Tolerance, narrow, wide};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "irradiance",
    about: "light entering each face: cosine times Fresnel transmittance, summed over the lights",
    equation: "Mertens et al. 2003, equation 5",
    writes: &[(BufferId::irradiance, Role::Output, Tolerance::Float { relative: 2e-5, floor: 2e-6 })],
    reason: "a short sum of products; the cosine cancels where light grazes, hence the floor",
    ..super::stage(cpu, gpu)
};

/// The share of its intensity that a light sends in the unit direction `away` from it.
fn emission(light: &Light, away: DVec3) -> f64 {
    let cosine = wide(light.axis).dot(away);
    match light.kind {
        LIGHT_SPOT => {
            let (inner, outer) = (f64::from(light.inner), f64::from(light.outer));
            let t = ((outer - (1.0 - cosine)) / (outer - inner)).clamp(0.0, 1.0);
            t * t * (3.0 - 2.0 * t)
        }
        LIGHT_AREA => cosine.max(0.0),
        LIGHT_AREA_BOTH => cosine.abs(),
        _ => 1.0,
    }
}

/// The unit direction towards a light, and the share of its colour that arrives at a point.
#[must_use]
pub fn arrival(light: &Light, point: DVec3) -> (DVec3, f64) {
    let mut toward = wide(light.place);
    let mut falloff = 1.0;
    if light.kind != LIGHT_DIRECTIONAL && light.kind != LIGHT_SKY_RAY {
        toward -= point;
        falloff = 1.0 / toward.length_squared().max(1e-30);
        toward *= falloff.sqrt();
        falloff *= emission(light, -toward);
    }
    (toward, falloff)
}

/// Whether a light reaches a face, according to the face's shadow bits.
#[must_use]
pub fn reaches(data: &Buffers, light: &Light, face: usize) -> bool {
    bit(&data.lit, data.object_params[0].shadow_words, light, face)
}

/// Whether a light reaches the surface that a pixel shows, according to the pixel's shadow bits.
#[must_use]
pub fn reaches_pixel(data: &Buffers, light: &Light, pixel: usize) -> bool {
    bit(&data.pixel_lit, data.camera[0].shadow_words, light, pixel)
}

/// Whether a light reaches element `index` of these shadow bits, `words` per element; a light that casts no shadows
/// always does.
fn bit(bits: &[u32], words: u32, light: &Light, index: usize) -> bool {
    let bit = |bit: u32| bits[index * words as usize + bit as usize / 32] >> (bit % 32) & 1;
    light.shadow == NONE || bit(light.shadow) == 1
}

/// How rays to the environment are distributed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SkyRays {
    /// Evenly over all directions.
    Evenly,
    /// By the cosine about the surface's normal.
    ByCosine,
}

/// E of equation 5 at a point with a unit normal, both in `place`, from those of the `lights` that reach it and the
/// environment.
pub fn entering(
    data: &Buffers,
    params: &ObjectParams,
    place: [DVec3; 2],
    (lights, rays): (&[Light], SkyRays),
    reaches: &dyn Fn(&Light) -> bool,
) -> DVec3 {
    let [point, normal] = place;
    let eta = params.eta.map(f64::from);
    let sky: Vec<DVec3> = data.harmonics.iter().take(SKY_HARMONICS).map(|&c| wide(c)).collect();
    let zonal = [wide(params.zonal_0), wide(params.zonal_1), wide(params.zonal_2)];
    let one_side = |normal: DVec3| {
        let (mut sum, mut all, mut free) = (DVec3::ZERO, DVec3::ZERO, DVec3::ZERO);
        for light in lights {
            let (toward, falloff) = arrival(light, point);
            let arrives = reaches(light);
            let cosine = normal.dot(toward).max(0.0);
            let passes = DVec3::from_array(eta.map(|eta| fresnel::transmittance(eta, cosine)));
            if light.kind == LIGHT_SKY_RAY {
                let share = match rays {
                    SkyRays::Evenly => cosine,
                    SkyRays::ByCosine => f64::from(u8::from(cosine > 0.0)),
                };
                let weight = harmonics::radiance(&sky, toward) * passes * share;
                all += weight;
                free += if arrives { weight } else { DVec3::ZERO };
            } else if arrives {
                sum += wide(light.color) * passes * (cosine * falloff);
            }
        }
        if sky.is_empty() {
            return sum;
        }
        let share = |k: usize| if free[k] == all[k] { 1.0 } else { free[k] / all[k] };
        sum + harmonics::irradiance(&sky, zonal, normal) * DVec3::new(share(0), share(1), share(2))
    };
    one_side(normal) + if params.two_sided == 0 { DVec3::ZERO } else { one_side(-normal) }
}

fn cpu(state: &mut State, _at: Scope) {
    let data = &state.data;
    let of_face = |face: usize| {
        let leaf = &data.clusters[data.leaves[face] as usize];
        let area = f64::from(leaf.area);
        let normal = if area > 0.0 { wide(leaf.normal) / area } else { DVec3::ZERO };
        let reaches = |light: &Light| reaches(data, light, face);
        let params = &data.object_params[0];
        let place = [wide(placed(params, leaf.center)), wide(turned(params, narrow(normal)))];
        narrow(entering(data, params, place, (&data.lights, SkyRays::Evenly), &reaches))
    };
    state.data.irradiance = (0..data.triangles.len()).into_par_iter().map(of_face).collect();
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    let data = &pass.state.data;
    let uses = [u32::from(data.object_params[0].shadow_words > 0), u32::from(!data.sky.is_empty())];
    pass.dispatch(None, &uses, &[], pass.object().count.faces)
}
