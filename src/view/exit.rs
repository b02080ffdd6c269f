//! Stage `exit`: light that leaves towards the eye is multiplied by the texture at the place that is seen.

use rayon::prelude::*;

use crate::error::Result;
use crate::layout::{Hit, Slot, TEXTURE_LEAVES};
use crate::light::texture::{factor, place, untextured};
use crate::state::{Carrier, Need, Pass, Place, Role, Serves, Stage, State, Tolerance, Unit, Update, narrow, wide};

/// The table's entry.
pub static STAGE: Stage = Stage {
    name: "exit",
    room: "view",
    about: "radiance of each pixel that shows the object times the texture there, linear between texels",
    equation: "d'Eon et al. 2007, post-scatter texturing",
    writes: &[(Slot::radiance, Role::Update, Tolerance::Float { relative: 2e-5, floor: 2e-5 })],
    reason: "a place in the texture is off by some 1e-7, times its texels a unit and their contrast",
    sizes: &[],
    unit: Unit::Scene,
    carriers: Carrier::ALL,
    needs: &[Need::Light, Need::Picture],
    serves: Serves::ALL,
    skip: |state| untextured(state, TEXTURE_LEAVES),
    runs: Update::picture,
    cpu,
    gpu,
};

/// Radiance of a pixel after the texture.
fn left(state: &State, hit: &Hit, before: [f32; 3]) -> [f32; 3] {
    let (data, face) = (&state.data, hit.face as usize);
    let frame = &data.frame[state.object_of(face)];
    if face >= data.triangles.len() || frame.texture_side & TEXTURE_LEAVES == 0 {
        return before;
    }
    narrow(wide(before) * factor(frame, &data.texels, place(data, face, hit.u.into(), hit.v.into())))
}

fn cpu(state: &mut State, _at: Place) {
    let data = &state.data;
    let pixels = data.hits.par_iter().zip(&data.radiance);
    state.data.radiance = pixels.map(|(hit, &before)| left(state, hit, before)).collect();
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    pass.dispatch(None, &[pass.state.objects.len() as u32], &[], pass.state.data.radiance.len())
}
