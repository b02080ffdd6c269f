//! Stage `opaque_faces`: radiosity of the faces of opaque objects, by Lambert's law.

use rayon::prelude::*;

use crate::error::Result;
use crate::layout::BufferId;
use crate::state::{Pass, Role, Scope, Serves, Stage, State, Tolerance, Update, narrow, wide};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "opaque_faces",
    about: "radiosity of opaque objects: albedo times irradiance",
    equation: "Lambert: B = albedo E",
    writes: &[(BufferId::radiosity, Role::Output, Tolerance::Float { relative: 2e-7, floor: 0.0 })],
    reason: "one product",
    serves: Serves {
        object: |object, _| object.opaque && object.lit_by_face(),
        none: "no opaque object is lit by triangle",
    },
    runs: Update::sums,
    ..super::stage(cpu, gpu)
};

fn cpu(state: &mut State, _at: Scope) {
    let data = &state.data;
    let albedo = wide(data.object_params[0].albedo);
    state.data.radiosity = data.irradiance.par_iter().map(|&light| narrow(albedo * wide(light))).collect();
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    pass.dispatch(None, &[], &[], pass.object().count.faces)
}
