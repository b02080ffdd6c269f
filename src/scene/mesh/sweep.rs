//! Closed surfaces swept around an axis, ring by ring.

use super::Mesh;
use super::number;
use glam::DVec3;
use std::f64::consts::TAU;

/// A surface of rings with these numbers of vertices, each equal to the one before, or twice or half of it, or 1 on the
/// axis, as the first and the last are. `point` gives the position for a ring and an angle. With the axis on the left,
/// the outside is to the right of the path from ring to ring.
pub(super) fn sweep(counts: &[u32], point: impl Fn(usize, f64) -> DVec3) -> Mesh {
    let mut positions = Vec::new();
    let mut starts = Vec::with_capacity(counts.len());
    for (ring, &cells) in counts.iter().enumerate() {
        starts.push(positions.len());
        positions.extend((0..cells).map(|cell| point(ring, TAU * f64::from(cell) / f64::from(cells))));
    }
    let mut triangles = Vec::new();
    for (pair, start) in counts.windows(2).zip(starts.windows(2)) {
        join(&positions, (start[0], pair[0] as usize), (start[1], pair[1] as usize), &mut triangles);
    }
    Mesh::made(positions, triangles)
}

/// A torus about the z axis with major radius 1 and minor radius `tube`: `cells` along it, and around the tube as many
/// as make cells nearly square.
pub(super) fn torus(cells: u32, tube: f64) -> Mesh {
    let round = ((f64::from(cells) * tube).round() as u32).max(3);
    let point = |k: u32| {
        let [along, about] = [(k / round, cells), (k % round, round)].map(|(k, n)| TAU * f64::from(k) / f64::from(n));
        let radius = 1.0 + tube * about.cos();
        DVec3::new(radius * along.cos(), radius * along.sin(), tube * about.sin())
    };
    let cell = |k: u32| {
        let at = |along: u32, about: u32| (k / round + along) % cells * round + (k % round + about) % round;
        [[at(0, 0), at(1, 0), at(1, 1)], [at(0, 0), at(1, 1), at(0, 1)]]
    };
    Mesh::made((0..cells * round).map(point).collect(), (0..cells * round).flat_map(cell).collect())
}

/// The triangles between two rings, each given by its first vertex and its count. The counts are equal, or one is twice
/// the other, or one is 1.
fn join(positions: &[DVec3], (a, na): (usize, usize), (b, nb): (usize, usize), triangles: &mut Vec<[u32; 3]>) {
    let low = |cell: usize| number(a + cell % na);
    let high = |cell: usize| number(b + cell % nb);
    for cell in 0..na.max(nb) {
        let [a0, a1] = [low(cell * na / na.max(nb)), low((cell + 1) * na / na.max(nb))];
        let [b0, b1] = [high(cell * nb / na.max(nb)), high((cell + 1) * nb / na.max(nb))];
        if na == 1 || (na < nb && a0 == a1) {
            triangles.push([a0, b0, b1]);
        } else if nb == 1 || (nb < na && b0 == b1) {
            triangles.push([a0, b0, a1]);
        } else {
            // Two triangles, along the shorter diagonal.
            let length = |p: u32, q: u32| positions[p as usize].distance(positions[q as usize]);
            if length(b0, a1) <= length(a0, b1) {
                triangles.extend([[a0, b0, a1], [a1, b0, b1]]);
            } else {
                triangles.extend([[a0, b0, b1], [a0, b1, a1]]);
            }
        }
    }
}

/// The same surface, oriented outwards whichever way it was swept.
pub(super) fn outward(mut mesh: Mesh) -> Mesh {
    if mesh.volume() < 0.0 {
        mesh.triangles.iter_mut().for_each(|corners| corners.swap(1, 2));
    }
    mesh
}

/// Smoothstep: from 0 at `low` to 1 at `high`.
pub(super) fn smooth(low: f64, high: f64, x: f64) -> f64 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}
