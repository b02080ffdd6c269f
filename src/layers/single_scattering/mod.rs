//! Stage `single_scattering`: light that is refracted in, scattered once in the medium, and refracted out towards the
//! eye, for materials that ask for it. The dipole holds diffused light only.
//!
//! At a point x with refracted view direction w_o', light of index eta inside over outside is
//!
//! L(x, w_o) = T(w_o) / eta^2 integral of sigma_s p(w_i', w_o') E' e^(-sigma_t (s + s')) ds,
//!
//! over the refracted ray down to where it leaves the object. A light of irradiance E on a plane that faces it brings
//! E' = E T(w_i) mu_i / mu_i': a beam that loses light by Fresnel's transmittance T, and has another width inside than
//! outside. Radiance falls by 1 / eta^2 on its way out. On a half-space under a distant light this is [`half_space`].
//!
//! The entry of light and its length in the medium are Jensen's estimate: a straight ray from the sample to the light
//! meets the surface after s_i, with a normal by which light is refracted; then s' = s_i mu_i / mu_i'. It is exact for
//! a distant light where the surface is flat around the entry, and for an index of 1 anywhere; light from a place falls
//! off with the square of its distance to the surface plus s' / eta. The estimate leaves out that curved surfaces focus
//! light. Shadow bits are those of the triangle where light enters.
//!
//! Between samples light times phase function and optical depth are taken as linear, and their integral is exact; so
//! the result is exact on a half-space, however few the samples.

mod ray;

use glam::DVec3;
use rayon::prelude::*;

use crate::error::Result;
use crate::geometry::trace::UNFINISHED;
use crate::layers::beneath::{phase, segment};
use crate::layout::{BufferId, Hit, InnerRay, LIGHT_DIRECTIONAL, Light, SINGLE_STEPS, ScatteringMedium};
use crate::lighting::fresnel::transmittance;
use crate::lighting::irradiance::{arrival, reaches};
use crate::lighting::shadow::RAYS;
use crate::state::{Carrier, Pass, Role, Scope, Serves, Size, Stage, State, Tolerance, narrow, wide};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "single_scattering",
    about: "light scattered once in the medium beneath each visible point, refracted in and out",
    equation: "Hanrahan and Krueger 1993, equation 8; Jensen et al. 2001, equation 6 and section 4.1",
    writes: &[
        (BufferId::radiance, Role::Update, Tolerance::Float { relative: 1e-4, floor: 2e-5 }),
        (BufferId::inner_rays, Role::Update, Tolerance::Float { relative: 2e-5, floor: 2e-6 }),
        (BufferId::cut_short, Role::Update, Tolerance::Exact),
    ],
    reason: "which triangles rays meet is decided bit for bit; a distance is one division, a cosine cancels where light \
             grazes, and an exponential's depth is off by some roundings of its own size",
    sizes: &[(BufferId::inner_rays, Size::Elements(|state| state.pixels().min(RAYS)))],
    carriers: &[Carrier::Blocks, Carrier::Links, Carrier::Octree, Carrier::Brute, Carrier::Cdrf, Carrier::Nothing],
    serves: Serves { object: |object, _| object.scatters_once, none: "no material has single_scattering = true" },
    ..super::stage(cpu, gpu)
};

/// Radiance that a half-space scatters once towards the cosine `eye`, per irradiance of a distant light on a plane that
/// faces it, at the cosine `light`; both are outside. `albedo` is sigma_s / sigma_t, and `phase` the phase function's
/// value for the directions inside:
///
/// albedo p T(mu_o) T(mu_i) mu_i / (eta^2 (mu_i' + mu_o')).
#[must_use]
pub fn half_space(albedo: f64, eta: f64, phase: f64, light: f64, eye: f64) -> f64 {
    let through = transmittance(eta, light) * transmittance(eta, eye);
    albedo * phase * through * light / (eta * eta * (inside(eta, light) + inside(eta, eye)))
}

