//! Stage `backdrop`: the environment and its sun, where a pixel's ray hits nothing.

use std::f64::consts::PI;

use glam::DVec3;
use rayon::prelude::*;

use super::visibility::ray;
use crate::error::Result;
use crate::layout::{BufferId, Buffers, LIGHT_DIRECTIONAL, Light};
use crate::lighting::sky;
use crate::state::{Pass, Role, Scope, Stage, State, Tolerance, narrow, wide};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "backdrop",
    about: "radiance of pixels that show no object: the environment's image, linear between pixels",
    equation: "the image's latitude and longitude",
    writes: &[(BufferId::radiance, Role::Update, Tolerance::Float { relative: 2e-5, floor: 2e-5 })],
    reason: "a place in the image is an angle in f32, off by some 4e-7, times its pixels per radian and their contrast",
    skip,
    ..super::stage(cpu, gpu)
};

fn skip(state: &State) -> Option<&'static str> {
    if state.data.camera.iter().all(|camera| camera.environment == 0) {
        return Some("the background is a colour");
    }
    state.data.sky.is_empty().then_some("the environment is black")
}

/// The sun of the environment; one of no size if there is none.
fn sun(data: &Buffers) -> Light {
    let sun = |light: &&Light| light.kind == LIGHT_DIRECTIONAL && light.outer > 0.0;
    data.lights.iter().find(sun).copied().unwrap_or_default()
}

/// What a sun adds in a direction: a disc, brightest in the middle, so that its edge is soft.
fn disc(sun: &Light, direction: DVec3) -> DVec3 {
    let (off, outer) = ((direction.normalize_or_zero() - wide(sun.place)).length_squared() / 2.0, f64::from(sun.outer));
    if off < outer { wide(sun.color) * ((1.0 - off / outer) / (PI * outer)) } else { DVec3::ZERO }
}

fn cpu(state: &mut State, _at: Scope) {
    let data = &state.data;
    let camera = data.camera[0];
    let sun = sun(data);
    let pixel = |(pixel, hit): (usize, &crate::layout::Hit)| match data.triangles.get(hit.face as usize) {
        Some(_) => data.radiance[pixel],
        None => {
            let direction = wide(ray(&camera, pixel as u32));
            narrow((sky::radiance(data, direction) + disc(&sun, direction)) * f64::from(camera.radiance))
        }
    };
    state.data.radiance = data.hits.par_iter().enumerate().map(|(k, hit)| pixel((k, hit))).collect();
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    let data = &pass.state.data;
    let (sun, pixels) = (sun(data), data.radiance.len());
    pass.dispatch(None, &[], bytemuck::bytes_of(&sun), pixels)
}
