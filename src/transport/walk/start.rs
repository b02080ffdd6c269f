//! How photons start: at a triangle, at a place on it, and in a direction inside, in step with
//! `glsl/transport/walk/random_walk/start.comp` and `entering.glsl`.

use super::exact::{about, inside, inverse, passes, random4, refracted, root, unit, unit_random};
use super::{blocks, sum64, total};
use crate::geometry::placement::{placed, turned};
use crate::geometry::trace::{cross, dot, minus};
use crate::layout::{
    Buffers, FAR_FROM_DENORMAL, LIGHT_AREA, LIGHT_AREA_BOTH, LIGHT_DIRECTIONAL, LIGHT_SKY_RAY, LIGHT_SPOT, Light, NONE,
    Photon, WALK_TRIES, WALK_WEIGHT, WalkBalance,
};
use crate::lighting::irradiance::reaches;

/// The unit normal of a triangle out of the medium.
pub(crate) fn normal([a, b, c]: [[f32; 3]; 3]) -> [f32; 3] {
    unit(cross(minus(b, a), minus(c, a)).map(|x| FAR_FROM_DENORMAL * x))
}

/// The triangle at this share of the light that enters, `place` / 2^32.
fn drawn(data: &Buffers, channel: usize, place: u32) -> usize {
    let light = (u128::from(total(data).sum(channel)) * u128::from(place)) >> 32;
    let below = data.entry_sums.partition_point(|sum| u128::from(sum.sum(channel)) <= light);
    below.min(data.entry_sums.len() - 1)
}

/// The share of a light's intensity in the unit direction `away` from it.
fn emitted(light: &Light, away: [f32; 3]) -> f32 {
    let (c, s) = (dot(light.axis, away), cross(light.axis, away));
    match light.kind {
        LIGHT_SPOT => {
            let beyond = dot(s, s) * inverse(1.0 + c.max(0.0));
            let t = ((light.outer - beyond) * inverse((light.outer - light.inner).max(1e-20))).clamp(0.0, 1.0);
            if c > 0.0 { t * t * (3.0 - 2.0 * t) } else { 0.0 }
        }
        LIGHT_AREA => c.max(0.0),
        LIGHT_AREA_BOTH => c.abs(),
        _ => 1.0,
    }
}

/// Light of one channel that enters at a triangle's centre from a light, and the unit direction towards that light; all
/// in the scene, the normal too.
pub(crate) fn entered(data: &Buffers, light: &Light, channel: usize, face: usize, normal: [f32; 3]) -> (f32, [f32; 3]) {
    let center = placed(&data.object_params[0], data.clusters[data.leaves[face] as usize].center);
    let far = light.kind == LIGHT_DIRECTIONAL || light.kind == LIGHT_SKY_RAY;
    let apart = minus(light.place, center);
    let toward = if far { light.place } else { unit(apart) };
    let falls = if far { 1.0 } else { emitted(light, toward.map(|x| -x)) * inverse(dot(apart, apart).max(1e-30)) };
    let cosine = dot(normal, toward).max(0.0);
    let eta = data.object_params[0].eta[channel];
    let share = passes(eta, cosine, inside(eta, cosine));
    let sum = light.color[channel] * falls * (cosine * share);
    let counts = light.kind != LIGHT_SKY_RAY && reaches(data, light, face);
    (if counts { sum } else { 0.0 }, toward)
}

/// The unit direction inside of a photon that enters a triangle, in the object's own frame. The lights are drawn in
/// proportion to what enters from each; irradiance that none of them explains is the environment's, and comes evenly
/// from all directions.
fn entry(data: &Buffers, channel: usize, face: usize, normal: [f32; 3], number: u32, random: u32) -> [f32; 3] {
    let (params, eta) = (&data.object_params[0], data.object_params[0].eta[channel]);
    let out = turned(params, normal);
    let each: Vec<(f32, [f32; 3])> = data.lights.iter().map(|light| entered(data, light, channel, face, out)).collect();
    let direct = each.iter().fold(0.0, |sum, one| sum + one.0);
    let sky = if data.sky.is_empty() { 0.0 } else { (data.irradiance[face][channel] - direct).max(0.0) };
    let pick = unit_random(random) * (direct + sky);
    let (mut before, mut found, mut from) = (0.0, false, normal);
    for (one, toward) in each.into_iter().filter(|one| one.0 > 0.0) {
        if !found {
            let [x, y, z] = toward;
            from = std::array::from_fn(|k| x * params.turn_x[k] + y * params.turn_y[k] + z * params.turn_z[k]);
        }
        found |= pick < before + one;
        before += one;
    }
    if !found && sky > 0.0 {
        for tries in 0..WALK_TRIES {
            let more = random4(number, NONE - tries, channel as u32, data.walk_params[0].seed);
            let cosine = root(unit_random(more[0]));
            if unit_random(more[1]) < passes(eta, cosine, inside(eta, cosine)) || tries + 1 == WALK_TRIES {
                from = about(normal, cosine, unit_random(more[2]));
                break;
            }
        }
    }
    refracted(eta, from, normal)
}

/// Starts the next photon of a slot, if none is under way and one is left.
pub(super) fn start(data: &Buffers, slot: u32, photon: &mut Photon, balance: &mut WalkBalance) {
    let (params, channel) = (&data.walk_params[0], slot % 3);
    let number = slot / 3 + photon.started * (params.slots / 3);
    let light = data.entry_blocks[blocks(data.triangles.len())].sum(channel as usize) > 0;
    if photon.weight != 0 || number >= params.photons || !light {
        return;
    }
    let random = random4(number, 0, channel, params.seed);
    let face = drawn(data, channel as usize, random[0]);
    let corners = data.triangles[face].map(|v| data.positions[v as usize]);
    let [a, b, c] = corners;
    let (b, c) = (minus(b, a), minus(c, a));

    // Drawn evenly over the parallelogram, whose other half is folded back.
    let (u, v) = (unit_random(random[1]), unit_random(random[2]));
    let (across, up) = if u + v > 1.0 { (1.0 - u, 1.0 - v) } else { (u, v) };
    *photon = Photon {
        place: std::array::from_fn(|k| a[k] + (across * b[k] + up * c[k])),
        way: entry(data, channel as usize, face, normal(corners), number, random[3]),
        weight: WALK_WEIGHT,
        face: face as u32,
        number,
        flights: 0,
        collisions: 0,
        started: photon.started + 1,
    };
    balance.entered = super::words64(sum64(balance.entered) + u64::from(WALK_WEIGHT));
}
