//! Textures: what they do to light that enters and to light that leaves, where they lie on a mesh, and what is refused.

mod shell;

use std::f64::consts::TAU;

use milkglass::layout::Slot;
use milkglass::render::plan::{Change, Goal, Mode, Options, Transport};
use milkglass::render::run::{Room, Session};
use milkglass::scene::{Scene, Side, Texture, Wrap};
use shell::{bad, folder, good, read};

/// A small ball that may have a texture, and its settings.
fn ball(sets: &[&str]) -> Scene {
    let small = ["object.0.detail=3", "camera.size=[48, 40]", "object.0.material.texture=builtin:checker"];
    let sets: Vec<_> = small.iter().chain(sets).map(ToString::to_string).collect();
    Scene::load("sphere", &sets).unwrap()
}

/// The same with this texture, or none.
fn painted(texture: Option<Texture>) -> Scene {
    let mut scene = ball(&[]);
    scene.object.material.texture = texture;
    scene
}

/// A scene after one frame of the reference.
fn drawn(scene: &Scene, options: Options) -> Session {
    let mut session = Session::new(scene, None, options, Room::default()).unwrap();
    session.frame(Change::EVERYTHING).unwrap();
    session
}

fn grey(value: f32, side: Side) -> Option<Texture> {
    Some(Texture::new([1, 1], vec![[value; 3]], side, Wrap::Repeat))
}

/// Whether all numbers of `found` are `factor` times those of `bare`.
fn scaled(found: &[[f32; 3]], bare: &[[f32; 3]], factor: f32, slack: f32) -> bool {
    let near = |(a, b): (&f32, &f32)| (a - factor * b).abs() <= slack * factor * b;
    assert!(found.len() == bare.len() && bare.as_flattened().iter().any(|&x| x > 0.0));
    found.as_flattened().iter().zip(bare.as_flattened()).all(near)
}

#[test]
fn half_a_texture_is_half_the_light() {
    let background =
        |scene: Scene| Scene { camera: milkglass::scene::Camera { background: [0.0; 3], ..scene.camera }, ..scene };
    let run = |texture| drawn(&background(painted(texture)), Options::default());
    let mut bare = run(None);
    let (light, picture) = (bare.state().data.radiosity.clone(), bare.picture().unwrap().pixels);
    for (side, leaves) in [(Side::Exit, 1.0), (Side::Entry, 0.5), (Side::Both, 0.5f32.sqrt())] {
        let mut half = run(grey(0.5, side));
        assert!(scaled(&half.state().data.radiosity, &light, leaves, 1e-5), "{side:?}");
        assert!(scaled(&half.picture().unwrap().pixels, &picture, 0.5, 1e-5), "{side:?}");
    }
}

#[test]
fn what_enters_through_a_texture_and_its_complement_adds_up() {
    let tiles = ball(&["object.0.material.texture=builtin:tiles"]).object.material.texture.unwrap();
    let of = |turn: fn(f32) -> f32| {
        let texels = tiles.texels.iter().map(|texel| texel.map(turn)).collect();
        Some(Texture::new(tiles.size, texels, Side::Entry, Wrap::Repeat))
    };
    for transport in [Transport::Hierarchy, Transport::Brute, Transport::Octree] {
        let run = |texture| drawn(&painted(texture), Options { transport, ..Options::default() });
        let [all, some, rest] =
            [None, of(|x| x), of(|x| 1.0 - x)].map(|texture| run(texture).state().data.radiosity.clone());
        let (mut error, mut size) = (0.0, 0.0);
        for (k, all) in all.as_flattened().iter().enumerate() {
            error += (some.as_flattened()[k] + rest.as_flattened()[k] - all).powi(2);
            size += all * all;
        }
        // The octree errs by its angle each time.
        let slack = if transport == Transport::Octree { 0.05 } else { 2e-3 };
        assert!((error / size).sqrt() < slack, "{transport:?}: {}", (error / size).sqrt());
    }
}

