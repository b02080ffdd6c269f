//! The rays inside an object: decisions, in step with `glsl/layers/single_scattering`.

use crate::geometry::exact::{inside, inverse, refracted, unit};
use crate::geometry::trace::{Nearest, Sight, cross, dot, meets, minus};
use crate::layout::{Buffers, Hit, NONE, SINGLE_MARGIN, ScatteringMedium};

fn blend(weight: [f32; 3], [a, b, c]: [[f32; 3]; 3]) -> [f32; 3] {
    std::array::from_fn(|k| weight[0] * a[k] + weight[1] * b[k] + weight[2] * c[k])
}

/// A triangle's corners in the scene.
fn corners(data: &Buffers, face: u32) -> [[f32; 3]; 3] {
    data.triangles[face as usize].map(|v| data.in_scene()[v as usize])
}

/// The point that a pixel shows.
pub(super) fn point(data: &Buffers, hit: &Hit) -> [f32; 3] {
    blend([1.0 - hit.u - hit.v, hit.u, hit.v], corners(data, hit.face))
}

/// Where a ray of any length leaves its object: the nearest triangle that it passes outward. Rounding may put the
/// origin just outside: triangles count from a little behind it.
fn leaving(data: &Buffers, object: u32, origin: [f32; 3], direction: [f32; 3]) -> Nearest {
    let params = &data.object_params[object as usize];
    let mut nearest = Nearest { face: NONE, weights: [0.0; 3], numerator: 0.0, denominator: 1.0 };
    let ray = Sight::new(direction);
    let mut node = params.first_node;
    while node < params.next_node {
        let bounds = &data.bounds_in_scene()[node as usize];
        let met = meets(bounds.low, bounds.high, origin, &ray, &nearest);
        if met && bounds.face == NONE {
            node += 1;
            continue;
        }
        node = bounds.next;
        if !met {
            continue;
        }
        let points = corners(data, bounds.face);
        let Some(found) = ray.pierce(points.map(|p| minus(p, origin))) else { continue };
        let (mine, its) = (found.numerator * nearest.denominator, nearest.numerator * found.denominator);
        let nearer = nearest.face == NONE || mine < its || (mine == its && bounds.face < nearest.face);
        let normal = cross(minus(points[1], points[0]), minus(points[2], points[0]));
        let size = normal.map(f32::abs);
        let least = SINGLE_MARGIN * (size[0] + size[1] + size[2]);
        let inside = found.numerator > 0.0 || dot(minus(points[0], origin), normal) > -least;
        if inside && dot(direction, normal) > 0.0 && nearer {
            nearest = Nearest { face: bounds.face, ..found };
        }
    }
    nearest.numerator *= ray.scale;
    nearest.denominator *= ray.square;
    nearest
}

/// The refracted view ray beneath the point that a pixel shows, its unit direction and its length; the length is 0
/// where the surface is seen from behind, or all light is reflected.
pub(super) fn refract(data: &Buffers, medium: &ScatteringMedium, hit: &Hit) -> ([f32; 3], f32) {
    let point = point(data, hit);
    let apart = minus(data.camera[0].origin, point);
    let [a, b, c] = corners(data, hit.face);
    let area = cross(minus(b, a), minus(c, a));
    let weight = [1.0 - hit.u - hit.v, hit.u, hit.v];
    let blended = blend(weight, data.triangles[hit.face as usize].map(|v| data.normals_in_scene()[v as usize]));

    // A normal that leans away from the eye is mirrored.
    let eye = unit(apart);
    let mut normal = if dot(blended, blended) > 1e-12 { unit(blended) } else { eye };
    let leaning = dot(eye, normal);
    if leaning < 0.0 {
        normal = std::array::from_fn(|k| normal[k] - 2.0 * leaning * eye[k]);
    }
    if dot(apart, area) <= 0.0 || inside(medium.eta, leaning.abs()) <= 0.0 {
        return ([0.0; 3], 0.0);
    }
    let way = refracted(medium.eta, eye, normal);
    let end = leaving(data, medium.object, point, way);
    let distance = end.numerator * inverse(end.denominator);
    (way, if end.face == NONE { medium.reach } else { distance.clamp(0.0, medium.reach) })
}

/// The triangle through which a straight ray from a sample's `place` towards a light leaves; none if there is none, or
/// if the light is nearer. The `first` sample is the visible point. `light` is the light's position, or the direction
/// to it if it is `far`.
pub(super) fn entry(
    data: &Buffers,
    medium: &ScatteringMedium,
    hit: &Hit,
    (place, first): ([f32; 3], bool),
    (light, far): ([f32; 3], bool),
) -> Option<Nearest> {
    let direction = if far { light } else { minus(light, place) };
    let [a, b, c] = corners(data, hit.face);
    let facing = dot(direction, cross(minus(b, a), minus(c, a))) > 0.0;
    let entry = if first && facing {
        let weights = [1.0 - hit.u - hit.v, hit.u, hit.v];
        Nearest { face: hit.face, weights, numerator: 0.0, denominator: 1.0 }
    } else {
        leaving(data, medium.object, place, direction)
    };
    (entry.face != NONE && (far || entry.numerator < entry.denominator)).then_some(entry)
}
