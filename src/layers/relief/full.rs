//! Reference for the march: ray marching in the layered volume itself, with each approximation of the march available
//! separately, to measure its error.
//!
//! The depth of a point in the volume is its distance to the nearest point of the surface, and the interfaces are
//! those of the maps there. The view ray ends where it first leaves the object. Whether a light arrives is decided at
//! the scattering point and by the real boundary ([`way`]), whatever reaches the visible triangle: the straight line
//! to the light is attenuated wherever it lies in the object, also where it enters the object again, and another
//! object on it blocks the light. So light comes through a part that is thin enough, from behind as well. Where a
//! light casts no shadows, only the line's first part in the object counts.

use glam::{DVec2, DVec3};

use super::boundary::way;
use super::ray::{Depths, MapPlaces, Ray};
use crate::layers::beneath::{optical_depth, phase, segment};
use crate::layout::{FADING, GRAZING, LEAST_COSINE, LIGHT_DIRECTIONAL, LIGHT_SKY_RAY, Light, MOST_LAYERS, NONE};
use crate::lighting::irradiance::{arrival, reaches};
use crate::state::wide;

/// Optical depth beyond which light is negligible: a share of 4e-11 is left.
const DARK: f64 = 24.0;

/// Which approximations of the march the reference keeps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Kept {
    /// Light arrives where it reaches the visible triangle, and nowhere else.
    pub triangle_shadow: bool,
    /// Light enters through a plane between the tangent plane and the fitted one (equations 9 and 10).
    pub planar_entry: bool,
    /// Light from the front is attenuated by the mean interface depths at its leg's two ends (equations 11 and 12).
    pub mean_depths: bool,
    /// Depth along the view ray is measured from the fitted plane, and its map coordinates follow the tangents.
    pub tangent_space: bool,
}

impl Kept {
    /// The march itself: all of its approximations.
    pub const ALL: Self = Self { triangle_shadow: true, planar_entry: true, mean_depths: true, tangent_space: true };
}

/// A point on a line: its depth, and the interface depths there. Far below all interfaces its depth is [`BELOW`] and
/// theirs are 0.
#[derive(Clone, Copy)]
struct Node {
    depth: f64,
    depths: Depths,
}

/// The depth recorded for a point far below all interfaces, whose nearest point of the surface is not looked for.
const BELOW: f64 = 1e9;

/// Splits the way between two nodes where it crosses interfaces, assuming that depths vary linearly: calls `part` with
/// the shares of the way where each part begins and ends, and its layer.
fn split([a, b]: [&Node; 2], layers: usize, mut part: impl FnMut(f64, f64, usize)) {
    let mut cuts = [1.0; MOST_LAYERS + 1];
    let mut count = 0;
    for j in 0..layers {
        let (from, to) = (a.depth - a.depths[j], b.depth - b.depths[j]);
        if (from >= 0.0) != (to >= 0.0) {
            cuts[count] = from / (from - to);
            count += 1;
        }
    }
    cuts[..count].sort_by(f64::total_cmp);
    let mut begin = 0.0;
    for &end in &cuts[..=count] {
        let node = a.between(b, f64::midpoint(begin, end));
        part(begin, end, node.depths[..layers].iter().filter(|&&bottom| node.depth >= bottom).count());
        begin = end;
    }
}

impl Node {
    fn between(&self, other: &Self, share: f64) -> Self {
        let mix = |a: f64, b: f64| if a < 1e30 { a + (b - a) * share } else { a };
        let depths = std::array::from_fn(|j| mix(self.depths[j], other.depths[j]));
        Self { depth: mix(self.depth, other.depth), depths }
    }
}

/// A scattering point: its position, its share of the way down the view ray, and the interface depths there.
struct Place {
    at: DVec3,
    share: f64,
    depths: Depths,
}

