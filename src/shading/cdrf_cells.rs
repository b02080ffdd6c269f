//! Stage `cdrf_cells`: the cells of the CDRF's table, each packed into one word, so that a look-up is one load of 4
//! bytes per channel.
//!
//! A cell of an n x n table stores its value at the first corner, in steps of 2^-13, and its differences across, up
//! and mixed, in steps of 1 / (31 (n - 1)): across, where the slope of f is at most 1, that is at most 62 steps.
//! Differences are taken from the rounded value, so that every corner is within half a step of the table's value, or
//! within 2^-13 if that is more. Between corners the cell is bilinear: with 256 x 256 within 2e-3 of f, worst at the
//! terminator as sigma tends to 0, where the kink of max(cos, 0) falls inside a cell.

use crate::error::Result;
use crate::layout::{BufferId, CDRF_WIDEST};
use crate::shading::cdrf_table::{side, untabled};
use crate::state::{Pass, Role, Scope, Size, Stage, State, Tolerance};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "cdrf_cells",
    about: "the cells of the CDRF's table, each in 4 bytes",
    equation: "Kubo et al. 2010, figure 8",
    writes: &[(BufferId::cdrf_cells, Role::Output, Tolerance::Exact)],
    reason: "multiplications, additions and floors, each rounded once",
    sizes: &[(BufferId::cdrf_cells, Size::Elements(|state| (side(state) as usize - 1).pow(2)))],
    skip: untabled,
    ..super::stage(cpu, gpu)
};

/// Packs a cell from its corners: the first, the one across, the one up, the last.
fn cell([first, across, up, last]: [f32; 4], side: u32) -> u32 {
    let code = (first * 8192.0 + 0.5).floor().min(8191.0);
    let steps = |value: f32| ((value - code / 8192.0) * (31.0 * (side - 1) as f32) + 0.5).floor() as i32;
    let (x, y) = (steps(across).clamp(0, 63), steps(up).clamp(-64, 63));
    let both = (steps(last) - x - y).clamp(-32, 31);
    code as u32 | (x as u32) << 13 | (both as u32 & 0x3f) << 19 | (y as u32) << 25
}

/// A cell's value at its first corner, and its differences across, up and mixed.
fn parts(cell: u32, side: u32) -> [f64; 4] {
    let word = cell as i32;
    let steps = |count: i32| f64::from(count) / (31.0 * f64::from(side - 1));
    [f64::from(cell & 0x1fff) / 8192.0, steps(word >> 13 & 0x3f), steps(word >> 25), steps(word << 7 >> 26)]
}

/// The table's value, interpolated bilinearly.
#[must_use]
pub fn lookup(cells: &[u32], side: u32, cosine: f64, sigma: f64) -> f64 {
    let last = f64::from(side - 1);
    let place = |share: f64| {
        let at = share.clamp(0.0, 1.0) * last;
        let cell = at.floor().min(last - 1.0);
        (cell as usize, at - cell)
    };
    let ((column, x), (row, y)) = (place(0.5 * cosine + 0.5), place(sigma / CDRF_WIDEST));
    let [first, across, up, both] = parts(cells[row * (side - 1) as usize + column], side);
    first + across * x + up * y + both * x * y
}

fn cpu(state: &mut State, _at: Scope) {
    let side = side(state);
    let grid = &state.data.cdrf_grid;
    let packed = |k: u32| {
        let first = (k / (side - 1) * side + k % (side - 1)) as usize;
        let next = first + side as usize;
        cell([grid[first], grid[first + 1], grid[next], grid[next + 1]], side)
    };
    state.data.cdrf_cells = (0..(side - 1) * (side - 1)).map(packed).collect();
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    let side = side(pass.state);
    pass.dispatch(None, &[side], &[], ((side - 1) * (side - 1)) as usize)
}

#[cfg(test)]
mod tests {
    use crate::shading::cdrf_cells::*;
    use crate::shading::cdrf_table;
    use crate::state::Local;

    #[test]
    fn no_corner_of_a_cell_is_off_by_more_than_half_a_step() {
        for (side, most) in [(8, 2.31e-3), (9, 2.02e-3), (33, 5.1e-4), (256, 6.4e-5), (1024, 8e-5)] {
            let mut state = State::default();
            state.method.local = Some(Local::Table(side));
            (cdrf_table::STAGE.cpu)(&mut state, Scope::SCENE);
            cpu(&mut state, Scope::SCENE);
            let grid = |column: u32, row: u32| f64::from(state.data.cdrf_grid[(row * side + column) as usize]);
            let mut worst = 0f64;
            for (k, &cell) in (0..).zip(&state.data.cdrf_cells) {
                let (column, row) = (k % (side - 1), k / (side - 1));
                let [first, x, y, both] = parts(cell, side);
                for [right, down] in [[0, 0], [1, 0], [0, 1], [1, 1]] {
                    let value = first + f64::from(right) * x + f64::from(down) * (y + f64::from(right) * both);
                    worst = worst.max((value - grid(column + right, row + down)).abs());
                }
            }
            assert!(worst < most && worst > 0.2 * most, "{side}: {worst}");
        }
    }
}
