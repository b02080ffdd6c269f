//! Stage `deposit`: where the light that enters each triangle collides first. It flies in the refracted direction w, a
//! mean free path L on average, unless it leaves at the far side: over a thickness of tau L along w, the share
//! 1 - e^-tau collides, at l = L (1 - tau / (e^tau - 1)) on average. With several lights the place is the mean of their
//! places, weighted by the light that enters from each. The environment's light, from all around, goes along -n, by its
//! mean depth.

use glam::DVec3;
use rayon::prelude::*;

use crate::error::Result;
use crate::geometry::placement::turned;
use crate::layout::{BufferId, Buffers, Deposit};
use crate::state::{Pass, Role, Scope, Stage, State, Tolerance, Update, narrow, wide};
use crate::transport::walk::exact::refracted;
use crate::transport::walk::hit::{Meeting, meeting};
use crate::transport::walk::start::{entered, normal};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "deposit",
    about: "where the light that enters each triangle is scattered first, and how much of it",
    equation: "weight = alpha' (1 - e^-tau), l = L (1 - tau / (e^tau - 1)), tau: thickness along the refracted ray over L",
    writes: &[(BufferId::deposits, Role::Output, Tolerance::Float { relative: 1e-4, floor: 1e-6 })],
    reason: "one exponential; rays and their directions are found by additions, multiplications and comparisons",
    runs: Update::transport,
    ..super::stage(cpu, gpu)
};

/// The share of light that collides over a thickness of `tau` mean free paths, and the mean depth of its collisions, in
/// mean free paths.
fn collides(tau: f64) -> [f64; 2] {
    let deep = if tau < 1e-3 { 0.5 * tau - tau * tau / 12.0 } else { 1.0 - tau / tau.exp_m1() };
    [-(-tau).exp_m1(), deep]
}

/// The distance through the object from a triangle's centroid; infinite where no way out is found.
fn thickness(data: &Buffers, face: usize, center: [f32; 3], way: [f32; 3]) -> f64 {
    let Meeting::At(out, weights) = meeting(data, center, way, BEYOND, face as u32) else { return f64::INFINITY };
    let corners = data.triangles[out].map(|v| wide(data.positions[v as usize]));
    let weights = weights.map(f64::from);
    let sum: f64 = weights.iter().sum();
    let place: DVec3 = corners.iter().zip(weights).map(|(corner, weight)| *corner * weight).sum::<DVec3>() / sum;
    (place - wide(center)).dot(wide(way)).max(0.0)
}

/// Farther than any object is wide.
const BEYOND: f32 = 8.0;

/// The deposit of one triangle in one channel: its light, and the vector from the centroid to its place.
fn of_face(data: &Buffers, face: usize, c: usize) -> (f64, DVec3) {
    let params = &data.object_params[0];
    let center = data.clusters[data.leaves[face] as usize].center;
    let inward = normal(data.triangles[face].map(|v| data.positions[v as usize]));
    let out = turned(params, inward);
    let albedo = 4.0 * std::f64::consts::PI * f64::from(params.strength[c]);
    let (mut all, mut light, mut place) = (0.0, 0.0, DVec3::ZERO);
    let mut add = |one: f64, way: [f32; 3], path: f64| {
        let tau = thickness(data, face, center, way) / path.max(1e-30);
        let [share, deep] = collides(tau.min(80.0));
        light += one * share;
        place += one * share * path * deep * wide(way);
    };
    for record in &data.lights {
        let (one, [x, y, z]) = entered(data, record, c, face, out);
        if one > 0.0 {
            let toward = std::array::from_fn(|k| x * params.turn_x[k] + y * params.turn_y[k] + z * params.turn_z[k]);
            all += f64::from(one);
            add(f64::from(one), refracted(params.eta[c], toward, inward), f64::from(params.z_real[c]));
        }
    }
    let irradiance = f64::from(data.irradiance[face][c]);
    let sky = if data.sky.is_empty() { 0.0 } else { (irradiance - all).max(0.0) };
    if sky > 0.0 {
        add(sky, inward.map(|x| -x), f64::from(params.sky_depth[c]));
    }
    let whole = all + sky;
    if !(light > 0.0 && whole > 0.0) {
        return (0.0, DVec3::ZERO);
    }
    // A texture at the entry dims all lights alike.
    (albedo * irradiance * light / whole, place / light)
}

fn cpu(state: &mut State, _at: Scope) {
    let data = &state.data;
    let deposit = |face: usize| {
        let [red, green, blue] = [0, 1, 2].map(|c| of_face(data, face, c));
        Deposit {
            red: narrow(red.1),
            green: narrow(green.1),
            blue: narrow(blue.1),
            light: [red.0 as f32, green.0 as f32, blue.0 as f32],
        }
    };
    let deposits: Vec<Deposit> = (0..data.triangles.len()).into_par_iter().map(deposit).collect();
    state.data.deposits = deposits;
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    let data = &pass.state.data;
    let uses = [u32::from(data.object_params[0].shadow_words > 0), u32::from(!data.sky.is_empty())];
    pass.dispatch(None, &uses, &[], pass.object().count.faces)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn light_collides_where_it_should() {
        // Thick: all of it, a mean free path deep. Thin: as much as it is thick, in the middle.
        assert_eq!(collides(80.0), [1.0, 1.0]);
        for tau in [1e-9, 1e-4, 9.99e-4, 1.001e-3, 0.3, 2.0, 9.0] {
            let [share, deep] = collides(tau);
            // The integrals of e^-t and t e^-t by the midpoint rule.
            let t = |k: usize| (k as f64 + 0.5) * tau / 1e4;
            let sum: f64 = (0..10_000).map(|k| (-t(k)).exp() * tau / 1e4).sum();
            let first: f64 = (0..10_000).map(|k| t(k) * (-t(k)).exp() * tau / 1e4).sum();
            assert!((share / sum - 1.0).abs() < 1e-6 && (deep / (first / sum) - 1.0).abs() < 1e-6, "{tau}");
        }
    }
}
