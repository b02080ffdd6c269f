//! Stage `accumulate`: the mean of a pixel's samples so far. Each sample is a frame with its rays through another point
//! of the pixels.

use rayon::prelude::*;

use crate::error::Result;
use crate::layout::BufferId;
use crate::state::{Pass, Role, Scope, Size, Stage, State, Tolerance, narrow, wide};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "accumulate",
    about: "mean radiance over the samples of each pixel",
    equation: "mean += (radiance - mean) / number of samples so far",
    writes: &[(BufferId::mean, Role::Update, Tolerance::Float { relative: 5e-7, floor: 2e-7 })],
    reason: "three f32 operations",
    sizes: &[(BufferId::mean, Size::Elements(State::pixels))],
    skip,
    ..super::stage(cpu, gpu)
};

fn skip(state: &State) -> Option<&'static str> {
    let one = state.data.camera.iter().all(|camera| camera.samples == 1);
    one.then_some("there is one sample a pixel")
}

fn cpu(state: &mut State, _at: Scope) {
    let data = &mut state.data;
    let weight = f64::from(data.camera[0].weight);
    data.mean.par_iter_mut().zip(&data.radiance).for_each(|(mean, sample)| {
        *mean = if weight == 1.0 { *sample } else { narrow(wide(*mean).lerp(wide(*sample), weight)) };
    });
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    pass.dispatch(None, &[], &[], pass.state.data.radiance.len())
}
