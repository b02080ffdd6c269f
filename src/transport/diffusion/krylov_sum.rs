//! Stage `krylov_sum`: the solution in the basis, by back substitution, and radiosity, which is nowhere negative.
//!
//! The residual r = b - M B is the last entry of the rotated right-hand side, rotated back. The error e solves M e = r,
//! so that e = 2 (r - K e), with K the integral over the surface: twice the local residual, and a smooth rest of the
//! size of the mean. The estimate is twice |r|, four times its mean, and the error that clusters may add; it was above
//! the error at 98 % of the triangles or more, on four shapes solved densely in `f64` at 1e-2, 1e-3 and 1e-4.

use crate::error::Result;
use crate::layout::{
    BufferId, Buffers, CLUSTER_SHARE, MOST_STEPS, RESIDUAL_SPREAD, SMALL_COEFFICIENTS, SMALL_COSINES, SMALL_MATRIX,
    SMALL_NORMS, SMALL_RESIDUAL, SMALL_RIGHT, SMALL_SINES,
};
use crate::state::{Pass, Role, Scope, Stage, State, Tolerance};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "krylov_sum",
    about: "the solution: coefficients by back substitution, then the sum of the basis; radiosity",
    equation: "R y = g, B = B_0 + sum y_k v_k",
    writes: &[
        (BufferId::small_system, Role::Update, Tolerance::Float { relative: 1e-4, floor: 1e-5 }),
        (BufferId::solution, Role::Update, Tolerance::Float { relative: 1e-4, floor: 1e-5 }),
        (BufferId::radiosity, Role::Output, Tolerance::Float { relative: 1e-4, floor: 1e-5 }),
        (BufferId::estimate, Role::Update, Tolerance::Float { relative: 1e-3, floor: 1e-5 }),
    ],
    reason: "sums of at most 30 terms",
    ..super::stage(cpu, gpu)
};

/// How many steps were taken: the scope's number, or, where that is 0, the method's.
fn taken(state: &State, at: Scope) -> usize {
    if at.chunk > 0 { at.chunk } else { state.method.steps as usize }
}

fn cpu(state: &mut State, at: Scope) {
    let (steps, warm, estimated) = (taken(state, at), state.method.warm, state.method.estimate);
    let data = &mut state.data;
    let faces = data.triangles.len();
    for c in 0..3 {
        let mut y = vec![0.0; steps];
        for k in (0..steps).rev() {
            let at = |j: usize| f64::from(data.small_system[SMALL_MATRIX + j * (MOST_STEPS + 1) + k][c]);
            let rest: f64 = (k + 1..steps).map(|j| at(j) * y[j]).sum();
            let right = f64::from(data.small_system[SMALL_RIGHT + k][c]);
            y[k] = if at(k) > 1e-30 { (right - rest) / at(k) } else { 0.0 };
        }
        let left = residual(data, steps, c);
        let [source, mean] = [SMALL_NORMS, SMALL_NORMS + 1].map(|place| f64::from(data.small_system[place][c]));
        let error = f64::from(CLUSTER_SHARE) * f64::from(data.object_params[0].link_error);
        for face in 0..faces {
            let start = if warm { f64::from(data.solution[face][c]) } else { 0.0 };
            let value = (0..steps).map(|k| y[k] * f64::from(data.krylov[k * faces + face][c])).sum::<f64>() + start;
            data.solution[face][c] = value as f32;
            data.radiosity[face][c] = value.max(0.0) as f32;
            if estimated {
                let own: f64 =
                    left.iter().enumerate().map(|(k, z)| z * f64::from(data.krylov[k * faces + face][c])).sum();
                let clusters = error * (value.abs() + source);
                data.estimate[face][c] = (2.0 * own.abs() + f64::from(RESIDUAL_SPREAD) * mean + clusters) as f32;
            }
        }
        for (k, y) in y.into_iter().enumerate() {
            data.small_system[SMALL_COEFFICIENTS + k][c] = y as f32;
        }
        for (k, z) in left.into_iter().enumerate() {
            data.small_system[SMALL_RESIDUAL + k][c] = z as f32;
        }
    }
}

/// The residual's coefficients after this many steps: the last entry of the right-hand side, rotated back.
fn residual(data: &Buffers, steps: usize, c: usize) -> Vec<f64> {
    let at = |place: usize| f64::from(data.small_system[place][c]);
    let (mut carried, mut left) = (at(SMALL_RIGHT + steps), vec![0.0; steps + 1]);
    for k in (0..steps).rev() {
        left[k + 1] = at(SMALL_COSINES + k) * carried;
        carried *= -at(SMALL_SINES + k);
    }
    left[0] = carried;
    left
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    let (steps, faces) = (taken(pass.state, pass.at) as u32, pass.object().count.faces);
    let push = bytemuck::bytes_of(&steps).to_vec();
    pass.dispatch(Some("coefficients"), &[], &push, 1)?;
    let uses = [u32::from(pass.state.method.warm), u32::from(pass.state.method.estimate)];
    pass.dispatch(Some("add"), &uses, &push, faces)
}
