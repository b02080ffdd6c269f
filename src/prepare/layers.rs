//! Layers beneath surfaces, as the stages `plane_fit` and `relief` read them.

use glam::DVec3;
use rayon::prelude::*;

use super::units::Units;
use crate::layers::beneath::parameter;
use crate::layers::islands::{Atlas, Whole, atlas};
use crate::layers::relief::GRAZING;
use crate::layout::{LIGHT_SKY_RAY, Layer, Layering, Light};
use crate::lighting::sky::fibonacci_direction;
use crate::scene::{Integration, Layers, Object, Phase, Sky, Source};
use crate::state::options::{Goal, Options};
use crate::state::{State, narrow};

/// The largest extinction, per internal length: beyond it light goes no farther than `f32` can distinguish positions.
const DENSEST_LAYER: f64 = 1e8;
/// Light attenuated below this share is ignored.
const FAINTEST: f64 = 1e-4;
/// Number of directional lights that represent an environment in layers.
pub const DIRECTIONS: u32 = 32;

/// Adds the objects' layers to the state. `faces` gives, for each object, the mesh triangle of each of its triangles
/// in the state. Returns a message about each object's maps.
pub(crate) fn layers(state: &mut State, objects: &[Object], faces: &[Vec<u32>], units: Units) -> Vec<String> {
    let data = &mut state.data;
    let mut said = Vec::new();
    for (number, object) in objects.iter().enumerate() {
        let Some(layers) = &object.material.layers else { continue };
        let first = data.layer_media.len();
        data.layer_media.extend(layers.layers.iter().map(|layer| record(layer, layers.phase, units)));
        let media = &data.layer_media[first..];
        let least = |media: &[Layer]| media.iter().flat_map(|layer| layer.sigma_t).fold(f32::INFINITY, f32::min);
        // Distance at which light becomes negligible; at most to the object's other end.
        let extent = {
            let (low, high) = object.mesh.bounds();
            (high - low).length() * units.length
        };
        let radius = -layers.epsilon.ln() / f64::from(least(&media[..1]));
        data.object_params[number].fit_radius = radius.min(extent).max(1e-9) as f32;
        state.objects[number].layered = true;
        let least = f64::from(least(media));
        let reach = (-FAINTEST.ln() / least).min(1e6);
        let islands = match layers.map.mapped {
            true => {
                Some(atlas(&object.mesh, &layers.map, f64::min(reach / units.length, layers.map.deepest / GRAZING)))
            }
            false => None,
        };
        said.extend(islands.as_ref().map(|islands| format!("object {number}: {}", about(islands))));
        let islands = islands.and_then(Result::ok);
        data.layerings.push(Layering {
            object: number as u32,
            first_layer: first as u32,
            layers: media.len() as u32,
            first_island: islands.as_ref().map_or(u32::MAX, |_| data.islands.len() as u32),
            first_texel: data.depths.len() as u32,
            size: islands.as_ref().map_or(layers.map.size, |islands| islands.size),
            wrap: layers.map.wrap.code(),
            samples: steps(layers),
            deepest: (layers.map.deepest * units.length) as f32,
            reach: reach as f32,
            paper: u32::from(layers.integration == Integration::Paper),
            henyey: u32::from(layers.phase == Phase::HenyeyGreenstein),
            fresnel: u32::from(layers.fresnel),
        });
        let inside = |x: f32| if x < 1e30 { (f64::from(x) * units.length) as f32 } else { x };
        let texels = islands.as_ref().map_or(&layers.map.texels[..], |islands| &islands.texels);
        data.depths.extend(texels.iter().map(|texel| texel.map(inside)));
        let places = islands.iter().flat_map(|islands| faces[number].iter().map(|&face| islands.places[face as usize]));
        data.islands.extend(places);
    }
    said
}

/// Steps along a ray. Each interface crossed takes a sample as well, so there is one step less per inner interface,
/// to take no more samples than the left rule; but at least half of the samples are steps.
fn steps(layers: &Layers) -> u32 {
    match layers.integration {
        Integration::Paper => layers.samples,
        Integration::Exact => {
            layers.samples.saturating_sub(layers.layers.len() as u32 - 1).max(layers.samples.div_ceil(2))
        }
    }
}

