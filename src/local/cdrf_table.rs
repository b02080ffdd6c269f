//! Stage `cdrf_table`: the CDRF over a grid of cosines from -1 to 1 and sigmas from 0 to [`WIDEST`] (figure 8). A cell holds
//! the values at its four corners, so that a look-up is one load.
//!
//! Between the grid's points the table is linear: with 256 x 256 within 2e-3, worst at the terminator as sigma tends to 0,
//! where the kink of max(cos, 0) falls inside a cell. Beyond [`WIDEST`] the last row serves, within 1.1e-3.

use rayon::prelude::*;

use super::reflectance::cdrf;
use crate::error::Result;
use crate::layout::Slot;
use crate::state::{Local, Pass, Place, Role, Stage, State, Tolerance, Unit};

/// The table's entry.
pub static STAGE: Stage = Stage {
    name: "cdrf_table",
    room: "local",
    about: "the CDRF over a grid of cosine and sigma",
    equation: "Kubo et al. 2010, figure 8",
    writes: &[(Slot::cdrf_cells, Role::Output, Tolerance::Float { relative: 0.0, floor: 1e-5 })],
    reason: "the device's closed form is within 6e-6 of the convolution, and rounds",
    unit: Unit::Scene,
    cpu,
    gpu,
};

/// The largest sigma of the table.
pub const WIDEST: f64 = 3.5;

/// Cells of a table of this many rows and columns.
#[must_use]
pub fn cells(side: u32) -> usize {
    ((side - 1) * (side - 1)) as usize
}

/// The table's value.
#[must_use]
pub fn lookup(cells: &[[f32; 4]], side: u32, cosine: f64, sigma: f64) -> f64 {
    let last = f64::from(side - 1);
    let place = |share: f64| {
        let at = share.clamp(0.0, 1.0) * last;
        let cell = at.floor().min(last - 1.0);
        (cell as usize, at - cell)
    };
    let ((column, x), (row, y)) = (place(0.5 * cosine + 0.5), place(sigma / WIDEST));
    let [a, b, c, d] = cells[row * (side - 1) as usize + column].map(f64::from);
    (a + (b - a) * x) * (1.0 - y) + (c + (d - c) * x) * y
}

fn side(state: &State) -> u32 {
    match state.method.local {
        Some(Local::Table(side)) => side,
        _ => 2,
    }
}

fn cpu(state: &mut State, _at: Place) {
    let side = side(state);
    let at = |column: u32, row: u32| {
        let share = |k: u32| f64::from(k) / f64::from(side - 1);
        cdrf(2.0 * share(column) - 1.0, WIDEST * share(row)) as f32
    };
    let values: Vec<f32> = (0..side * side).into_par_iter().map(|k| at(k % side, k / side)).collect();
    let cell = |k: u32| {
        let first = (k / (side - 1) * side + k % (side - 1)) as usize;
        let next = first + side as usize;
        [values[first], values[first + 1], values[next], values[next + 1]]
    };
    state.data.cdrf_cells = (0..(side - 1) * (side - 1)).map(cell).collect();
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    let side = side(pass.state);
    pass.dispatch(None, &[side], &[], cells(side))
}
