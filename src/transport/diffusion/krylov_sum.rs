//! Stage `krylov_sum`: the solution in the basis, by back substitution, and radiosity, which is nowhere negative.

use crate::error::Result;
use crate::layout::{BufferId, MOST_STEPS, SMALL_COEFFICIENTS, SMALL_MATRIX, SMALL_RIGHT};
use crate::state::{
    Carrier, Granularity, Need, Pass, Role, Scope, Serves, Stage, State, Tolerance, Update, stage::never,
};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "krylov_sum",
    module: "transport/diffusion",
    about: "the solution: coefficients by back substitution, then the sum of the basis; radiosity",
    equation: "R y = g, B = B_0 + sum y_k v_k",
    writes: &[
        (BufferId::small_system, Role::Update, Tolerance::Float { relative: 1e-4, floor: 1e-5 }),
        (BufferId::solution, Role::Update, Tolerance::Float { relative: 1e-4, floor: 1e-5 }),
        (BufferId::radiosity, Role::Output, Tolerance::Float { relative: 1e-4, floor: 1e-5 }),
    ],
    reason: "sums of at most 30 terms",
    sizes: &[],
    granularity: Granularity::Object,
    carriers: &[Carrier::Diffusion],
    needs: &[Need::Light],
    serves: Serves::TRANSLUCENT,
    skip: never,
    runs: Update::sums,
    cpu,
    gpu,
};

/// How many steps were taken: as many as the scope says, or, where it does not, all.
fn taken(state: &State, at: Scope) -> usize {
    if at.chunk > 0 { at.chunk } else { state.method.steps as usize }
}

fn cpu(state: &mut State, at: Scope) {
    let (steps, warm) = (taken(state, at), state.method.warm);
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
        for face in 0..faces {
            let start = if warm { f64::from(data.solution[face][c]) } else { 0.0 };
            let value = (0..steps).map(|k| y[k] * f64::from(data.krylov[k * faces + face][c])).sum::<f64>() + start;
            data.solution[face][c] = value as f32;
            data.radiosity[face][c] = value.max(0.0) as f32;
        }
        for (k, y) in y.into_iter().enumerate() {
            data.small_system[SMALL_COEFFICIENTS + k][c] = y as f32;
        }
    }
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    let (steps, faces) = (taken(pass.state, pass.at) as u32, pass.object().count.faces);
    let push = bytemuck::bytes_of(&steps).to_vec();
    pass.dispatch(Some("coefficients"), &[], &push, 1)?;
    pass.dispatch(Some("add"), &[u32::from(pass.state.method.warm)], &push, faces)
}
