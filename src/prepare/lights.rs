//! The scene's lights as the records, rays and tables that the stages of module `lighting` read.

use std::mem::take;

use glam::DVec3;
use rayon::prelude::*;

use super::blocks::group;
use super::layers::beams;
use super::pixel_lights::pixel_lights;
use super::sky_cells::sky_cells;
use super::units::Units;
use crate::layout::{
    LIGHT_AREA, LIGHT_AREA_BOTH, LIGHT_DIRECTIONAL, LIGHT_POINT, LIGHT_SKY_RAY, LIGHT_SPOT, Light as Record,
    REFLECTION_NONE, SkyCell, SkyColumn, SkyRow,
};
use crate::lighting::sky::fibonacci_direction;
use crate::scene::{Light, Object, Sky, Source};
use crate::state::{Group, Local, State, narrow};

/// The lights, and after them the sun of an environment, which casts shadows as the environment's light says.
pub fn with_sun(lights: &[Light]) -> Vec<Light> {
    let sun = |light: &Light| match &light.source {
        Source::Environment { sky, .. } => sky.sun().map(|(direction, irradiance, _)| Light {
            source: Source::Directional { direction, irradiance },
            shadows: light.shadows,
        }),
        _ => None,
    };
    lights.iter().cloned().chain(lights.iter().filter_map(sun)).collect()
}

/// Writes the lights' records and sets the light unit: about the largest irradiance anywhere on the objects.
pub fn lights(state: &mut State, given: &[Light], units: &mut Units, objects: &[Object]) {
    let lights = &with_sun(given);
    let brightest: f64 = lights.iter().map(|light| brightest(light, *units, objects)).sum();
    units.light = if brightest > 0.0 && brightest.is_finite() { brightest.log2().ceil().exp2() } else { 1.0 };
    state.data.lights = lights.iter().flat_map(|light| records(light, *units)).collect();
    let narrowness = lights.iter().find_map(|light| match &light.source {
        Source::Environment { sky, .. } => sky.sun().map(|(_, _, narrowness)| narrowness as f32),
        _ => None,
    });
    if let (Some(outer), Some(sun)) = (narrowness, state.data.lights.last_mut()) {
        sun.outer = outer;
    }

    // Each record that casts shadows gets a bit.
    let mut bits = 0;
    let alone =
        state.method.local.is_some_and(Local::spares_itself) && state.objects.len() == 1 && !state.objects[0].opaque;
    for record in state.data.lights.iter_mut().filter(|record| record.shadow != u32::MAX) {
        if alone {
            // In local shading an object does not shadow itself.
            record.shadow = u32::MAX;
            continue;
        }
        record.shadow = bits;
        bits += 1;
    }
    for params in &mut state.data.object_params {
        params.lights = state.data.lights.len() as u32;
        params.shadow_words = bits.div_ceil(32);
        params.sky = [0; 2];
    }
    let mut before = Some(Before::of(state));
    for light in lights {
        if let Source::Environment { sky, .. } = &light.source
            && (sky.brightest() != [0.0; 3] || sky.sun().is_some())
            && let Some(before) = before.take()
        {
            tables(state, sky, units.light, before);
        }
    }
    beams(state, lights, units.light);
    for (object, params) in state.objects.iter_mut().zip(&mut state.data.object_params) {
        object.groups = group(params, &state.data.texels, lights);
        // Diffusion carries all channels at once, those without light, too.
        if object.solves() {
            object.groups = vec![Group { channels: 7, lead: 0 }];
        }
    }
    if let Some(camera) = state.data.camera.first_mut() {
        camera.radiance = units.radiance();
    }
    pixel_lights(state, given, *units);
}

fn largest(channels: [f64; 3]) -> f64 {
    channels.into_iter().fold(0.0, f64::max)
}

/// Squared distance of the origin to a triangle, length^2.
fn distance2(corners: [DVec3; 3]) -> f64 {
    // The nearest point of the three edges, or of the plane if the origin projects inside the triangle.
    let [a, b, c] = corners;
    let edge = |p: DVec3, q: DVec3| {
        let along = q - p;
        let t = (-p.dot(along) / along.length_squared().max(f64::MIN_POSITIVE)).clamp(0.0, 1.0);
        (p + t * along).length_squared()
    };
    let nearest = edge(a, b).min(edge(b, c)).min(edge(c, a));
    let normal = (b - a).cross(c - a);
    let inside = [(a, b), (b, c), (c, a)].into_iter().all(|(p, q)| p.cross(q).dot(normal) > 0.0);
    if inside { nearest.min(a.dot(normal).powi(2) / normal.length_squared()) } else { nearest }
}

