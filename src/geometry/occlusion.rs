//! Whether a ray from a triangle towards a light is blocked: a decision, in step with `glsl/geometry/occlusion.glsl`.
//!
//! A triangle blocks the ray if the ray passes through it by [`trace`](super::trace)'s test, and all of these hold:
//! - It is not the triangle that the ray starts from.
//! - One of its corners lies in front of the plane of that triangle, for certain ([`Plane::beyond`]). Light that
//!   arrives from the front never goes below that plane, so this rejects no triangle that could block, but every one
//!   that rounding might put in the way: flat and convex neighbours, however fine, and coincident sheets. A convex
//!   object never shadows itself, at any light and any scale.
//! - It is not spared. Where an object does not shadow itself, all its triangles are spared, and the test of corners
//!   is skipped.
//! - The light, if it has a position, lies beyond the triangle, for certain: a light in a surface is not blocked by
//!   that surface.
//!
//! The only thing left to rounding is on which side of an edge a ray passes, as for any ray; a ray through a shared
//! edge or corner hits at least one of the triangles.

use std::ops::Range;

use super::plane::Plane;
use super::trace::{Nearest, Sight, UNFINISHED, dot, meets, minus};
use crate::layout::{Buffers, NONE};

/// A ray from a triangle towards a light.
#[derive(Clone, Debug)]
pub struct Ray {
    /// The triangle that it starts from.
    pub face: u32,
    /// The point where it starts.
    pub origin: [f32; 3],
    /// Its direction, of any length.
    pub direction: [f32; 3],
    /// The light's position; none for a light at infinity.
    pub light: Option<[f32; 3]>,
    /// On which side of its triangle the ray leaves: 1 in front, -1 behind.
    pub side: f32,
    /// Triangles that block nothing. If given, triangles behind the plane that the ray starts from do block.
    pub spared: Option<Range<u32>>,
}

/// Whether any triangle of `data` blocks the ray.
pub fn blocked(data: &Buffers, ray: &Ray) -> bool {
    let corners = |face: u32| data.triangles[face as usize].map(|v| data.in_scene()[v as usize]);
    let start = Plane::new(corners(ray.face));
    let face = if ray.light.is_none() { NONE } else { UNFINISHED };
    let sight = Sight::new(ray.direction);
    // The light is at `along / scale`.
    let limit = Nearest { face, weights: [0.0; 3], numerator: sight.square, denominator: sight.scale };
    let mut node = 0;
    let boxes = data.bounds_in_scene();
    while let Some(bounds) = boxes.get(node) {
        let met = meets(bounds.low, bounds.high, ray.origin, &sight, &limit);
        node = if met && bounds.face == NONE { node + 1 } else { bounds.next as usize };
        let spared = ray.spared.as_ref().is_some_and(|spared| spared.contains(&bounds.face));
        if !met || bounds.face == NONE || bounds.face == ray.face || spared {
            continue;
        }
        let points = corners(bounds.face);
        let Some(found) = sight.pierce(points.map(|point| minus(point, ray.origin))) else { continue };
        let plane = Plane::new(points);
        let through = if dot(ray.direction, plane.normal) > 0.0 { 1.0 } else { -1.0 };
        let nearer = ray.light.is_none_or(|light| plane.beyond(light, through));
        let front = || points.iter().any(|&point| start.beyond(point, ray.side));
        if found.numerator > 0.0 && nearer && (ray.spared.is_some() || front()) {
            return true;
        }
    }
    false
}
