//! Rays to the environment from a surface that reflects it, drawn from the lobe in which it mirrors the eye, in step with
//! `glsl/view/mirror_ray.glsl`.
//!
//! GGX: microfacets as the eye sees them, by spherical caps (Dupuy and Benyoub 2023). Phong: about the mirror direction,
//! by the distribution of microfacets that is nearest to the lobe, [`narrowing`]. Numbers are those of [`square_point`]: other
//! ones in each pixel and sample. All arithmetic is in `f32`, with the same bits on every device, since rays decide what
//! is hidden.

use super::pixel_receivers::place;
use crate::geometry::deform::turn;
use crate::geometry::exact::{inverse, kept_unit, root, unit};
use crate::geometry::plane::Plane;
use crate::geometry::random::{about, across_axis};
use crate::geometry::trace::{dot, minus};
use crate::layout::{Buffers, Hit, LIGHT_SKY_RAY, Light, ObjectParams, REFLECTION_GGX};
use crate::lighting::pixel_light::square_point;

/// A point of the surface, as the eye sees it.
pub struct Seen {
    /// The point.
    pub place: [f32; 3],
    /// The unit interpolated normal, on the side of the triangle that is seen.
    pub normal: [f32; 3],
    /// The unit direction to the eye.
    pub eye: [f32; 3],
    /// Normal of the triangle; its length is twice the area.
    plane: [f32; 3],
    /// Whether the eye is on the side that this normal points to.
    outside: bool,
}

impl Seen {
    /// The point that a pixel shows.
    pub fn new(data: &Buffers, hit: &Hit, corners: [u32; 3]) -> Self {
        let at = corners.map(|v| data.in_scene()[v as usize]);
        let point = place(hit, at);
        let toward = minus(data.camera[0].origin, point);
        let plane = Plane::new(at).normal;
        let outside = dot(toward, plane) >= 0.0;
        let normal = unit(place(hit, corners.map(|v| data.normals_in_scene()[v as usize])));
        let normal = if outside { normal } else { normal.map(|x| -x) };
        Self { place: point, normal, eye: unit(toward), plane, outside }
    }

    /// Whether this ray is to be traced. Where the interpolated normal sends it below the triangle, and on a side that is
    /// seen from inside, it counts as free.
    pub fn traced(&self, ray: &Light) -> bool {
        self.outside && dot(ray.place, self.plane) > 0.0
    }
}

/// alpha^2 - 1 of the microfacets whose distribution is nearest to Phong's lobe of this exponent: alpha^2 = 4 / (m + 3).
fn narrowing(exponent: f32) -> f32 {
    4.0 * inverse(exponent + 3.0) - 1.0
}

/// The ray to the environment that stands for this record in a pixel; its place is the direction, about unit length.
#[must_use]
pub fn mirror_ray(data: &Buffers, light: &Light, pixel: usize, seen: &Seen, params: &ObjectParams) -> Light {
    let place = drawn(square_point(data, light, pixel), seen.normal, seen.eye, params);
    Light { kind: LIGHT_SKY_RAY, place, ..*light }
}

/// The direction drawn by this point of the unit square.
pub(super) fn drawn([u, v]: [f32; 2], normal: [f32; 3], eye: [f32; 3], params: &ObjectParams) -> [f32; 3] {
    let (shape, along) = (params.roughness, dot(normal, eye));
    if params.reflection == REFLECTION_GGX {
        let [right, up] = across_axis(normal);
        let local = [dot(right, eye), dot(up, eye), along.abs()];
        let facet = facet_seen([u, v], local, shape);
        let met = dot(local, facet);
        let [x, y, z]: [f32; 3] = std::array::from_fn(|k| 2.0 * met * facet[k] - local[k]);
        std::array::from_fn(|k| x * right[k] + y * up[k] + z * normal[k])
    } else {
        let mirror = std::array::from_fn(|k| 2.0 * along * normal[k] - eye[k]);
        about(kept_unit(mirror), root((1.0 - u) * inverse(1.0 + narrowing(shape) * u)), v)
    }
}

/// A microfacet as the eye sees it, from a point of the unit square; `local` is the direction to the eye, in the frame of
/// the normal.
fn facet_seen([u, v]: [f32; 2], local: [f32; 3], alpha: f32) -> [f32; 3] {
    let stretched = unit([alpha * local[0], alpha * local[1], local[2]]);
    let rise = (1.0 - u) * (1.0 + stretched[2]);
    let cosine = rise - stretched[2];
    let across = root(1.0 - cosine * cosine);
    let [sine, cos] = turn(v);
    unit([alpha * (across * cos + stretched[0]), alpha * (across * sine + stretched[1]), rise])
}
