//! What can be done in the window: each control does what it says, and what it shows or saves is what `render` makes.

use milkglass::scene::{Scene, Source};

use super::*;

/// Plays events until the picture is whole, prints its command, and closes. Returns the picture and what was printed.
fn played(folder: &Path, arguments: &[&str], events: &str) -> (Pixels, Output) {
    let events = format!("{events}, {{ whole = true }}, {{ key = 'c' }}, {{ screenshot = 'a.png' }}, {{ key = 'q' }}");
    let out = view(folder, arguments, &events);
    (part(&read(folder.join("a.png")), [200, 150]), out)
}

fn printed(out: &Output) -> String {
    String::from_utf8_lossy(&out.stdout).into_owned()
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_handle_is_dragged_and_its_light_follows() {
    let folder = tempfile::tempdir().unwrap();
    let scene = Scene::load("slab").unwrap();
    let camera = scene.camera.clone().sized([200, 150]).unwrap();
    let Source::Point { position, .. } = scene.lights[0].source else { panic!("the lamp of slab is a point") };
    let (right, up, forward) = camera.basis();
    let offset = position - camera.position;
    let scale = 75.0 / (offset.dot(forward) * (camera.fov.to_radians() / 2.0).tan());
    let (x, y) = (100.0 + offset.dot(right) * scale, 75.0 - offset.dot(up) * scale);
    let drag = format!("{{ drag = {{ from = [{x}, {y}], to = [{}, {}] }} }}", x + 30.0, y - 12.0);
    // Shown again: then it can be dragged.
    let (shown, out) = played(folder.path(), &SMALL, &format!("{{ key = 'h' }}, {drag}, {{ key = 'h' }}"));
    let text = printed(&out);
    assert!(text.contains("light.0.position") && !text.contains("camera.position"), "{text}");
    let place = text.split("light.0.position=[").nth(1).unwrap().split(']').next().unwrap();
    let place: Vec<f64> = place.split(", ").map(|x| x.parse().unwrap()).collect();
    let wanted = position + (right * 30.0 + up * 12.0) / scale;
    let off = (0..3).map(|k| (place[k] - wanted[k]).abs()).fold(0.0, f64::max);
    assert!(off < 1e-6 * offset.length(), "{place:?} is not {wanted}");
    assert!(shown == repeated(folder.path(), &out), "not the picture of the command");
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn an_animation_steps_plays_and_stops() {
    let folder = tempfile::tempdir().unwrap();
    let scene = folder.path().join("slab.toml");
    let text = String::from_utf8(Command::new(PROGRAM).args(["scenes", "slab"]).output().unwrap().stdout).unwrap();
    let text = text.replace("exposure = 1.0", "exposure = { keyframes = [[0, 0.5], [40, 2.0]] }");
    std::fs::write(scene, text).unwrap();
    let arguments = ["slab.toml", "--size=200x150"];
    let at = |events: &str| {
        let (shown, out) = played(folder.path(), &arguments, events);
        assert!(shown == repeated(folder.path(), &out), "{events}: not the picture of the command");
        let frame = printed(&out).split("--frame=").nth(1).unwrap().split(' ').next().unwrap().to_owned();
        (frame.parse::<f64>().unwrap(), shown)
    };
    let (first, dark) = at("{ frames = 1 }");
    let (third, bright) = at("{ key = 'n' }, { key = 'n' }, { key = 'n' }, { key = 'N' }, { key = 'n' }");
    assert_eq!((first, third), (0.0, 3.0));
    assert!(dark != bright, "the frame is not shown");
    // If it does not begin again, it stops at its last frame, whole.
    let (last, _) = at("{ key = 'b' }, { key = 'space' }, { frames = 1 }");
    assert_eq!(last, 40.0);
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_layer_that_cannot_be_shown_is_told_and_the_light_comes_back() {
    let folder = tempfile::tempdir().unwrap();
    let dark = [&SMALL[..], &["--set", "light=[]"]].concat();
    let events = format!("{}, {{ message = true }}, {{ key = 'c' }}, {{ key = 'q' }}", ["{ key = 'v' }"; 8].join(", "));
    let out = view(folder.path(), &dark, &events);
    assert!(!printed(&out).contains("--view") && !printed(&out).contains("--aov"), "{}", printed(&out));
    // Where nothing casts shadows there is no layer of them.
    let unshadowed = [&SMALL[..], &["--set", "light.0.shadows=false", "--set", "light.1.shadows=false"]].concat();
    let events = "{ key = 'v' }, { key = 'v' }, { message = true }, { key = 'c' }, { key = 'q' }";
    let out = view(folder.path(), &unshadowed, events);
    assert!(!printed(&out).contains("--aov"), "{}", printed(&out));
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn what_is_saved_is_what_is_shown() {
    let folder = tempfile::tempdir().unwrap();
    let at = |name: &str| folder.path().join(name);
    let events = "{ drag = { from = [50, 50], to = [90, 70] } }, { key = 'm' }, { key = 'w' }, { whole = true }, \
                  { key = 's' }, { frames = 2 }, { key = 'e' }, { frames = 2 }, { key = 'S' }, { frames = 2 }, { key = 'g' }, \
                  { frames = 2 }";
    let (_, out) = played(folder.path(), &SMALL, events);
    let shown = read(at("slab-1.png"));
    assert!(shown == repeated(folder.path(), &out), "png");
    assert!(shown == rendered(folder.path(), &["slab-1.toml"]), "scene");
    let text = printed(&out).replace("slab.png", "linear.exr");
    repeat(folder.path(), &Output { stdout: text.into_bytes(), ..out });
    assert!(std::fs::read(at("slab-1.exr")).unwrap() == std::fs::read(at("linear.exr")).unwrap(), "exr");
    let trace: serde_json::Value = serde_json::from_str(&std::fs::read_to_string(at("slab-1.json")).unwrap()).unwrap();
    let events = trace["traceEvents"].as_array().unwrap();
    let named =
        |name: &str| events.iter().any(|event| event["name"] == name && event["dur"].as_f64().is_some_and(|d| d > 0.0));
    assert!(named("frame") && named("visibility"), "{trace}");
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn the_error_of_a_picture_is_estimated_and_refined() {
    let folder = tempfile::tempdir().unwrap();
    let events = "{ settled = true }, { screenshot = 'a.png' }, { key = 'a' }, { frames = 2 }, { settled = true }, \
                  { screenshot = 'b.png' }, { close = true }";
    for (method, estimated) in [("hierarchy", true), ("cdrf", false)] {
        view(folder.path(), &["slab", "--size=200x300", "--set=camera.samples=2", "--transport", method], events);
        let [before, after] = ["a.png", "b.png"].map(|name| read(folder.path().join(name)));
        assert!(part(&before, [200, 300]) == part(&after, [200, 300]), "{method}: the picture changed");
        assert_eq!(before != after, estimated, "{method}: the panel");
    }
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_scene_that_cannot_be_rendered_gives_way_to_the_last_good_one() {
    let folder = tempfile::tempdir().unwrap();
    let events =
        "{ whole = true }, { key = 'm' }, { whole = true }, { set = 'object.0.detail=500' }, { message = true }";
    let (shown, out) = played(folder.path(), &[&SMALL[..], &["--limit-memory=256M"]].concat(), events);
    assert!(printed(&out).contains("preset") && !printed(&out).contains("detail"), "{}", printed(&out));
    // Below the message.
    let [shown, good] =
        [shown, repeated(folder.path(), &out)].map(|(wide, _, rgb)| rgb[(wide * 3 * 120) as usize..].to_vec());
    assert!(shown == good, "not the picture of the last good scene");
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn methods_that_refuse_a_scene_are_passed() {
    let folder = tempfile::tempdir().unwrap();
    let sets = ["--set", "transport.receivers='pixels'", "--set", "transport.walks=1000", "--transport=none"];
    let events = "{ whole = true }, { key = 'T' }, { message = true }";
    let (_, out) = played(folder.path(), &[&SMALL[..], &sets].concat(), events);
    // Before none come auto and diffusion, which is solved at triangles.
    assert!(printed(&out).contains("--transport walk "), "{}", printed(&out));
}

mod rare {
    use super::*;

    #[test]
    #[ignore = "rare: part of .ci/full, `cargo test --release -- --include-ignored`"]
    fn layers_are_those_of_render() {
        let folder = tempfile::tempdir().unwrap();
        let keys = |count: usize| vec!["{ key = 'v' }"; count].join(", ");
        for (events, view) in [
            (keys(8), &["--view=curvature"][..]),
            ("{ key = 'x' }".into(), &["--view=clusters", "--pick=100,75"]),
            (format!("{}, {{ key = 'V' }}, {{ key = 'V' }}, {{ key = 'V' }}", keys(3)), &[]),
        ] {
            let (shown, out) = played(folder.path(), &SMALL, &events);
            assert!(
                shown == rendered(folder.path(), &[&SMALL[..], view].concat()),
                "{view:?}: not the picture of render"
            );
            assert!(shown == repeated(folder.path(), &out), "{view:?}: not the picture of the command");
        }
        // Layers of numbers are those of the file that the same key saves, and that the command writes.
        let mut seen = vec![rendered(folder.path(), &SMALL)];
        for count in 1..8 {
            let (shown, out) =
                played(folder.path(), &SMALL, &format!("{}, {{ whole = true }}, {{ key = 'e' }}", keys(count)));
            assert!(!seen.contains(&shown), "layer {count} is another one");
            seen.push(shown);
            let saved = folder.path().join("slab-1.exr");
            repeat(folder.path(), &out);
            assert!(
                std::fs::read(&saved).unwrap() == std::fs::read(folder.path().join("slab.exr")).unwrap(),
                "layer {count}"
            );
            std::fs::remove_file(saved).unwrap();
        }
    }

    #[test]
    #[ignore = "rare: part of .ci/full, `cargo test --release -- --include-ignored`"]
    fn deformations_and_options_are_what_the_printed_command_renders() {
        let folder = tempfile::tempdir().unwrap();
        let plain = rendered(folder.path(), &SMALL);
        for (events, changed) in [
            ("{ key = 'w' }, { key = '>' }, { key = '>' }", "object.0.deform.0.angle=117.0"),
            ("{ key = 'alt+right' }, { key = 'alt+up' }", "light.0.position"),
            ("{ key = 'y' }", "transport.scheme=links"),
            ("{ key = '}' }, { key = '}' }", "light.0.intensity"),
        ] {
            let (shown, out) = played(folder.path(), &SMALL, events);
            assert!(printed(&out).contains(changed), "{changed}: {}", printed(&out));
            assert!(shown != plain, "{changed}: nothing changed");
            assert!(shown == repeated(folder.path(), &out), "{changed}: not the picture of the command");
        }
        let (shown, out) = played(folder.path(), &SMALL, "{ key = 'k' }");
        assert!(printed(&out).contains("--mode render") && shown == repeated(folder.path(), &out), "mode");
    }
}
