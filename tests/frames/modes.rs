//! What each mode keeps between frames, and that the results do not depend on it.

use crate::devices;
use crate::shell::{bytes, folder, good};
use milkglass::internals::gpu::Device;
use milkglass::internals::layout::BufferId;
use milkglass::internals::pipeline::plan::{Change, Goal, Mode, Options};
use milkglass::internals::session::run::Session;
use milkglass::measure::norms::worst;
use milkglass::measure::reference::verify;
use milkglass::scene::{Light, Scene};

const RENDER: Options = Options {
    transport: milkglass::internals::pipeline::plan::ShadingMethod::Hierarchy,
    mode: Mode::Render,
    goal: Goal::Radiosity,
    estimate: false,
};

pub fn scene(name: &str, sets: &[&str]) -> Scene {
    Scene::load_with(name, &sets.iter().map(|set| set.to_string()).collect::<Vec<_>>()).unwrap()
}

/// The scene's light, at this fraction of a full turn.
fn turned(scene: &Scene, turn: f64) -> Vec<Light> {
    let (sine, cosine) = (std::f64::consts::TAU * turn).sin_cos();
    let direction =
        format!("light.0={{ type = 'directional', direction = [{sine}, {cosine}, 0.2], irradiance = [3, 2, 1] }}");
    let mut lights = Scene::load_with(&scene.name, &[direction]).unwrap().lights;
    lights.truncate(1);
    lights
}

fn radiosity(session: &mut Session) -> Vec<[f32; 3]> {
    session.fetch(&[BufferId::radiosity]).unwrap();
    session.state().data.radiosity.clone()
}

pub fn names(session: &mut Session, change: Change) -> Vec<String> {
    session.frame(change).unwrap().into_iter().map(|time| time.name).collect()
}

