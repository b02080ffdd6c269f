//! Reference for the march: ray marching in the layered volume itself, with each approximation of the march available
//! separately, to measure its error.
//!
//! The depth of a point in the volume is its distance to the nearest point of the surface, and the interfaces are
//! those of the maps there. Light enters where a ray towards it leaves the object, traced through the same tree as
//! all rays.

use glam::{DVec2, DVec3};

use super::ray::{Depths, MapPlaces, Ray};
use crate::geometry::trace::{UNFINISHED, trace};
use crate::layers::beneath::{optical_depth, phase};
use crate::layout::{FADING, GRAZING, LEAST_COSINE, Light};
use crate::lighting::irradiance::{arrival, reaches};
use crate::state::{narrow, wide};

/// Which approximations of the march the reference keeps.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Kept {
    /// Light enters through a plane between the tangent plane and the fitted one (equations 9 and 10).
    pub planar_entry: bool,
    /// The light's leg is attenuated by the mean interface depths at its two ends (equations 11 and 12).
    pub mean_depths: bool,
    /// Depth along the view ray is measured from the fitted plane, and its map coordinates follow the tangents.
    pub tangent_space: bool,
}

impl Ray<'_> {
    /// Radiance towards the eye, internal units, with `steps` midpoints along the view ray and `legs` along each leg
    /// of the light.
    pub fn full(&self, kept: Kept, steps: u32, legs: u32) -> DVec3 {
        let (data, layers) = (&self.state.data, self.layers());
        let lights: Vec<&Light> = data.layer_lights.iter().filter(|light| reaches(data, light, self.face)).collect();
        let leaves = self.distance(self.point - self.eye * 1e-4, -self.eye).map_or(f64::INFINITY, |far| far + 1e-4);
        let length = if kept.tangent_space { self.length } else { leaves.min(self.layering.reach.into()) };
        let step = length / f64::from(steps);
        let (mut sum, mut above) = (DVec3::ZERO, DVec3::ZERO);
        for i in 0..steps {
            let t = (f64::from(i) + 0.5) * step;
            let at = self.point - t * self.eye;
            let (depth, depths) = match kept.tangent_space {
                true => (self.slope * t, self.depths(-t * self.eye)),
                false => self.beneath(at),
            };
            let number = depths.iter().filter(|&&bottom| depth >= bottom).count();
            let layer = &layers[number.min(layers.len() - 1)];
            let half = wide(layer.sigma_t) * (0.5 * step);
            if number < layers.len() {
                for light in &lights {
                    let (toward, falloff) = arrival(light, at);
                    let below = self.leg(kept, t / length, at, toward, &depths, legs);
                    let p = phase(self.layering.henyey != 0, layer.g.into(), toward.dot(self.eye));
                    let dimmed = above + half + below;
                    let arrives = falloff * p * step * wide(light.color) * wide(layer.sigma_s);
                    sum += arrives * DVec3::new((-dimmed.x).exp(), (-dimmed.y).exp(), (-dimmed.z).exp());
                }
            }
            above += 2.0 * half;
        }
        sum
    }

    /// Optical depth of the light's leg to a point.
    fn leg(&self, kept: Kept, share: f64, at: DVec3, toward: DVec3, depths: &Depths, legs: u32) -> DVec3 {
        let normal = self.normal.lerp(self.plane_normal, share).normalize_or_zero();
        let height = (self.point.lerp(self.plane_point, share) - at).dot(normal).max(0.0);
        let facing = normal.dot(toward);
        let cosine = facing.max(LEAST_COSINE);
        // No light comes through a plane from behind: it fades out near grazing incidence.
        let lost = if kept.planar_entry { -(facing / FADING).clamp(1e-30, 1.0).ln() } else { 0.0 };
        // A point from which no ray meets the surface lies outside.
        let length = match kept.planar_entry {
            true => (height / cosine).min(1e3),
            false => self.distance(at, toward).unwrap_or(0.0),
        };
        let sigma_t = &self.sigma_t[..self.layering.layers as usize];
        if kept.mean_depths {
            let entry = at + toward * length;
            let there = if kept.tangent_space { self.depths(entry - self.point) } else { self.beneath(entry).1 };
            return DVec3::splat(lost)
                + optical_depth(
                    sigma_t,
                    |j| 0.5 * (depths[j] + there[j]),
                    length * cosine.max(GRAZING),
                    cosine.max(GRAZING),
                );
        }
        let part = length / f64::from(legs);
        let one = |k: u32| {
            let (depth, depths) = self.beneath(at + toward * (part * (f64::from(k) + 0.5)));
            let number = depths.iter().filter(|&&bottom| depth >= bottom).count();
            sigma_t[number.min(sigma_t.len() - 1)] * part
        };
        DVec3::splat(lost) + (0..legs).map(one).sum::<DVec3>()
    }

    /// Distance from a point inside to where a ray leaves the object; none where it does not.
    fn distance(&self, from: DVec3, along: DVec3) -> Option<f64> {
        let hit = trace(&self.state.data, narrow(from), narrow(along));
        (hit.face < UNFINISHED).then(|| f64::from(hit.numerator / hit.denominator))
    }

    /// Depth of a point, and the interface depths at the nearest point of the surface.
    fn beneath(&self, at: DVec3) -> (f64, Depths) {
        let data = &self.state.data;
        let params = &data.object_params[self.layering.object as usize];
        let (first, count) = (params.first_node as usize, params.nodes as usize);
        let (mut best, mut found) = (f64::INFINITY, (0usize, DVec2::ZERO));
        let mut node = first;
        while node < first + count {
            let bounds = &data.bounds[node];
            let out = (wide(bounds.low) - at).max(at - wide(bounds.high)).max(DVec3::ZERO);
            if out.length_squared() >= best {
                node = bounds.next as usize;
                continue;
            }
            let Some(corners) = data.triangles.get(bounds.face as usize) else {
                node += 1;
                continue;
            };
            let (weights, d2) = nearest(corners.map(|v| wide(data.positions[v as usize]) - at));
            if d2 < best {
                (best, found) = (d2, (bounds.face as usize, weights));
            }
            node = bounds.next as usize;
        }
        let (face, DVec2 { x, y }) = found;
        let map = MapPlaces::of(self.state, self.layering, face);
        let place = map.map_or(DVec2::ZERO, |MapPlaces { corners: [a, b, c], .. }| (1.0 - x - y) * a + x * b + y * c);
        (best.sqrt(), self.depths_of(place, map.and_then(|map| map.limits)))
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
