//! Stage `curvature`: mean and Gaussian curvature at each vertex, from the triangles around it (Meyer et al. 2003).
//!
//! With the mixed area A (a triangle's Voronoi part, or a half or a quarter of an obtuse one), H n = sum over the
//! edges of (cot a + cot b) (x - y) / (4 A), of which the component along the vertex normal is taken, and K = (2 pi -
//! sum of the angles) / A. Outward is positive: a ball of radius r has H = 1 / r.
//!
//! Where the triangles do not close around a vertex (an open edge, or parts that touch there) neither formula holds:
//! the vertex takes the mean over its triangles' corners with a curvature of their own, or 0. A vertex without
//! triangles, or with degenerate triangles only, is flat. Cotangents are clamped to 100 (angles of 0.6 degrees), H to
//! 1e4 and K to 1e8 in internal units, so that a needle's tip stays finite.

use std::f64::consts::TAU;

use glam::DVec3;
use rayon::prelude::*;

use crate::error::Result;
use crate::layout::{
    BufferId, Buffers, Curvature, FLAT_TRIANGLE, KAPPA_RMS, LEAST_MIXED_AREA, MOST_COTANGENT, MOST_CURVATURE,
};
use crate::state::{Field, Granularity, Pass, Role, Scope, Stage, State, Tolerance, wide};

/// Tolerances: of kappa and H as a share of kappa, of K as a share of its square.
const FIELDS: &[Field] = &[
    Field { name: "kappa", relative: 1e-3, floor: 1e-3, of: "" },
    Field { name: "mean", relative: 1e-3, floor: 1e-3, of: "" },
    Field { name: "gaussian", relative: 1e-3, floor: 1e-2, of: "" },
    Field { name: "area", relative: 1e-4, floor: 0.0, of: "" },
];

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "curvature",
    about: "mean and Gaussian curvature of each vertex, and kappa",
    equation: "Meyer et al. 2003, equations 8 to 10",
    writes: &[(BufferId::curvature, Role::Output, Tolerance::Fields(FIELDS))],
    reason: "sums that cancel: roundings of an edge, 2^-24, over its length squared; angles of 2e-7 over the area",
    granularity: Granularity::Object,
    ..super::stage(cpu, gpu)
};

/// Sums over the triangles around a vertex.
struct Ring {
    /// The next corner and the previous corner in each triangle.
    rim: [Vec<u32>; 2],
    /// The mixed area.
    area: f64,
    /// The sum of (cot a + cot b) (x - y).
    pull: DVec3,
    /// The sum of the angles.
    angle: f64,
}

/// The corners of a triangle, rotated so that `vertex` is the first.
fn turned(triangle: [u32; 3], vertex: u32) -> [u32; 3] {
    let [a, b, c] = triangle;
    if a == vertex {
        [a, b, c]
    } else if b == vertex {
        [b, c, a]
    } else {
        [c, a, b]
    }
}

/// The triangles around a vertex of the first object; their corners are numbered among the vertices of all objects.
fn around(data: &Buffers, vertex: usize) -> impl Iterator<Item = [u32; 3]> + '_ {
    let own = data.object_params[0].first_vertex + vertex as u32;
    let faces = &data.corners[data.corner_starts[vertex] as usize..data.corner_starts[vertex + 1] as usize];
    faces.iter().map(move |&face| turned(data.triangles[face as usize], own))
}

