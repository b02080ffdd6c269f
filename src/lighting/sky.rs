//! The environment's radiance from one direction: its image, bilinear between the centres of pixels.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use crate::layout::Buffers;
use crate::state::wide;

/// Radiance from a direction of any length but 0, in internal units; columns wrap around, rows end at the poles.
#[must_use]
pub fn radiance(data: &Buffers, direction: DVec3) -> DVec3 {
    let params = &data.object_params[0];
    let [width, height] = params.sky.map(|n| n as usize);
    let turns = direction.x.atan2(-direction.z) / TAU + f64::from(params.sky_turn);
    let polar = direction.x.hypot(direction.z).atan2(direction.y);
    let x = width as f64 * turns.rem_euclid(1.0) - 0.5;
    let y = (height as f64 * polar / PI - 0.5).clamp(0.0, (height - 1) as f64);
    let left = (x.floor() as i64).rem_euclid(width as i64) as usize;
    let top = y.floor() as usize;
    let row = |row: usize| {
        let at = |column: usize| wide(data.sky[row.min(height - 1) * width + column % width]);
        at(left).lerp(at(left + 1), x - x.floor())
    };
    row(top).lerp(row(top + 1), y - y.floor())
}

/// The direction of ray `k` of `count`, evenly spread over the sphere: a Fibonacci lattice.
#[must_use]
pub fn fibonacci_direction(k: u32, count: u32) -> DVec3 {
    let y = 1.0 - (2.0 * f64::from(k) + 1.0) / f64::from(count);
    let turn = f64::from(k) * PI * (3.0 - 5f64.sqrt());
    let across = (1.0 - y * y).sqrt();
    DVec3::new(across * turn.cos(), y, across * turn.sin())
}
