//! Stage `random_walk`: photons start, fly, collide, scatter, lose weight, are reflected from within, and leave. One
//! run is a round of flights; photons under way go on in the next one.

use rayon::prelude::*;

use super::flight::{Exit, fly};
use super::start::start;
use crate::error::Result;
use crate::layout::{BufferId, Photon, WalkBalance};
use crate::state::{Pass, Role, Scope, Size, Stage, State, Tolerance};

/// Flights of a round.
pub const FLIGHTS: usize = 64;
/// Flights after which slots whose photon has ended start another one.
const BETWEEN: usize = 8;

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "random_walk",
    about: "photons fly through the object: collisions, absorption, scattering, reflection from within, exit",
    equation: "the radiative transfer equation: free paths of exponential length, Henyey and Greenstein 1941, Fresnel",
    writes: &[
        (BufferId::photons, Role::Update, Tolerance::Exact),
        (BufferId::balances, Role::Update, Tolerance::Exact),
        (BufferId::exits, Role::Update, Tolerance::Exact),
    ],
    reason: "decisions, and integers: one wrong bit sends a photon elsewhere",
    sizes: &[(BufferId::photons, Size::Elements(slots)), (BufferId::balances, Size::Elements(slots))],
    ..super::stage(cpu, gpu)
};

fn slots(state: &State) -> usize {
    state.data.walk_params.iter().map(|params| params.slots as usize).max().unwrap_or(0)
}

fn cpu(state: &mut State, _at: Scope) {
    let data = &state.data;
    let exits: Vec<Exit> = data.exits.iter().map(Exit::of).collect();
    let slots = data.walk_params[0].slots as usize;
    let walk = |(slot, (photon, balance)): (usize, (&Photon, &WalkBalance))| {
        let (mut photon, mut balance) = (*photon, *balance);
        for flight in 0..FLIGHTS {
            if flight % BETWEEN == 0 {
                start(data, slot as u32, &mut photon, &mut balance);
            }
            if photon.weight != 0 {
                fly(data, slot % 3, &mut photon, &mut balance, &exits);
            }
        }
        (photon, balance)
    };
    let of_slots = data.photons[..slots].par_iter().zip(&data.balances[..slots]).enumerate();
    let (photons, balances): (Vec<_>, Vec<_>) = of_slots.map(walk).unzip();
    state.data.exits = exits.iter().map(Exit::sum).collect();
    state.data.photons[..slots].copy_from_slice(&photons);
    state.data.balances[..slots].copy_from_slice(&balances);
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    let data = &pass.state.data;
    let slots = data.walk_params[pass.at.object].slots as usize;
    let uses = [u32::from(data.object_params[0].shadow_words > 0), u32::from(!data.sky.is_empty())];
    for flight in 0..FLIGHTS {
        if flight % BETWEEN == 0 {
            pass.dispatch(Some("start"), &uses, &[], slots)?;
        }
        pass.dispatch(Some("fly"), &[], &[], slots)?;
    }
    Ok(())
}
