//! Stage `exit_radiosity`: each triangle's radiosity, and its standard error, from the weights of the photons that left
//! through it.
//!
//! A photon leaves through at most one triangle, once. So the squares of the weights w that left through a triangle
//! give the variance of their sum without batches: sum w^2 - (sum w)^2 / N, for N photons.

use rayon::prelude::*;

use super::total;
use crate::error::Result;
use crate::layout::BufferId;
use crate::state::{Pass, Role, Scope, Stage, State, Tolerance};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "exit_radiosity",
    about: "radiosity of each triangle and its standard error from the photons that left through it",
    equation: "the mean of independent photons, and its variance",
    writes: &[
        (BufferId::radiosity, Role::Output, Tolerance::Float { relative: 2e-6, floor: 1e-9 }),
        (BufferId::walk_noise, Role::Output, Tolerance::Float { relative: 2e-5, floor: 1e-6 }),
    ],
    reason: "a few products and quotients; where a large share of all photons leaves through one triangle, the variance \
             is a difference",
    ..super::stage(cpu, gpu)
};

fn cpu(state: &mut State, _at: Scope) {
    let data = &mut state.data;
    let (total, photons) = (total(data), f64::from(data.walk_params[0].photons.max(1)));
    let of_face = |face: usize| {
        let area = f64::from(data.clusters[data.leaves[face] as usize].area);
        let of_channel = |c: usize| {
            let [left, squares] = data.exits[face].moments(c);
            let light = if area > 0.0 { total.light(c) / photons / area } else { 0.0 };
            [light * left, light * (squares - left * left / photons).max(0.0).sqrt()].map(|x| x as f32)
        };
        [0, 1, 2].map(of_channel)
    };
    let rows: Vec<[[f32; 2]; 3]> = (0..data.triangles.len()).into_par_iter().map(of_face).collect();
    (data.radiosity, data.walk_noise) = rows.iter().map(|row| (row.map(|x| x[0]), row.map(|x| x[1]))).unzip();
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    pass.dispatch(None, &[], &[], pass.object().count.faces)
}
