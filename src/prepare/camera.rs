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

/// Sends the rays through another point of the pixels, in pixels from their centres, and of the lens, in radii from its
/// middle. The picture is shifted so that what is in focus stays where it is.
pub fn shift(record: &mut Record, camera: &Camera, units: Units, pixel: [f64; 2], lens: [f64; 2]) {
    let (right, up, _) = camera.basis();
    let [across, above] = lens.map(|x| 0.5 * camera.aperture * x);
    record.origin = narrow(units.inside(camera.position + across * right + above * up));
    // In twice a pixel.
    let [left, down] = lens.map(|x| (0.5 * camera.lens() * x) as f32);
    record.shift_x = 2.0 * pixel[0] as f32 - left;
    record.shift_y = 2.0 * pixel[1] as f32 + down;
}

/// Writes the tones, unless they were dropped.
pub fn tones(state: &mut State, camera: &Camera) {
    if state.data.camera.is_empty() || !state.data.tones.is_empty() {
        state.data.tones = thresholds(camera.exposure, camera.tone);
    }
}