/// Approximately the largest irradiance of a light anywhere on the objects, in the scene's units.
fn brightest(light: &Light, units: Units, objects: &[Object]) -> f64 {
    let color = largest(light.color());
    let near = |place: &DVec3| {
        let nearest = |object: &Object| {
            let corners = |face| Some(object.corners(face)?.map(|corner| corner - *place));
            let faces = (0..object.mesh.triangles.len()).into_par_iter().filter_map(corners);
            faces.map(distance2).reduce(|| f64::INFINITY, f64::min)
        };
        let d2 = objects.iter().map(nearest).fold(f64::INFINITY, f64::min);
        color / d2.max(1e-12 / units.length.powi(2))
    };
    match &light.source {
        Source::Directional { .. } => color,
        Source::Point { position, .. } | Source::Spot { position, .. } => near(position),
        Source::Area { position, edge_u, edge_v, .. } => {
            let flux = near(position) * edge_u.cross(*edge_v).length();
            flux.min(std::f64::consts::PI * color)
        }
        Source::Environment { sky, .. } => std::f64::consts::PI * sky.mean().max_element(),
    }
}

/// The records of a light, one of each sample.
fn records(light: &Light, units: Units) -> Vec<Record> {
    match &light.source {
        Source::Area { .. } => {
            let record = record_of(light, units, light.samples());
            light.places().iter().map(|&place| Record { place: narrow(units.inside(place)), ..record }).collect()
        }
        Source::Environment { occlusion, .. } => {
            let ray = |k| Record { place: narrow(fibonacci_direction(k, *occlusion)), ..record_of(light, units, 1) };
            (0..if light.color() == [0.0; 3] { 0 } else { *occlusion }).map(ray).collect()
        }
        _ => vec![record_of(light, units, 1)],
    }
}

/// The record of a light, or of one of so many samples of it, whose place is left out. `shadow` is 0 for now if it
/// casts shadows (bits are numbered later), otherwise all ones.
pub fn record_of(light: &Light, units: Units, samples: usize) -> Record {
    let black = light.color() == [0.0; 3];
    let shadow = if light.shadows && !black { 0 } else { u32::MAX };
    let scaled = |color: [f64; 3], factor: f64| color.map(|x| (x * factor / units.light) as f32);
    let square = units.length * units.length;
    match &light.source {
        Source::Directional { direction, irradiance } => {
            let color = scaled(*irradiance, 1.0);
            Record { kind: LIGHT_DIRECTIONAL, place: narrow(*direction), color, shadow, ..Record::default() }
        }
        Source::Point { position, intensity } => {
            let (place, color) = (narrow(units.inside(*position)), scaled(*intensity, square));
            Record { kind: LIGHT_POINT, place, color, shadow, ..Record::default() }
        }
        Source::Spot { position, direction, intensity, inner, outer } => {
            // 1 - cos, without cancellation.
            let narrowness = |degrees: f64| (2.0 * (0.5 * degrees.to_radians()).sin().powi(2)) as f32;
            let (place, color) = (narrow(units.inside(*position)), scaled(*intensity, square));
            let (axis, inner, outer) = (narrow(*direction), narrowness(*inner), narrowness(*outer));
            Record { kind: LIGHT_SPOT, place, color, axis, inner, outer, shadow, ..Record::default() }
        }
        Source::Area { edge_u, edge_v, radiance, two_sided, .. } => {
            let normal = edge_u.cross(*edge_v);
            let color = scaled(*radiance, square * normal.length() / samples as f64);
            let kind = if *two_sided { LIGHT_AREA_BOTH } else { LIGHT_AREA };
            Record { kind, color, axis: narrow(normal.normalize()), shadow, ..Record::default() }
        }
        Source::Environment { .. } => Record { kind: LIGHT_SKY_RAY, shadow: 0, ..Record::default() },
    }
}