#[test]
fn light_is_coloured_once_however_often_it_changes() {
    let scene = ball(&["object.0.material.texture=builtin:tiles", "object.0.material.texture_on=both"]);
    let options = Options { mode: Mode::Render, ..Options::default() };
    let mut kept = drawn(&scene, options);
    let (light, picture) = (kept.state().data.irradiance.clone(), kept.picture().unwrap().pixels);
    let names = |change, session: &mut Session| -> Vec<String> {
        session.frame(change).unwrap().into_iter().map(|step| step.name).filter(|name| name.starts_with('e')).collect()
    };
    assert_eq!(names(Change::VIEW, &mut kept), ["exit"]);
    assert_eq!(names(Change::RESUM, &mut kept), ["exit"]);
    for lights in [vec![], scene.lights.clone(), scene.lights.clone()] {
        kept.set_lights(&lights).unwrap();
        assert_eq!(names(Change::LIGHT, &mut kept).len(), if lights.is_empty() { 0 } else { 2 });
    }
    assert_eq!(kept.state().data.irradiance, light);
    assert_eq!(kept.picture().unwrap().pixels, picture);
}

#[test]
fn channels_part_only_where_a_texture_at_the_entry_parts_them() {
    let groups = |texels: Vec<[f32; 3]>, side| {
        let mut scene = painted(Some(Texture::new([2, 1], texels, side, Wrap::Repeat)));
        scene.lights.truncate(1);
        drawn(&scene, Options::default()).state().groups.len()
    };
    let colors = vec![[0.5, 0.2, 0.1], [0.1, 0.2, 0.5]];
    assert_eq!((groups(colors.clone(), Side::Entry), groups(colors, Side::Exit)), (3, 1));
    let one = vec![[0.5, 0.25, 0.1], [0.25, 0.125, 0.05]];
    assert_eq!((groups(one.clone(), Side::Entry), groups(one, Side::Both)), (1, 1));
    assert_eq!(groups(vec![[0.5, 0.0, 0.1], [0.2, 0.0, 0.3]], Side::Entry), 2);

    // A ratio of channels is carried by the light alone: each is right by itself.
    let [together, red] = [[0.5, 0.25, 0.1], [0.1, 0.1, 0.1]].map(|texel| {
        drawn(&painted(Some(Texture::new([1, 1], vec![texel], Side::Entry, Wrap::Clamp))), Options::default())
    });
    let blue = |session: &Session| session.state().data.radiosity.iter().map(|b| [b[2]; 3]).collect::<Vec<_>>();
    assert!(scaled(&blue(&together), &blue(&red), 1.0, 2e-3));
    let mut black = drawn(&painted(grey(0.0, Side::Entry)), Options::default());
    assert!(black.state().groups.is_empty());
    let hit: Vec<bool> = black.state().data.hits.iter().map(|hit| hit.face != u32::MAX).collect();
    let pixels = black.picture().unwrap().pixels;
    assert!(pixels.iter().zip(hit).all(|(pixel, hit)| !hit || *pixel == [0.0; 3]));
}

