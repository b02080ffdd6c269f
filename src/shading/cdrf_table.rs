//! Stage `cdrf_table`: the CDRF over a grid of cosines from -1 to 1 and sigmas from 0 to [`CDRF_WIDEST`] (figure 8).

use rayon::prelude::*;

use super::reflectance::cdrf;
use crate::error::Result;
use crate::layout::{BufferId, CDRF_WIDEST};
use crate::state::{Local, Pass, Role, Scope, Size, Stage, State, Tolerance};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "cdrf_table",
    about: "the CDRF over a grid of cosine and sigma",
    equation: "Kubo et al. 2010, figure 8",
    writes: &[(BufferId::cdrf_grid, Role::Output, Tolerance::Float { relative: 0.0, floor: 1e-5 })],
    reason: "the device's closed form is within 6e-6 of the convolution, and rounds",
    sizes: &[(BufferId::cdrf_grid, Size::Elements(|state| (side(state) as usize).pow(2)))],
    skip: untabled,
    ..super::stage(cpu, gpu)
};

/// The reason to skip the table: the closed form is used.
pub(super) fn untabled(state: &State) -> Option<&'static str> {
    let closed = !matches!(state.method.local, Some(Local::Table(_)));
    closed.then_some("transport.cdrf is closed: nothing is looked up")
}

/// Rows and columns of the table; 2 where no table is used.
pub(super) fn side(state: &State) -> u32 {
    match state.method.local {
        Some(Local::Table(side)) => side,
        _ => 2,
    }
}

fn cpu(state: &mut State, _at: Scope) {
    let side = side(state);
    let share = |k: u32| f64::from(k) / f64::from(side - 1);
    let at = |k: u32| cdrf(2.0 * share(k % side) - 1.0, CDRF_WIDEST * share(k / side)) as f32;
    state.data.cdrf_grid = (0..side * side).into_par_iter().map(at).collect();
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    let side = side(pass.state);
    pass.dispatch(None, &[side], &[], (side * side) as usize)
}
