//! Stage `push_links`: a face's radiosity B is the sum of the light gathered at its leaf and at every cluster above it
//! (section 3.2).

use rayon::prelude::*;

use crate::error::Result;
use crate::layout::{BufferId, NONE};
use crate::state::{Pass, Role, Scope, Stage, State, Tolerance, narrow, wide};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "push_links",
    about: "radiosity of each face: its own sum plus those of the clusters above it",
    equation: "Mertens et al. 2003, section 3.2",
    writes: &[(BufferId::radiosity, Role::Output, Tolerance::Float { relative: 5e-6, floor: 1e-7 })],
    reason: "a sum of some 40 non-negative terms",
    ..super::stage(cpu, gpu)
};

fn cpu(state: &mut State, _at: Scope) {
    let data = &mut state.data;
    data.radiosity = data
        .leaves
        .par_iter()
        .map(|&leaf| {
            let up = |&node: &u32| Some(data.topology[node as usize].parent).filter(|&parent| parent != NONE);
            narrow(std::iter::successors(Some(leaf), up).map(|node| wide(data.gathered[node as usize])).sum())
        })
        .collect();
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    pass.dispatch(None, &[], &[], pass.object().count.faces)
}
