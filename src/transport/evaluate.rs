//! Stage `evaluate`: single form factors and profile values, so that users can check the kernels.

use glam::DVec3;
use rayon::prelude::*;

use crate::dipole::form_factor::Distance;
use crate::dipole::form_factor::exact::edge_form_exact;
use crate::dipole::profile::Dipole;
use crate::error::Result;
use crate::layout::BufferId;
use crate::state::{Pass, Role, Scope, Stage, State, Tolerance, wide};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "evaluate",
    module: "transport",
    about: "single form factors, radial and with displaced sources, and values of the profile",
    equation: "Mertens et al. 2003, Table 1 and equation 7",
    writes: &[(BufferId::answers, Role::Output, Tolerance::Float { relative: 1e-4, floor: 1e-5 })],
    reason: "twelve nodes an edge against graded quadrature in f64; edges of a thin triangle cancel, and those of a \
             far one, which takes one sample with its second moment instead",
    ..Stage::new(cpu, gpu)
};

fn cpu(state: &mut State, _at: Scope) {
    let answer = |query: &crate::layout::Query| {
        let triangle = [query.a, query.b, query.c].map(wide);
        let dipole = Dipole {
            strength: query.strength.into(),
            sigma: query.sigma.into(),
            z_real: query.z_real.into(),
            z_virtual: query.z_virtual.into(),
        };
        let form = |distance| edge_form_exact(&triangle, [0, 1, 2], DVec3::ZERO, &dipole, distance) as f32;
        let profile = dipole.radial(wide(query.a).length_squared()) as f32;
        [form(Distance::Radial), form(Distance::Table1 { clamp: false }), profile]
    };
    state.data.answers = state.data.queries.par_iter().map(answer).collect();
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    pass.dispatch(None, &[], &[], pass.state.data.queries.len())
}