impl Ray<'_> {
    /// Radiance towards the eye, internal units, with `steps` steps along the view ray and `legs` along each part of
    /// the light's way in the object, all split at the interfaces. Steps are shorter near the surface.
    pub fn full(&self, kept: Kept, steps: u32, legs: u32) -> DVec3 {
        let (data, layers) = (&self.state.data, self.layers());
        let wanted = |light: &&Light| !kept.triangle_shadow || reaches(data, light, self.face);
        let lights: Vec<&Light> = data.layer_lights.iter().filter(wanted).collect();
        let length = if kept.tangent_space { self.length } else { self.leaves().min(self.layering.reach.into()) };
        let node = |t: f64, reach: f64, step: f64| match kept.tangent_space {
            true => Node { depth: self.slope * t, depths: self.depths(-t * self.eye) },
            false => self.beneath(self.point - t * self.eye, reach, step),
        };
        let (mut sum, mut above, mut from) = (DVec3::ZERO, DVec3::ZERO, 0.0);
        let mut before = node(0.0, f64::INFINITY, length);
        for i in 0..steps {
            let to = length * (f64::from(i + 1) / f64::from(steps)).powi(2);
            let step = to - from;
            let after = node(to, before.depth + step, step);
            split([&before, &after], layers.len(), |begin, end, number| {
                let layer = &layers[number.min(layers.len() - 1)];
                let part = (end - begin) * step;
                let dims = wide(layer.sigma_t) * part;
                if number < layers.len() && part > 0.0 {
                    let share = f64::midpoint(begin, end);
                    let t = from + share * step;
                    let depths = before.between(&after, share).depths;
                    let place = Place { at: self.point - t * self.eye, share: t / length, depths };
                    for light in &lights {
                        let (toward, falloff) = arrival(light, place.at);
                        let Some(below) = self.leg(kept, &place, light, toward, legs) else { continue };
                        let p = phase(self.layering.henyey != 0, layer.g.into(), toward.dot(self.eye));
                        let arrives = falloff * p * part * wide(light.color) * wide(layer.sigma_s);
                        // The mean of the view path's transmittance over the part.
                        let dimmed = |c: usize| segment(1.0, 1.0, above[c], above[c] + dims[c]) * (-below[c]).exp();
                        sum += arrives * DVec3::new(dimmed(0), dimmed(1), dimmed(2));
                    }
                }
                above += dims;
            });
            (before, from) = (after, to);
            if above.min_element() > DARK {
                break;
            }
        }
        sum * self.transmitted(self.normal.dot(self.eye).abs())
    }

    /// Length of the view ray within the object; infinite where it never leaves.
    fn leaves(&self) -> f64 {
        let from = self.point - self.eye * 1e-5;
        let way = way(self.state, self.layering.object as usize, from, -self.eye, self.side(), f64::INFINITY);
        way.inside.first().map_or(f64::INFINITY, |[_, out]| out.min(way.other) + 1e-5)
    }

    /// 1 where the visible triangle faces the eye, -1 where it faces away.
    fn side(&self) -> f64 {
        let [a, b, c] = self.state.data.triangles[self.face].map(|v| wide(self.state.data.in_scene()[v as usize]));
        if (b - a).cross(c - a).dot(self.eye) < 0.0 { -1.0 } else { 1.0 }
    }

    /// Optical depth of the light's leg to a point, Fresnel reflection included; none where the light does not arrive.
    fn leg(&self, kept: Kept, place: &Place, light: &Light, toward: DVec3, legs: u32) -> Option<DVec3> {
        let at = place.at;
        let far = light.kind == LIGHT_DIRECTIONAL || light.kind == LIGHT_SKY_RAY;
        let limit = if far { f64::INFINITY } else { wide(light.place).distance(at) };
        let way = way(self.state, self.layering.object as usize, at, toward, self.side(), limit);
        let real = way.inside.first().map(|[_, out]| *out);
        let casts = light.shadow != NONE && !kept.triangle_shadow;
        if casts && way.other < limit {
            return None;
        }
        let normal = self.normal.lerp(self.plane_normal, place.share).normalize_or_zero();
        let height = (self.point.lerp(self.plane_point, place.share) - at).dot(normal).max(0.0);
        let facing = normal.dot(toward);
        let cosine = facing.max(LEAST_COSINE);
        // No light comes through a plane from behind: it fades out near grazing incidence.
        let lost = if kept.planar_entry { -(facing / FADING).clamp(1e-30, 1.0).ln() } else { 0.0 };
        let length = if kept.planar_entry { (height / cosine).min(1e3) } else { real? };
        let sigma_t = &self.sigma_t[..self.layering.layers as usize];
        let least = sigma_t.iter().map(|sigma| sigma.min_element()).fold(f64::INFINITY, f64::min);
        let parts = if casts { way.inside.get(1..).unwrap_or_default() } else { &[] };
        let inside = length + parts.iter().map(|[begin, end]| end - begin).sum::<f64>();
        if lost + least * inside > DARK {
            return None;
        }
        let enters = self.transmitted(if kept.planar_entry { cosine } else { way.cosine });
        let mut sum = DVec3::new(lost - enters.x.ln(), lost - enters.y.ln(), lost - enters.z.ln());
        // From behind the plane there is no such mean.
        if kept.mean_depths && (kept.planar_entry || facing > 0.0) {
            let entry = at + toward * length;
            let there = match kept.tangent_space {
                true => self.depths(entry - self.point),
                false => self.beneath(entry, f64::INFINITY, 1.0).depths,
            };
            let mean = |j: usize| 0.5 * (place.depths[j] + there[j]);
            sum += optical_depth(sigma_t, mean, length * cosine.max(GRAZING), cosine.max(GRAZING));
        } else {
            sum += self.through(at, toward, [0.0, length], legs);
        }
        Some(sum + parts.iter().map(|&part| self.through(at, toward, part, legs)).sum::<DVec3>())
    }

    /// Optical depth between two distances along a line.
    fn through(&self, from: DVec3, along: DVec3, [begin, end]: [f64; 2], legs: u32) -> DVec3 {
        let (part, layers, mut sum) = ((end - begin) / f64::from(legs), self.layering.layers as usize, DVec3::ZERO);
        let mut before = self.beneath(from + along * begin, f64::INFINITY, part);
        for k in 1..=legs {
            let after = self.beneath(from + along * (begin + part * f64::from(k)), before.depth + part, part);
            split([&before, &after], layers, |begin, end, number| {
                sum += self.sigma_t[number.min(layers - 1)] * ((end - begin) * part);
            });
            before = after;
        }
        sum
    }

    /// Depth of a point, and the interface depths at the nearest point of the surface, which lies within `reach` of
    /// it. That point is not looked for if a step up would still end below all interfaces.
    fn beneath(&self, at: DVec3, reach: f64, step: f64) -> Node {
        let data = &self.state.data;
        let params = &data.object_params[self.layering.object as usize];
        let (first, count) = (params.first_node as usize, params.nodes as usize);
        let reach = reach.min(f64::from(self.layering.deepest) + 2.0 * step) * (1.0 + 1e-6) + 1e-9;
        let (mut best, mut found) = (reach * reach, None);
        let mut node = first;
        while node < first + count {
            let bounds = &data.bounds_in_scene()[node];
            let out = (wide(bounds.low) - at).max(at - wide(bounds.high)).max(DVec3::ZERO);
            if out.length_squared() >= best {
                node = bounds.next as usize;
                continue;
            }
            let Some(corners) = data.triangles.get(bounds.face as usize) else {
                node += 1;
                continue;
            };
            let (weights, d2) = nearest(corners.map(|v| wide(data.in_scene()[v as usize]) - at));
            if d2 < best {
                (best, found) = (d2, Some((bounds.face as usize, weights)));
            }
            node = bounds.next as usize;
        }
        let Some((face, DVec2 { x, y })) = found else { return Node { depth: BELOW, depths: [0.0; MOST_LAYERS] } };
        let map = MapPlaces::of(self.state, self.layering, face);
        let place = map.map_or(DVec2::ZERO, |MapPlaces { corners: [a, b, c], .. }| (1.0 - x - y) * a + x * b + y * c);
        Node { depth: best.sqrt(), depths: self.depths_of(place, map.and_then(|map| map.limits)) }
    }
}

