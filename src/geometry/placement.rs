//! Stage `placement`: turns and shifts vertices and normals of an object from its own frame, where light is carried,
//! into the scene, where lights, rays and the camera are; and computes the boxes of its tree there. The stage is
//! skipped if every object lies in the scene as in its own frame: later stages then read the originals.
//!
//! Rays decide by these positions, so they are `f32` additions and multiplications in the order of
//! `glsl/geometry/placed.glsl`.

use rayon::prelude::*;

use crate::error::Result;
use crate::layout::{Bounds, BufferId, NONE, ObjectParams};
use crate::state::{Pass, Role, Scope, Serves, Size, Stage, State, Tolerance, Update};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "placement",
    about: "vertices, normals and boxes of moved objects, in the scene",
    equation: "x' = R x + t",
    writes: &[
        (BufferId::arrivals, Role::Update, Tolerance::Exact),
        (BufferId::placed_positions, Role::Update, Tolerance::Exact),
        (BufferId::placed_normals, Role::Output, Tolerance::Exact),
        (BufferId::placed_bounds, Role::Output, Tolerance::Exact),
    ],
    reason: "additions and multiplications in f32, minima and maxima",
    sizes: &[(BufferId::placed_positions, Size::Elements(|state| state.data.positions.len()))],
    serves: Serves { object: |object, _| object.placed, none: "no object is turned or shifted" },
    runs: Update::placed,
    ..super::stage(cpu, gpu)
};

/// A direction of an object's own frame, turned into the scene.
#[must_use]
pub fn turned(params: &ObjectParams, v: [f32; 3]) -> [f32; 3] {
    [params.turn_x, params.turn_y, params.turn_z].map(|row| row[0] * v[0] + row[1] * v[1] + row[2] * v[2])
}

/// Where a point of an object's own frame lies in the scene.
#[must_use]
pub fn placed(params: &ObjectParams, point: [f32; 3]) -> [f32; 3] {
    let turned = turned(params, point);
    std::array::from_fn(|k| turned[k] + params.shift[k])
}

fn cpu(state: &mut State, _at: Scope) {
    let data = &mut state.data;
    let params = data.object_params[0];
    let vertices = params.first_vertex as usize..(params.first_vertex + params.vertices) as usize;
    let places: Vec<_> = data.positions[vertices.clone()].par_iter().map(|&p| placed(&params, p)).collect();
    data.placed_positions[vertices].copy_from_slice(&places);
    data.placed_normals = data.normals.par_iter().map(|&normal| turned(&params, normal)).collect();

    let all = |f: fn(f32, f32) -> f32, [a, b]: [[f32; 3]; 2]| std::array::from_fn(|k| f(a[k], b[k]));
    let mut boxes = data.bounds.clone();
    for node in (0..boxes.len()).rev() {
        let place = data.topology[node];
        let parts: Vec<[[f32; 3]; 2]> = if place.face == NONE {
            [node + 1, data.topology[node + 1].skip as usize].map(|k| [boxes[k].low, boxes[k].high]).into()
        } else {
            data.triangles[place.face as usize].map(|v| [data.placed_positions[v as usize]; 2]).into()
        };
        let merge = |k: usize, f| parts.iter().map(|part| part[k]).reduce(|a, b| all(f, [a, b])).unwrap_or_default();
        boxes[node] = Bounds { low: merge(0, f32::min), high: merge(1, f32::max), ..boxes[node] };
    }
    data.placed_bounds = boxes;
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    let count = pass.object().count;
    pass.dispatch(Some("vertex"), &[], &[], count.vertices)?;
    pass.dispatch(Some("leaf"), &[], &[], count.faces)?;
    pass.climb("cluster", &[])
}