/// The environment's image and its map as they were, since the map takes long to make.
struct Before {
    sky: Vec<[f32; 3]>,
    turn: f32,
    cells: Vec<SkyCell>,
}

impl Before {
    /// Takes both from the state, which has no environment then.
    fn of(state: &mut State) -> Self {
        let data = &mut state.data;
        (data.sky_rows, data.sky_columns) = Default::default();
        let turn = data.object_params.first().map_or(0.0, |params| params.sky_turn);
        Self { sky: take(&mut data.sky), turn, cells: take(&mut data.sky_cells) }
    }
}

/// An environment's image, and the integrals over its rows and columns whose products are the harmonics.
fn tables(state: &mut State, sky: &Sky, unit: f64, before: Before) {
    let data = &mut state.data;
    for params in &mut data.object_params {
        params.sky = sky.size;
        params.sky_turn = (0.5 + sky.rotation / 360.0).rem_euclid(1.0) as f32;
    }
    let factor = sky.factor.map(|x| x / unit);
    let scale = |pixel: &[f32; 3]| std::array::from_fn(|c| (f64::from(pixel[c]) * factor[c]) as f32);
    data.sky = sky.pixels.iter().map(scale).collect();
    let difference = |f: fn(f64) -> f64, from: f64, to: f64| (f(to) - f(from)) as f32;
    let row = |row: u32| {
        // Antiderivatives of sin t times 1, cos t, sin t; cos^2 t, sin t cos t, sin^2 t.
        let integral = |f| difference(f, sky.polar(row), sky.polar(row + 1));
        SkyRow {
            first: [
                integral(|t| -t.cos()),
                integral(|t| 0.5 * t.sin().powi(2)),
                integral(|t| 0.5 * (t - t.sin() * t.cos())),
            ],
            second: [
                integral(|t| -t.cos().powi(3) / 3.0),
                integral(|t| t.sin().powi(3) / 3.0),
                integral(|t| t.cos().powi(3) / 3.0 - t.cos()),
            ],
        }
    };
    let column = |column: u32| {
        // Of 1, sin a, -cos a; -sin a cos a, sin^2 a - cos^2 a.
        let integral = |f| difference(f, sky.azimuth(column), sky.azimuth(column + 1));
        SkyColumn {
            first: [integral(|a| a), integral(|a| -a.cos()), integral(|a| -a.sin())],
            second: [integral(|a| -0.5 * a.sin().powi(2)), integral(|a| -0.5 * (2.0 * a).sin())],
        }
    };
    data.sky_rows = (0..sky.size[1]).map(row).collect();
    data.sky_columns = (0..sky.size[0]).map(column).collect();
    if data.object_params.iter().any(|params| params.reflection != REFLECTION_NONE) {
        let same = !before.cells.is_empty() && before.turn == data.object_params[0].sky_turn && before.sky == data.sky;
        data.sky_cells = if same { before.cells } else { sky_cells(data) };
    }
}

#[cfg(test)]
mod tests {
    use crate::prepare::lights::*;

    #[test]
    fn the_nearest_place_of_a_triangle_may_be_inside_on_an_edge_or_a_corner() {
        let from = |x: f64, y: f64, z: f64| {
            let [a, b, c] = [[0.0, 0.0], [2.0, 0.0], [0.0, 2.0]].map(|[u, v]| DVec3::new(u - x, v - y, -z));
            assert_eq!(distance2([a, b, c]), distance2([a, c, b]), "both sides alike");
            distance2([a, b, c])
        };
        assert!((from(0.5, 0.5, 0.1) - 0.01).abs() < 1e-15);
        assert!((from(1.0, -3.0, 4.0) - 25.0).abs() < 1e-12);
        assert!((from(-3.0, 0.0, -4.0) - 25.0).abs() < 1e-12);
        // A degenerate triangle is a line or a point.
        let line = [DVec3::new(-1.0, 1.0, 0.0), DVec3::new(3.0, 1.0, 0.0), DVec3::new(1.0, 1.0, 0.0)];
        assert!((distance2(line) - 1.0).abs() < 1e-15);
        assert_eq!(distance2([DVec3::new(0.0, 3.0, 4.0); 3]), 25.0);
    }
}