/// Weights of the second and third corner at the point of a triangle nearest to the origin, and its squared distance
/// (Ericson 2004, section 5.1.5).
fn nearest([a, b, c]: [DVec3; 3]) -> (DVec2, f64) {
    let (ab, ac) = (b - a, c - a);
    let [d1, d2, d3, d4, d5, d6] = [-ab.dot(a), -ac.dot(a), -ab.dot(b), -ac.dot(b), -ab.dot(c), -ac.dot(c)];
    let (va, vb, vc) = (d3 * d6 - d5 * d4, d5 * d2 - d1 * d6, d1 * d4 - d3 * d2);
    let weights = if d1 <= 0.0 && d2 <= 0.0 {
        DVec2::ZERO
    } else if d3 >= 0.0 && d4 <= d3 {
        DVec2::X
    } else if d6 >= 0.0 && d5 <= d6 {
        DVec2::Y
    } else if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        DVec2::new(d1 / (d1 - d3), 0.0)
    } else if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        DVec2::new(0.0, d2 / (d2 - d6))
    } else if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        let w = (d4 - d3) / ((d4 - d3) + (d5 - d6));
        DVec2::new(1.0 - w, w)
    } else {
        DVec2::new(vb, vc) / (va + vb + vc)
    };
    (weights, (a + weights.x * ab + weights.y * ac).length_squared())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_nearest_point_of_a_triangle_may_be_a_corner_on_an_edge_or_inside() {
        let from = |x: f64, y: f64, z: f64| {
            let corners = [[0.0, 0.0], [2.0, 0.0], [0.0, 2.0]].map(|[u, v]| DVec3::new(u - x, v - y, -z));
            nearest(corners)
        };
        let half = DVec2::splat(0.5);
        let cases = [
            ((-1.0, -1.0, 0.0), DVec2::ZERO, 2.0),
            ((3.0, -1.0, 1.0), DVec2::X, 3.0),
            ((-1.0, 4.0, 0.0), DVec2::Y, 5.0),
            ((1.0, -1.0, 0.0), DVec2::new(0.5, 0.0), 1.0),
            ((-2.0, 0.5, 0.0), DVec2::new(0.0, 0.25), 4.0),
            ((2.0, 2.0, 1.0), half, 3.0),
            ((0.5, 0.5, 3.0), half * 0.5, 9.0),
        ];
        for ((x, y, z), weights, square) in cases {
            let (found, d2) = from(x, y, z);
            assert!((found - weights).length() < 1e-12 && (d2 - square).abs() < 1e-12, "{x} {y} {z}: {found} {d2}");
        }
    }
}
