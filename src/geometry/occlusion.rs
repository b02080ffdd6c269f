//! Whether a ray from a triangle towards a light is blocked: a decision, in step with `glsl/geometry/occlusion.glsl`.
//!
//! A triangle blocks when the ray passes through it by [`trace`](super::trace)'s test, and
//! - it is not the one that the ray starts from;
//! - one of its corners lies in front of the plane of that one, for certain ([`Plane::beyond`]). Light that arrives from
//!   the front never goes below that plane, so this leaves out no triangle that could block, but every one that rounding
//!   might put in the way: flat and convex neighbours, however fine, and coincident sheets. A convex object never shadows
//!   itself, at any light and any scale;
//! - a light that has a place lies beyond the triangle, for certain: a light in a surface is not blocked by that surface.
//!
//! What is left to rounding is which side of an edge a ray passes, as for any ray; a ray along a shared edge meets at
//! least one of the two triangles.

use super::plane::Plane;
use super::trace::{Nearest, UNFINISHED, cross, dot, meets, minus};
use crate::layout::Buffers;

/// A ray from a triangle towards a light.
#[derive(Clone, Copy, Debug)]
pub struct Ray {
    /// The triangle that it starts from.
    pub face: u32,
    /// Where it starts.
    pub origin: [f32; 3],
    /// Where it runs to, of any length.
    pub direction: [f32; 3],
    /// The light's position; none where it is infinitely far away.
    pub light: Option<[f32; 3]>,
    /// On which side of its triangle it leaves: 1 in front, -1 behind.
    pub side: f32,
}

/// Whether any triangle of `data` blocks the ray.
pub fn blocked(data: &Buffers, ray: &Ray) -> bool {
    let corners = |face: u32| data.triangles[face as usize].map(|v| data.positions[v as usize]);
    let own = Plane::new(corners(ray.face));
    let face = if ray.light.is_none() { u32::MAX } else { UNFINISHED };
    let limit = Nearest { face, weights: [0.0; 3], numerator: 1.0, denominator: 1.0 };
    let (origin, direction) = (ray.origin, ray.direction);
    let dd = dot(direction, direction);
    let mut node = 0;
    while let Some(bounds) = data.bounds.get(node) {
        let met = meets(bounds.low, bounds.high, origin, direction, dd, &limit);
        node = if met && bounds.face == u32::MAX { node + 1 } else { bounds.next as usize };
        if !met || bounds.face == u32::MAX || bounds.face == ray.face {
            continue;
        }
        let points = corners(bounds.face);
        let [a, b, c] = points.map(|point| minus(point, origin));
        let w = [dot(direction, cross(b, c)), dot(direction, cross(c, a)), dot(direction, cross(a, b))];
        let inside = w.iter().all(|&x| x >= 0.0) || w.iter().all(|&x| x <= 0.0);
        if !inside || w[0] + w[1] + w[2] == 0.0 {
            continue;
        }
        let plane = Plane::new(points);
        let (numerator, denominator) = (dot(a, plane.normal), dot(direction, plane.normal));
        let through = if denominator > 0.0 { 1.0 } else { -1.0 };
        let ahead = denominator != 0.0 && through * numerator > 0.0;
        let nearer = ray.light.is_none_or(|light| plane.beyond(light, through));
        if ahead && nearer && points.iter().any(|&point| own.beyond(point, ray.side)) {
            return true;
        }
    }
    false
}
