//! A fish-like body: a swept spindle, narrower than it is high, with fins in the same surface.

use super::Mesh;
use super::sweep::{outward, smooth, sweep};
use glam::DVec3;
use std::f64::consts::PI;

/// Vertices of a ring, and rings, at detail 1.
const CELLS: u32 = 34;
const RINGS: u32 = 41;

/// A fish 1 long, its nose at +x, its back at +y; at detail 1 it has 1396 vertices and 2788 triangles.
pub(super) fn fish(detail: u32) -> Mesh {
    let (cells, rings) = (CELLS * detail, RINGS * detail);
    let counts: Vec<u32> = (0..rings + 2).map(|ring| if ring == 0 || ring == rings + 1 { 1 } else { cells }).collect();
    // Rings are denser towards both ends.
    let along = |ring: usize| 0.5 - 0.5 * (PI * ring as f64 / f64::from(rings + 1)).cos();
    outward(sweep(&counts, |ring, angle| surface(along(ring), angle)))
}

/// The point at `s`, 0 at the nose to 1 at the tail's end, and an angle around the body, 0 at its side.
fn surface(s: f64, angle: f64) -> DVec3 {
    let (up, side) = angle.sin_cos();
    // Body: a drop, thickest at a third of its length, that tapers into the tail.
    let body = (s / 0.34).clamp(0.0, 1.0);
    let front = (body * (2.0 - body)).sqrt();
    let back = 1.0 - 0.84 * smooth(0.3, 0.86, s);
    let (mut height, width) = (0.17 * front * back, 0.085 * front * back * (1.0 - 0.7 * smooth(0.8, 1.0, s)));
    // The tail fin spreads, with a notch that is deepest in the middle; fins on back and belly.
    let tail = smooth(0.84, 0.97, s);
    height += 0.17 * tail * up.abs().sqrt();
    let dorsal = 0.1 * smooth(0.3, 0.42, s) * (1.0 - smooth(0.5, 0.72, s)) * smooth(0.8, 1.0, up);
    let ventral = 0.06 * smooth(0.52, 0.58, s) * (1.0 - smooth(0.6, 0.7, s)) * smooth(0.85, 1.0, -up);
    let end = 1.0 - smooth(0.985, 1.0, s);
    let y = (height * up) * end + dorsal - ventral;
    let cut = 0.05 * tail * (1.0 - up.abs() * end) * smooth(0.9, 1.0, s);
    DVec3::new(0.5 - s + cut, y, width * side * end)
}
