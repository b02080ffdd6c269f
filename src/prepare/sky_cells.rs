//! The octahedral map of where an environment is bright, as a table for the alias method (Walker 1974; Vose 1991).

use std::f64::consts::PI;

use glam::DVec3;
use rayon::prelude::*;

use crate::layout::{Buffers, SKY_CELLS, SkyCell};
use crate::lighting::sky::radiance;
use crate::state::{narrow, wide};
use crate::view::mirror_ray::cell_of;

/// An environment is nearly even where the mean of its squares is below this many squares of its mean.
const NEARLY_EVEN: f64 = 4.0;

/// Draws of a cell, of which it keeps some.
const DRAWS: u64 = 1 << 16;

/// Light of each cell of the map, of any scale: samples of the image at its pixels' centres, or closer together where
/// pixels are larger than half a cell; each counts for the cells around it, too, as far as the image is interpolated.
fn light(data: &Buffers) -> Vec<f64> {
    let side = SKY_CELLS as usize;
    let [width, height] = data.object_params[0].sky.map(|n| n as usize);
    let (columns, rows) = (width * (4 * side).div_ceil(width), height * (2 * side).div_ceil(height));
    let turned = f64::from(data.object_params[0].sky_turn) * 2.0 * PI;
    let row = |row: usize| -> Vec<(usize, f64)> {
        let (sine, cosine) = (PI * (row as f64 + 0.5) / rows as f64).sin_cos();
        let at = |column: usize| {
            let (x, z) = (2.0 * PI * (column as f64 + 0.5) / columns as f64 - turned).sin_cos();
            let way = DVec3::new(sine * x, cosine, -sine * z);
            (cell_of(narrow(way)) as usize, radiance(data, way).element_sum() * sine)
        };
        (0..columns).map(at).filter(|&(_, light)| light > 0.0).collect()
    };
    let mut cells = vec![0.0; side * side];
    for row in (0..rows).into_par_iter().map(row).collect::<Vec<_>>() {
        row.into_iter().for_each(|(cell, light)| cells[cell] += light);
    }
    let around = |cell: usize| {
        let near = |n: usize| n.saturating_sub(1)..(n + 2).min(side);
        let (x, y) = (cell % side, cell / side);
        near(y).flat_map(|y| near(x).map(move |x| (x, y))).map(|(x, y)| cells[y * side + x]).sum()
    };
    (0..side * side).map(around).collect()
}

/// The table, once image and rows are written; empty where the environment is nearly even.
pub fn sky_cells(data: &Buffers) -> Vec<SkyCell> {
    let width = data.sky_columns.len();
    let (mut area, mut mean, mut square) = (0.0, 0.0, 0.0);
    for (row, pixels) in data.sky_rows.iter().zip(data.sky.chunks(width)) {
        let each = f64::from(row.first[0]);
        area += each * width as f64;
        for light in pixels.iter().map(|pixel| wide(*pixel).element_sum()) {
            mean += each * light;
            square += each * light * light;
        }
    }
    if square * area <= NEARLY_EVEN * mean * mean {
        return Vec::new();
    }
    let light = light(data);
    table(&light, light.iter().sum())
}

/// The table for cells of these weights.
fn table(weights: &[f64], sum: f64) -> Vec<SkyCell> {
    // Shares in draws.
    let mut shares: Vec<f64> = weights.iter().map(|x| x / sum * weights.len() as f64 * DRAWS as f64).collect();
    let mut cells: Vec<SkyCell> =
        (0..weights.len() as u32).map(|other| SkyCell { kept: DRAWS as u32, other, density: 0.0 }).collect();
    let (mut less, mut more): (Vec<usize>, Vec<usize>) =
        (0..shares.len()).partition(|&cell| shares[cell] < DRAWS as f64);
    while let (Some(&giver), Some(taker)) = (more.last(), less.pop()) {
        let kept = shares[taker].round() as u32;
        (cells[taker].kept, cells[taker].other) = (kept, giver as u32);
        shares[giver] -= DRAWS as f64 - f64::from(kept);
        if shares[giver] < DRAWS as f64 {
            less.extend(more.pop());
        }
    }
    // Densities are those of the whole numbers, not of the weights.
    let mut draws = vec![0; cells.len()];
    for (number, cell) in cells.iter().enumerate() {
        draws[number] += u64::from(cell.kept);
        draws[cell.other as usize] += DRAWS - u64::from(cell.kept);
    }
    // The map is a square of side 2.
    let area = 4.0 / cells.len() as f64;
    let all = cells.len() as f64 * DRAWS as f64;
    cells.iter_mut().zip(draws).for_each(|(cell, draws)| cell.density = (draws as f64 / all / area) as f32);
    cells
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::{Camera, LIGHT_BRIGHT_RAY, Light};
    use crate::view::mirror_ray::{bright, bright_density};

    #[test]
    fn rays_divided_by_their_density_have_the_mean_of_the_sphere() {
        let count = SKY_CELLS * SKY_CELLS;
        let weights: Vec<f64> = (0..count).map(|k| 1.0 + 3.0 * f64::from(k / 5000 % 4)).collect();
        let cells = table(&weights, weights.iter().sum());
        let mut data = Buffers { sky_cells: cells, camera: vec![Camera::default()], ..Buffers::default() };
        let ray = Light { kind: LIGHT_BRIGHT_RAY, of: 1, ..Light::default() };
        let (rays, mut sums) = (40_000, [0.0; 4]);
        for number in 0..rays {
            data.camera[0].sample_number = number;
            let way = bright(&data, &ray, 7);
            let [x, y, z] = way.map(f64::from);
            let share = 1.0 / bright_density(&data, way) / f64::from(rays) / (4.0 * PI);
            [1.0, x * x, y * z, z].iter().zip(&mut sums).for_each(|(value, sum)| *sum += share * value);
        }
        let off = sums.iter().zip([1.0, 1.0 / 3.0, 0.0, 0.0]).map(|(sum, exact)| (sum - exact).abs());
        assert!(off.fold(0.0, f64::max) < 0.01, "{sums:?}");
    }

    #[test]
    fn the_table_draws_cells_by_their_weights() {
        let weights: Vec<f64> = (0..512).map(|k| if k % 7 == 0 { f64::from(k * k) } else { 0.5 }).collect();
        let sum: f64 = weights.iter().sum();
        let cells = table(&weights, sum);
        let area = 4.0 / 512.0;
        let mut whole = 0.0;
        for (weight, cell) in weights.iter().zip(&cells) {
            let share = f64::from(cell.density) * area;
            // Each of the other cells may be rounded by half a draw.
            assert!((share - weight / sum).abs() <= 0.5 / DRAWS as f64, "{weight}: {share}");
            assert!(u64::from(cell.kept) <= DRAWS && (cell.other as usize) < 512);
            whole += share;
        }
        assert!((whole - 1.0).abs() < 1e-6, "{whole}");
    }
}