/// The cosine inside for one outside, at least 0.
fn inside(eta: f64, outer: f64) -> f64 {
    if eta == 1.0 { outer } else { (outer * outer - (1.0 - eta) * (1.0 + eta)).max(0.0).sqrt() / eta }
}

/// The light that arrives at a sample from one light source, per channel and times the phase function, but without the
/// medium's attenuation, and the length of its way in the medium.
fn arriving(
    state: &State,
    medium: &ScatteringMedium,
    hit: &Hit,
    light: &Light,
    way: DVec3,
    (place, first): ([f32; 3], bool),
) -> (DVec3, f64) {
    let data = &state.data;
    let far = light.kind == LIGHT_DIRECTIONAL;
    let Some(entry) = ray::entry(data, medium, hit, (place, first), (light.place, far)) else {
        return (DVec3::ZERO, 0.0);
    };
    let weights = entry.weights.map(f64::from);
    let normals = data.triangles[entry.face as usize].map(|v| wide(data.normals_in_scene()[v as usize]));
    let normal: DVec3 = normals.iter().zip(weights).map(|(&n, weight)| weight * n).sum();
    let normal = (normal / weights.iter().sum::<f64>()).normalize_or_zero();
    let place = wide(place);
    let straight = if far { wide(light.place) } else { wide(light.place) - place };
    let toward = straight.normalize_or_zero();
    let straight = straight * (f64::from(entry.numerator) / f64::from(entry.denominator)).max(0.0);
    let (eta, outer) = (f64::from(medium.eta), normal.dot(toward).clamp(0.0, 1.0));
    let (passes, inner) = (transmittance(eta, outer), inside(eta, outer));
    if passes <= 0.0 {
        return (DVec3::ZERO, 0.0);
    }
    let bent = (toward - outer * normal) / eta + inner * normal;
    let phases = medium.g.map(|g| phase(true, g.into(), -bent.dot(way)));
    let lit = if reaches(data, light, entry.face as usize) { 1.0 } else { 0.0 };
    let ratio = outer / inner;
    let leg = straight.length() * ratio;
    // Inside, light from a place falls off as if it had gone leg / eta.
    let (_, falloff) = arrival(light, place + straight - toward * (leg / eta));
    (DVec3::from_array(phases) * wide(light.color) * (falloff * passes * ratio * lit), leg)
}

/// Radiance that a medium adds to a pixel, internal units, and the pixel's ray as the last sample leaves it.
fn scattered(state: &State, medium: &ScatteringMedium, hit: &Hit) -> (DVec3, InnerRay) {
    let data = &state.data;
    let (way, length) = ray::refract(data, medium, hit);
    let mut kept = InnerRay { way, end: length, ..InnerRay::default() };
    if length <= 0.0 {
        return (DVec3::ZERO, kept);
    }
    let start = ray::point(data, hit);
    let (sigma_s, sigma_t) = (wide(medium.sigma_s), wide(medium.sigma_t));
    let mut sum = DVec3::ZERO;
    for light in &data.layer_lights {
        let mut before: Option<(f64, DVec3, DVec3)> = None;
        for sample in 0..=SINGLE_STEPS {
            let share = (sample * sample) as f32 * (1.0 / (SINGLE_STEPS * SINGLE_STEPS) as f32);
            let t = share * length;
            let place = std::array::from_fn(|k| start[k] + t * way[k]);
            let (arrived, leg) = arriving(state, medium, hit, light, wide(way), (place, sample == 0));
            let (t, depth) = (f64::from(t), sigma_t * (f64::from(t) + leg));
            if let Some((from, light_from, depth_from)) = before {
                let part = |c: usize| segment(light_from[c], arrived[c], depth_from[c], depth[c]);
                sum += (t - from) * sigma_s * DVec3::new(part(0), part(1), part(2));
            }
            before = Some((t, arrived, depth));
        }
        if let Some((_, arrived, depth)) = before {
            (kept.arrived, kept.depth) = (narrow(arrived), narrow(depth));
        }
    }
    let corners = data.triangles[hit.face as usize].map(|v| wide(data.normals_in_scene()[v as usize]));
    let weights = [1.0 - f64::from(hit.u) - f64::from(hit.v), hit.u.into(), hit.v.into()];
    let normal: DVec3 = corners.iter().zip(weights).map(|(&n, weight)| weight * n).sum();
    let eye = (wide(data.camera[0].origin) - wide(start)).normalize_or_zero();
    let eta = f64::from(medium.eta);
    (sum * transmittance(eta, normal.normalize_or_zero().dot(eye).abs()) / (eta * eta), kept)
}

