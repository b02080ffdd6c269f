//! The scene's lights as pixels see them: where opaque objects are lit pixel by pixel, or objects reflect lights; and
//! the rays along which the environment is reflected.
//!
//! A light's points, or an environment's rays, are spread over the samples of a picture: each sample of a pixel takes
//! its share of them, at places of its own, and their mean is that of all.

use super::lights::{record_of, with_sun};
use super::units::Units;
use crate::layout::{LIGHT_BRIGHT_RAY, LIGHT_MIRROR_RAY, LIGHT_SKY_RAY, Light as Record, NONE, REFLECTION_NONE};
use crate::scene::{Light, Source};
use crate::state::{Local, Object, State, narrow};

/// Fewest rays to an environment in one sample: what is hidden of it is a ratio of two of their sums.
const FEWEST_RAYS: usize = 4;

/// Most rays of a pixel's reflection of the environment in one sample, where they are traced and where nothing hides
/// the environment. A picture of many samples takes a quarter of them in each.
const MOST_MIRROR_RAYS: [usize; 2] = [8, 32];

/// The rays along which an environment is reflected, for one sample of so many; half of them go where it is bright, if
/// some places are much brighter than others.
fn mirror_rays(occlusion: u32, samples: usize, uneven: bool) -> Vec<Record> {
    let hidden = occlusion > 0;
    let most = MOST_MIRROR_RAYS[usize::from(!hidden)];
    let rays = (4 * most / samples.max(1)).clamp(most / 4, most) as u32;
    let shadow = if hidden { 0 } else { NONE };
    let kinds = if uneven { &[LIGHT_MIRROR_RAY, LIGHT_BRIGHT_RAY][..] } else { &[LIGHT_MIRROR_RAY] };
    let of = rays / kinds.len() as u32;
    let rays = |&kind| (0..of).map(move |number| Record { kind, of, number, shadow, ..Record::default() });
    kinds.iter().flat_map(rays).collect()
}

/// Writes `pixel_lights` and their numbers in the camera's record; none where no pixel needs them.
pub fn pixel_lights(state: &mut State, lights: &[Light], units: Units) {
    state.data.pixel_lights.clear();
    let Some(samples) = state.data.camera.first().map(|camera| camera.samples as usize) else { return };
    let plain = state.objects.iter().any(Object::plain);
    let reflects = state.data.object_params.iter().any(|params| params.reflection != REFLECTION_NONE);
    if !plain && !reflects {
        count(state, 0, 0);
        return;
    }
    let (mut records, mut mirrored) = (Vec::new(), Vec::new());
    for light in &with_sun(lights) {
        // One point of an area serves for its reflection where there are several samples.
        let most = if plain || samples == 1 { usize::MAX } else { 1 };
        let share = light.samples().div_ceil(samples.max(1)).min(most);
        if let Source::Environment { sky, occlusion } = &light.source
            && reflects
            && sky.brightest() != [0.0; 3]
        {
            mirrored = mirror_rays(*occlusion, samples, !state.data.sky_cells.is_empty());
        }
        match &light.source {
            Source::Environment { .. } if !plain || share == 0 || light.color() == [0.0; 3] => {}
            Source::Environment { .. } => {
                let rays = share.max(FEWEST_RAYS);
                let ray = Record { kind: LIGHT_SKY_RAY, of: rays as u32, ..Record::default() };
                records.extend((0..rays as u32).map(|number| Record { number, ..ray }));
            }
            Source::Area { position, edge_u, edge_v, .. } => {
                let record = Record {
                    place: narrow(units.inside(*position)),
                    edge_u: narrow(*edge_u * units.length),
                    edge_v: narrow(*edge_v * units.length),
                    of: share as u32,
                    ..record_of(light, units, share)
                };
                records.extend((0..share as u32).map(|number| Record { number, ..record }));
            }
            _ => records.push(record_of(light, units, 1)),
        }
    }
    let lit_by = records.len();
    records.extend(mirrored);
    // In local shading an object does not shadow itself.
    let alone = state.method.local.is_some_and(Local::spares_itself) && state.objects.len() == 1 && !plain;
    let mut bits = 0;
    for record in records.iter_mut().filter(|record| record.shadow != NONE) {
        record.shadow = if alone { NONE } else { bits };
        bits += u32::from(!alone);
    }
    state.data.pixel_lights = records;
    count(state, lit_by, bits);
}

/// Writes the number of pixel lights that light, and of words for the `bits` of all shadows, into the camera's record.
fn count(state: &mut State, lights: usize, bits: u32) {
    for camera in &mut state.data.camera {
        (camera.lights, camera.shadow_words) = (lights as u32, bits.div_ceil(32));
    }
}
