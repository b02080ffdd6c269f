//! How drags and keys move the camera and the lights.

use glam::{DQuat, DVec3};
use milkglass::scene::{Camera, Light, Source};

/// The least angle between the view and the camera's up direction, degrees.
const POLE: f64 = 1.0;

/// The camera, moved around its target by degrees to the right and upwards.
pub(super) fn orbit(camera: &Camera, right: f64, up: f64) -> Camera {
    let (axis, ..) = camera.basis();
    let offset = camera.position - camera.target;
    let height = offset.angle_between(camera.up).to_degrees();
    let raised = (height - up).clamp(POLE.min(height), (180.0 - POLE).max(height)) - height;
    let offset = DQuat::from_axis_angle(axis, raised.to_radians()) * offset;
    let offset = DQuat::from_axis_angle(camera.up, right.to_radians()) * offset;
    Camera { position: camera.target + offset, ..camera.clone() }
}

/// The camera, shifted with its target by parts of the picture's height.
pub(super) fn pan(camera: &Camera, right: f64, up: f64) -> Camera {
    let (across, upwards, _) = camera.basis();
    let height = 2.0 * camera.position.distance(camera.target) * (camera.fov.to_radians() / 2.0).tan();
    let shift = height * (across * right + upwards * up);
    Camera { position: camera.position + shift, target: camera.target + shift, ..camera.clone() }
}

/// The camera with its distance from its target multiplied by `factor`; unchanged where a scene may not have that.
pub(super) fn zoom(camera: &Camera, factor: f64) -> Camera {
    let offset = (camera.position - camera.target) * factor;
    let length = offset.length();
    if !(1e-6..=1e8).contains(&length) {
        return camera.clone();
    }
    Camera { position: camera.target + offset, ..camera.clone() }
}

/// Whether a light can be moved: any but an environment.
pub(super) fn moves(light: &Light) -> bool {
    !matches!(light.source, Source::Environment { .. })
}