#[test]
fn the_seam_of_a_ball_is_not_seen() {
    // Brighter once round, darkest at the seam, which the eye looks at; and brighter upwards.
    let texel = |k: u32| {
        let (u, v) = ((f64::from(k % 128) + 0.5) / 128.0, 1.0 - (f64::from(k / 128) + 0.5) / 64.0);
        [0.5 - 0.4 * (TAU * u).cos(), v, 0.5 + 0.4 * (TAU * u).sin()].map(|x| x as f32)
    };
    let mut scene =
        ball(&["camera.position=[0, 4, -35]", "light.0.direction=[0.2, 0.3, -1]", "camera.target=[0, 0, 0]"]);
    scene.object.material.texture = None;
    let bare = drawn(&scene, Options::default()).picture().unwrap().pixels;
    scene.object.material.texture =
        Some(Texture::new([128, 64], (0..128 * 64).map(texel).collect(), Side::Exit, Wrap::Repeat));
    let mut session = drawn(&scene, Options::default());
    let pixels = session.picture().unwrap().pixels;
    let (data, mut seen) = (&session.state().data, [0; 2]);
    for (pixel, hit) in data.hits.iter().enumerate().filter(|(_, hit)| hit.face != u32::MAX) {
        let corners = data.triangles[hit.face as usize];
        let weight = [1.0 - hit.u - hit.v, hit.u, hit.v];
        let p: glam::Vec3 = (0..3).map(|k| weight[k] * glam::Vec3::from(data.positions[corners[k] as usize])).sum();
        let p = p.as_dvec3().normalize();
        if bare[pixel].contains(&0.0) || p.x.hypot(p.z) < 0.5 {
            continue;
        }
        let turn = p.x.atan2(p.z);
        let expected = [0.5 + 0.4 * turn.cos(), 0.5 + p.y.asin() * 2.0 / TAU, 0.5 - 0.4 * turn.sin()];
        let found = [0, 1, 2].map(|c| f64::from(pixels[pixel][c] / bare[pixel][c]));
        assert!((0..3).all(|c| (found[c] - expected[c]).abs() < 0.02), "{p}: {found:?} {expected:?}");
        seen[usize::from(p.x > 0.0)] += 1;
    }
    assert!(seen.iter().all(|&seen| seen > 100), "{seen:?}");
}

/// Two triangles with three textures across, from one before the first to one after it.
const SHEET: &str = "mtllib a.mtl\nv 0 0 0\nv 9 0 0\nv 9 3 0\nv 0 3 0\nvt -1 0\nvt 2 0\nvt 2 1\nvt -1 1\nusemtl paint\n\
                     f 1/1 2/2 3/3 4/4\n";
const SCENE: &str = "[camera]\nposition = [4.5, 1.5, 6]\nsize = [48, 16]\n[[light]]\ntype = 'directional'\n\
                     direction = [0, 0, 1]\nirradiance = 3\n[[object]]\nmesh = 'parts/a.obj'\n[object.0]\n";

/// A folder with that sheet, its material library, and a texture of two texels.
fn sheet(library: &str) -> tempfile::TempDir {
    let here = folder(&[]);
    std::fs::create_dir(here.path().join("parts")).unwrap();
    let write = |name: &str, text: &str| std::fs::write(here.path().join(name), text).unwrap();
    write("parts/a.obj", SHEET);
    write("parts/a.mtl", library);
    write("a.toml", &SCENE.replace("[object.0]\n", "material = { preset = 'marble' }\n"));
    let pixel = |x: u32, _| image::Rgb(if x == 0 { [255u8, 188, 0] } else { [0, 188, 255] });
    image::RgbImage::from_fn(2, 1, pixel).save(here.path().join("parts/two.png")).unwrap();
    here
}

