//! A triangle as the edge form needs it: its edges as seen from the foot of the receiving point.
//!
//! Symbols of Table 2 of Mertens et al. 2003: the foot `d'` is the projection of the point on the triangle's plane,
//! `R` its distance to an edge's line (here [`Edge::offset`], with a sign: `sense * offset` is positive where the foot
//! is on the inner side), `t` the position along that line, counted from the foot's projection on it. Both
//! sources and all channels share the foot, so one footprint serves them all.

use super::vector_area;
use glam::DVec3;

/// One edge, walked from its lower to its higher vertex index.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// +1 if this walk is the triangle's own counter-clockwise direction, else -1.
    pub sense: f64,
    /// Distance of the foot to the edge's line, length; positive on the left of the walk.
    pub offset: f64,
    /// Position of the first end along the line, length.
    pub start: f64,
    /// Position of the second end along the line, length, not below `start`.
    pub end: f64,
}

/// A triangle seen from a point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Footprint {
    /// Signed height of the point over the triangle's plane, along its normal, length.
    pub delta: f64,
    /// The three edges in the triangle's order: corners 0-1, 1-2, 2-0.
    pub edges: [Edge; 3],
    /// Distance in the plane from the foot to the triangle, length; 0 inside and on the border.
    pub nearest: f64,
}

impl Footprint {
    /// The footprint of a triangle with counter-clockwise corners for the point `x_o`.
    ///
    /// `indices` are the corners' vertex indices in the mesh: an edge shared by two triangles with equal normals then
    /// has the same bits in both, with opposite `sense`. None if the area is 0 or not finite.
    #[must_use]
    pub fn new(triangle: &[DVec3; 3], indices: [u32; 3], x_o: DVec3) -> Option<Self> {
        let area = vector_area(triangle);
        let length = area.length();
        if length == 0.0 || !length.is_finite() {
            return None;
        }
        let normal = area / length;
        // All further arithmetic is relative to the point.
        let corners = [triangle[0] - x_o, triangle[1] - x_o, triangle[2] - x_o];
        let edge = |a: usize, b: usize| {
            if indices[a] <= indices[b] {
                Edge::new(corners[a], corners[b], normal, 1.0)
            } else {
                Edge::new(corners[b], corners[a], normal, -1.0)
            }
        };
        let edges = [edge(0, 1), edge(1, 2), edge(2, 0)];
        let lowest = (0..3).min_by_key(|&k| indices[k]).unwrap_or(0);
        Some(Self { delta: -corners[lowest].dot(normal), edges, nearest: nearest(&edges) })
    }
}

impl Edge {
    /// The edge between two points of a plane, relative to the foot, or to a point above it along the `normal`.
    pub(super) fn new(from: DVec3, to: DVec3, normal: DVec3, sense: f64) -> Self {
        let along = to - from;
        let length = along.length();
        // An edge without length has no direction; with no offset it contributes nothing.
        if length == 0.0 {
            return Self { sense, offset: 0.0, start: 0.0, end: 0.0 };
        }
        let unit = along / length;
        let start = from.dot(unit);
        Self { sense, offset: from.cross(unit).dot(normal), start, end: start + length }
    }

    /// Distance from the foot to the edge, length.
    fn distance(&self) -> f64 {
        let beyond = self.start.max(-self.end).max(0.0);
        self.offset.hypot(beyond)
    }
}

fn nearest(edges: &[Edge; 3]) -> f64 {
    if edges.iter().all(|edge| edge.sense * edge.offset >= 0.0) {
        return 0.0;
    }
    nearest_of(edges)
}

/// Distance in the plane from the foot to the nearest of these edges, length.
pub(super) fn nearest_of(edges: &[Edge]) -> f64 {
    edges.iter().map(Edge::distance).fold(f64::INFINITY, f64::min)
}

#[cfg(test)]
mod tests {
    use super::*;

    const TRIANGLE: [DVec3; 3] = [DVec3::ZERO, DVec3::X, DVec3::Y];

    #[test]
    fn inside_and_outside() {
        let inside = Footprint::new(&TRIANGLE, [0, 1, 2], DVec3::new(0.2, 0.3, 0.5)).unwrap();
        assert_eq!((inside.delta, inside.nearest), (0.5, 0.0));
        let outside = Footprint::new(&TRIANGLE, [5, 1, 2], DVec3::new(-3.0, -4.0, -1.0)).unwrap();
        assert_eq!((outside.delta, outside.nearest), (-1.0, 5.0));
    }

    #[test]
    fn no_area_no_footprint() {
        let line = [DVec3::ZERO, DVec3::X, 2.0 * DVec3::X];
        assert!(Footprint::new(&line, [0, 1, 2], DVec3::ZERO).is_none());
    }
}
