//! Loading of built-in scenes, scene files and meshes alone, and its errors.

use super::*;
use glam::DVec3;

const TRIANGLE: &str = "v 0 0 0\nv 4 0 0\nv 0 2 0\nf 1 2 3\n";

fn sets(texts: &[&str]) -> Vec<String> {
    texts.iter().map(ToString::to_string).collect()
}

fn message(result: Result<Scene>) -> String {
    result.err().map(|error| error.to_string()).unwrap_or_default()
}

/// A folder with these files, and the path of the first.
fn files(contents: &[(&str, &str)]) -> (tempfile::TempDir, String) {
    let folder = tempfile::tempdir().expect("a folder");
    for (name, text) in contents {
        std::fs::write(folder.path().join(name), text).expect("written");
    }
    let first = contents.first().map(|(name, _)| folder.path().join(name)).unwrap_or_default();
    (folder, first.to_string_lossy().into_owned())
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn every_built_in_scene_loads_without_a_word() {
    for (name, toml, about) in BUILTIN {
        let scene = Scene::load_with(&name.to_uppercase(), &[]).expect(name);
        assert_eq!((scene.name.as_str(), scene.report.len()), (*name, 0));
        assert!(!about.is_empty() && !scene.lights.is_empty());
        assert_eq!(scene.objects[0].mesh.open_edges, 0);
        // Users copy the text to their own file.
        let (_folder, path) = files(&[("copy.toml", toml)]);
        let copy = Scene::load_with(&path, &[]).expect(name);
        assert_eq!((copy.name.as_str(), &copy.camera), ("copy", &scene.camera));
    }
}

#[test]
fn the_candle_stands_in_the_bowl() {
    let scene = Scene::load_with("lotus", &[]).expect("lotus");
    let Some(Source::Point { position, .. }) = scene.lights.first().map(|light| &light.source) else {
        panic!("the first light is the candle");
    };
    // The candle is above the floor of the bowl and below its rim.
    let (_, high) = scene.objects[0].mesh.bounds();
    let near = |p: &&DVec3| p.x.hypot(p.z) < 2.0;
    let floor = scene.objects[0].mesh.positions.iter().filter(near).map(|p| p.y);
    let floor = floor.fold(f64::NEG_INFINITY, f64::max);
    assert!(position.y > floor + 3.0 && position.y < high.y, "{floor} {position} {high}");
}

#[test]
fn a_mesh_alone_is_a_scene_too() {
    let (_folder, path) = files(&[("leaf.obj", TRIANGLE)]);
    let scene = Scene::load_with(&path, &[]).expect("a triangle");
    assert_eq!((scene.name.as_str(), scene.objects[0].material.name.as_str()), ("leaf", "Marble"));
    let (low, high) = scene.objects[0].mesh.bounds();
    assert_eq!((low, high), (DVec3::new(-10.0, -5.0, 0.0), DVec3::new(10.0, 5.0, 0.0)));
    assert_eq!(scene.report.len(), 1);
    assert!(scene.report[0].starts_with("open: 3 edges have one face only"));

    let settings = sets(&["object.0.size=30", "object.0.material.preset=whole-milk", "unit=cm"]);
    let scene = Scene::load_with(&path, &settings).expect("a larger triangle");
    assert!((scene.objects[0].mesh.bounds().1.x - 15.0).abs() < 1e-12);
    assert!((scene.objects[0].material.sigma_s_prime[0] - 25.5).abs() < 1e-12);

    let error = message(Scene::load_with(&path, &sets(&["object.0.size=0"])));
    assert!(error.starts_with("--set object.0.size=0: object.0.size: out of range; found 0"), "{error}");
}

#[test]
fn meshes_are_found_beside_the_scene_file_and_keep_their_size() {
    let text = "[[object]]\nmesh = 'leaf.obj'\nmaterial.preset = 'apple'\n";
    let (_folder, path) = files(&[("a.toml", text), ("leaf.obj", TRIANGLE)]);
    let scene = Scene::load_with(&path, &[]).expect("a triangle");
    assert_eq!(scene.objects[0].mesh.bounds().1, DVec3::new(4.0, 2.0, 0.0));
    assert_eq!(scene.camera.target, DVec3::new(2.0, 1.0, 0.0));
    assert!(scene.report.contains(&"dark: the scene has no [[light]]".to_owned()));
}

#[test]
fn what_is_not_there_or_cannot_be_read_is_an_error() {
    let error = message(Scene::load_with("lotsu", &[]));
    let expected = "neither a built-in scene nor a file, did you mean `lotus`?; found lotsu; \
                    expected a file, or one of bump, bust, candle, fish, gecko, lotus, noise, slab, slab-layers, sphere, torus, \
                    twist, veins";
    assert_eq!(error, expected);
    let error = message(Scene::load_with("no/such/horse.obj", &[]));
    assert!(error.starts_with("neither a built-in scene nor a file; found no/such/horse.obj"), "{error}");

    let (folder, path) = files(&[("a.toml", "[[object]]\nmesh = 'gone.obj'\nmaterial.preset = 'apple'\n")]);
    assert!(message(Scene::load_with(&path, &[])).ends_with("gone.obj: there is no such mesh file"));
    let error = message(Scene::load_with(&folder.path().to_string_lossy(), &[]));
    assert!(error.contains(": the scene file cannot be read; found "), "{error}");
    std::fs::write(&path, b"\xff\xfe").expect("written");
    assert!(message(Scene::load_with(&path, &[])).contains("a.toml: the scene file cannot be read"));
}

#[test]
fn normals_of_a_file_shade_it_where_nothing_moves_its_vertices() {
    let text = "v 0 0 0\nv 4 0 0\nv 0 2 0\nvn 0 0.6 0.8\nvn 0 0 1\nf 1//1 2//2 3//2\n";
    let (_folder, path) = files(&[("a.obj", text), ("b.obj", TRIANGLE)]);
    let normals =
        |path: &str, set: &[&str]| Scene::load_with(path, &sets(set)).expect("a scene").objects[0].mesh.normals.clone();
    assert_eq!(normals(&path, &[]), Some(vec![DVec3::new(0.0, 0.6, 0.8), DVec3::Z, DVec3::Z]));
    assert_eq!(normals(&path, &["object.0.normals='file'"]), normals(&path, &[]));
    for set in ["object.0.normals='faces'", "object.0.deform=[{ type = 'twist', axis = [0, 0, 1], angle = 30 }]"] {
        assert_eq!(normals(&path, &[set]), None, "{set}");
    }
    assert_eq!(normals(&path.replace("a.obj", "b.obj"), &[]), None);
    let shape = message(Scene::load_with("sphere", &sets(&["object.0.normals='faces'"])));
    assert!(shape.contains("a shape has no file with normals") && shape.contains("object.0.normals"), "{shape}");
    let other = message(Scene::load_with(&path, &sets(&["object.0.normals='smooth'"])));
    assert!(other.contains("object.0.normals") && other.contains("expected file, faces"), "{other}");
}

#[test]
fn a_camera_that_stands_on_its_target_has_a_line() {
    let text = "[camera]\nposition = [0, 0, 0]\n[[object]]\nshape = 'slab'\nmaterial.preset = 'apple'\n";
    let (_folder, path) = files(&[("a.toml", text)]);
    let error = message(Scene::load_with(&path, &[]));
    assert!(error.contains("a.toml:2: camera.position: the camera stands on"), "{error}");

    // An error caused by a setting names that setting.
    let sets = ["camera.position=[0,0,0]".to_owned()];
    let error = message(Scene::load_with("sphere", &sets));
    assert!(error.starts_with("--set camera.position=[0,0,0]: camera.position: the camera stands on"), "{error}");
}

#[test]
fn a_preset_that_is_set_is_the_whole_preset() {
    let material = |sets: &[&str]| {
        let sets: Vec<String> = sets.iter().map(|set| (*set).to_owned()).collect();
        Scene::load_with("lotus", &sets).expect("a scene").objects[0].material.clone()
    };
    let marble = material(&["object.0.material.preset=marble"]);
    assert_eq!((marble.name.as_str(), marble.sigma_s_prime, marble.eta), ("Marble", [2.19, 2.62, 3.0], [1.5; 3]));
    let denser = material(&["object.0.material.preset=marble", "object.0.material.eta=1.2"]);
    assert_eq!((denser.sigma_a, denser.eta), (marble.sigma_a, [1.2; 3]));
}