#[test]
fn textures_of_files_and_libraries_go_on_as_they_are_told() {
    let here = sheet("newmtl bare\nKd 1 1 1\nnewmtl paint\nmap_Kd two.png\n");
    let path = here.path().join("a.toml").to_string_lossy().into_owned();
    let load = |sets: &[String]| drawn(&Scene::load(&path, sets).unwrap(), Options::default());
    let bare = load(&[]).picture().unwrap().pixels;
    // Red of the two texels is 1 and 0: a hill about the first one's centre.
    let wave = |wrap: &str, u: f64| {
        let at = 2.0 * u - 0.5;
        let step = match wrap {
            "repeat" => (at - 2.0 * (at / 2.0).round()).abs(),
            "clamp" => at,
            // The first two of four at -1 and 0, the others at 1 and 2.
            _ => (at + 0.5 - 4.0 * ((at + 0.5) / 4.0).round()).abs() - 0.5,
        };
        1.0 - step.clamp(0.0, 1.0)
    };
    for (wrap, name) in [("repeat", "mtl"), ("clamp", "parts/two.png"), ("mirror", "mtl")] {
        let sets = [format!("object.0.material.texture={name}"), format!("object.0.material.texture_wrap={wrap}")];
        let mut session = load(&sets);
        let (pixels, mut seen) = (session.picture().unwrap().pixels, 0);
        let (data, units) = (&session.state().data, *session.units());
        for (pixel, hit) in data.hits.iter().enumerate().filter(|(_, hit)| hit.face != u32::MAX) {
            let corners = data.triangles[hit.face as usize];
            let x = |k: usize| f64::from(data.positions[corners[k] as usize][0]) / units.length + units.center.x;
            let x = x(0) + f64::from(hit.u) * (x(1) - x(0)) + f64::from(hit.v) * (x(2) - x(0));
            let red = wave(wrap, x / 3.0 - 1.0);
            let expected = [red, 0.502_886_5, 1.0 - red];
            let found = [0, 1, 2].map(|c| f64::from(pixels[pixel][c] / bare[pixel][c]));
            assert!((0..3).all(|c| (found[c] - expected[c]).abs() < 1e-5), "{wrap}, {x}: {found:?} {expected:?}");
            seen += 1;
        }
        assert!(seen > 200, "{seen}");
    }
}

#[test]
fn bad_textures_are_named() {
    let here = sheet("newmtl a\nmap_Kd two.png\nnewmtl b\nmap_Kd b.png\n");
    let write = |name: &str, text: &[u8]| std::fs::write(here.path().join(name), text).unwrap();
    write("broken.png", b"\x89PNG but no more");
    write("c.obj", SHEET.replace("1/1", "1").as_bytes());
    write("d.obj", SHEET.replace("mtllib a.mtl\n", "").as_bytes());
    for (name, value) in [("high.exr", 1.5f32), ("low.exr", -0.1), ("nan.exr", f32::NAN)] {
        let pixel = move |x: usize, _| (0.5f32, if x == 1 { value } else { 0.5 }, 0.5f32);
        exr::prelude::write_rgb_file(here.path().join(name), 2, 1, pixel).unwrap();
    }
    image::GrayImage::new(16_385, 1).save(here.path().join("long.png")).unwrap();
    let cases: &[(&str, &str, &[&str])] = &[
        (
            "a.toml",
            "texture=gone.png",
            &["object.0.material.texture: ", "gone.png: the texture cannot be read; found "],
        ),
        ("a.toml", "texture=broken.png", &["object.0.material.texture: ", "broken.png: the texture cannot be read"]),
        (
            "a.toml",
            "texture=a.jpg",
            &["not the name of a texture; found ", "a.jpg", ".png, .exr or .hdr, mtl, or builtin:"],
        ),
        (
            "a.toml",
            "texture=high.exr",
            &["texel (1, 0), from the top left, is no albedo; found [0.5, 1.5, 0.5]", "0 to 1"],
        ),
        ("a.toml", "texture=low.exr", &["is no albedo; found [0.5, -0.1, 0.5]"]),
        ("a.toml", "texture=nan.exr", &["is no albedo; found [0.5, NaN, 0.5]"]),
        (
            "a.toml",
            "texture=long.png",
            &["too few or too many texels; found 16385 x 1", "8388608 texels, at most 16384 a"],
        ),
        ("a.toml", "texture=mtl", &["a.mtl: one material with a texture", "found 2: a, b"]),
        ("d.obj", "texture=mtl", &["object.0.material.texture: d.obj: the mesh names no material library"]),
        (
            "c.obj",
            "texture=builtin:checker",
            &["c.obj:11: object.0.material.texture: the mesh has no texture coordinates"],
        ),
        ("sphere", "texture=mtl", &["object.0.material.texture: a shape has no material library"]),
        ("sphere", "texture=builtin:chekcer", &["built in, did you mean `builtin:checker`?", "builtin:tiles"]),
        ("sphere", "texture_on=entry", &["object.0.material.texture_on: the material has no texture; expected a `tex"]),
        ("sphere", "texture_wrap=clamp", &["object.0.material.texture_wrap: the material has no texture"]),
        ("sphere", "texture_on=exti", &["unknown value, did you mean `exit`?", "expected entry, exit, both"]),
        ("sphere", "texture_wrap=tile", &["unknown value; found tile; expected repeat, clamp, mirror"]),
        ("sphere", "texture=3", &["object.0.material.texture=3", "invalid type; found integer `3`"]),
    ];
    for (scene, set, words) in cases {
        bad(&here, &format!("render {scene} --device cpu --set object.0.material.{set} -o x.png"), 2, words);
    }
    // A file's own fault has its line, whichever file it is about.
    write("a.obj", SHEET.as_bytes());
    write(
        "f.toml",
        SCENE
            .replace("parts/a", "a")
            .replace("[object.0]", "material = { preset = 'apple', texture = 'mtl' }")
            .as_bytes(),
    );
    bad(
        &here,
        "render f.toml -o x.png",
        2,
        &["f.toml:10: object.0.material.texture: a.obj:1: a.mtl: the material library"],
    );
    write(
        "e.toml",
        SCENE.replace("[object.0]\n", "material.preset = 'apple'\nmaterial.texture = 'gone.png'\n").as_bytes(),
    );
    bad(
        &here,
        "render e.toml -o x.png",
        2,
        &["e.toml:11: object.0.material.texture: gone.png: the texture cannot be read"],
    );
}

