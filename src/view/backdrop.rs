//! Stage `backdrop`: the environment, where a pixel's ray hits nothing.

use rayon::prelude::*;

use super::visibility::ray;
use crate::error::Result;
use crate::layout::BufferId;
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

fn cpu(state: &mut State, _at: Scope) {
    let data = &state.data;
    let camera = data.camera[0];
    let pixel = |(pixel, hit): (usize, &crate::layout::Hit)| match data.triangles.get(hit.face as usize) {
        Some(_) => data.radiance[pixel],
        None => narrow(sky::radiance(data, wide(ray(&camera, pixel as u32))) * f64::from(camera.radiance)),
    };
    state.data.radiance = data.hits.par_iter().enumerate().map(|(k, hit)| pixel((k, hit))).collect();
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    pass.dispatch(None, &[], &[], pass.state.data.radiance.len())
}
