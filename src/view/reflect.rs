//! Stage `reflect`: reflection of lights and environment at the surface, times the Fresnel reflectance of the
//! material's boundary, 1 - F_t.
//!
//! GGX: D G F / (4 (n.v) (n.l)), F at the facet. Phong: (m + 2) / (2 pi) cos^m F, F at the normal, cos from the
//! mirror direction. The environment is a sum over [`DIRECTIONS`] fixed facets or directions, distributed as D or as
//! the lobe. The interpolated vertex normal is used, on the visible side of the triangle; where it faces away at a
//! silhouette, n.v counts as |n.v|.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use rayon::prelude::*;

use crate::error::Result;
use crate::layout::{
    BufferId, Hit, LIGHT_SKY_RAY, Light, ObjectParams, REFLECTION_GGX, REFLECTION_NONE, REFLECTION_PHONG,
};
use crate::lighting::irradiance::{arrival, reaches_pixel};
use crate::lighting::pixel_light::pixel_light;
use crate::lighting::{fresnel, sky};
use crate::state::{Need, Pass, Role, Scope, Stage, State, Tolerance, narrow, wide};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "reflect",
    about: "reflection of lights and environment towards the eye: Phong lobe or GGX microfacets",
    equation: "Walter et al. 2007, equations 20, 33; Heitz 2014, equation 99; Lafortune and Willems 1994",
    writes: &[(BufferId::radiance, Role::Update, Tolerance::Float { relative: 5e-5, floor: 2e-5 })],
    reason: "a narrow lobe multiplies a cosine's rounding by its exponent or by 2 / alpha; the image as in backdrop",
    needs: &[Need::Light, Need::Picture],
    skip,
    ..super::stage(cpu, gpu)
};

fn skip(state: &State) -> Option<&'static str> {
    let dull = state.data.object_params.iter().all(|params| params.reflection == REFLECTION_NONE);
    dull.then_some("the material's surface reflects nothing")
}

/// Number of environment look-ups per pixel.
pub const DIRECTIONS: u32 = 32;

/// The facets or directions of an object's environment look-ups, about the z axis; only meaningful if it reflects.
#[must_use]
pub fn lobe(params: &ObjectParams) -> Vec<[f32; 3]> {
    let shape = f64::from(params.roughness);
    let direction = |k: u32| {
        // A golden-ratio lattice in the unit square, mapped to the distribution of the lobe.
        let u = (f64::from(k) + 0.5) / f64::from(DIRECTIONS);
        let turn = TAU * (f64::from(k) * 0.618_033_988_749_894_9).fract();
        let cosine = match params.reflection {
            REFLECTION_PHONG => (1.0 - u).powf(1.0 / (shape + 1.0)),
            _ => ((1.0 - u) / (1.0 + (shape * shape - 1.0) * u)).sqrt(),
        };
        let sine = (1.0 - cosine * cosine).max(0.0).sqrt();
        narrow(DVec3::new(sine * turn.cos(), sine * turn.sin(), cosine))
    };
    (0..DIRECTIONS).map(direction).collect()
}

/// G / (4 (n.v) (n.l)) with Smith's lambda for GGX.
fn masking(alpha: f64, seen: f64, lights: f64) -> f64 {
    let slope = |cosine: f64| (alpha * alpha + (1.0 - alpha * alpha) * cosine * cosine).sqrt();
    0.5 / (lights * slope(seen) + seen * slope(lights)).max(1e-30)
}

/// D of a facet, by the cosine of its angle to the normal.
fn facets(alpha: f64, cosine: f64) -> f64 {
    let (c2, a2) = (cosine * cosine, alpha * alpha);
    a2 / (PI * (c2 * (a2 - 1.0) + 1.0).powi(2))
}

fn sky_ray(light: &Light) -> bool {
    light.kind == LIGHT_SKY_RAY
}

