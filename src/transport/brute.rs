//! Stage `brute`: every face to every face, the reference for the hierarchy.

use rayon::prelude::*;

use super::links::form_factor::{Emitters, QuadratureRule};
use crate::error::Result;
use crate::layout::{BufferId, Range};
use crate::state::{Carrier, Distance, Near, Pass, Role, Scope, Stage, State, Tolerance, narrow, wide};

/// Most receivers of one dispatch, so that no dispatch runs for many seconds.
const RECEIVERS: u32 = 8192;
/// Most emitters of one dispatch: lavapipe silently ends an invocation's loops after 65,535 iterations in total.
const FAR_EMITTERS: u32 = 32768;
/// The same where each emitter may take the edge form's nested loops.
const NEAR_EMITTERS: u32 = 1024;

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "brute",
    about: "radiosity of each face from every face, one sample or the edge form",
    equation: "Mertens et al. 2003, equation 6, without clusters",
    writes: &[(BufferId::radiosity, Role::Output, Tolerance::Float { relative: 1e-4, floor: 1e-6 })],
    reason: "a sum over all faces in f32: rounding grows with the square root of their number, and e^{-sigma s} by \
             its argument's; the edge form's share is a difference between edges",
    carriers: &[Carrier::Brute],
    ..super::stage(cpu, gpu)
};

fn cpu(state: &mut State, _at: Scope) {
    let data = &state.data;
    let emitters = Emitters::new(data, state.distance, Near::Exact);
    let sum = |receiver: usize| {
        let center = data.clusters[data.leaves[receiver] as usize].center;
        let pair = |face: usize| {
            let leaf = data.leaves[face];
            let far = crate::dipole::distance2(center, data.clusters[leaf as usize].center) >= data.reach[face][0];
            let factor =
                emitters.factor(leaf, wide(center), if far { QuadratureRule::Center } else { QuadratureRule::Edges });
            wide(data.irradiance[face]) * factor
        };
        narrow((0..data.triangles.len()).map(pair).sum())
    };
    let radiosity = (0..data.triangles.len()).into_par_iter().map(sum).collect();
    state.data.radiosity = radiosity;
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    let displaced = u32::from(pass.state.distance == Distance::Table1);
    let faces = pass.object().count.faces as u32;
    for receiver in (0..faces).step_by(RECEIVERS as usize) {
        let receivers = Range { first: receiver, count: RECEIVERS.min(faces - receiver) };
        for (part, most) in [("far", FAR_EMITTERS), ("near", NEAR_EMITTERS)] {
            for first in (0..faces).step_by(most as usize) {
                let emitters = Range { first, count: most.min(faces - first) };
                let push = [receivers, emitters];
                pass.dispatch(Some(part), &[displaced], bytemuck::bytes_of(&push), receivers.count as usize)?;
            }
        }
    }
    Ok(())
}
