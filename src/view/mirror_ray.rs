//! Rays to the environment from a surface that reflects it, drawn from the lobe in which it mirrors the eye, in step
//! with `glsl/view/mirror_ray.glsl`.
//!
//! GGX: microfacets as the eye sees them, by spherical caps (Dupuy and Benyoub 2023). Phong: about the mirror
//! direction, by the distribution of microfacets that is nearest to the lobe. Where the environment is uneven, half of
//! the rays go where it is bright, by cells of an octahedral map. Numbers are those of [`square_point`]: other ones in
//! each pixel and sample. All arithmetic is in `f32`, with the same bits on every device, since rays decide what is
//! hidden.

use super::pixel_receivers::place;
use crate::geometry::deform::turn;
use crate::geometry::exact::{inverse, kept_unit, root, unit};
use crate::geometry::plane::Plane;
use crate::geometry::random::{about, across_axis, random4, unit_random};
use crate::geometry::trace::{dot, minus};
use crate::layout::{
    Buffers, Hit, LIGHT_BRIGHT_RAY, LIGHT_SKY_RAY, Light, ObjectParams, REFLECTION_GGX, SKY_CELLS, SQUARE_STEPS,
};
use crate::lighting::pixel_light::square_point;
use crate::state::wide;

/// A point of the surface, as the eye sees it.
pub struct Seen {
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
        Self { normal, eye: unit(toward), plane, outside }
    }

    /// Whether this ray is to be traced. Where the interpolated normal sends it below the triangle, and on a side that
    /// is seen from inside, it counts as free.
    pub fn traced(&self, ray: &Light) -> bool {
        self.outside && dot(ray.place, self.plane) > 0.0
    }
}

/// alpha^2 - 1 of the microfacets whose distribution is nearest to Phong's lobe of this exponent m, where alpha^2 is
/// 4 / (m + 3).
fn narrowing(exponent: f32) -> f32 {
    4.0 * inverse(exponent + 3.0) - 1.0
}

/// The cell of the octahedral map in which a direction lies: x and y of the octahedron |x| + |y| + |z| = 1, its lower
/// half folded outwards.
#[must_use]
pub fn cell_of(way: [f32; 3]) -> u32 {
    let [x, y, z] = way;
    let by = inverse(x.abs() + y.abs() + z.abs());
    let (x, y) = (x * by, y * by);
    let [x, y] = if z < 0.0 { folded(x, y) } else { [x, y] };
    let [column, row] = [x, y].map(|x| ((x * 0.5 + 0.5) * SKY_CELLS as f32).clamp(0.0, (SKY_CELLS - 1) as f32) as u32);
    row * SKY_CELLS + column
}

/// A place of the octahedron's upper half on the lower one, and back.
fn folded(x: f32, y: f32) -> [f32; 2] {
    let (across, along) = (1.0 - y.abs(), 1.0 - x.abs());
    [if x < 0.0 { -across } else { across }, if y < 0.0 { -along } else { along }]
}

/// The direction to a place in a cell that is drawn by the alias method.
#[must_use]
pub fn bright(data: &Buffers, light: &Light, pixel: usize) -> [f32; 3] {
    let point = data.camera[0].sample_number.wrapping_mul(light.of).wrapping_add(light.number);
    let [shift, ..] = random4(pixel as u32, light.kind, 0, 0);
    let cell = shift.wrapping_add(point.wrapping_mul(SQUARE_STEPS[0])) >> 16;
    let [across, along, kept, _] = random4(pixel as u32, light.kind, point, 1);
    let drawn = &data.sky_cells[cell as usize];
    let cell = if kept >> 16 < drawn.kept { cell } else { drawn.other };
    let at = |n: u32, bits| (n as f32 + unit_random(bits)) * (2.0 / SKY_CELLS as f32) - 1.0;
    let (x, y) = (at(cell % SKY_CELLS, across), at(cell / SKY_CELLS, along));
    let z = 1.0 - x.abs() - y.abs();
    let [x, y] = if z < 0.0 { folded(x, y) } else { [x, y] };
    unit([x, y, z])
}

/// The density of such directions, by solid angle.
#[must_use]
pub fn bright_density(data: &Buffers, direction: [f32; 3]) -> f64 {
    let way = wide(direction);
    let whole = way.abs().element_sum();
    f64::from(data.sky_cells[cell_of(direction) as usize].density) * (way.length() / whole).powi(3)
}

/// The ray to the environment that stands for this record in a pixel; its place is the direction, about unit length.
#[must_use]
pub fn mirror_ray(data: &Buffers, light: &Light, pixel: usize, seen: &Seen, params: &ObjectParams) -> Light {
    let place = match light.kind {
        LIGHT_BRIGHT_RAY => bright(data, light, pixel),
        _ => {
            let params = ObjectParams { roughness: drawn_shape(data, light, pixel, params), ..*params };
            drawn(square_point(data, light, pixel), seen.normal, seen.eye, &params)
        }
    };
    Light { kind: LIGHT_SKY_RAY, place, ..*light }
}

/// The shape of the lobe from which a pixel draws this ray.
fn drawn_shape(data: &Buffers, light: &Light, pixel: usize, params: &ObjectParams) -> f32 {
    if params.second_share == 0.0 {
        return params.roughness;
    }
    let point = data.camera[0].sample_number.wrapping_mul(light.of).wrapping_add(light.number);
    let second = unit_random(random4(pixel as u32, light.kind, point, 2)[0]) < params.second_share;
    if second { params.second_roughness } else { params.roughness }
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

/// A microfacet as the eye sees it, from a point of the unit square; `local` is the direction to the eye, in the frame
/// of the normal.
fn facet_seen([u, v]: [f32; 2], local: [f32; 3], alpha: f32) -> [f32; 3] {
    let stretched = unit([alpha * local[0], alpha * local[1], local[2]]);
    let rise = (1.0 - u) * (1.0 + stretched[2]);
    let cosine = rise - stretched[2];
    let across = root(1.0 - cosine * cosine);
    let [sine, cos] = turn(v);
    unit([alpha * (across * cos + stretched[0]), alpha * (across * sine + stretched[1]), rise])
}
