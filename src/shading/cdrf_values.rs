//! Stage `cdrf_values`: single values of the CDRF's closed form, for checks of the kernel by `milkglass eval`.

use rayon::prelude::*;

use super::reflectance::cdrf;
use crate::error::Result;
use crate::layout::{BufferId, Query};
use crate::state::{Pass, Role, Scope, Stage, State, Tolerance};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "cdrf_values",
    module: "shading",
    about: "single values of the CDRF: a query's corner a is cosine and sigma",
    equation: "Kubo et al. 2010, equation 1",
    writes: &[(BufferId::answers, Role::Output, Tolerance::Float { relative: 0.0, floor: 1e-5 })],
    reason: "the device's closed form is within 6e-6 of the convolution, and rounds",
    ..Stage::new(cpu, gpu)
};

fn cpu(state: &mut State, _at: Scope) {
    let answer = |query: &Query| [cdrf(query.a[0].into(), query.a[1].into()) as f32, 0.0, 0.0];
    state.data.answers = state.data.queries.par_iter().map(answer).collect();
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    pass.dispatch(None, &[], &[], pass.state.data.queries.len())
}
