//! The lotus: a bowl of two staggered rows of petals, as one closed sheet, thick at the base and thin at the rim, so
//! that a light inside makes the petals glow.
//!
//! The sheet is swept around the y axis. Its middle follows a curve from the bottom to the rim, ends at a height that
//! outlines the petals, and is offset in and out to cup them; the two walls are half a thickness on either side.

use super::Mesh;
use super::sweep::{smooth, sweep};
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// Petals in a row.
const PETALS: f64 = 8.0;

/// The Bezier curve of the sheet's middle: radius and height from the bottom to the highest tip.
const CURVE: [DVec2; 4] = [DVec2::ZERO, DVec2::new(0.84, 0.0), DVec2::new(0.68, 0.52), DVec2::new(0.92, 1.04)];

/// The full thickness at the bottom and at the rim.
const THICKNESS: [f64; 2] = [0.12, 0.03];

/// Where the rounding of the rim begins, as a fraction of the way from bottom to rim.
const ROUNDING: f64 = 0.986;

/// Half the width of a petal of the inner row, as a fraction of half the pitch.
const INNER_WIDTH: f64 = 0.64;

/// A closed lotus with `cells` around the circle, in units of about half its width.
pub(super) fn lotus(cells: u32) -> Mesh {
    let rings = rings(cells);
    let counts: Vec<u32> = rings.iter().map(|ring| ring.cells).collect();
    sweep(&counts, |ring, angle| point(angle, rings[ring].way, rings[ring].side))
}

/// One ring of vertices.
#[derive(Debug, Clone, Copy)]
struct Ring {
    /// Position from the bottom to the rim, 0 to 1.
    way: f64,
    /// The wall: 1 the outer, -1 the inner, and in between over the rim.
    side: f64,
    /// Vertices on the ring; 1 at the bottom.
    cells: u32,
}

/// The rings from the bottom up the outer wall, over the rim, and down the inner wall.
fn rings(cells: u32) -> Vec<Ring> {
    // The wall: even steps, with fewer cells where the circle gets small.
    let rows = (cells / 4).max(6);
    let mut wall: Vec<Ring> =
        (0..=rows).map(|row| Ring { way: ROUNDING * f64::from(row) / f64::from(rows), side: 1.0, cells }).collect();
    let step = 1.3 / f64::from(rows);
    let mut count = cells;
    for ring in wall.iter_mut().rev() {
        let spacing = TAU * curve(ring.way * 0.85)[0].x / f64::from(count);
        if spacing < 0.6 * step && count.is_multiple_of(2) && count >= 16 {
            count /= 2;
        }
        ring.cells = count;
    }
    if let Some(bottom) = wall.first_mut() {
        bottom.cells = 1;
    }

    // The rim: a half circle, whose middle belongs to both walls.
    let cap = (1..6).map(|step| {
        let (sine, cosine) = (TAU / 12.0 * f64::from(step)).sin_cos();
        let side = if step == 3 { 0.0 } else { cosine };
        Ring { way: ROUNDING + (1.0 - ROUNDING) * sine, side, cells }
    });
    let inner = wall.iter().rev().map(|ring| Ring { side: -1.0, ..*ring });
    wall.iter().copied().chain(cap).chain(inner).collect()
}

/// A point of the sheet at an angle, a position from bottom to rim, and a side.
fn point(angle: f64, way: f64, side: f64) -> DVec3 {
    let petal = Petal::at(angle);
    let t = way * petal.height;
    let [middle, tangent] = curve(t);
    let normal = DVec2::new(tangent.y, -tangent.x).normalize_or(DVec2::NEG_Y);
    let thickness = THICKNESS[0] + (THICKNESS[1] - THICKNESS[0]) * smooth(0.05, 0.95, way);
    let offset = petal.push * smooth(0.2, 0.95, t) + side * thickness / 2.0;
    let flat = middle + normal * offset;
    // The poles lie exactly on the axis.
    let radius = if way == 0.0 { 0.0 } else { flat.x };
    DVec3::new(radius * angle.cos(), flat.y, radius * angle.sin())
}

/// Height and offset of the sheet at an angle.
#[derive(Debug)]
struct Petal {
    /// How far the sheet reaches along the curve, 0 to 1.
    height: f64,
    /// How far the rim is pushed outwards.
    push: f64,
}

impl Petal {
    fn at(angle: f64) -> Self {
        // Distance from the middle of the nearest petal of each row, 0 to 1.
        let turn = angle * PETALS / TAU;
        let inner = 2.0 * (turn - turn.round()).abs();
        let outer = 1.0 - inner;

        // The outline: each petal is an arch that ends in a point.
        let arch = |x: f64| (1.0 - x * x).max(0.0).sqrt() * 0.76 + 0.24 * (-x / 0.15).exp();
        let inner_height = 0.46 + 0.54 * arch((inner / 0.88).min(1.0));
        let outer_height = 0.46 + 0.40 * arch((outer / 0.72).min(1.0));
        let height = soft_max(inner_height, outer_height, 0.015);

        // The rows: both are cupped, the outer one leans further out.
        let cup = |x: f64, width: f64| 1.0 - (x / width).powi(2);
        let inner_push = 0.10 * cup(inner, INNER_WIDTH);
        let outer_push = 0.15 + 0.07 * cup(outer, 1.0 - INNER_WIDTH);
        let blend = smooth(INNER_WIDTH - 0.12, INNER_WIDTH + 0.12, inner);
        Self { height, push: inner_push + (outer_push - inner_push) * blend }
    }
}

/// The point and the tangent of the middle curve at `t`, 0 to 1.
fn curve(t: f64) -> [DVec2; 2] {
    let u = 1.0 - t;
    let [a, b, c, d] = CURVE;
    let point = a * u * u * u + b * 3.0 * u * u * t + c * 3.0 * u * t * t + d * t * t * t;
    let tangent = (b - a) * u * u + (c - b) * 2.0 * u * t + (d - c) * t * t;
    [point, tangent]
}

/// The larger of two numbers, smoothed where they are within `width` of each other.
fn soft_max(a: f64, b: f64, width: f64) -> f64 {
    f64::midpoint(a + b, ((a - b).powi(2) + width * width).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn walls_are_thick_below_and_thin_at_the_rim() {
        let gap = |way: f64| point(0.0, way, 1.0).distance(point(0.0, way, -1.0));
        assert!((gap(0.0) - THICKNESS[0]).abs() < 1e-12);
        assert!((gap(1.0) - THICKNESS[1]).abs() < 1e-12);
    }

    #[test]
    fn every_eighth_of_a_turn_is_the_same() {
        for step in 0..100 {
            let angle = TAU * f64::from(step) / 800.0;
            let (a, b) = (Petal::at(angle), Petal::at(angle + TAU / PETALS));
            assert!((a.height - b.height).abs() < 1e-9 && (a.push - b.push).abs() < 1e-9);
            assert!(a.height > 0.46 && a.height <= 1.01);
        }
    }

    #[test]
    fn triangles_are_well_shaped() {
        let mesh = lotus(256);
        let quality = |triangle: usize| {
            let [a, b, c] = mesh.corners(triangle).unwrap_or_default();
            let longest = a.distance(b).max(b.distance(c)).max(c.distance(a));
            (b - a).cross(c - a).length() / (longest * longest)
        };
        let worst = (0..mesh.triangles.len()).map(quality).fold(f64::INFINITY, f64::min);
        assert!(worst > 0.02, "{worst}");
    }
}
