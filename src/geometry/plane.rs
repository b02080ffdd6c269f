//! A triangle's plane, and on which side of it a point certainly lies: `f32` additions, multiplications and comparisons
//! in the order of `glsl/geometry/plane.glsl`.
//!
//! For corners a, b, c in `f32` and u = 2^-24: the edges b - a and c - a carry one rounding each (u), the products of
//! the normal two edges and one rounding (3 u), their difference one more (4 u), all relative to `size`, the same sum
//! with every term positive. The height of a point over the plane is a dot product of its offset from a (u) and that
//! normal: products (6 u), two sums (8 u). So its error is at most 8 u times the dot product of |offset| and `size`,
//! to first order in u. The test requires twice that, which covers the higher orders and the rounding of the bound
//! itself. The bound is relative, so it holds at every scale.

use super::trace::{cross, dot, minus};
use crate::layout::PLANE_ROUNDING;

/// The plane of a triangle.
#[derive(Clone, Copy, Debug)]
pub struct Plane {
    corner: [f32; 3],
    /// The plane's normal; its length is twice the triangle's area.
    pub normal: [f32; 3],
    size: [f32; 3],
}

impl Plane {
    /// The plane through these corners.
    pub fn new([a, b, c]: [[f32; 3]; 3]) -> Self {
        let (e1, e2) = (minus(b, a), minus(c, a));
        let (p, q) = (e1.map(f32::abs), e2.map(f32::abs));
        let size = [p[1] * q[2] + p[2] * q[1], p[2] * q[0] + p[0] * q[2], p[0] * q[1] + p[1] * q[0]];
        Self { corner: a, normal: cross(e1, e2), size }
    }

    /// Whether a point lies beyond the plane for certain, on the side that the normal points to (`side` 1) or the other
    /// (-1).
    pub fn beyond(&self, point: [f32; 3], side: f32) -> bool {
        let a = minus(point, self.corner);
        let height = side * dot(a, self.normal);
        height > PLANE_ROUNDING * dot(a.map(f32::abs), self.size)
    }
}
