//! Meshes in their studio: which way up they stand, what the camera sees, and what is said about them.

use super::*;
use crate::scene::Source;

/// A table with four feet, whose top juts out, `long` in one direction, as an OBJ file; the axis points upwards.
fn table(axis: usize, long: f64) -> String {
    let mut text = String::new();
    let mut count = 0;
    let mut solid = |low: [f64; 3], high: [f64; 3]| {
        for corner in 0..8 {
            let mut p = [0, 1, 2].map(|k| if corner >> k & 1 == 0 { low[k] } else { high[k] });
            p.rotate_right((axis + 1) % 3);
            text += &format!("v {} {} {}\n", p[0], p[1], p[2]);
        }
        for [a, b, c, d] in [[1, 3, 4, 2], [5, 6, 8, 7], [1, 2, 6, 5], [3, 7, 8, 4], [1, 5, 7, 3], [2, 4, 8, 6]] {
            text += &format!("f {} {} {} {}\n", a + count, b + count, c + count, d + count);
        }
        count += 8;
    };
    // In these coordinates the third is up.
    solid([-0.2, -0.2, 2.0], [2.2, long + 0.2, 3.0]);
    for (x, y) in [(0.0, 0.0), (1.8, 0.0), (0.0, long - 0.2), (1.8, long - 0.2)] {
        solid([x, y, 0.0], [x + 0.2, y + 0.2, 2.1]);
    }
    text
}

fn studio(text: &str, sets: &[&str], wishes: Wishes) -> (tempfile::TempDir, Studio) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("table.obj");
    std::fs::write(&path, text).expect("written");
    let sets: Vec<String> = sets.iter().map(ToString::to_string).collect();
    let made = Studio::around(&path.to_string_lossy(), &sets, 0.0, &Files::default(), wishes).expect("a studio");
    (folder, made.expect("a mesh alone"))
}

#[test]
fn a_mesh_stands_on_its_feet() {
    for (axis, up) in [(1, "y"), (2, "z")] {
        let (_folder, made) = studio(&table(axis, 2.0), &[], Wishes::default());
        let scene = made.scene(0.0, &[], 0.0, &Files::default()).expect("a scene");
        assert!(made.told[0].starts_with(&format!("table: {up} is up (a guess: --up), 20 mm")), "{:?}", made.told);
        let (low, high) = scene.bounds();
        assert!(high.y - low.y > 1.2 * (high.x - low.x), "{up}: {low} {high}");
        let feet = scene.objects[0].mesh.positions.iter().filter(|&&p| scene.objects[0].placed(p).y < low.y + 0.1);
        assert_eq!(feet.count(), 16, "{up}");
    }
    let wishes = Wishes { up: Some(Up::Y), ..Wishes::default() };
    let (_folder, made) = studio(&table(2, 2.0), &[], wishes);
    assert!(made.told[0].starts_with("table: y is up, 20 mm"), "{:?}", made.told);
}

#[test]
fn all_light_leaves_in_the_studio_whatever_the_preset() {
    for preset in Preset::names() {
        let wishes = || Wishes { preset: Some(preset.into()), ..Wishes::default() };
        let (_folder, made) = studio(&table(1, 2.0), &[], wishes());
        let made = [made, Studio::around_shape("torus", &Files::default(), wishes()).expect("a studio")];
        for scene in made.map(|made| made.scene(0.0, &[], 0.0, &Files::default()).expect("a scene")) {
            assert!(scene.objects[0].material.surface.normalize_exit, "{preset}");
        }
    }
    let set = "object.0.material.normalize_exit=false";
    let (_folder, made) = studio(&table(1, 2.0), &[], Wishes { ground: true, ..Wishes::default() });
    let scene = made.scene(0.0, &[set.into()], 0.0, &Files::default()).expect("a scene");
    let normalized = scene.objects.iter().map(|object| object.material.surface.normalize_exit);
    assert_eq!(normalized.collect::<Vec<_>>(), [false; 2], "as it is set, and the table is opaque");
}

