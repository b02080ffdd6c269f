//! Stage `blur`: the baked irradiance, blurred by one Gaussian after another, each along rows and then down columns.
//!
//! Each Gaussian blurs the result of the one before, by the difference of their variances. At a texel that spans the
//! length s, a standard deviation of w is w / s texels: the stretch correction of d'Eon et al. 2007. The tap stride
//! is p texels, a power of two of at least w / (8 s), but below 1/16 of a row; taps reach out to 6 w or more, at most
//! 48 on either side. Texels that show no surface are skipped, and the sum is divided by the sum of weights, so that
//! uniform light is preserved, also at borders.

use rayon::prelude::*;

use crate::error::Result;
use crate::layout::{BLUR_REACH, BufferId, Buffers, GAUSSIANS, NONE, Unwrapping};
use crate::state::{Carrier, Pass, Role, Scope, Size, Stage, State, Tolerance, Update};

/// The stage's declaration.
pub static STAGE: Stage = Stage {
    name: "blur",
    about: "irradiance blurred over the texture by Gaussians, along rows and down columns, widened by the stretch",
    equation: "d'Eon et al. 2007, section 5",
    writes: &[
        (BufferId::irradiance_maps, Role::Update, Tolerance::Float { relative: 5e-5, floor: 2e-5 }),
        (BufferId::blurred_rows, Role::Output, Tolerance::Float { relative: 5e-5, floor: 2e-5 }),
    ],
    reason: "twelve weighted means of up to 97 values of one sign; an exponential is off by some roundings of its exponent, 8 at most",
    sizes: &[(BufferId::blurred_rows, Size::Elements(|state| state.data.texel_hits.len()))],
    carriers: &[Carrier::TextureBlur],
    runs: Update::light,
    ..super::stage(cpu, gpu)
};

/// Tap stride, and taps per side; only additions, multiplications and comparisons in `f32`, so that devices agree.
fn taps(deviation: f32, length: f32, side: u32) -> (i64, i64) {
    let mut pace = 1;
    while 32 * pace < i64::from(side) && deviation > 8.0 * (pace as f32 * length) {
        pace *= 2;
    }
    let least = i64::from(BLUR_REACH);
    let mut reach = least;
    while reach < 8 * least && deviation > (reach / least) as f32 * (pace as f32 * length) {
        reach *= 2;
    }
    (pace, reach)
}

/// One texel of a map after a blur along a row (axis 0) or down a column (axis 1).
fn mean(data: &Buffers, own: &Unwrapping, from: &[[f32; 4]], texel: usize, axis: usize, deviation: f32) -> [f32; 4] {
    if data.texel_hits[own.first as usize + texel].face == NONE {
        return [0.0; 4];
    }
    let (side, at) = (i64::from(own.side), [texel as i64 % i64::from(own.side), texel as i64 / i64::from(own.side)]);
    let length = data.stretch[own.first as usize + texel][axis];
    let (pace, reach) = taps(deviation, length, own.side);
    let (mut sum, mut whole) = ([0.0; 3], 0.0);
    for tap in -reach..=reach {
        let mut place = at;
        place[axis] += tap * pace;
        if own.round[axis] != 0 {
            place[axis] = place[axis].rem_euclid(side);
        }
        if !(0..side).contains(&place[axis]) {
            continue;
        }
        let [r, g, b, there] = from[(place[1] * side + place[0]) as usize].map(f64::from);
        let distance = (tap * pace) as f64 * f64::from(length) / f64::from(deviation);
        let weight = (-0.5 * distance * distance).exp();
        sum = [sum[0] + weight * r, sum[1] + weight * g, sum[2] + weight * b];
        whole += weight * there;
    }
    let [r, g, b] = sum.map(|sum| (sum / whole) as f32);
    [r, g, b, 1.0]
}

/// Computes an object's blurred maps from its first map, the irradiance.
fn object(data: &mut Buffers, number: usize) {
    let own = data.unwrappings[number];
    let (first, count, irradiance_map) = (own.first as usize, (own.side * own.side) as usize, data.texel_hits.len());
    for k in 0..GAUSSIANS {
        let deviation = data.gaussians[number * GAUSSIANS + k][3];
        let blurred = |data: &Buffers, from: &[[f32; 4]], axis: usize| -> Vec<[f32; 4]> {
            (0..count).into_par_iter().map(|texel| mean(data, &own, from, texel, axis, deviation)).collect()
        };
        let crossed = blurred(data, &data.irradiance_maps[k * irradiance_map + first..][..count], 0);
        let down = blurred(data, &crossed, 1);
        data.blurred_rows[first..first + count].copy_from_slice(&crossed);
        data.irradiance_maps[(k + 1) * irradiance_map + first..][..count].copy_from_slice(&down);
    }
}

fn cpu(state: &mut State, _at: Scope) {
    (0..state.data.unwrappings.len()).for_each(|number| object(&mut state.data, number));
}

