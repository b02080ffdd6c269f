//! The scene's camera as the record that the stages of `view` read.

use super::units::Units;
use crate::layout::Camera as Record;
use crate::scene::Camera;
use crate::state::{State, narrow};
use crate::view::tone::thresholds;

/// Writes the camera's record, without its lights, and, unless a frame does without them, the tones.
pub fn camera(state: &mut State, camera: &Camera, units: Units) {
    tones(state, camera);
    let (right, up, forward) = camera.basis();
    let [width, height] = camera.size;
    let half = f64::tan(0.5 * camera.fov.to_radians());
    state.data.camera = vec![Record {
        origin: narrow(units.inside(camera.position)),
        right: narrow(right * half * f64::from(width) / f64::from(height)),
        up: narrow(up * half),
        forward: narrow(forward),
        width,
        height,
        shift_x: 0.0,
        shift_y: 0.0,
        background: camera.background.map(|x| x as f32),
        environment: u32::from(camera.environment),
        radiance: units.radiance(),
        samples: camera.samples,
        weight: 1.0,
        ..Record::default()
    }];
}

/// Writes the tones, unless they were dropped.
pub fn tones(state: &mut State, camera: &Camera) {
    if state.data.camera.is_empty() || !state.data.tones.is_empty() {
        state.data.tones = thresholds(camera.exposure, camera.tone);
    }
}
