//! A light as one pixel sees it in one sample, in step with `glsl/lighting/pixel_light.glsl`.
//!
//! An area is seen at points, an environment along rays, that follow a sequence which fills the unit square evenly: R2,
//! whose steps are powers of the plastic number. It is shifted for each pixel by random numbers (Cranley and Patterson
//! 1976), so errors of neighbours have nothing in common: no bands, only grain, which further samples reduce. Rays to
//! the environment are distributed by the cosine about the surface's normal. All arithmetic is in `f32`, with the same
//! bits on every device, since shadows are decided by it.

use crate::geometry::exact::{root, unit};
use crate::geometry::random::{about, random4, unit_random};
use crate::layout::{Buffers, LIGHT_AREA, LIGHT_AREA_BOTH, LIGHT_SKY_RAY, Light, SQUARE_STEPS};

/// The point of the unit square for a light's number in this pixel and sample.
#[must_use]
pub fn square_point(data: &Buffers, light: &Light, pixel: usize) -> [f32; 2] {
    let point = data.camera[0].sample_number.wrapping_mul(light.of).wrapping_add(light.number);
    let shift = random4(pixel as u32, light.kind, 0, 0);
    std::array::from_fn(|k| unit_random(shift[k].wrapping_add(point.wrapping_mul(SQUARE_STEPS[k]))))
}

/// Light `number` of `pixel_lights` as a pixel sees it, at a surface with this normal of any length.
#[must_use]
pub fn pixel_light(data: &Buffers, number: usize, pixel: usize, normal: [f32; 3]) -> Light {
    let light = data.pixel_lights[number];
    let sky = light.kind == LIGHT_SKY_RAY;
    if !sky && ![LIGHT_AREA, LIGHT_AREA_BOTH].contains(&light.kind) {
        return light;
    }
    let [u, v] = square_point(data, &light, pixel);
    if sky {
        return Light { place: about(unit(normal), root(1.0 - u), v), ..light };
    }
    let (across, along) = (u - 0.5, v - 0.5);
    let place = std::array::from_fn(|k| light.place[k] + (across * light.edge_u[k] + along * light.edge_v[k]));
    Light { place, ..light }
}