#[test]
fn skin_is_larger_unless_a_size_is_given() {
    let cases = [("marble", None, "", 20), ("skin1", None, "", 40), ("Skin 2", None, "camera.size=[9, 9]", 40)];
    let given = [("skin1", Some(30.0), "camera.size=[9, 9]", 30), ("skin1", None, "object.0.size=25", 25)];
    for (preset, size_mm, set, extent) in cases.into_iter().chain(given) {
        let sets: Vec<&str> = Some(set).into_iter().filter(|set| !set.is_empty()).collect();
        let wishes = Wishes { preset: Some(preset.into()), size_mm, ..Wishes::default() };
        let (_folder, made) = studio(&table(1, 2.0), &sets, wishes);
        assert!(made.told[0].contains(&format!(", {extent} mm (--size-mm)")), "{preset}, {set}: {:?}", made.told);
    }
}

#[test]
fn the_camera_sees_all_of_the_broad_side() {
    for (ground, turn, pixels) in [(false, 0.0, [100, 100]), (true, 120.0, [300, 100])] {
        let wishes = Wishes { ground, pixels: Some(pixels), ..Wishes::default() };
        let (_folder, made) = studio(&table(2, 7.0), &[], wishes);
        let scene = made.scene(turn, &[], 0.0, &Files::default()).expect("a scene");
        let (right, up, forward) = scene.camera.basis();
        let tall = (scene.camera.fov.to_radians() / 2.0).tan();
        let wide = tall * f64::from(pixels[0]) / f64::from(pixels[1]);
        let mut most = 0.0f64;
        for &point in &scene.objects[0].mesh.positions {
            let seen = scene.objects[0].placed(point) - scene.camera.position;
            let depth = seen.dot(forward);
            most = most.max(seen.dot(right).abs() / depth / wide).max(seen.dot(up).abs() / depth / tall);
        }
        assert!(turn > 0.0 || (0.75..1.0).contains(&most), "{most}");
        let (low, high) = scene.objects[0].bounds();
        let across = if high.x - low.x > high.z - low.z { right.x } else { right.z };
        assert!(turn > 0.0 || across.abs() > 0.9, "{across}");
        assert_eq!(scene.objects.len(), if ground { 2 } else { 1 });
        assert_eq!((scene.camera.samples, scene.lights.len()), (8, 3));
    }
}

#[test]
fn sizes_that_hide_the_light_are_told() {
    let told = |size: f64| {
        let wishes = Wishes { size_mm: Some(size), ..Wishes::default() };
        studio(&table(1, 2.0), &[], wishes).1.told
    };
    assert_eq!(told(20.0).len(), 1);
    let [thick, thin] = [told(2000.0), told(0.2)];
    assert!(
        thick[1].contains("looks opaque") && thin[1].contains("thinner than a mean free path"),
        "{thick:?} {thin:?}"
    );
    for told in [thick, thin] {
        let better = told[1].split("--size-mm ").nth(1).and_then(|rest| rest.split(' ').next()?.parse::<f64>().ok());
        assert!(better.is_some_and(|size| (2.0..=200.0).contains(&size)), "{told:?}");
    }
}

#[test]
fn settings_come_last_and_shape_the_studio() {
    let sets = ["object.0.size=5", "light.2.radiance=7", "camera.exposure=3"];
    let (_folder, made) = studio(&table(1, 2.0), &sets, Wishes::default());
    let scene = made.scene(0.0, &sets.map(String::from), 0.0, &Files::default()).expect("a scene");
    assert!(made.told[0].contains(" 5 mm"), "{:?}", made.told);
    assert!(scene.camera.position.distance(scene.camera.target) < 25.0 && scene.camera.exposure == 3.0);
    assert!(matches!(scene.lights[2].source, Source::Area { radiance: [7.0, ..], .. }));
    let (_folder, made) = studio(&table(1, 2.0), &[], Wishes::default());
    let copy = Scene::parse("copy.toml", &made.toml(), &[]).expect("its text is a scene file");
    assert_eq!(copy.lights.len(), 3);
}

