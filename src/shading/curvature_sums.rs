//! Stage `curvature_sums`: the integrals of mean and Gaussian curvature over every cluster, for stage
//! `smooth_curvature`.
//!
//! The estimates of stage `curvature` are means over the mixed area around a vertex. Times that area they are measures:
//! the integral over a part of the surface is the sum over its vertices (Cohen-Steiner and Morvan 2003). The Gaussian
//! measure is the missing angle at the vertex; by the theorem of Gauss and Bonnet its sum depends on the boundary of
//! the part alone, whatever the noise inside. A vertex's measure is divided equally among its triangles.

use crate::error::Result;
use crate::layout::{BufferId, Buffers, CurvatureSum, NONE};
use crate::state::{Field, Granularity, Pass, Role, Scope, Stage, State, Tolerance};

/// Tolerances: of areas relative to themselves, of the integrals as shares of the extent (H) and of a full turn (K).
const FIELDS: &[Field] = &[
    Field { name: "area", relative: 5e-5, floor: 0.0, of: "" },
    Field { name: "mean", relative: 5e-5, floor: 1e-5, of: "" },
    Field { name: "gaussian", relative: 5e-5, floor: 2e-5, of: "" },
];

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "curvature_sums",
    about: "integrals of mean and Gaussian curvature over every cluster",
    equation: "Cohen-Steiner and Morvan 2003, section 4: curvature measures",
    writes: &[
        (BufferId::arrivals, Role::Update, Tolerance::Exact),
        (BufferId::curvature_sums, Role::Output, Tolerance::Fields(FIELDS)),
    ],
    reason: "sums climb some 40 levels of f32 rounding, and parts of either sign cancel",
    granularity: Granularity::Object,
    skip: rough,
    ..super::stage(cpu, gpu)
};

/// Why curvature is not smoothed, if it is not.
pub fn rough(state: &State) -> Option<&'static str> {
    let none = state.data.object_params.iter().all(|params| params.curvature_radius == 0.0);
    none.then_some("curvature is that of the triangles around a vertex: every curvature_radius is 0")
}

/// The share of a vertex's measures that each of its triangles takes: area, integral of H, integral of K. Vertices are
/// counted from the object's first.
fn part(data: &Buffers, vertex: usize) -> [f64; 3] {
    let bend = data.curvature[vertex];
    let triangles = f64::from(data.corner_starts[vertex + 1] - data.corner_starts[vertex]);
    [1.0, bend.mean, bend.gaussian].map(|mean| f64::from(mean) * f64::from(bend.area) / triangles)
}

fn cpu(state: &mut State, _at: Scope) {
    let data = &state.data;
    let first = data.object_params[0].first_vertex;
    let mut sums = vec![[0.0; 3]; data.topology.len()];
    // Children come after their parent, so one backward sweep sees them first.
    for (node, place) in data.topology.iter().enumerate().rev() {
        let below = match place.face {
            NONE => vec![sums[node + 1], sums[data.topology[node + 1].skip as usize]],
            face => data.triangles[face as usize].map(|v| part(data, (v - first) as usize)).to_vec(),
        };
        sums[node] = [0, 1, 2].map(|k| below.iter().map(|sum: &[f64; 3]| sum[k]).sum());
    }
    let record = |[area, mean, gaussian]: [f64; 3]| CurvatureSum {
        area: area as f32,
        mean: mean as f32,
        gaussian: gaussian as f32,
    };
    state.data.curvature_sums = sums.into_iter().map(record).collect();
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    pass.dispatch(Some("leaf"), &[], &[], pass.object().count.faces)?;
    pass.climb("cluster", &[])
}
