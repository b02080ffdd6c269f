//! Stage `average`: radiosity at the vertices, for Gouraud interpolation (section 3.2).

use rayon::prelude::*;

use crate::error::Result;
use crate::layout::BufferId;
use crate::state::{Need, Pass, Role, Scope, Serves, Stage, State, Tolerance, narrow, wide};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "average",
    about: "radiosity of each vertex: area-weighted mean over the faces around it",
    equation: "Mertens et al. 2003, section 3.2",
    writes: &[(BufferId::vertex_radiosity, Role::Output, Tolerance::Float { relative: 5e-6, floor: 1e-7 })],
    reason: "a short weighted mean of non-negative terms",
    needs: &[Need::Light, Need::Picture],
    serves: Serves {
        object: |object, method| (Serves::LIT_BY_FACE.object)(object, method) && !object.by_pixel,
        none: "the receivers are the points that pixels show",
    },
    ..super::stage(cpu, gpu)
};

fn cpu(state: &mut State, _at: Scope) {
    let data = &mut state.data;
    data.vertex_radiosity = (0..data.corner_starts.len() - 1)
        .into_par_iter()
        .map(|v| {
            let round = &data.corners[data.corner_starts[v] as usize..data.corner_starts[v + 1] as usize];
            let area = |&face: &u32| f64::from(data.clusters[data.leaves[face as usize] as usize].area);
            // 0 times infinity is no number: a triangle without area has no part in the mean, however bright.
            let faces = round.iter().filter(|face| area(face) > 0.0);
            let sum: glam::DVec3 = faces.map(|f| area(f) * wide(data.radiosity[*f as usize])).sum();
            let whole: f64 = round.iter().map(area).sum();
            if whole > 0.0 { narrow(sum / whole) } else { [0.0; 3] }
        })
        .collect();
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    pass.dispatch(None, &[], &[], pass.object().count.vertices)
}