fn cpu(state: &mut State, _at: Scope) {
    let data = &state.data;
    let scale = f64::from(data.camera[0].radiance);
    let of_pixel = |(hit, &before): (&Hit, &[f32; 3])| {
        let shows = |medium: &&ScatteringMedium| {
            hit.face < UNFINISHED && state.object_of(hit.face as usize) == medium.object as usize
        };
        let (mut sum, mut kept) = (wide(before), None);
        for medium in data.scattering_media.iter().filter(shows) {
            let (more, ray) = scattered(state, medium, hit);
            sum += scale * more;
            kept = Some(ray);
        }
        (narrow(sum), kept)
    };
    let found: Vec<([f32; 3], Option<InnerRay>)> = data.hits.par_iter().zip(&data.radiance).map(of_pixel).collect();
    // Groups of pixels take turns in the buffer of rays.
    for (pixel, (radiance, kept)) in found.into_iter().enumerate() {
        state.data.radiance[pixel] = radiance;
        if let Some(ray) = kept {
            state.data.inner_rays[pixel % RAYS] = ray;
        }
    }
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    let data = &pass.state.data;
    let pixels = data.radiance.len();
    let shadows = u32::from(data.object_params[0].shadow_words > 0);
    for first in (0..pixels).step_by(RAYS) {
        let last = pixels.min(first + RAYS);
        let range = [first as u32, last as u32];
        for medium in 0..data.scattering_media.len() as u32 {
            pass.dispatch(Some("refract"), &[], bytemuck::cast_slice(&[medium, range[0], range[1]]), last - first)?;
            for beam in 0..data.layer_lights.len() as u32 {
                for sample in 0..=SINGLE_STEPS {
                    let push = [medium, beam, sample, range[0], range[1]];
                    pass.dispatch(Some("march"), &[shadows], bytemuck::cast_slice(&push), last - first)?;
                }
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_half_space_is_its_integral() {
        // Along the refracted view ray, as equation 6 has it.
        for (eta, light, eye) in [(1.0, 0.5, 0.8), (1.3, 0.9, 0.2), (1.5, 0.1, 1.0), (0.8, 0.9, 0.8)] {
            let (sigma_s, sigma_t, p) = (2.0, 3.0, 0.1);
            let (mu_i, mu_o) = (inside(eta, light), inside(eta, eye));
            assert!(((1.0 - mu_i * mu_i) * eta * eta - (1.0 - light * light)).abs() < 1e-12, "Snell");
            let (steps, end) = (200_000, 12.0);
            let at = |k: u32| {
                let s = end * (f64::from(k) + 0.5) / f64::from(steps);
                sigma_s * p * transmittance(eta, light) * light / mu_i * (-sigma_t * (s + s * mu_o / mu_i)).exp()
            };
            let sum: f64 = (0..steps).map(at).sum::<f64>() * end / f64::from(steps);
            let expected = sum * transmittance(eta, eye) / (eta * eta);
            let found = half_space(sigma_s / sigma_t, eta, p, light, eye);
            assert!((found / expected - 1.0).abs() < 1e-6, "{eta}: {found}, {expected}");
        }
    }
}