#[test]
fn wrong_wishes_are_named() {
    let message = |wishes: Wishes| {
        let folder = tempfile::tempdir().expect("a folder");
        let path = folder.path().join("a.obj");
        std::fs::write(&path, table(1, 2.0)).expect("written");
        let made = Studio::around(&path.to_string_lossy(), &[], 0.0, &Files::default(), wishes);
        made.err().map(|error| error.to_string()).unwrap_or_default()
    };
    let error = message(Wishes { preset: Some("marbel".into()), ..Wishes::default() });
    assert!(error.starts_with("--preset: unknown preset, did you mean `Marble`?; found marbel; expected"), "{error}");
    let error = message(Wishes { size_mm: Some(-1.0), ..Wishes::default() });
    assert!(error.starts_with("--size-mm: not a size; found -1; expected"), "{error}");
    let error = message(Wishes { environment: Some("none.hdr".into()), ..Wishes::default() });
    assert!(error.starts_with("--environment: none.hdr: the image cannot be read"), "{error}");
    assert!(Studio::around("lotus", &[], 0.0, &Files::default(), Wishes::default()).expect("built in").is_none());
}

/// The studio of a file with this name and text.
fn named(name: &str, text: &str, sets: &[&str], wishes: Wishes) -> (tempfile::TempDir, Studio, Scene) {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join(name);
    std::fs::write(&path, text).expect("written");
    let sets: Vec<String> = sets.iter().map(ToString::to_string).collect();
    let made = Studio::around(&path.to_string_lossy(), &sets, 0.0, &Files::default(), wishes);
    let made = made.expect("a studio").expect("a mesh alone");
    let scene = made.scene(0.0, &sets, 0.0, &Files::default()).expect("a scene");
    (folder, made, scene)
}

#[test]
fn sheets_are_lit_from_both_sides_and_bodies_from_one() {
    let leaf = "v 0 0 0\nv 1 0 0.2\nv 1 1 0\nv 0 1 0.2\nf 4 3 2 1\n";
    let (_folder, made, scene) = named("leaf.obj", leaf, &[], Wishes::default());
    assert!(scene.objects[0].material.two_sided && scene.lights[0].samples() == 64);
    assert_eq!(made.told.len(), 2);
    assert!(made.told[1].starts_with("leaf: an open sheet without thickness, lit from both sides"), "{:?}", made.told);
    // The light behind a sheet does not drown the one in front.
    let Source::Area { radiance: [thin, ..], .. } = scene.lights[2].source else { panic!("{:?}", scene.lights) };
    let (_folder, made, scene) = named("leaf.obj", leaf, &["object.0.material.two_sided=false"], Wishes::default());
    assert!(!scene.objects[0].material.two_sided && made.told.len() == 1, "{:?}", made.told);
    let (_folder, made, scene) = named("table.obj", &table(1, 2.0), &[], Wishes::default());
    assert!(!scene.objects[0].material.two_sided && made.told.len() == 1, "{:?}", made.told);
    assert_eq!(scene.lights[0].samples(), 0);
    assert!(matches!(scene.lights[2].source, Source::Area { radiance: [thick, ..], .. } if thick > 3.9 * thin));
}

