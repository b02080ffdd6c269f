//! Opaque objects in pictures, lit per pixel.

use std::f64::consts::PI;

use crate::devices::on_devices;
use glam::DVec3;
use milkglass::internals::gpu::Device;
use milkglass::internals::layout::BufferId;
use milkglass::internals::pipeline::plan::{Change, Goal, Options, ShadingMethod};
use milkglass::internals::session::run::Session;
use milkglass::scene::Scene;

/// A floor of two triangles, a ball above it, and a lamp above the ball.
fn scene(sets: &[&str]) -> Scene {
    let all = [
        "camera.size=[64, 48]",
        "camera.position=[0, 60, 80]",
        "camera.target=[0, 0, 0]",
        "camera.samples=1",
        "camera.background=0",
        "object.0.detail=4",
        "object.0.size=10",
        "object.0.position=[0, 15, 0]",
        "object.1={ shape = 'plane', detail = 1, size = 200, material = { opaque = true, albedo = [0.5, 0.25, 0] } }",
        "light.0={ type = 'point', position = [0, 40, 0], intensity = [2000, 3000, 4000] }",
    ];
    let sets: Vec<String> = all.iter().chain(sets).map(|set| set.to_string()).collect();
    Scene::load_with("sphere", &sets).unwrap()
}

fn run(scene: &Scene, device: Option<&Device>, options: Options) -> Session {
    let mut session = Session::new(scene, device, options).unwrap();
    session.frame(Change::EVERYTHING).unwrap();
    session
}

/// Runs `body` on the CPU and on every device.
fn on_each(body: &dyn Fn(Option<&Device>)) {
    body(None);
    on_devices(|device| body(Some(device)));
}

/// Position and radiance of each pixel that shows the floor, in the scene's units.
fn floor(session: &mut Session) -> Vec<(DVec3, [f32; 3])> {
    let picture = session.picture().unwrap();
    session.fetch(&[BufferId::placed_positions]).unwrap();
    let (state, units) = (session.state(), *session.units());
    let data = &state.data;
    let shown = data
        .hits
        .iter()
        .zip(picture.pixels)
        .filter(|(hit, _)| (hit.face as usize) < data.triangles.len() && state.object_of(hit.face as usize) == 1);
    let place = |hit: &milkglass::internals::layout::Hit| {
        let weights = [1.0 - f64::from(hit.u) - f64::from(hit.v), hit.u.into(), hit.v.into()];
        let corners =
            data.triangles[hit.face as usize].map(|v| DVec3::from(data.in_scene()[v as usize].map(f64::from)));
        units.outside(corners.iter().zip(weights).map(|(corner, weight)| *corner * weight).sum())
    };
    shown.map(|(hit, radiance)| (place(hit), radiance)).collect()
}

#[test]
fn a_floor_of_two_triangles_has_the_lamps_light_and_the_balls_shadow() {
    let lamp = DVec3::new(0.0, 40.0, 0.0);
    on_each(&|device| {
        let pixels = floor(&mut run(&scene(&[]), device, Options::default()));
        let (mut lit, mut dark) = (0, 0);
        for (place, radiance) in pixels {
            let way = lamp - place;
            // Distance between the ray to the lamp and the ball's centre.
            let near = (DVec3::new(0.0, 15.0, 0.0) - place).cross(way).length() / way.length();
            let irradiance = way.y / way.length().powi(3);
            let expected = [0.5, 0.25, 0.0].map(|albedo| albedo * irradiance / PI);
            for (c, intensity) in [2000.0, 3000.0, 4000.0].into_iter().enumerate() {
                let expected = if near < 4.9 { 0.0 } else { expected[c] * intensity };
                let off = (f64::from(radiance[c]) - expected).abs();
                assert!((4.9..5.0).contains(&near) || off <= 1e-5 * expected, "{place}: {radiance:?}, not {expected}");
            }
            lit += u32::from(near > 5.0);
            dark += u32::from(near < 4.9);
        }
        assert!(lit > 500 && dark > 50, "{lit} lit, {dark} dark");
    });
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn every_transport_shows_the_same() {
    let picture = |transport| floor(&mut run(&scene(&[]), None, Options { transport, ..Options::default() }));
    let carried = picture(ShadingMethod::Hierarchy);
    for transport in [ShadingMethod::None, ShadingMethod::Cdrf, ShadingMethod::Lambert, ShadingMethod::Brute] {
        assert_eq!(picture(transport), carried, "{transport:?}");
    }
    // The same in a picture with layers, though its triangles are lit as well.
    let layers = Options { goal: Goal::Layers, estimate: true, ..Options::default() };
    let mut session = run(&scene(&[]), None, layers);
    assert_eq!(floor(&mut session), carried);
    let first = session.state().objects[1].first.faces;
    assert!(session.state().data.irradiance[first..first + 2].iter().any(|light| light[0] > 0.0));
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_frame_after_a_change_is_a_new_sessions() {
    let before = scene(&["object.1.material.reflection=ggx"]);
    let light = scene(&["object.1.material.reflection=ggx", "light.0.position=[9, 30, -4]"]);
    let mut view = light.clone();
    view.camera.position.x += 7.0;
    on_each(&|device| {
        let mut session = run(&before, device, Options::default());
        for next in [&light, &view] {
            session.show(next).unwrap();
            session.frame(Change::default()).unwrap();
            let kept = session.picture().unwrap().pixels;
            assert_eq!(kept, run(next, device, Options::default()).picture().unwrap().pixels);
        }
    });
}

#[test]
fn what_nobody_asks_for_has_no_stage() {
    let session = |sets: &[&str], options| run(&scene(sets), None, options);
    let stages_run = |session: &Session| {
        let names: Vec<&str> = session.plan().stages.iter().map(|stage| stage.name).collect();
        let has = |name: &str| names.contains(&name);
        (has("pixel_shadow"), has("shade_opaque"), has("opaque_faces"))
    };
    let picture = Options::default();
    assert_eq!(stages_run(&session(&[], picture)), (true, true, false));
    assert_eq!(stages_run(&session(&["light.0.shadows=false"], picture)), (false, true, false));
    assert_eq!(stages_run(&session(&["transport.receivers=faces"], picture)), (false, false, true));
    assert_eq!(stages_run(&session(&["object.1.material={ preset = 'marble' }"], picture)), (false, false, false));
    assert_eq!(stages_run(&session(&[], Options { goal: Goal::Radiosity, ..picture })), (false, false, true));

    // If everything is opaque, no lighting is evaluated per triangle.
    let all = session(&["object.0.material={ opaque = true }"], picture);
    let names: Vec<&str> = all.plan().stages.iter().map(|stage| stage.name).collect();
    assert_eq!(names, ["refit", "placement", "widen", "visibility", "shade", "pixel_shadow", "shade_opaque", "tone"]);
    assert!(all.state().data.lit.is_empty());
    assert!(session(&["object.1.material={ preset = 'marble' }"], picture).state().data.pixel_lit.is_empty());
}
