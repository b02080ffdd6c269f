//! Stage `texture_out`: multiplies the light towards the eye by the texture at the visible point.

use rayon::prelude::*;

use crate::error::Result;
use crate::layout::{BufferId, Hit, TEXTURE_LEAVES};
use crate::lighting::texture::{factor, place, untextured};
use crate::state::{Need, Pass, Role, Scope, Stage, State, Tolerance, narrow, wide};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "texture_out",
    about: "radiance of each pixel that shows the object times the texture there, linear between texels",
    equation: "d'Eon et al. 2007, post-scatter texturing",
    writes: &[(BufferId::radiance, Role::Update, Tolerance::Float { relative: 2e-5, floor: 2e-5 })],
    reason: "a place in the texture is off by about 1e-7, times its texels per unit and their contrast",
    needs: &[Need::Light, Need::Picture],
    skip: |state| untextured(state, TEXTURE_LEAVES),
    ..super::stage(cpu, gpu)
};

/// Radiance of a pixel after the texture.
fn left(state: &State, hit: &Hit, before: [f32; 3]) -> [f32; 3] {
    let (data, face) = (&state.data, hit.face as usize);
    let params = &data.object_params[state.object_of(face)];
    if face >= data.triangles.len() || params.texture_side & TEXTURE_LEAVES == 0 {
        return before;
    }
    narrow(wide(before) * factor(params, &data.texels, place(data, face, hit.u.into(), hit.v.into())))
}

fn cpu(state: &mut State, _at: Scope) {
    let data = &state.data;
    let pixels = data.hits.par_iter().zip(&data.radiance);
    state.data.radiance = pixels.map(|(hit, &before)| left(state, hit, before)).collect();
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    pass.dispatch(None, &[pass.state.objects.len() as u32], &[], pass.state.data.radiance.len())
}