fn ring(data: &Buffers, vertex: usize) -> Ring {
    let mut ring = Ring { rim: [Vec::new(), Vec::new()], area: 0.0, pull: DVec3::ZERO, angle: 0.0 };
    for corners in around(data, vertex) {
        ring.rim[0].push(corners[1]);
        ring.rim[1].push(corners[2]);
        let [a, b, c] = corners.map(|v| wide(data.positions[v as usize]));
        if !whole(corners.map(|v| data.positions[v as usize])) {
            continue;
        }
        let double = (b - a).cross(c - a).length();
        let cosines = [(b - a).dot(c - a), (a - b).dot(c - b), (a - c).dot(b - c)];
        let cotangent = cosines.map(|cosine| (cosine / double).clamp(-MOST_COTANGENT, MOST_COTANGENT));
        ring.pull += cotangent[2] * (a - b) + cotangent[1] * (a - c);
        ring.angle += double.atan2(cosines[0]);
        ring.area += if cosines[0] < 0.0 {
            double / 4.0
        } else if cosines[1] < 0.0 || cosines[2] < 0.0 {
            double / 8.0
        } else {
            ((b - a).length_squared() * cotangent[2] + (c - a).length_squared() * cotangent[1]) / 8.0
        };
    }
    ring
}

/// Whether a triangle has an area in `f32`, as on a device: its squared cross product is above [`FLAT_TRIANGLE`].
fn whole([a, b, c]: [[f32; 3]; 3]) -> bool {
    let edge = |end: [f32; 3]| -> [f32; 3] { std::array::from_fn(|k| end[k] - a[k]) };
    let (u, w) = (edge(b), edge(c));
    let n = [u[1] * w[2] - u[2] * w[1], u[2] * w[0] - u[0] * w[2], u[0] * w[1] - u[1] * w[0]];
    n[0] * n[0] + n[1] * n[1] + n[2] * n[2] > FLAT_TRIANGLE
}

/// Whether the triangles close around the vertex: every corner that follows it also precedes it in another triangle.
fn closed(ring: &Ring) -> bool {
    let mut rim = ring.rim.clone();
    rim.iter_mut().for_each(|corners| corners.sort_unstable());
    !rim[0].is_empty() && rim[0] == rim[1]
}

/// Curvature of a vertex from its own triangles.
fn own(data: &Buffers, vertex: usize) -> Curvature {
    let ring = ring(data, vertex);
    // Sheets back to back have no vertex normal: their curvature is unknown.
    if !closed(&ring) || ring.area <= LEAST_MIXED_AREA || data.normals[vertex] == [0.0; 3] {
        return Curvature::default();
    }
    let mean = (ring.pull.dot(wide(data.normals[vertex])) / (4.0 * ring.area)).clamp(-MOST_CURVATURE, MOST_CURVATURE);
    let gaussian =
        ((TAU - ring.angle) / ring.area).clamp(-MOST_CURVATURE * MOST_CURVATURE, MOST_CURVATURE * MOST_CURVATURE);
    let kappa = match data.object_params[0].kappa {
        KAPPA_RMS => (mean * mean + (mean * mean - gaussian).max(0.0)).sqrt(),
        _ => mean.abs(),
    };
    Curvature { kappa: kappa as f32, mean: mean as f32, gaussian: gaussian as f32, area: ring.area as f32 }
}

fn cpu(state: &mut State, _at: Scope) {
    let data = &state.data;
    let own: Vec<Curvature> = (0..data.corner_starts.len() - 1).into_par_iter().map(|v| own(data, v)).collect();
    let filled = |vertex: usize| {
        let first = data.object_params[0].first_vertex;
        let corners = around(data, vertex).flat_map(|[_, b, c]| [b, c]);
        let known: Vec<_> = corners.map(|v| own[(v - first) as usize]).filter(|c| c.area > 0.0).collect();
        if own[vertex].area > 0.0 || known.is_empty() {
            return own[vertex];
        }
        let mean = |field: fn(&Curvature) -> f32| {
            (known.iter().map(|c| f64::from(field(c))).sum::<f64>() / known.len() as f64) as f32
        };
        Curvature { kappa: mean(|c| c.kappa), mean: mean(|c| c.mean), gaussian: mean(|c| c.gaussian), area: 0.0 }
    };
    let curvature = (0..own.len()).into_par_iter().map(filled).collect();
    state.data.curvature = curvature;
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    let vertices = pass.object().count.vertices;
    pass.dispatch(Some("vertex"), &[], &[], vertices)?;
    pass.dispatch(Some("rim"), &[], &[], vertices)
}
