//! Stage `environment`: the nine spherical-harmonic coefficients of the environment's image, a reduction over its
//! pixels.
//!
//! Each pixel has constant radiance. The integral of a harmonic over it is a product of an integral over its row and
//! one over its column, both tabulated by the host, so that a constant image of any size has no error.

use glam::DVec3;
use rayon::prelude::*;

use crate::error::Result;
use crate::layout::{BufferId, Buffers, Range, SKY_BLOCK, SKY_HARMONICS};
use crate::state::{Granularity, Pass, Role, Scope, Serves, Size, Stage, State, Tolerance, narrow, wide};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "environment",
    about: "nine spherical-harmonic coefficients of the environment: sums over its image",
    equation: "Mertens et al. 2003, section 5.3; Ramamoorthi and Hanrahan 2001, equations 3 and 10",
    writes: &[(BufferId::harmonics, Role::Output, Tolerance::Float { relative: 2e-5, floor: 5e-6 })],
    reason: "sums of 64 terms, nested three or four deep, 64 x 2^-24 = 4e-6 each at worst; terms of either sign cancel",
    sizes: &[(BufferId::harmonics, Size::Elements(|state| elements(state.data.object_params[0].sky)))],
    granularity: Granularity::Scene,
    serves: Serves::ALL,
    skip: |state| state.data.sky.is_empty().then_some("no light is an environment"),
    ..super::stage(cpu, gpu)
};

/// Sizes of the levels of the reduction: the number of blocks of pixels, of blocks of their sums, and so on to one.
fn levels([width, height]: [u32; 2]) -> Vec<usize> {
    let mut levels = vec![height as usize * (width as usize).div_ceil(SKY_BLOCK)];
    while let Some(&last) = levels.last().filter(|&&last| last > 1) {
        levels.push(last.div_ceil(SKY_BLOCK));
    }
    levels
}

/// Elements of the buffer `harmonics` for an image of this size.
pub fn elements(size: [u32; 2]) -> usize {
    SKY_HARMONICS * levels(size).iter().sum::<usize>()
}

/// Image times harmonics over block `k`.
fn block(data: &Buffers, k: usize) -> [DVec3; SKY_HARMONICS] {
    let width = data.object_params[0].sky[0] as usize;
    let across = width.div_ceil(SKY_BLOCK);
    let (row, start) = (k / across, k % across * SKY_BLOCK);
    let mut sums = [DVec3::ZERO; SKY_HARMONICS];
    for column in start..(start + SKY_BLOCK).min(width) {
        let radiance = wide(data.sky[row * width + column]);
        let (r, c) = (&data.sky_rows[row], &data.sky_columns[column]);
        let ([one, y, s], [yy, sy, ss]) = (r.first.map(f64::from), r.second.map(f64::from));
        let ([all, x, z], [xz, difference]) = (c.first.map(f64::from), c.second.map(f64::from));
        // Solid angle times each harmonic's polynomial, not yet normalised.
        let polynomials =
            [one * all, s * x, y * all, s * z, sy * z, ss * xz, sy * x, (3.0 * yy - one) * all, ss * difference];
        for (sum, polynomial) in sums.iter_mut().zip(polynomials) {
            *sum += radiance * polynomial;
        }
    }
    let norms = norms();
    std::array::from_fn(|k| sums[k] * norms[k])
}

/// The factor that makes each polynomial orthonormal, from `basis` where the polynomial is known.
fn norms() -> [f64; SKY_HARMONICS] {
    let at = |x, y, z| super::harmonics::basis(DVec3::new(x, y, z));
    let (axis, middle) = (at(0.0, 1.0, 0.0), at(1.0, 1.0, 1.0));
    [axis[0], middle[1], middle[2], middle[3], middle[4], middle[5], middle[6], axis[7] / 2.0, at(1.0, 0.0, 0.0)[8]]
}

fn cpu(state: &mut State, _at: Scope) {
    let data = &state.data;
    let levels = levels(data.object_params[0].sky);
    let mut sums: Vec<[DVec3; SKY_HARMONICS]> = (0..levels[0]).into_par_iter().map(|k| block(data, k)).collect();

    // Levels are stored last to first, so that the final sum comes first.
    let mut all = vec![sums.clone()];
    for _ in 1..levels.len() {
        let add =
            |blocks: &[[DVec3; SKY_HARMONICS]]| std::array::from_fn(|k| blocks.iter().map(|block| block[k]).sum());
        sums = sums.chunks(SKY_BLOCK).map(add).collect();
        all.push(sums.clone());
    }
    state.data.harmonics = all.iter().rev().flatten().flatten().map(|&sum| narrow(sum)).collect();
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    let levels = levels(pass.state.data.object_params[0].sky);
    let before = |level: usize| levels[level + 1..].iter().sum::<usize>() as u32;
    let range = Range { first: before(0), count: levels[0] as u32 };
    pass.dispatch(Some("pixels"), &[], bytemuck::bytes_of(&range), levels[0])?;
    for level in 1..levels.len() {
        let range = Range { first: before(level), count: levels[level] as u32 };
        pass.dispatch(Some("sum"), &[levels[level - 1] as u32], bytemuck::bytes_of(&range), 9 * levels[level])?;
    }
    Ok(())
}