fn gpu(pass: &mut Pass<'_>) -> Result<()> {
    for (number, own) in (0u32..).zip(&pass.state.data.unwrappings) {
        for level in 0..GAUSSIANS as u32 {
            for part in ["across", "down"] {
                let push = [number, level];
                pass.dispatch(Some(part), &[], bytemuck::cast_slice(&push), (own.side * own.side) as usize)?;
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use crate::dipole::profile::Dipole;
    use crate::layout::TexelHit;
    use crate::shading::blur::*;
    use crate::shading::gaussians::fit;

    /// A plane of `side` x `side` texels with this stretch, lit by `lit` of a texel's column and row.
    fn plane(side: u32, stretch: impl Fn(usize) -> [f32; 2], lit: impl Fn(u32, u32) -> f32) -> (Buffers, [Dipole; 3]) {
        let dipoles = [Dipole::new(60.0, 0.5, 3.0), Dipole::new(90.0, 1.0, 3.0), Dipole::new(120.0, 2.0, 3.0)];
        let count = (side * side) as usize;
        let mut data = Buffers {
            unwrappings: vec![Unwrapping { side, ..Unwrapping::default() }],
            texel_hits: vec![TexelHit::default(); count],
            stretch: (0..count).map(stretch).collect(),
            gaussians: fit(&dipoles).records().to_vec(),
            irradiance_maps: vec![[0.0; 4]; (1 + GAUSSIANS) * count],
            blurred_rows: vec![[0.0; 4]; count],
            ..Buffers::default()
        };
        for (k, texel) in data.irradiance_maps.iter_mut().take(count).enumerate() {
            let light = lit(k as u32 % side, k as u32 / side);
            *texel = [light, light, light, 1.0];
        }
        (data, dipoles)
    }

    /// The weighted sum of Gaussians at a texel, one channel.
    fn value(data: &Buffers, texel: usize, channel: usize) -> f64 {
        let count = data.texel_hits.len();
        let term = |k: usize| {
            f64::from(data.gaussians[k][channel]) * f64::from(data.irradiance_maps[(k + 1) * count + texel][channel])
        };
        (0..GAUSSIANS).map(term).sum()
    }

    #[test]
    fn even_light_gives_back_the_total() {
        let (mut data, dipoles) = plane(48, |k| [0.02 + 1e-3 * (k % 7) as f32, 0.03], |_, _| 0.7);
        // An empty texel inside; the borders are tested below.
        data.texel_hits[48 * 20 + 11].face = NONE;
        data.irradiance_maps[48 * 20 + 11] = [0.0; 4];
        object(&mut data, 0);
        for texel in [0, 47, 48 * 20 + 10, 48 * 20 + 12, 48 * 48 - 1, 1000] {
            for (c, dipole) in dipoles.iter().enumerate() {
                let (found, expected) = (value(&data, texel, c), 0.7 * dipole.total());
                assert!((found / expected - 1.0).abs() < 1e-6, "{texel} {c}: {found} {expected}");
            }
        }
    }

    #[test]
    #[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
    fn an_edge_of_light_is_blurred_as_by_the_sum_of_gaussians() {
        // Texels are 1 / 256 wide and two thirds of that high; the edge of light runs across either axis.
        let side = 256;
        let lengths = [1.0 / 256.0, 1.0 / 384.0];
        for axis in [0, 1] {
            let lit = |column: u32, row: u32| if [column, row][axis] >= 128 { 1.0 } else { 0.0 };
            let (mut data, dipoles) = plane(side, |_| lengths, lit);
            object(&mut data, 0);
            let ideal = fit(&dipoles);
            for offset in [-40i32, -15, -6, -2, -1, 0, 1, 3, 9, 30] {
                let place = 128 + offset;
                let texel = if axis == 0 { 128 * 256 + place } else { place * 256 + 128 };
                let distance = (f64::from(offset) + 0.5) * f64::from([lengths[0], lengths[1]][axis]);
                for (c, dipole) in dipoles.iter().enumerate() {
                    let (found, expected) = (value(&data, texel as usize, c), ideal.edge(c, distance));
                    let share = (found - expected).abs() / dipole.total();
                    assert!(share < 8e-3, "axis {axis}, {offset}, {c}: {found} {expected}");
                }
            }
        }
    }

    #[test]
    fn where_texels_span_nothing_the_mean_of_the_circle_is_left() {
        let (mut data, _) = plane(16, |k| [if k / 16 == 3 { 0.0 } else { 0.5 }, 0.5], |column, _| column as f32);
        data.unwrappings[0].round = [1, 0];
        object(&mut data, 0);
        for k in 0..16 {
            assert!((data.blurred_rows[3 * 16 + k][0] - 7.5).abs() < 0.1, "{:?}", data.blurred_rows[3 * 16 + k]);
        }
        assert!((data.irradiance_maps[256 + 5 * 16 + 9][0] - 9.0).abs() < 1e-3);
    }
}
