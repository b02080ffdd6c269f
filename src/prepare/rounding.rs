//! What rounding to `f32` may change of an object's radiosity, from the size and the place of its triangles.

use crate::state::{State, wide};
use crate::transport::blocks::estimate;

/// Sets `rounding` of each channel for an object, from its shape at rest.
pub(super) fn rounding(state: &mut State, number: usize) {
    let (first, count) = (state.objects[number].first, state.objects[number].count);
    let data = &mut state.data;
    let rest = if data.rest.is_empty() { &data.positions } else { &data.rest };
    let (mut areas, mut perimeters) = (0.0, 0.0);
    for triangle in &data.triangles[first.faces..][..count.faces] {
        let [a, b, c] = triangle.map(|v| wide(rest[v as usize]));
        areas += 0.5 * (b - a).cross(c - a).length();
        perimeters += a.distance(b) + b.distance(c) + c.distance(a);
    }
    let inradius = (2.0 * areas / perimeters).max(1e-12);
    let places = &rest[first.vertices..][..count.vertices];
    let most = places.iter().flatten().fold(0.0f32, |most, x| most.max(x.abs()));
    let params = &mut data.object_params[number];
    for c in 0..3 {
        let [sigma, depth] = [params.sigma[c], params.z_real[c]].map(f64::from);
        params.rounding[c] = estimate::rounding(sigma, depth, inradius, most.into()) as f32;
    }
}