/// A message about an object's maps.
fn about(islands: &Result<Atlas, Whole>) -> String {
    match islands {
        Ok(Atlas { islands, seams, margin, share, .. }) => format!(
            "{islands} islands in its maps meet at {seams} edges; each has a margin of what lies across, up to {margin} texels \
             ({:.0} % of how far rays go)",
            100.0 * share
        ),
        Err(Whole::Seamless) => "its maps have no seams, and are taken as they are".into(),
        Err(Whole::TooLarge(texels)) => {
            format!("its maps have seams that show: islands with margins would take {texels} texels")
        }
        Err(Whole::TooFolded) => {
            "its maps have seams that show: triangles lie over one another in them too often to be laid out".into()
        }
    }
}

fn record(layer: &crate::scene::Layer, phase: Phase, units: Units) -> Layer {
    let change =
        |c: usize| f64::min(1.0, DENSEST_LAYER * units.length / layer.sigma_t[c].max(f64::MIN_POSITIVE)) / units.length;
    let scaled = |values: [f64; 3]| std::array::from_fn(|c| (values[c] * change(c)) as f32);
    Layer { sigma_s: scaled(layer.sigma_s), sigma_t: scaled(layer.sigma_t), g: parameter(phase, layer.g) as f32 }
}

/// Sets the lights for layers and scattering media, if there are any: the state's lights that are not black, and the
/// environment as directional lights, each with the light of the part of the sphere that is nearest to its direction.
pub(crate) fn beams(state: &mut State, lights: &[crate::scene::Light], unit: f64) {
    state.data.layer_lights.clear();
    if state.data.layerings.is_empty() && state.data.scattering_media.is_empty() {
        return;
    }
    let shines = |light: &Light| light.kind != LIGHT_SKY_RAY && light.color != [0.0; 3];
    state.data.layer_lights = state.data.lights.iter().filter(|light| shines(light)).copied().collect();
    for light in lights {
        if let Source::Environment { sky, .. } = &light.source {
            state.data.layer_lights.extend(suns(sky, unit));
        }
    }
}

/// An environment as directional lights.
fn suns(sky: &Sky, unit: f64) -> Vec<Light> {
    let directions: Vec<DVec3> = (0..DIRECTIONS).map(|k| fibonacci_direction(k, DIRECTIONS)).collect();
    let [width, height] = sky.size;
    // Large pixels are subdivided, so that even one that covers the sphere gives each direction its share.
    let cuts = [64u32.div_ceil(width), 32u32.div_ceil(height)];
    let solid = |row: u32| {
        let cosine = |row: u32| (std::f64::consts::PI * f64::from(row) / f64::from(height * cuts[1])).cos();
        (cosine(row) - cosine(row + 1)) * std::f64::consts::TAU / f64::from(width * cuts[0])
    };
    let of_row = |row: u32| {
        let mut sums = vec![DVec3::ZERO; directions.len()];
        let (sin, cos) = (std::f64::consts::PI * (f64::from(row) + 0.5) / f64::from(height * cuts[1])).sin_cos();
        for column in 0..width * cuts[0] {
            let (left, right) = (sky.azimuth(column / cuts[0]), sky.azimuth(column / cuts[0] + 1));
            let azimuth = left + (right - left) * (f64::from(column % cuts[0]) + 0.5) / f64::from(cuts[0]);
            let place = DVec3::new(sin * azimuth.sin(), cos, -sin * azimuth.cos());
            let near = |k: usize| directions[k].dot(place);
            let nearest = (1..directions.len()).fold(0, |best, k| if near(k) > near(best) { k } else { best });
            sums[nearest] += sky.radiance(column / cuts[0], row / cuts[1]) * solid(row);
        }
        sums
    };
    let rows: Vec<Vec<DVec3>> = (0..height * cuts[1]).into_par_iter().map(of_row).collect();
    let color = |k: usize| narrow(rows.iter().map(|row| row[k]).sum::<DVec3>() / unit);
    let light = |(k, &direction): (usize, &DVec3)| Light {
        place: narrow(direction),
        color: color(k),
        shadow: u32::MAX,
        ..Light::default()
    };
    directions.iter().enumerate().map(light).filter(|light| light.color != [0.0; 3]).collect()
}

/// Drops layers and scattering media if a frame with these options never reads them.
pub(crate) fn drop_unlooked(state: &mut State, options: Options) {
    if options.goal == Goal::Radiosity {
        let data = &mut state.data;
        (data.layerings, data.layer_media, data.depths, data.layer_lights, data.islands) = Default::default();
        data.scattering_media = Vec::new();
        data.object_params.iter_mut().for_each(|params| params.fit_radius = 0.0);
    }
}
