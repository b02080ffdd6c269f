//! Stage `irradiance`: the light that enters each face, E of equation 5, from unshadowed lights.
//!
//! Below an index of 1 transmittance rises from the critical angle as a square root, so that the rounding of a cosine
//! counts: where the squared cosine is within 0.01 of the critical one, a device in `f32` may miss the stage's tolerance,
//! by up to 2e-3 of the light right at it. The fixture of such indices has no face there.

use rayon::prelude::*;

use super::fresnel;
use crate::error::Result;
use crate::layout::Slot;
use crate::state::{Pass, Place, Role, Stage, State, Tolerance, Unit, narrow, wide};

/// The table's entry.
pub static STAGE: Stage = Stage {
    name: "irradiance",
    room: "light",
    about: "light entering each face: cosine times Fresnel transmittance, summed over the lights",
    equation: "Mertens et al. 2003, equation 5",
    writes: &[(Slot::irradiance, Role::Output, Tolerance::Float { relative: 2e-5, floor: 2e-6 })],
    reason: "a short sum of products; the cosine cancels where light grazes, hence the floor",
    unit: Unit::Frame,
    cpu,
    gpu,
};

fn cpu(state: &mut State, _at: Place) {
    let data = &mut state.data;
    let eta = data.frame[0].eta.map(f64::from);
    data.irradiance = (0..data.triangles.len())
        .into_par_iter()
        .map(|face| {
            let leaf = &data.clusters[data.leaves[face] as usize];
            let area = f64::from(leaf.area);
            let normal = if area > 0.0 { wide(leaf.normal) / area } else { glam::DVec3::ZERO };
            let mut sum = glam::DVec3::ZERO;
            for light in &data.lights {
                let mut toward = wide(light.place);
                let mut falloff = 1.0;
                if light.kind == 1 {
                    toward -= wide(leaf.center);
                    falloff = 1.0 / toward.length_squared().max(1e-30);
                    toward *= falloff.sqrt();
                }
                let cosine = normal.dot(toward);
                let enters = eta.map(|eta| fresnel::transmittance(eta, cosine));
                sum += wide(light.color) * glam::DVec3::from_array(enters) * (cosine.max(0.0) * falloff);
            }
            narrow(sum)
        })
        .collect();
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    pass.dispatch(None, &[], &[], pass.state.data.triangles.len())
}
