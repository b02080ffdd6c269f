//! Moving shapes: deformations, keyframes, sequences.

use crate::devices;
use crate::shell::{bad, bytes, folder, good, names, numbers, read};
use milkglass::internals::layout::BufferId;
use milkglass::internals::pipeline::plan::{Change, Options};
use milkglass::internals::prepare::shape::turned;
use milkglass::internals::session::run::Session;
use milkglass::measure::norms::worst;
use milkglass::measure::reference::verify;
use milkglass::scene::{Deform, Scene};

const SCENE: &str = "[camera]\nposition = [0, 9, 30]\nsize = [40, 30]\nfov = 40\n\n\
    [[light]]\ntype = 'point'\nposition = [0, 20, { keyframes = [[0, 9], [3, -9]] }]\n\
    intensity = { keyframes = [[0, [300, 200, 100]], [2, [100, 200, 300]]], curve = 'smooth' }\n\n\
    [[object]]\nshape = 'candle'\ndetail = 16\nsize = 10\nmaterial = { preset = 'marble' }\n\
    [[object.deform]]\ntype = 'noise'\namplitude = 0.3\nscale = 2\n\
    offset = { keyframes = [[0, [0, 0, 0]], [9, [0, 9, 0]]] }\n\
    [[object.deform]]\ntype = 'twist'\nangle = { keyframes = [[0, 0], [3, 120]] }\n";

fn at(frame: f64) -> Scene {
    let folder = folder(&[("moving.toml", SCENE)]);
    Scene::load_at(folder.path().join("moving.toml").to_str().unwrap(), &[], frame).unwrap()
}

