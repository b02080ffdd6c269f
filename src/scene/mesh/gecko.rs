//! A gecko-like body with four legs, in a skin of small bumps.

use super::Mesh;
use super::number;
use super::sweep::{outward, smooth, sweep};
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, PI};

/// Cells around and rings along the body and a leg, at detail 1.
const BODY: [u32; 2] = [40, 90];
const LEG: [u32; 2] = [18, 26];

/// A gecko about 1 long in the xz-plane, its nose at +x, its back at +y; at detail 1 it has 10,944 triangles.
pub(super) fn gecko(detail: u32) -> Mesh {
    let mut parts = vec![tube(BODY.map(|n| n * detail), |s, angle| bumpy(spine(s), radius(s), angle))];
    for (place, side) in [(0.3, 1.0), (0.3, -1.0), (0.55, 1.0), (0.55, -1.0)] {
        parts.push(tube(LEG.map(|n| n * detail), |s, angle| bumpy(leg(place, side, s), limb(s), angle)));
    }
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for part in parts {
        let first = number(positions.len());
        positions.extend(part.positions);
        triangles.extend(part.triangles.iter().map(|corners| corners.map(|v| v + first)));
    }
    Mesh::made(positions, triangles)
}

/// A tube of so many cells and rings that is closed at both ends.
fn tube([cells, rings]: [u32; 2], point: impl Fn(f64, f64) -> DVec3) -> Mesh {
    let counts: Vec<u32> = (0..rings + 2).map(|ring| if ring == 0 || ring == rings + 1 { 1 } else { cells }).collect();
    let along = |ring: usize| ring as f64 / f64::from(rings + 1);
    outward(sweep(&counts, |ring, angle| point(along(ring), angle)))
}

/// Position and direction of the spine, from nose to tail.
fn spine(s: f64) -> (DVec3, DVec3) {
    let bend = |s: f64| 0.1 * (2.2 * PI * s).sin() * smooth(0.2, 0.9, s);
    let step = 1e-4;
    let slope = (bend(s + step) - bend(s - step)) / (2.0 * step);
    (DVec3::new(0.5 - s, 0.0, bend(s)), DVec3::new(-1.0, 0.0, slope).normalize())
}

/// Half width and half height of the body.
fn radius(s: f64) -> [f64; 2] {
    let head = 0.06 * smooth(0.0, 0.08, s).sqrt() * (1.0 - 0.45 * smooth(0.1, 0.2, s));
    let trunk = 0.04 * smooth(0.17, 0.35, s) * (1.0 - smooth(0.5, 0.68, s));
    let tail = 1.0 - smooth(0.55, 1.02, s) * 0.98;
    [(head + trunk) * tail, 0.72 * (head + trunk) * tail]
}

/// Position and direction of a leg that begins at `place` of the spine and goes to one side, then down.
fn leg(place: f64, side: f64, s: f64) -> (DVec3, DVec3) {
    let (hip, _) = spine(place);
    let at = |s: f64| {
        let turn = FRAC_PI_2 * s;
        let forward = if place < 0.4 { 0.05 } else { -0.05 };
        hip + DVec3::new(forward * (PI * s).sin(), -0.06 * (1.0 - turn.cos()), side * 0.17 * turn.sin())
    };
    let step = 1e-4;
    (at(s), (at(s + step) - at(s - step)).normalize())
}

fn limb(s: f64) -> [f64; 2] {
    let round = smooth(0.0, 0.1, s).sqrt() * (1.0 - smooth(0.9, 1.0, s)).sqrt();
    // The foot.
    let thick = 0.02 - 0.006 * smooth(0.2, 0.7, s) + 0.012 * smooth(0.78, 0.95, s);
    [thick * round, (0.02 - 0.01 * smooth(0.6, 1.0, s)) * round]
}

/// A point around a position on a tube, displaced by the skin's bumps.
fn bumpy((center, along): (DVec3, DVec3), [width, height]: [f64; 2], angle: f64) -> DVec3 {
    let aside = along.cross(DVec3::Y).normalize_or(DVec3::Z);
    let up = aside.cross(along);
    let (sin, cos) = angle.sin_cos();
    let flat = center + aside * (width * cos) + up * (height * sin);
    let wave =
        |p: DVec3| (95.0 * p.x).sin() * (95.0 * p.z + 1.3).sin() + (71.0 * (p.x + p.z)).sin() * (80.0 * p.y).cos();
    let lift = 1.0 + 0.05 * wave(flat);
    center + (flat - center) * lift
}