/// Reflected radiance of one pixel, internal units.
fn reflected(state: &State, pixel: usize, hit: &Hit) -> DVec3 {
    let (data, camera) = (&state.data, &state.data.camera[0]);
    let Some(corners) = data.triangles.get(hit.face as usize) else { return DVec3::ZERO };
    let object = state.object_of(hit.face as usize);
    let params = &data.object_params[object];
    if params.reflection == REFLECTION_NONE {
        return DVec3::ZERO;
    }
    let weight = [1.0 - f64::from(hit.u) - f64::from(hit.v), hit.u.into(), hit.v.into()];
    let mix = |values: &[[f32; 3]]| -> DVec3 {
        corners.iter().zip(weight).map(|(&v, weight)| weight * wide(values[v as usize])).sum()
    };
    let [a, b, c] = corners.map(|v| wide(data.in_scene()[v as usize]));
    let (point, toward) = (mix(data.in_scene()), wide(camera.origin) - mix(data.in_scene()));
    let side = if (b - a).cross(c - a).dot(toward) < 0.0 { -1.0 } else { 1.0 };
    let (normal, eye) = (mix(data.normals_in_scene()).normalize_or_zero() * side, toward.normalize_or_zero());
    let (seen, shape, ggx) = (normal.dot(eye).abs(), f64::from(params.roughness), params.reflection == REFLECTION_GGX);
    let mirror = 2.0 * normal.dot(eye) * normal - eye;
    let reflectance =
        |cosine: f64| DVec3::from_array(params.eta.map(|eta| 1.0 - fresnel::transmittance(eta.into(), cosine)));

    let mut sum = DVec3::ZERO;
    for number in (0..data.pixel_lights.len()).filter(|&number| !sky_ray(&data.pixel_lights[number])) {
        let light = pixel_light(data, number, pixel, narrow(normal));
        let (toward, falloff) = arrival(&light, point);
        let cosine = normal.dot(toward);
        if cosine <= 0.0 || !reaches_pixel(data, &light, pixel) {
            continue;
        }
        let (lobe, met) = if ggx {
            let facet = (eye + toward).normalize_or_zero();
            (facets(shape, normal.dot(facet)) * masking(shape, seen, cosine), eye.dot(facet))
        } else {
            ((shape + 2.0) / TAU * mirror.dot(toward).max(0.0).powf(shape), cosine)
        };
        sum += wide(light.color) * reflectance(met) * (falloff * cosine * lobe);
    }

    // The environment, in a frame about the lobe's axis.
    let axis = if ggx { normal } else { mirror };
    let flat = |v: DVec3| v - v.dot(axis) * axis;
    let right = flat(wide(camera.right).normalize_or_zero());
    let across = if right.length_squared() < 1e-6 { flat(wide(camera.up)) } else { right }.normalize_or_zero();
    let other = axis.cross(across);
    for &local in data.reflection_directions.iter().skip(object * DIRECTIONS as usize).take(DIRECTIONS as usize) {
        let drawn = across * f64::from(local[0]) + other * f64::from(local[1]) + axis * f64::from(local[2]);
        let (direction, met, weight) = if ggx {
            let met = eye.dot(drawn).max(0.0);
            let direction = 2.0 * met * drawn - eye;
            let cosine = normal.dot(direction).max(0.0);
            (direction, met, 4.0 * cosine * masking(shape, seen, cosine) * met / f64::from(local[2]))
        } else {
            let met = normal.dot(drawn).max(0.0);
            (drawn, met, met * (shape + 2.0) / (shape + 1.0))
        };
        sum += sky::radiance(data, direction) * reflectance(met) * (weight / f64::from(DIRECTIONS));
    }
    sum
}

fn cpu(state: &mut State, _at: Scope) {
    let data = &state.data;
    let scale = f64::from(data.camera[0].radiance);
    let pixels = data.hits.par_iter().zip(&data.radiance).enumerate();
    let radiance = |(pixel, (hit, &before))| narrow(wide(before) + scale * reflected(state, pixel, hit));
    state.data.radiance = pixels.map(radiance).collect();
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    let data = &pass.state.data;
    let pixels = data.radiance.len();
    for (object, params) in (0u32..).zip(&data.object_params).filter(|(_, params)| params.reflection != REFLECTION_NONE)
    {
        let (ggx, push) = (u32::from(params.reflection == REFLECTION_GGX), object.to_le_bytes());
        if !data.pixel_lights.iter().all(sky_ray) {
            let shadows = u32::from(data.camera[0].shadow_words > 0);
            pass.dispatch(Some("lights"), &[shadows, ggx], &push, pixels)?;
        }
        if !data.reflection_directions.is_empty() {
            pass.dispatch(Some("environment"), &[ggx, DIRECTIONS], &push, pixels)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn facets_cover_the_plane_once() {
        for alpha in [0.01, 0.2, 1.0] {
            let steps = 200_000;
            let at = |i: u32| (f64::from(i) + 0.5) / f64::from(steps);
            // With the substitution cos = 1 - s^4: narrow lobes lie near s = 0.
            let term = |s: f64| facets(alpha, 1.0 - s.powi(4)) * (1.0 - s.powi(4)) * TAU * 4.0 * s.powi(3);
            let sum = (0..steps).map(|i| term(at(i))).sum::<f64>() / f64::from(steps);
            assert!((sum - 1.0).abs() < 1e-4, "{alpha}: {sum}");
        }
    }
}