fn open(scene: &Scene) -> Session {
    let mut session = Session::new(scene, None, Options::default()).unwrap();
    session.frame(Change::EVERYTHING).unwrap();
    session
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_session_that_moves_on_is_a_new_one() {
    // Forwards, backwards, and to an undeformed scene and back.
    let mut moving = open(&at(1.0));
    let bare = |frame: f64| {
        let mut scene = at(frame);
        scene.objects[0].deforms.clear();
        scene
    };
    for scene in [at(2.0), at(3.0), at(0.0), bare(0.0), bare(1.0), at(1.0)] {
        moving.show(&scene).unwrap();
        moving.frame(Change::default()).unwrap();
        let fresh = open(&scene);
        for slot in
            [BufferId::positions, BufferId::bounds, BufferId::irradiance, BufferId::radiosity, BufferId::radiance]
        {
            let [a, b] = [&moving, &fresh].map(|session| session.state().data.bytes(slot).to_vec());
            assert!(a == b, "{slot:?}");
        }
    }
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_spoilt_tree_is_built_anew() {
    let twist = |frame: f64| Scene::load_at("twist", &["object.0.detail=16".to_string()], frame).unwrap();
    let mut moving = open(&twist(0.0));
    assert_eq!(moving.prepared().spoilt, [None]);
    let trees = moving.prepared().trees.clone();
    moving.show(&twist(3.0)).unwrap();
    assert!(moving.prepared().spoilt == [None] && moving.prepared().trees == trees);
    // Forwards and back, each time without a trace of earlier frames.
    for frame in [40.0, 45.0, 0.0] {
        moving.show(&twist(frame)).unwrap();
        moving.frame(Change::default()).unwrap();
        let fresh = open(&twist(frame));
        assert_eq!(moving.prepared().spoilt[0].is_some(), frame > 0.0, "{frame}");
        assert!(moving.prepared().trees == fresh.prepared().trees, "{frame}");
        assert!(moving.state().data.radiance == fresh.state().data.radiance, "{frame}");
        assert_eq!(moving.prepared().trees == trees, frame == 0.0, "{frame}");
    }
}

#[test]
fn a_tree_that_is_built_anew_is_told() {
    let here = folder(&[]);
    for (frame, told) in [(0, false), (40, true)] {
        for command in ["plan", "profile --frames 1"] {
            let run = format!(
                "{command} twist --frame {frame} --device cpu --set object.0.detail=16 --set camera.size=[9,9]"
            );
            assert_eq!(good(&here, &run).0.contains("tree rebuilt"), told, "{run}");
        }
    }
}

#[test]
fn a_deformed_shape_meets_the_tolerance_and_has_its_own_triangles() {
    let scene = at(3.0);
    let mut session = open(&scene);
    assert_eq!(turned(session.state()), [0]);
    let error = worst(&verify(&mut session, 200, 3).unwrap());
    assert!(error.l2 < scene.transport.tolerance, "{error:?}");
    // Most positions differ from the rest pose, and the root's bounds contain them all.
    let data = &session.state().data;
    let moved = data.positions.iter().zip(&data.rest).filter(|(a, b)| a != b).count();
    assert!(moved > data.positions.len() / 2, "{moved}");
    let root = data.bounds[0];
    let inside = |p: &[f32; 3]| (0..3).all(|k| root.low[k] <= p[k] && p[k] <= root.high[k]);
    assert!(data.positions.iter().all(inside));
}

#[test]
fn what_does_not_move_costs_nothing() {
    let mut scene = at(0.0);
    scene.objects[0].deforms.clear();
    let session = open(&scene);
    let data = &session.state().data;
    assert!(data.rest.is_empty() && data.rest_normals.is_empty() && data.deforms.is_empty());
    assert!(session.plan().left_out.iter().any(|(name, why)| *name == "deform" && why.contains("nothing deforms")));
    assert!(open(&at(0.0)).plan().stages.iter().any(|stage| stage.name == "deform"));
}

#[test]
fn triangles_turned_inside_out_are_told() {
    let here = folder(&[]);
    let ball = "solve sphere --set object.0.detail=3 --device cpu -o a.csv";
    // A hollow deeper than the ball is thick; a bend tighter than the ball is wide.
    for deform in [
        "{type='bump',position=[0,10,0],radius=9,height=-25}",
        "{type='bend',angle=400,axis=[0,1,0],toward=[1,0,0],length=6}",
    ] {
        let (_, warned) = good(&here, &format!("{ball} --set object.0.deform=[{deform}]"));
        assert!(warned.contains("inside out"), "{deform}: {warned}");
    }
    let (_, warned) = good(&here, &format!("{ball} --set object.0.deform=[{{type='twist',angle=720}}]"));
    assert!(!warned.contains("inside out"), "{warned}");
}

#[test]
fn solve_knows_the_moved_triangles() {
    let here = folder(&[]);
    let ball = "solve sphere --set object.0.detail=2 --device cpu -o a.csv";
    let rows = |more: &str| {
        good(&here, &format!("{ball} {more}"));
        numbers(&read(&here, "a.csv")).1
    };
    let (still, moved) = (
        rows(""),
        rows("--set object.0.deform=[{type='bump',position=[0,0,0],radius=900,height=3,direction=[1,0,0]}]"),
    );
    for (a, b) in still.iter().zip(&moved) {
        assert!((b[1] - a[1] - 3.0).abs() < 2e-3 && (b[2] - a[2]).abs() < 1e-4, "{a:?}, {b:?}");
    }
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn frames_do_not_depend_on_each_other() {
    let here = folder(&[("moving.toml", SCENE)]);
    for device in ["--device cpu", ""] {
        good(&here, &format!("render moving.toml --frames 0..3 -o f%02d.png {device}"));
        good(&here, &format!("render moving.toml --frame 2 -o one.png {device}"));
        assert!(bytes(&here, "f02.png") == bytes(&here, "one.png"), "{device:?}");
        assert!(bytes(&here, "f02.png") != bytes(&here, "f03.png"), "{device:?}");
    }
    assert_eq!(names(here.path()), ["f00.png", "f01.png", "f02.png", "f03.png", "moving.toml", "one.png"]);
    // With `--skip-existing`, existing files are left alone.
    std::fs::write(here.path().join("f01.png"), "mine").unwrap();
    std::fs::remove_file(here.path().join("f02.png")).unwrap();
    let (_, said) = good(&here, "render moving.toml --frames 1..2 --skip-existing -o f%02d.png --device cpu");
    assert!(said.contains("1 frames") && said.contains("1 were there"), "{said}");
    assert_eq!(read(&here, "f01.png"), "mine");
}

#[test]
fn a_mesh_a_frame() {
    // First other positions, then other triangles.
    let tall = |top: f64| format!("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 {top}\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n");
    let scene = "[camera]\nposition = [3, 3, 3]\nsize = [24, 24]\n[[light]]\ntype = 'directional'\n\
                 direction = [1, 2, 1]\nirradiance = 1\n[transport]\nreceivers = 'faces'\n\
                 [[object]]\nmesh = 'm/f%02d.obj'\nmaterial = { preset = 'marble', scale = 20 }\n";
    let here = folder(&[("moving.toml", scene)]);
    std::fs::create_dir(here.path().join("m")).unwrap();
    let write = |name: &str, text: String| std::fs::write(here.path().join("m").join(name), text).unwrap();
    write("f00.obj", tall(1.0));
    write("f01.obj", tall(2.0));
    write("f02.obj", tall(2.0).replace("f 3 1 4\n", "v 0.2 0.2 0.9\nf 3 1 5\nf 1 4 5\nf 4 3 5\n"));
    good(&here, "render moving.toml --frames 0..2 -o a%d.png --device cpu");
    for frame in 0..3 {
        good(&here, &format!("render moving.toml --frame {frame} -o b.png --device cpu"));
        assert!(bytes(&here, &format!("a{frame}.png")) == bytes(&here, "b.png"), "{frame}");
    }
    assert!(bytes(&here, "a0.png") != bytes(&here, "a1.png") && bytes(&here, "a1.png") != bytes(&here, "a2.png"));
    bad(&here, "render moving.toml --frame 3 -o c.png --device cpu", 2, &["f03.obj"]);
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn what_moves_from_object_to_object() {
    // As many deformations but of another object, another picture size, and deformations with another centre.
    let ball = |x: f64, angle: &str| {
        format!(
            "[[object]]\nshape = 'slab'\ndetail = 4\nsize = 8\nposition = [{x}, 0, 0]\n\
             material = {{ preset = 'marble' }}\ndeform = [{{ type = 'twist', angle = {{ keyframes = {angle} }} }}]\n"
        )
    };
    let scene = format!(
        "[camera]\nsize = {{ keyframes = [[0, [24, 20]], [1, [30, 20]]] }}\n[[light]]\ntype = 'directional'\n\
         direction = [1, 2, 1]\nirradiance = 1\n{}{}",
        ball(-5.0, "[[0, 9], [1, 0]]"),
        ball(5.0, "[[0, 0], [1, 9]]")
    );
    let here = folder(&[("moving.toml", &scene)]);
    for device in ["--device cpu", ""] {
        for more in ["", "--set transport.subdivide=1"] {
            good(&here, &format!("render moving.toml {more} --frames 0..1 -o a%d.png {device}"));
            good(&here, &format!("render moving.toml {more} --frame 1 -o b.png {device}"));
            assert!(bytes(&here, "a1.png") == bytes(&here, "b.png"), "{device:?} {more:?}");
        }
    }
}

#[test]
fn ends_are_the_objects_wherever_the_centre_is() {
    let sets = |center: &str| {
        let deform = format!("object.0.deform=[{{type='twist', angle=90, center={center}}}]");
        Scene::load_with("sphere", &["object.0.detail=2".into(), deform]).unwrap().objects[0].deforms[0].clone()
    };
    let span = |deform: Deform| match deform {
        Deform::Twist { span, .. } => (span.center.y + span.low, span.length),
        other => panic!("{other:?}"),
    };
    let (low, length) = span(sets("[0, 0, 0]"));
    let (other_low, other_length) = span(sets("[0, -500, 0]"));
    assert!((low - other_low).abs() < 1e-9 && (length - other_length).abs() < 1e-9);
}

#[test]
fn faults_are_named() {
    let here = folder(&[("moving.toml", SCENE)]);
    let run = "render moving.toml --device cpu -o a%d.png";
    for (arguments, words) in [
        ("--frames 3..1", "--frames: not a range of frames; found 3..1"),
        ("--frames 0..1 --set 'camera.fov={keyframes=[[0,40],[1,nan]]}'", "not finite"),
        ("--frames 0..1 --set 'camera.fov={keyframes=[[0,40],[1,400]]}'", "camera.fov: out of range; found 400"),
        ("--frame nan", "--frame: not a frame"),
        ("--set 'object.0.deform=[{type=\"twist\"}]'", "missing field"),
        ("--set 'object.0.deform=[{type=\"twitch\",angle=3}]'", "did you mean `twist`"),
        ("--set 'object.0.deform=[{type=\"twist\",angle=inf}]'", "object.0.deform.0.angle: not a finite number"),
        (
            "--set 'object.0.deform=[{type=\"bump\",position=[0,0,0],radius=0,height=1}]'",
            "deform.0.radius: out of range",
        ),
        ("--set 'object.0.deform=[{type=\"bend\",angle=3,axis=[0,1,0],toward=[0,2,0]}]'", "deform.0.toward"),
        (
            "--set 'object.0.deform.0.amplitude=1e9'",
            "object.0.deform: the deformations move the object too far; found a vertex",
        ),
        ("--skip-existing", "--frames"),
    ] {
        bad(&here, &format!("{run} {}", arguments.replace('\'', "")), 2, &[words]);
    }
    bad(&here, "render moving.toml --frames 0..1 -o a.png", 2, &["%04d"]);
    let broken =
        SCENE.replace("angle = { keyframes = [[0, 0], [3, 120]] }", "angle = { keyframes = [[3, 0], [0, 120]] }");
    std::fs::write(here.path().join("moving.toml"), broken).unwrap();
    bad(&here, run, 2, &["moving.toml:", "object.0.deform.1.angle: keyframes are not in order"]);
    assert_eq!(names(here.path()), ["moving.toml"]);
}

#[test]
fn a_frame_of_another_shape_deforms_nothing_on_the_host() {
    let twist = |frame: f64| Scene::load_at("twist", &["object.0.detail=16".to_string()], frame).unwrap();
    devices::on_devices(|device| {
        let mut moving = Session::new(&twist(1.0), Some(device), Options::default()).unwrap();
        moving.frame(Change::EVERYTHING).unwrap();
        let before = moving.state().data.positions.clone();
        moving.show(&twist(3.0)).unwrap();
        moving.frame(Change::default()).unwrap();
        assert!(moving.state().data.positions == before, "the host has deformed the vertices");
        // The host has them once they are fetched.
        moving.fetch(&[BufferId::positions, BufferId::normals]).unwrap();
        let fresh = Session::new(&twist(3.0), None, Options::default()).unwrap();
        assert!(moving.state().data.positions == fresh.state().data.positions);
        assert!(moving.vertices() == fresh.vertices());
    });
}