/// Keys of a light in a scene file, and their new values.
pub(super) type Keys = Vec<(&'static str, String)>;

/// A vector, or red, green and blue, as scene files have it.
pub(super) fn list(v: impl Into<[f64; 3]>) -> String {
    let [x, y, z] = v.into();
    format!("[{x:?}, {y:?}, {z:?}]")
}

/// Multiplies what a light emits. Returns and changes as [`turn_light`] does.
pub(super) fn brighten(light: &mut Light, factor: f64) -> Keys {
    let alike = matches!(&light.source, Source::Environment { sky, .. } if sky.is_constant());
    let (key, emitted) = match &mut light.source {
        Source::Directional { irradiance, .. } => ("irradiance", irradiance),
        Source::Point { intensity, .. } | Source::Spot { intensity, .. } => ("intensity", intensity),
        Source::Area { radiance, .. } => ("radiance", radiance),
        Source::Environment { sky, .. } => ("intensity", &mut sky.factor),
    };
    *emitted = emitted.map(|value| value * factor);
    let value = list(*emitted);
    if alike { vec![("radiance", value), ("intensity", list([1.0; 3]))] } else { vec![(key, value)] }
}

/// The keys of a light that change when it is turned about `middle`, by degrees to the right and upwards as the camera
/// sees it. The light itself becomes that of a scene file with these keys. An image from all around turns about +y.
pub(super) fn turn_light(light: &mut Light, camera: &Camera, middle: DVec3, right: f64, up: f64) -> Keys {
    let (across, upwards, _) = camera.basis();
    let turn = DQuat::from_axis_angle(upwards, right.to_radians()) * DQuat::from_axis_angle(across, -up.to_radians());
    let about = |point: DVec3| middle + turn * (point - middle);
    // Rounded as by the reader of scene files.
    let unit = |vector: DVec3| (vector / vector.abs().max_element()).normalize();
    match &mut light.source {
        Source::Directional { direction, .. } => {
            let new = turn * *direction;
            *direction = unit(new);
            vec![("direction", list(new))]
        }
        Source::Point { position, .. } => {
            *position = about(*position);
            vec![("position", list(*position))]
        }
        Source::Spot { position, direction, .. } => {
            let new = turn * *direction;
            (*position, *direction) = (about(*position), unit(new));
            vec![("position", list(*position)), ("direction", list(new))]
        }
        Source::Area { position, edge_u, edge_v, .. } => {
            (*position, *edge_u, *edge_v) = (about(*position), turn * *edge_u, turn * *edge_v);
            vec![("position", list(*position)), ("edge_u", list(*edge_u)), ("edge_v", list(*edge_v))]
        }
        Source::Environment { sky, .. } if sky.is_constant() => Vec::new(),
        Source::Environment { sky, .. } => {
            sky.rotation = (sky.rotation + right).rem_euclid(360.0);
            vec![("rotation", format!("{:?}", sky.rotation))]
        }
    }
}

/// Where a light is in a scene whose middle and extent (half the diagonal) these are: one infinitely far away is shown
/// at that distance. None for an environment.
pub(super) fn place_of(light: &Light, middle: DVec3, extent: f64) -> Option<DVec3> {
    match &light.source {
        Source::Directional { direction, .. } => Some(middle + *direction * extent),
        Source::Point { position, .. } | Source::Spot { position, .. } | Source::Area { position, .. } => {
            Some(*position)
        }
        Source::Environment { .. } => None,
    }
}

/// The pixel where a point is seen, from the upper left, and its distance along the view; none behind the camera.
pub(super) fn project(camera: &Camera, point: DVec3) -> Option<([f64; 2], f64)> {
    let (across, upwards, forward) = camera.basis();
    let offset = point - camera.position;
    let depth = offset.dot(forward);
    let [width, height] = camera.size.map(f64::from);
    let scale = height / (2.0 * depth * (camera.fov.to_radians() / 2.0).tan());
    (depth > 0.0)
        .then(|| ([width / 2.0 + offset.dot(across) * scale, height / 2.0 - offset.dot(upwards) * scale], depth))
}

/// Moves a light to `place`, where [`place_of`] then has it: a light infinitely far away turns. Otherwise as
/// [`turn_light`].
pub(super) fn move_light(light: &mut Light, middle: DVec3, place: DVec3) -> Keys {
    match &mut light.source {
        Source::Directional { direction, .. } => {
            let new = place - middle;
            if new.length() > 0.0 {
                *direction = (new / new.abs().max_element()).normalize();
            }
            vec![("direction", list(new))]
        }
        Source::Point { position, .. } | Source::Spot { position, .. } | Source::Area { position, .. } => {
            *position = place;
            vec![("position", list(place))]
        }
        Source::Environment { .. } => Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use milkglass::scene::Scene;

    fn camera() -> Camera {
        let camera = Scene::load("sphere").unwrap().camera;
        Camera { position: DVec3::new(0.0, 0.0, 5.0), target: DVec3::ZERO, up: DVec3::Y, ..camera }
    }

    #[test]
    fn an_orbit_keeps_the_distance_and_stops_at_the_poles() {
        let side = orbit(&camera(), 90.0, 0.0);
        assert!(side.position.distance(DVec3::new(5.0, 0.0, 0.0)) < 1e-12, "{}", side.position);
        let above = orbit(&camera(), 0.0, 30.0);
        assert!((above.position.y - 2.5).abs() < 1e-12 && above.position.z > 0.0, "{}", above.position);
        for up in [500.0, -500.0] {
            let pole = orbit(&camera(), 0.0, up).position;
            assert!((pole.length() - 5.0).abs() < 1e-12 && pole.z > 0.0 && pole.y * up > 0.0, "{pole}");
        }
        // A view along the up direction is left alone.
        let along = Camera { position: DVec3::new(0.0, 5.0, 0.0), ..camera() };
        assert!(orbit(&along, 10.0, 0.0).position.distance(along.position) < 1e-12);
    }

    #[test]
    fn a_pan_shifts_by_parts_of_the_picture_and_a_zoom_keeps_the_target() {
        let camera = camera();
        let height = 10.0 * (camera.fov.to_radians() / 2.0).tan();
        let shifted = pan(&camera, 1.0, -0.5);
        assert!(shifted.target.distance(DVec3::new(height, -0.5 * height, 0.0)) < 1e-12);
        assert!((shifted.position - shifted.target).distance(camera.position) < 1e-12);
        assert!(zoom(&camera, 0.5).position.distance(DVec3::new(0.0, 0.0, 2.5)) < 1e-12);
        assert_eq!(zoom(&camera, 1e300), camera);
    }

    #[test]
    #[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
    fn a_changed_light_is_that_of_a_scene_file_with_the_new_values() {
        let mut kinds = std::collections::BTreeSet::new();
        for name in ["sphere", "slab", "lotus", "candle", "bust"] {
            let scene = Scene::load(name).unwrap();
            let (low, high) = scene.bounds();
            for (index, before) in scene.lights.iter().enumerate() {
                let set = |(key, value): (&str, String)| format!("light.{index}.{key}={value}");
                let read = |keys: Keys| {
                    let sets: Vec<String> = keys.into_iter().map(set).collect();
                    Scene::load_with(name, &sets).unwrap().lights.swap_remove(index)
                };
                let mut bright = before.clone();
                let keys = brighten(&mut bright, 1.1);
                assert!(bright != *before && read(keys) == bright, "{name}");
                let mut turned = before.clone();
                let keys = turn_light(&mut turned, &scene.camera, (low + high) / 2.0, 12.3, -4.5);
                let constant = matches!(&before.source, Source::Environment { sky, .. } if sky.is_constant());
                assert!((turned == *before) == constant && read(keys) == turned, "{name}");
                kinds.insert((moves(before), constant));
            }
        }
        assert!(kinds.contains(&(true, false)) && kinds.contains(&(false, false)), "{kinds:?}");
        // A constant sky whose file has a factor.
        let sets = ["light=[{ type = 'environment', radiance = 2, intensity = 3 }]".to_owned()];
        let mut sky = Scene::load_with("sphere", &sets).unwrap().lights.swap_remove(0);
        let keys = brighten(&mut sky, 0.5).into_iter().map(|(key, value)| format!("light.0.{key}={value}"));
        let sets: Vec<String> = sets.into_iter().chain(keys).collect();
        assert_eq!(Scene::load_with("sphere", &sets).unwrap().lights[0], sky);
    }

    #[test]
    fn a_moved_light_is_seen_where_it_was_moved_to() {
        let scene = Scene::load("sphere").unwrap();
        let (low, high) = scene.bounds();
        let (middle, extent) = ((low + high) / 2.0, (high - low).length() / 2.0);
        let mut seen = 0;
        for light in &scene.lights {
            let Some(start) = place_of(light, middle, extent) else { continue };
            let (across, ..) = scene.camera.basis();
            let mut moved = light.clone();
            let keys = move_light(&mut moved, middle, start + across);
            let now = place_of(&moved, middle, extent).unwrap();
            let far = matches!(light.source, Source::Directional { .. });
            assert!(keys.len() == 1 && moved != *light && now.distance(start) < 1.0 + 1e-9);
            assert!(far || now.distance(start + across) < 1e-12);
            seen += 1;
        }
        assert!(seen > 0);
        let camera = camera();
        let ([x, y], depth) = project(&camera, DVec3::ZERO).unwrap();
        let [width, height] = camera.size.map(f64::from);
        assert!((x - width / 2.0).abs() < 1e-9 && (y - height / 2.0).abs() < 1e-9 && (depth - 5.0).abs() < 1e-12);
        let top = DVec3::new(0.0, 5.0 * (camera.fov.to_radians() / 2.0).tan(), 0.0);
        assert!(project(&camera, top).unwrap().0[1].abs() < 1e-9 && project(&camera, DVec3::Z * 6.0).is_none());
    }
}
