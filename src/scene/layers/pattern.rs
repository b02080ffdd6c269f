//! Depth maps made here.

use std::f64::consts::TAU;

/// Their names.
pub(super) const NAMES: [&str; 1] = ["builtin:veins"];

/// Texels along a side.
const SIDE: u32 = 512;

/// Whether a map of this name is made here.
pub(super) fn is(name: &str) -> bool {
    NAMES.contains(&name)
}

/// The map of this name, channels as shares of the scale, 0 at the surface; it goes on without a seam.
pub(super) fn of(name: &str) -> Option<([u32; 2], Vec<[f32; 4]>)> {
    let depths: fn(f64, f64) -> [f64; 4] = match name {
        "builtin:veins" => veins,
        _ => return None,
    };
    let place = |k: u32| (f64::from(k) + 0.5) / f64::from(SIDE);
    let texel = |k: u32| depths(place(k % SIDE), place(k / SIDE)).map(|x| x.clamp(0.0, 1.0) as f32);
    Some(([SIDE, SIDE], (0..SIDE * SIDE).map(texel).collect()))
}

/// A sum of waves that fits the unit square, about -1 to 1: wave numbers in u and v, phase in turns.
fn waves(u: f64, v: f64, list: &[(f64, f64, f64)]) -> f64 {
    let sum: f64 = list.iter().map(|&(a, b, turn)| (TAU * (a * u + b * v + turn)).sin()).sum();
    sum / (list.len() as f64).sqrt()
}

/// 1 where a wave crosses 0, falling to 0 at `width` on either side, as a tube's thickness does.
fn tube(wave: f64, width: f64) -> f64 {
    (1.0 - (wave / width).powi(2)).max(0.0).sqrt()
}

/// Skin, blood in two widths of veins, flesh to the full depth.
fn veins(u: f64, v: f64) -> [f64; 4] {
    let bend = 0.03 * waves(u, v, &[(3.0, 1.0, 0.1), (-2.0, 4.0, 0.6), (5.0, 3.0, 0.3)]);
    let (u, v) = (u + bend, v - bend);
    let large = waves(u, v, &[(2.0, 1.0, 0.2), (-1.0, 2.0, 0.7), (1.0, -3.0, 0.45)]);
    let small = waves(u, v, &[(5.0, 2.0, 0.9), (-3.0, 6.0, 0.15), (6.0, -5.0, 0.5), (-7.0, -2.0, 0.3)]);
    let blood = f64::max(0.45 * tube(large, 0.12), 0.2 * tube(small, 0.14));
    [0.2, 0.2 + blood, 1.0, 1.0]
}