/// A light circles a lotus: checks when lists are rebuilt, which stages run, and the errors.
fn round(device: Option<&Device>) {
    let scene = scene("lotus", &["object.0.detail=32", "transport.tolerance=1e-2"]);
    let mut session = Session::new(&scene, device, RENDER).unwrap();
    session.frame(Change::EVERYTHING).unwrap();
    let (mut kept, mut fresh_bits) = (0, 0);
    for step in 0..8 {
        let lights = turned(&scene, f64::from(step) / 8.0);
        let before = session.relinks();
        session.set_lights(&lights).unwrap();
        let ran = names(&mut session, Change::default());
        if session.relinks() == before && step > 0 {
            kept += 1;
            for idle in ["deform", "refit", "acceptance_radii", "link"] {
                assert!(!ran.iter().any(|name| name == idle), "{idle} ran though the lists serve: {ran:?}");
            }
        }
        let error = worst(&verify(&mut session, 100, 5).unwrap()).l2;
        assert!(error <= 1e-2, "turn {step}: {error}");
        if step % 3 == 1 {
            // Earlier frames leave no trace.
            let mut alone = scene.clone();
            alone.lights = lights;
            let mut alone = Session::new(&alone, device, RENDER).unwrap();
            alone.frame(Change::EVERYTHING).unwrap();
            assert!(radiosity(&mut alone) == radiosity(&mut session), "turn {step}");
            fresh_bits += 1;
        }
    }
    println!("kept {kept} of 7, made anew {}", session.relinks());
    assert!(kept >= 3 && session.relinks() > 0 && fresh_bits == 3, "kept {kept}");
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn lists_for_any_light_serve_a_light_that_goes_round() {
    round(None);
    devices::on_devices(|device| round(Some(device)));
}

#[test]
fn a_light_of_another_contrast_has_lists_made_anew() {
    let spot = |outer: u32| {
        let light = format!(
            "light.0={{ type = 'spot', position = [0, 0, 30], direction = [0, 0, -1], intensity = 900, \
             inner = 2, outer = {outer}, shadows = false }}"
        );
        let mut scene = scene("slab", &["object.0.detail=24", "transport.tolerance=1e-2", &light]);
        scene.lights.truncate(1);
        scene
    };
    let (wide, narrow) = (spot(60), spot(6));
    let mut session = Session::new(&wide, None, RENDER).unwrap();
    session.frame(Change::EVERYTHING).unwrap();
    let before = session.state().data.counters[0];
    assert!(before.serves() && session.relinks() == 0);
    session.set_lights(&narrow.lights).unwrap();
    session.frame(Change::default()).unwrap();
    let after = session.state().data.counters[0];
    assert!(
        after.serves() && session.relinks() == 1,
        "{} {:?} {:?}",
        session.relinks(),
        before.contrast,
        after.contrast
    );
    assert!(after.contrast != before.contrast);
    assert!(worst(&verify(&mut session, 300, 5).unwrap()).l2 <= 1e-2);
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn frames_of_a_sequence_are_those_of_a_new_session() {
    // Receivers at pixels and at triangles, an opaque object, and lights of two colours, one of them moving.
    let at = |turn: f64, receivers: &str| {
        let (sine, cosine) = (std::f64::consts::TAU * turn).sin_cos();
        let receivers = format!("transport.receivers={receivers}");
        let light =
            format!("light.0={{ type = 'directional', direction = [{sine}, {cosine}, 0.2], irradiance = [3, 2, 1] }}");
        let other = "light.1={ type = 'directional', direction = [0.5, 1, 1], irradiance = [0.1, 0.2, 0.2] }";
        let plate =
            "object.1={ shape = 'slab', detail = 2, size = 30, position = [0, -20, 0], material = { opaque = true } }";
        let sets = [
            "object.0.detail=24",
            "camera.size=[40, 30]",
            "transport.tolerance=1e-2",
            other,
            plate,
            &light,
            &receivers,
        ];
        scene("lotus", &sets)
    };
    let options = Options { mode: Mode::Render, goal: Goal::Picture, ..RENDER };
    devices::on_devices(|device| {
        for receivers in ["pixels", "faces"] {
            let mut session = Session::new(&at(0.0, receivers), Some(device), options).unwrap();
            session.frame(Change::EVERYTHING).unwrap();
            let mut contrasts = Vec::new();
            for turn in [0.1, 0.35, 0.5, 0.75] {
                session.show(&at(turn, receivers)).unwrap();
                session.frame(Change::default()).unwrap();
                let mut fresh = Session::new(&at(turn, receivers), Some(device), options).unwrap();
                fresh.frame(Change::EVERYTHING).unwrap();
                assert!(session.picture().unwrap().pixels == fresh.picture().unwrap().pixels, "{receivers} at {turn}");
                contrasts.push(session.state().data.counters[0].contrast);
            }
            contrasts.dedup();
            assert!(contrasts.len() > 1, "nothing to follow: {contrasts:?}");
        }
    });
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_frame_without_a_change_dispatches_nothing() {
    devices::on_devices(|device| {
        for (scheme, mode) in [("blocks", Mode::Render), ("blocks", Mode::OnTheFly), ("links", Mode::Render)] {
            let sets = ["object.0.detail=2", "camera.size=[32, 32]", &format!("transport.scheme={scheme}")];
            let options = Options { mode, goal: Goal::Picture, ..RENDER };
            let mut session = Session::new(&scene("sphere", &sets), Some(device), options).unwrap();
            assert!(!names(&mut session, Change::EVERYTHING).is_empty());
            assert_eq!(names(&mut session, Change::default()), [""; 0], "{scheme} {mode:?}");
            // A new view recomputes no transport.
            let transport = names(&mut session, Change::VIEW);
            assert_eq!(transport, ["visibility", "shade"], "{scheme} {mode:?}");
        }
    });
}

/// The steps that a frame runs after these settings are added to a scene of two balls.
fn after(more: &[&str], options: Options) -> Vec<String> {
    let base = [
        "object.0.detail=2",
        "object.1={ shape = 'sphere', detail = 2, size = 9, position = [16, 0, 0], material = { preset = 'ketchup' } }",
        "camera.size=[16, 16]",
        "transport.receivers=faces",
    ];
    let mut session = Session::new(&scene("sphere", &base), None, options).unwrap();
    session.frame(Change::EVERYTHING).unwrap();
    session.show(&scene("sphere", &[&base[..], more].concat())).unwrap();
    names(&mut session, Change::default())
}

#[test]
fn an_edit_runs_what_it_touches() {
    let picture = Options { goal: Goal::Picture, ..RENDER };
    let fly = Options { mode: Mode::OnTheFly, ..picture };

    // Coefficients of one of the two objects: the stages before transport stay, and so does the other object.
    let spread = ["coarse_solve", "acceptance_radii", "link", "gather", "push", "average"];
    assert_eq!(after(&["object.1.material.scale=2"], fly), [&spread[..], &["shade"]].concat());
    let kept = ["coarse_solve", "irradiance_ratio", "acceptance_radii", "link", "gather", "push", "average"];
    assert_eq!(after(&["object.1.material.scale=2"], picture), [&kept[..], &["shade"]].concat());

    // The camera runs the stages that depend on the view; exposure and tone run nothing.
    assert_eq!(after(&["camera.position=[0, 0, 50]"], fly), ["visibility", "shade"]);
    for shown in ["camera.exposure=2", "camera.tone=filmic"] {
        assert_eq!(after(&[shown], fly), [""; 0], "{shown}");
    }
    // The first light that casts shadows, and the first environment, leave shapes and lists for any light.
    let links = ["transport.scheme=links", "light.0.shadows=false", "object.0.detail=2", "camera.size=[16, 16]"];
    let more = |light: &str| {
        let mut session = Session::new(&scene("sphere", &links), None, picture).unwrap();
        session.frame(Change::EVERYTHING).unwrap();
        session.show(&scene("sphere", &[&links[..], &[light]].concat())).unwrap();
        names(&mut session, Change::default())
    };
    let summed = ["irradiance", "mean_irradiance", "sum_links", "push_links", "average", "shade"];
    let point = "light.1={ type='point', position=[4, 9, 25], intensity=500 }";
    assert_eq!(more(point), [&["shadow"], &summed[..]].concat());
    let sky = "light.1={ type='environment', image='builtin:sky', intensity=2 }";
    assert_eq!(more(sky), [&["environment"], &summed[..]].concat());
    // A new light leaves shapes and materials.
    let lit = after(&["light.0.direction=[1, 0, 0]"], fly);
    assert!(lit.iter().all(|name| name != "refit" && name != "deform"), "{lit:?}");
}

#[test]
fn the_plan_says_what_lists_serve() {
    let scene = scene("sphere", &["object.0.detail=2"]);
    let why = |options: Options| {
        let session = Session::new(&scene, None, options).unwrap();
        session.plan().left_out.iter().find(|(name, _)| *name == "irradiance_ratio").map(|(_, why)| why.clone())
    };
    assert_eq!(why(RENDER), None);
    assert!(why(Options { mode: Mode::OnTheFly, ..RENDER }).unwrap().contains("light of their frame"));
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn the_same_scene_gives_the_same_bytes() {
    let here = folder(&[]);
    for device in ["--device cpu", ""] {
        for scheme in ["blocks", "links"] {
            let sets = format!("--set object.0.detail=2 --set transport.scheme={scheme}");
            let line = format!("render sphere {sets} --size 16x16 {device}");
            good(&here, &format!("{line} -o a.exr"));
            good(&here, &format!("{line} -o b.exr"));
            good(&here, &format!("{line} -o c.exr --mode render"));
            good(&here, &format!("{line} -o d.exr --mode render"));
            assert_eq!(bytes(&here, "a.exr"), bytes(&here, "b.exr"), "twice, {device}");
            assert_eq!(bytes(&here, "c.exr"), bytes(&here, "d.exr"), "twice, --mode render, {device}");
            // Lists of blocks that serve any light differ from those of one light.
            let same = bytes(&here, "a.exr") == bytes(&here, "c.exr");
            assert_eq!(same, scheme == "links", "--mode render, {device}");
        }
    }
}
