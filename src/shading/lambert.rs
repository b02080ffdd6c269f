//! Stage `lambert`: Lambert's cosine at each pixel, for comparison. It is stage `cdrf` with f = max(cos, 0).

use super::diffuse::{record, shade};
use crate::error::Result;
use crate::layout::BufferId;
use crate::state::{Carrier, Pass, Role, Scope, Stage, State, Tolerance, Update};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "lambert",
    about: "radiance of each pixel by Lambert's cosine (`--transport lambert`)",
    equation: "L = F_t k_d / pi max(cos, 0) E",
    writes: &[(BufferId::radiance, Role::Update, Tolerance::Float { relative: 2e-5, floor: 2e-5 })],
    reason: "a short chain of f32 operations; a cosine cancels where light grazes",
    carriers: &[Carrier::Lambert],
    runs: Update::picture,
    ..super::stage(cpu, gpu)
};

fn cpu(state: &mut State, _at: Scope) {
    shade(state, &|cosine, _| cosine.max(0.0), false);
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    record(pass, None, &[])
}