#[test]
fn a_plan_has_no_texture_that_is_not_asked_for() {
    let here = folder(&[]);
    let plan = |sets: &str| {
        good(&here, &format!("plan sphere --set object.0.detail=1 --device cpu {sets} --json a.json"));
        let plan: serde_json::Value = serde_json::from_str(&read(&here, "a.json")).unwrap();
        let has = |list: &str, key: &str, name: &str| plan[list].as_array().unwrap().iter().any(|row| row[key] == name);
        let why = |name: &str| {
            let row = plan["left_out"].as_array().unwrap().iter().find(|row| row["stage"] == name).cloned();
            row.map_or(String::new(), |row| row["because"].as_str().unwrap_or_default().to_owned())
        };
        let buffers = ["corner_uvs", "texels"].map(|name| has("buffers", "buffer", name));
        assert_eq!(buffers[0], buffers[1]);
        (has("stages", "stage", "entry"), has("stages", "stage", "exit"), buffers[0], why("entry"), why("exit"))
    };
    let none = || "no material has a texture".to_owned();
    assert_eq!(plan(""), (false, false, false, none(), none()));
    let texture = "--set object.0.material.texture=builtin:checker --set object.0.material.texture_on";
    let (leaves, enters) =
        ("the texture is for light that leaves".to_owned(), "the texture is for light that enters".to_owned());
    assert_eq!(plan(&format!("{texture}=exit")), (false, true, true, leaves, String::new()));
    assert_eq!(plan(&format!("{texture}=entry")), (true, false, true, String::new(), enters));
    assert_eq!(plan(&format!("{texture}=both")), (true, true, true, String::new(), String::new()));

    // Numbers alone look at no texture where light leaves.
    let numbers = |side: &str| {
        let scene = ball(&[&format!("object.0.material.texture_on={side}")]);
        let session = drawn(&scene, Options { goal: Goal::Radiosity, ..Options::default() });
        let sizes = [Slot::texels, Slot::corner_uvs].map(|slot| session.state().data.bytes(slot).len());
        (session.plan.stages.iter().any(|stage| stage.name == "entry"), sizes.iter().all(|&bytes| bytes > 0))
    };
    assert_eq!((numbers("exit"), numbers("entry"), numbers("both")), ((false, false), (true, true), (true, true)));
}
