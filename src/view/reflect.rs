//! Stage `reflect`: reflection of lights and environment at the surface, times the Fresnel reflectance of the
//! material's boundary, 1 - F_t.
//!
//! GGX: D G F / (4 (n.v) (n.l)), F at the facet, of two lobes by their shares. Phong: (m + 2) / (2 pi) cos^m F, F at
//! the normal, cos from the mirror direction. The environment is a sum over rays that each pixel and sample draws anew
//! ([`mirror_ray`]): by the facets that the eye sees or about the mirror direction, and where the environment is
//! bright; each is divided by the density of all. The interpolated vertex normal is used, on the visible side of the
//! triangle; where it faces away at a silhouette, n.v counts as |n.v|.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use rayon::prelude::*;

use super::mirror_ray::{Seen, bright_density, mirror_ray};
use crate::error::Result;
use crate::layout::{
    BufferId, Hit, LIGHT_BRIGHT_RAY, LIGHT_SKY_RAY, Light, ObjectParams, REFLECTION_GGX, REFLECTION_NONE,
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

/// G / (4 (n.v) (n.l)) with Smith's lambda for GGX.
fn masking(alpha: f64, seen: f64, lights: f64) -> f64 {
    let slope = |cosine: f64| (alpha * alpha + (1.0 - alpha * alpha) * cosine * cosine).sqrt();
    0.5 / (lights * slope(seen) + seen * slope(lights)).max(1e-30)
}

/// The lobe times the cosine to the normal, without Fresnel's factor, in a direction, and the density of rays there
/// that are drawn from the lobe: by facets as the eye sees them, or by those that stand for Phong's lobe.
fn drawn_lobe(params: &ObjectParams, [normal, eye]: [DVec3; 2], direction: DVec3) -> [f64; 2] {
    let (shape, along) = (f64::from(params.roughness), normal.dot(eye));
    let (seen, cosine) = (along.abs(), normal.dot(direction).max(0.0));
    if params.reflection == REFLECTION_GGX {
        let facet = normal.dot((above(normal, eye) + direction).normalize_or_zero());
        let density = |alpha: f64| {
            let slope = (alpha * alpha + (1.0 - alpha * alpha) * seen * seen).sqrt();
            0.5 * facets(alpha, facet) / (seen + slope)
        };
        return [cosine * microfacets(params, facet, [seen, cosine]), both(params, density)];
    }
    let mirrored = (2.0 * along * normal - eye).dot(direction).max(0.0);
    let lobe = (shape + 2.0) / TAU * mirrored.powf(shape);
    [cosine * lobe, facets((4.0 / (shape + 3.0)).sqrt(), mirrored) * mirrored]
}

/// The mean of both lobes' values by their shares, from that of a lobe by its alpha.
fn both(params: &ObjectParams, value: impl Fn(f64) -> f64) -> f64 {
    let share = f64::from(params.second_share);
    let second = if share > 0.0 { value(params.second_roughness.into()) } else { 0.0 };
    (1.0 - share) * value(params.roughness.into()) + share * second
}

/// D G / (4 (n.v) (n.l)) of both lobes, by the cosines of the angles of facet, eye and light to the normal.
fn microfacets(params: &ObjectParams, facet: f64, [seen, light]: [f64; 2]) -> f64 {
    both(params, |alpha| facets(alpha, facet) * masking(alpha, seen, light))
}

/// The direction to the eye, taken to be above the surface, as its facets are.
fn above(normal: DVec3, eye: DVec3) -> DVec3 {
    eye - 2.0 * normal.dot(eye).min(0.0) * normal
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
    for number in (0..camera.lights as usize).filter(|&number| !sky_ray(&data.pixel_lights[number])) {
        let light = pixel_light(data, number, pixel, narrow(normal));
        let (toward, falloff) = arrival(&light, point);
        let cosine = normal.dot(toward);
        if cosine <= 0.0 || !reaches_pixel(data, &light, pixel) {
            continue;
        }
        let (lobe, met) = if ggx {
            let facet = (eye + toward).normalize_or_zero();
            (microfacets(params, normal.dot(facet), [seen, cosine]), eye.dot(facet))
        } else {
            ((shape + 2.0) / TAU * mirror.dot(toward).max(0.0).powf(shape), cosine)
        };
        sum += wide(light.color) * reflectance(met) * (falloff * cosine * lobe);
    }

    sum + mirrored(state, pixel, hit, &reflectance)
}

/// The environment's reflection: each ray divided by the density of all of them in its direction (Veach and Guibas
/// 1995).
fn mirrored(state: &State, pixel: usize, hit: &Hit, reflectance: &dyn Fn(f64) -> DVec3) -> DVec3 {
    let (data, camera) = (&state.data, &state.data.camera[0]);
    let params = &data.object_params[state.object_of(hit.face as usize)];
    let seen = Seen::new(data, hit, data.triangles[hit.face as usize]);
    let [normal, eye] = [seen.normal, seen.eye].map(|v| wide(v).normalize_or_zero());
    let rays = &data.pixel_lights[camera.lights as usize..];
    let bright = rays.iter().filter(|ray| ray.kind == LIGHT_BRIGHT_RAY).count();
    let counts = [rays.len() - bright, bright].map(|count| count as f64);
    let mut sum = DVec3::ZERO;
    for ray in rays.iter().filter(|ray| reaches_pixel(data, ray, pixel)) {
        let place = mirror_ray(data, ray, pixel, &seen, params).place;
        let direction = wide(place);
        let met = match params.reflection {
            REFLECTION_GGX => (0.5 + 0.5 * above(normal, eye).dot(direction)).max(0.0).sqrt(),
            _ => normal.dot(direction).max(0.0),
        };
        let [lobe, density] = drawn_lobe(params, [normal, eye], direction);
        let others = if bright > 0 { bright_density(data, place) } else { 0.0 };
        let weight = lobe / (counts[0] * density + counts[1] * others).max(1e-30);
        sum += sky::radiance(data, direction) * reflectance(met) * weight;
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
    let (data, camera) = (&pass.state.data, &pass.state.data.camera[0]);
    let (pixels, shadows) = (data.radiance.len(), u32::from(camera.shadow_words > 0));
    let (lights, rays) = data.pixel_lights.split_at(camera.lights as usize);
    for (object, params) in (0u32..).zip(&data.object_params).filter(|(_, params)| params.reflection != REFLECTION_NONE)
    {
        let lobes = 1 + u32::from(params.second_share > 0.0);
        let (ggx, push) = (if params.reflection == REFLECTION_GGX { lobes } else { 0 }, object.to_le_bytes());
        if !lights.iter().all(sky_ray) {
            pass.dispatch(Some("lights"), &[shadows, ggx], &push, pixels)?;
        }
        if !rays.is_empty() {
            let bright = rays.iter().filter(|ray| ray.kind == LIGHT_BRIGHT_RAY).count();
            let constants = [shadows, ggx, (rays.len() - bright) as u32, bright as u32];
            pass.dispatch(Some("environment"), &constants, &push, pixels)?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::mirror_ray::drawn;
    use super::*;
    use crate::geometry::random::unit_random;
    use crate::layout::SQUARE_STEPS;

    /// A ball's surroundings that are even, and some that are not.
    fn skies(way: DVec3) -> [f64; 2] {
        [1.0, 1.0 + way.x + way.z * way.z + 0.5 * way.y * way.x]
    }

    /// Their reflections by a lobe, without Fresnel's factor, by quadrature over the hemisphere.
    fn exact(params: &ObjectParams, eye: DVec3) -> [f64; 2] {
        let (shape, steps, mut sum) = (f64::from(params.roughness), 1200, [0.0; 2]);
        let mirror = DVec3::new(-eye.x, 0.0, eye.z);
        for k in 0..steps * steps {
            let z = (f64::from(k / steps) + 0.5) / f64::from(steps);
            let (sine, cosine) = (TAU * f64::from(k % steps) / f64::from(steps)).sin_cos();
            let across = (1.0 - z * z).sqrt();
            let way = DVec3::new(across * cosine, across * sine, z);
            let lobe = if params.reflection == REFLECTION_GGX {
                microfacets(params, (eye + way).normalize().z, [eye.z, z])
            } else {
                (shape + 2.0) / TAU * mirror.dot(way).max(0.0).powf(shape)
            };
            let share = lobe * z * TAU / f64::from(steps * steps);
            (0..2).for_each(|c| sum[c] += share * skies(way)[c]);
        }
        sum
    }

    /// The same along so many rays.
    fn along_rays(params: &ObjectParams, eye: DVec3, rays: u32) -> [f64; 2] {
        let mut sum = [0.0; 2];
        for k in 0..rays {
            let square = SQUARE_STEPS.map(|step| unit_random(k.wrapping_mul(step)));
            // Of a hundred rays as many come from the second lobe as its share says.
            let second = ((k * 37 % 100) as f32) < 100.0 * params.second_share;
            let roughness = if second { params.second_roughness } else { params.roughness };
            let way = wide(drawn(square, [0.0, 0.0, 1.0], narrow(eye), &ObjectParams { roughness, ..*params }));
            assert!((way.length() - 1.0).abs() < 1e-5, "{way}");
            let [lobe, density] = drawn_lobe(params, [DVec3::Z, eye], way);
            let weight = lobe / density.max(1e-30);
            assert!((0.0..=2.01).contains(&weight), "a ray that counts {weight} times");
            (0..2).for_each(|c| sum[c] += weight * skies(way)[c] / f64::from(rays));
        }
        sum
    }

    #[test]
    fn rays_have_the_mean_of_their_lobe_and_come_nearer_the_more_there_are() {
        for (reflection, roughness) in [(2, 0.1), (2, 0.3), (2, 1.0), (1, 1.0), (1, 5.0), (1, 200.0)] {
            let params = ObjectParams { reflection, roughness, ..ObjectParams::default() };
            for seen in [0.15, 0.6, 1.0_f64] {
                let eye = DVec3::new((1.0 - seen * seen).sqrt(), 0.0, seen);
                let exact = exact(&params, eye);
                let off = |rays| {
                    let found = along_rays(&params, eye, rays);
                    [0, 1].map(|c| (found[c] / exact[c] - 1.0).abs()).into_iter().fold(0.0, f64::max)
                };
                let (few, many) = (off(64), off(4096));
                assert!(few < 0.1 && many < 2e-3, "{reflection}, {roughness}, {seen}: {few} {many}");
            }
        }
    }

    #[test]
    fn rays_of_two_lobes_have_the_mean_of_both() {
        let lobes = ObjectParams { reflection: REFLECTION_GGX, roughness: 0.45, ..ObjectParams::default() };
        let lobes = ObjectParams { second_roughness: 0.25, second_share: 0.3, ..lobes };
        for seen in [0.3, 0.9_f64] {
            let eye = DVec3::new((1.0 - seen * seen).sqrt(), 0.0, seen);
            let (sum, found) = (exact(&lobes, eye), along_rays(&lobes, eye, 40_000));
            let alone = |roughness| exact(&ObjectParams { roughness, second_share: 0.0, ..lobes }, eye);
            let (first, second) = (alone(0.45), alone(0.25));
            for c in [0, 1] {
                assert!((sum[c] - 0.7 * first[c] - 0.3 * second[c]).abs() < 1e-6 && first[c] != second[c]);
                assert!((found[c] / sum[c] - 1.0).abs() < 5e-3, "{seen}: {found:?} {sum:?}");
            }
        }
    }

    #[test]
    fn a_mirror_has_one_direction() {
        let params = ObjectParams { reflection: REFLECTION_GGX, roughness: 0.001, ..ObjectParams::default() };
        let normal = wide([0.6, 0.0, 0.8]);
        let eye = DVec3::new(0.1, 0.3, 0.9).normalize();
        let mirror = 2.0 * normal.dot(eye) * normal - eye;
        for square in [[0.1, 0.2], [0.5, 0.9], [0.9, 0.6]] {
            let way = wide(drawn(square, narrow(normal), narrow(eye), &params));
            assert!(way.distance(mirror) < 0.01, "{way} {mirror}");
        }
    }

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
