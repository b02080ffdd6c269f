//! The bust: a head on shoulders and a plinth, a smooth union of ellipsoids, capsules and drums.

use super::{Mesh, edges::Edges, nets};
use glam::{DVec2, DVec3};

/// The corners of a bounding box.
const LOW: DVec3 = DVec3::new(-0.66, -1.02, -0.62);
const HIGH: DVec3 = DVec3::new(0.66, 0.9, 0.56);

/// A closed bust 1.8 high, looking along +z, with about `cells` grid cells from top to bottom.
pub(super) fn bust(cells: u32) -> Mesh {
    // If two sheets of the surface touch in an edge, try a slightly finer grid.
    let on = |finer: i32| {
        let side = (HIGH.y - LOW.y) / f64::from(cells) * (1.0 - 4e-3 * f64::from(finer));
        nets::surface(distance, LOW, HIGH, side)
    };
    let clean = |mesh: &Mesh| Edges::of(&mesh.triangles).crowded == 0;
    (0..16).map(on).find(clean).unwrap_or_else(|| on(0))
}

/// Approximate signed distance to the surface, negative inside; symmetric about x = 0 except for the hair.
fn distance(p: DVec3) -> f64 {
    let head = p + DVec3::Y * 0.1;
    blend(face(head), body(p), 0.1)
}

/// The head and the neck.
fn face(p: DVec3) -> f64 {
    let half = DVec3::new(p.x.abs(), p.y, p.z);
    let at = DVec3::new;

    // Skull, jaw, chin, cheeks and brows.
    let mut d = ellipsoid(p, at(0.0, 0.57, -0.05), at(0.27, 0.32, 0.34));
    d = blend(d, ellipsoid(p, at(0.0, 0.37, 0.09), at(0.2, 0.3, 0.23)), 0.08);
    d = blend(d, ellipsoid(p, at(0.0, 0.125, 0.215), at(0.08, 0.065, 0.065)), 0.1);
    d = blend(d, ellipsoid(half, at(0.125, 0.37, 0.2), at(0.07, 0.07, 0.07)), 0.09);
    d = blend(d, bar(half, at(0.03, 0.56, 0.29), at(0.15, 0.55, 0.235), 0.028, 0.022), 0.06);

    // Eyes: hollows with lids in them.
    d = carve(d, ellipsoid(half, at(0.1, 0.475, 0.345), at(0.075, 0.045, 0.06)), 0.06);
    d = blend(d, ellipsoid(half, at(0.1, 0.475, 0.258), at(0.055, 0.036, 0.04)), 0.012);

    // Nose and mouth.
    d = blend(d, bar(p, at(0.0, 0.53, 0.3), at(0.0, 0.36, 0.385), 0.024, 0.034), 0.04);
    d = blend(d, ellipsoid(half, at(0.034, 0.345, 0.34), at(0.026, 0.022, 0.034)), 0.03);
    d = blend(d, ellipsoid(p, at(0.0, 0.25, 0.285), at(0.08, 0.05, 0.05)), 0.05);
    d = blend(d, bar(half, at(0.0, 0.266, 0.335), at(0.06, 0.252, 0.3), 0.017, 0.008), 0.015);
    d = blend(d, bar(p * at(0.85, 1.0, 1.0), at(-0.03, 0.22, 0.322), at(0.03, 0.22, 0.322), 0.02, 0.02), 0.02);

    // Ears.
    d = blend(d, ellipsoid(half, at(0.275, 0.44, -0.03), at(0.035, 0.095, 0.06)), 0.02);
    d = carve(d, ellipsoid(half, at(0.315, 0.45, 0.0), at(0.02, 0.055, 0.03)), 0.03);

    // Hair: a wavy cap, open at the face.
    let wave = 0.013 * (26.0 * p.y + 9.0 * p.z + 3.0 * (5.0 * p.x).sin()).sin() * (1.0 - (-(p.x / 0.05).powi(2)).exp());
    let cap = ellipsoid(p, at(0.0, 0.605, -0.075), at(0.315, 0.335, 0.355)) + wave;
    let open = ellipsoid(p, at(0.0, 0.34, 0.33), at(0.27, 0.36, 0.3));
    let cap = carve(cap, open, 0.05);
    d = blend(d, cap, 0.012);
    d = blend(d, ellipsoid(p, at(0.0, 0.42, -0.42), at(0.12, 0.11, 0.1)) + 0.5 * wave, 0.05);

    blend(d, bar(p, at(0.0, 0.2, -0.06), at(0.0, -0.1, -0.09), 0.135, 0.16), 0.06)
}

/// Shoulders and chest, rounded off, on a plinth.
fn body(p: DVec3) -> f64 {
    let half = DVec3::new(p.x.abs(), p.y, p.z);
    let at = DVec3::new;
    let mut d = bar(half, at(0.0, -0.28, -0.09), at(0.36, -0.36, -0.1), 0.17, 0.14);
    d = blend(d, bar(half, at(0.06, -0.06, -0.12), at(0.34, -0.28, -0.11), 0.1, 0.09), 0.12);
    d = blend(d, ellipsoid(p, at(0.0, -0.43, -0.02), at(0.36, 0.3, 0.22)), 0.14);
    d = blend(d, ellipsoid(half, at(0.15, -0.4, 0.1), at(0.16, 0.12, 0.1)), 0.12);
    d = blend(d, drum(p, -0.7, 0.13, 0.11, 0.04), 0.1);
    blend(d, drum(p, -0.9, 0.24, 0.1, 0.045), 0.04)
}

/// Approximate signed distance to an ellipsoid.
fn ellipsoid(p: DVec3, middle: DVec3, radii: DVec3) -> f64 {
    let k = ((p - middle) / radii).length();
    let slope = ((p - middle) / (radii * radii)).length();
    if slope > 0.0 { k * (k - 1.0) / slope } else { -radii.min_element() }
}

/// Signed distance to a capsule, from radius `r` at `a` to `s` at `b`.
fn bar(p: DVec3, a: DVec3, b: DVec3, r: f64, s: f64) -> f64 {
    let along = ((p - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
    p.distance(a.lerp(b, along)) - (r + (s - r) * along)
}

/// Signed distance to an upright cylinder with rounded edges, about the vertical line at x = 0, z = -0.05.
fn drum(p: DVec3, middle: f64, radius: f64, half_height: f64, round: f64) -> f64 {
    let out = DVec2::new(p.x.hypot(p.z + 0.05) - radius, (p.y - middle).abs() - half_height) + round;
    out.max(DVec2::ZERO).length() + out.max_element().min(0.0) - round
}

/// Smooth union of two bodies, blended over `width`.
fn blend(a: f64, b: f64, width: f64) -> f64 {
    let near = (width - (a - b).abs()).max(0.0) / width;
    a.min(b) - near * near * near * width / 6.0
}

/// Smooth difference: the first body without the second.
fn carve(a: f64, b: f64, width: f64) -> f64 {
    -blend(-a, b, width)
}
