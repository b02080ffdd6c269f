//! Stage `cdrf`: radiance of each pixel by the curvature-dependent reflectance function, in closed form or from its
//! table.
//!
//! Closed form on a device: from sigma = 0.32 on, a cosine series of five terms; below it, a damped Lambert cosine,
//! and near the terminator a Gaussian times a polynomial of ten terms, fitted to the convolution. Both are within
//! 6e-6 of the convolution.

use super::cdrf_cells::lookup;
use super::diffuse::{record, shade};
use super::reflectance::cdrf;
use crate::error::Result;
use crate::layout::BufferId;
use crate::state::{Local, Pass, Role, Scope, Stage, State, Tolerance, Update};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "cdrf",
    about: "radiance of each pixel by light, normal and curvature there (`--transport cdrf`)",
    equation: "Kubo et al. 2010, equations 1, 4, 5",
    writes: &[(BufferId::radiance, Role::Update, Tolerance::Float { relative: 3e-5, floor: 3e-5 })],
    reason: "the closed form is within 6e-6 of the convolution, whose largest value is 1",
    runs: Update::picture,
    ..super::stage(cpu, gpu)
};

fn cpu(state: &mut State, _at: Scope) {
    match state.method.local {
        Some(Local::Table(side)) => {
            let cells = std::mem::take(&mut state.data.cdrf_cells);
            shade(state, &|cosine, sigma| lookup(&cells, side, cosine, sigma), true);
            state.data.cdrf_cells = cells;
        }
        _ => shade(state, &cdrf, true),
    }
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    let mapped = u32::from(pass.state.data.object_params.iter().any(|params| params.sigma_0_size != [0; 2]));
    match pass.state.method.local {
        Some(Local::Table(side)) => record(pass, Some("table"), &[mapped, side]),
        _ => record(pass, Some("closed"), &[mapped]),
    }
}
