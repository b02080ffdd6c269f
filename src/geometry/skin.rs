//! Stage `skin`: places the vertices of an animated object by the joints that they follow, after morph targets have
//! moved them. Deformations apply to the result.
//!
//! As in stage `deform`, all of it is `f32` additions and multiplications in the order of `glsl/geometry/skin.comp`.

use rayon::prelude::*;

use crate::error::Result;
use crate::layout::{BufferId, Buffers, ObjectParams};
use crate::state::{Pass, Role, Scope, Serves, Stage, State, Tolerance};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "skin",
    about: "vertices placed by the joints that they follow, after morph targets",
    equation: "linear blend: sum of weight times matrix times (base + sum of weight times target), glTF 2.0, 3.7.3",
    writes: &[(BufferId::skinned, Role::Output, Tolerance::Exact)],
    reason: "additions and multiplications in f32",
    serves: Serves { object: |object, _| object.skinned, none: "no object has joints that move" },
    ..super::stage(cpu, gpu)
};

/// Where the joints place vertex number `vertex` of the object, whose record is number `at` of `skin_vertices`.
fn place(data: &Buffers, params: &ObjectParams, at: usize, vertex: usize) -> [f32; 3] {
    let record = data.skin_vertices[at];
    let mut p = record.base;
    for k in 0..params.skin_targets as usize {
        let way = data.skin_targets[params.first_target as usize + vertex * params.skin_targets as usize + k];
        let weight = data.skin_weights[params.first_weight as usize + record.row as usize + k];
        p = [0, 1, 2].map(|c| p[c] + weight * way[c]);
    }
    let mut sum = [0.0; 3];
    for k in 0..params.skin_joints as usize {
        let joint = data.skin_joints[params.first_joint as usize + vertex * params.skin_joints as usize + k];
        let matrix = data.skin_matrices[params.first_matrix as usize + joint.matrix as usize];
        let row = |m: [f32; 4]| m[0] * p[0] + m[1] * p[1] + m[2] * p[2] + m[3];
        let q = [row(matrix.x), row(matrix.y), row(matrix.z)];
        sum = [0, 1, 2].map(|c| sum[c] + joint.weight * q[c]);
    }
    sum
}

fn cpu(state: &mut State, _at: Scope) {
    skin(&mut state.data, 0);
}

/// Places the vertices of one object, if it has a skin.
pub fn skin(data: &mut Buffers, object: usize) {
    let params = data.object_params[object];
    if params.skin_joints == 0 {
        return;
    }
    // In a state of one object buffers of vertices begin at 0, in one of several objects at the object's first vertex.
    let begin = if data.object_params.len() == 1 { 0 } else { params.first_vertex as usize };
    let mut skinned = std::mem::take(&mut data.skinned);
    let vertices = &mut skinned[begin..begin + params.vertices as usize];
    vertices.par_iter_mut().enumerate().for_each(|(vertex, p)| *p = place(data, &params, begin + vertex, vertex));
    data.skinned = skinned;
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    pass.dispatch(None, &[], &[], pass.object().count.vertices)
}