/// A tetrahedron under a light of this kind, as a glTF file.
fn lit_by(kind: &str) -> String {
    let light = match kind {
        "spot" => "{ \"type\": \"spot\", \"intensity\": 900, \"spot\": {} }".to_owned(),
        kind => format!("{{ \"type\": \"{kind}\", \"intensity\": 900 }}"),
    };
    format!(
        r#"{{ "asset": {{ "version": "2.0" }}, "scene": 0, "scenes": [{{ "nodes": [0, 1] }}], "nodes": [{{ "mesh": 0 }},
        {{ "translation": [3, 4, 5], "extensions": {{ "KHR_lights_punctual": {{ "light": 0 }} }} }}],
        "meshes": [{{ "primitives": [{{ "attributes": {{ "POSITION": 0 }}, "indices": 1 }}] }}],
        "accessors": [{{ "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3" }},
        {{ "bufferView": 1, "componentType": 5121, "count": 12, "type": "SCALAR" }}],
        "bufferViews": [{{ "buffer": 0, "byteLength": 48 }}, {{ "buffer": 0, "byteOffset": 48, "byteLength": 12 }}],
        "buffers": [{{ "byteLength": 60, "uri":
"data:application/octet-stream;base64,AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAAAAAAAAAAAAAAAIA/AAIBAAEDAAMCAQID"
        }}],
        "extensionsUsed": ["KHR_lights_punctual"],
        "extensions": {{ "KHR_lights_punctual": {{ "lights": [{light}] }} }} }}"#
    )
}

#[test]
fn what_the_studio_adds_is_as_bright_whatever_the_files_lights_need() {
    for kind in ["point", "spot", "directional"] {
        let (_folder, _, scene) = named("a.gltf", &lit_by(kind), &[], Wishes::default());
        let camera = &scene.camera;
        assert_eq!((camera.exposure, scene.lights.len()), (683.0, 1), "{kind}");
        let backdrop = format!("{:?}", camera.background);
        let shown = camera.exposure * camera.background[0];
        assert!((0.01..0.2).contains(&shown), "{kind}: {backdrop}");
    }
    let wishes = || Wishes { environment: Some("builtin:sky".into()), ..Wishes::default() };
    let (_folder, _, own) = named("a.gltf", &lit_by("point"), &[], wishes());
    let (_folder, _, bare) = named("a.obj", &table(1, 2.0), &[], wishes());
    let behind = |scene: &Scene| match scene.lights[1].source {
        Source::Area { radiance: [red, ..], .. } => red * scene.camera.exposure,
        _ => f64::NAN,
    };
    assert!((behind(&own) / behind(&bare) - 1.0).abs() < 1e-9, "{} {}", behind(&own), behind(&bare));
}

#[test]
fn the_camera_stands_where_it_is_asked_to() {
    let toward = |name: &str, text: &str, view: Option<&str>| {
        let view = view.map(|view| view.parse().expect("a view"));
        let (_folder, _, scene) = named(name, text, &[], Wishes { view, ..Wishes::default() });
        (scene.camera.position - scene.camera.target).normalize()
    };
    let long = table(1, 7.0);
    let (slant, rise) = ((0.5f64).sqrt(), 30f64.to_radians());
    for (view, way) in [
        ("front", DVec3::Z),
        ("back", -DVec3::Z),
        ("left", -DVec3::X),
        ("right", DVec3::X),
        ("45, 0", DVec3::new(slant, 0.0, slant)),
        ("-90,30", DVec3::new(-rise.cos(), rise.sin(), 0.0)),
    ] {
        let found = toward("a.obj", &long, Some(view));
        assert!(found.distance(way) < 1e-9, "{view}: {found}");
    }
    assert!(toward("a.obj", &long, Some("top")).y > 0.999);
    for bad in ["above", "0", "0,90", "x,1", "NaN,0"] {
        assert!(bad.parse::<ViewFrom>().is_err_and(|words| words.contains("front, back, left")), "{bad}");
    }
    // Of glTF +z is the front, even where the side is broader.
    let long = lit_by("point").replace("{ \"mesh\": 0 }", "{ \"mesh\": 0, \"scale\": [1, 1, 9] }");
    assert!(long.contains("\"scale\"") && toward("a.gltf", &long, None).z > 0.9);
}
