//! Stage `smooth_curvature`: kappa at each vertex from the curvature measures within `curvature_radius` (Cohen-Steiner
//! and Morvan 2003), so that it is the shape's curvature at the scale of the scattering, not that of the triangles.
//!
//! H = sum w_k int_k H / sum w_k A_k over the parts k of the surface, K likewise, with the weight w = (1 - d^2 / R^2)^2
//! max(n . n_k, 0): smooth, 0 from the radius R on, and 0 on the far side of a thin part, which faces away. Any weight
//! gives the exact curvature on a ball. A part is a cluster whose box has a diagonal of at most [`SMOOTHING_SHARE`] R,
//! or a triangle that is larger: so the work of a vertex is bounded, however fine the mesh, and since the parts are the
//! same for all vertices, kappa has no steps between them. d is the distance of the part's centroid.
//!
//! A vertex without a normal, or with nothing within the radius whose curvature is known, keeps the kappa of stage
//! `curvature`.

use glam::DVec3;
use rayon::prelude::*;

use super::curvature_sums::rough;
use crate::error::Result;
use crate::layout::{BufferId, Buffers, KAPPA_RMS, NONE, SMOOTHING_SHARE, SMOOTHING_STEPS};
use crate::state::{Granularity, Pass, Role, Scope, Stage, State, Tolerance, Update, wide};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "smooth_curvature",
    about: "kappa of each vertex from the curvature measures within a radius",
    equation: "Cohen-Steiner and Morvan 2003, section 4: curvature measures",
    writes: &[(BufferId::smooth_kappa, Role::Output, Tolerance::Float { relative: 1e-4, floor: 1e-4 })],
    reason: "sums of either sign cancel; where it is flat kappa is a root, which magnifies rounding",
    granularity: Granularity::Object,
    skip: rough,
    runs: Update::material,
    ..super::stage(cpu, gpu)
};

/// kappa of a vertex for shading: the smoothed one if the frame smooths it.
#[must_use]
pub fn kappa(data: &Buffers, vertex: usize) -> f32 {
    data.smooth_kappa.get(vertex).copied().unwrap_or_else(|| data.curvature[vertex].kappa)
}

/// The squared distance of a point from a box, and the square of the box's diagonal, rounded as on a device: both
/// decide which parts are summed.
fn squares(low: [f32; 3], high: [f32; 3], point: [f32; 3]) -> [f32; 2] {
    let square = |v: [f32; 3]| v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
    let off = |k: usize| (low[k] - point[k]).max(point[k] - high[k]).max(0.0);
    [square([off(0), off(1), off(2)]), square([high[0] - low[0], high[1] - low[1], high[2] - low[2]])]
}

/// kappa of a vertex of the only object.
fn smoothed(data: &Buffers, vertex: usize) -> f32 {
    let (params, rough_kappa) = (&data.object_params[0], data.curvature[vertex].kappa);
    let (radius, first) = (params.curvature_radius, params.first_vertex);
    let (normal, at) = (wide(data.normals[vertex]), data.positions[first as usize + vertex]);
    if radius == 0.0 || normal == DVec3::ZERO {
        return rough_kappa;
    }
    let (reach, small) = (radius * radius, (SMOOTHING_SHARE * radius) * (SMOOTHING_SHARE * radius));
    let mut sums = [0.0; 3];
    let (mut node, mut steps) = (0, 0);
    while node < data.topology.len() {
        let (place, bounds) = (data.topology[node], &data.bounds[node]);
        let [far, wide_box] = squares(bounds.low, bounds.high, at);
        steps += 1;
        let counts = far < reach;
        if counts && wide_box > small && place.face == NONE && steps < SMOOTHING_STEPS {
            node += 1;
            continue;
        }
        if counts {
            let (cluster, sum) = (&data.clusters[node], &data.curvature_sums[node]);
            let away = wide(cluster.center).distance(wide(at)) / f64::from(radius);
            let near = (1.0 - away * away).max(0.0).powi(2);
            let facing = normal.dot(wide(cluster.normal)).max(0.0) / f64::from(cluster.area.max(f32::MIN_POSITIVE));
            let part = [sum.area, sum.mean, sum.gaussian].map(f64::from);
            (0..3).for_each(|k| sums[k] += near * facing * part[k]);
        }
        node = place.skip as usize;
    }
    if sums[0] <= 0.0 {
        return rough_kappa;
    }
    let [mean, gaussian] = [sums[1] / sums[0], sums[2] / sums[0]];
    match params.kappa {
        KAPPA_RMS => (mean * mean + (mean * mean - gaussian).max(0.0)).sqrt() as f32,
        _ => mean.abs() as f32,
    }
}

fn cpu(state: &mut State, _at: Scope) {
    let data = &state.data;
    state.data.smooth_kappa = (0..data.curvature.len()).into_par_iter().map(|v| smoothed(data, v)).collect();
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    pass.dispatch(None, &[], &[], pass.object().count.vertices)
}
