//! Textures from image files and material libraries: their placement on a mesh, what is refused, and what a plan says.

use crate::shell::{bad, folder, good, read};
use milkglass::internals::pipeline::plan::{Change, Options};
use milkglass::internals::session::run::Session;
use milkglass::scene::Scene;

/// Two triangles across three periods of the texture, u from -1 to 2.
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
    let load = |sets: &[String]| {
        let mut session = Session::new(&Scene::load_with(&path, sets).unwrap(), None, Options::default()).unwrap();
        session.frame(Change::EVERYTHING).unwrap();
        session
    };
    let bare = load(&[]).picture().unwrap().pixels;
    // The two texels have red 1 and 0: interpolation gives a tent around the centre of the first.
    let wave = |wrap: &str, u: f64| {
        let at = 2.0 * u - 0.5;
        let step = match wrap {
            "repeat" => (at - 2.0 * (at / 2.0).round()).abs(),
            "clamp" => at,
            // A period of four texels: red at -1 and 0, the others at 1 and 2.
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

/// Scenes, settings that they refuse, and words of the messages.
const BAD: &[(&str, &str, &[&str])] = &[
    ("a.toml", "texture=gone.png", &["object.0.material.texture: ", "gone.png: the texture cannot be read; found "]),
    ("a.toml", "texture=broken.png", &["object.0.material.texture: ", "broken.png: the texture cannot be read"]),
    (
        "a.toml",
        "texture=a.gif",
        &["not the name of a texture; found ", "a.gif", ".png, .jpg, .exr or .hdr, mtl, mesh, or builtin:"],
    ),
    ("a.toml", "texture=high.exr", &["texel (1, 0), from the top left, is no albedo; found [0.5, inf, 0.5]", "0 to 1"]),
    ("a.toml", "texture=nan.exr", &["is no albedo; found [0.5, NaN, 0.5]"]),
    ("a.toml", "texture=long.png", &["too few or too many texels; found 16385 x 1", "8388608 texels, at most 16384 a"]),
    ("a.toml", "texture=mtl", &["a.mtl: one material with a texture", "found 2: a, b"]),
    ("d.obj", "texture=mtl", &["object.0.material.texture: d.obj: the mesh names no material library"]),
    ("c.obj", "texture=builtin:checker", &["c.obj:11: object.0.material.texture: the mesh has no texture coordinates"]),
    ("sphere", "texture=mtl", &["object.0.material.texture: a shape has neither a material library"]),
    ("sphere", "texture=builtin:chekcer", &["built in, did you mean `builtin:checker`?", "builtin:tiles"]),
    ("sphere", "texture_on=entry", &["object.0.material.texture_on: the material has no texture; expected a `tex"]),
    ("sphere", "texture_wrap=clamp", &["object.0.material.texture_wrap: the material has no texture"]),
    ("sphere", "texture_on=exti", &["unknown value, did you mean `exit`?", "expected entry, exit, both"]),
    ("sphere", "texture_wrap=tile", &["unknown value; found tile; expected repeat, clamp, mirror"]),
    ("sphere", "texture=3", &["object.0.material.texture=3", "invalid type; found integer `3`"]),
];

#[test]
fn bad_textures_are_named() {
    let here = sheet("newmtl a\nmap_Kd two.png\nnewmtl b\nmap_Kd b.png\n");
    let write = |name: &str, text: &[u8]| std::fs::write(here.path().join(name), text).unwrap();
    write("broken.png", b"\x89PNG but no more");
    write("c.obj", SHEET.replace("1/1", "1").as_bytes());
    write("d.obj", SHEET.replace("mtllib a.mtl\n", "").as_bytes());
    for (name, value) in [("high.exr", f32::INFINITY), ("nan.exr", f32::NAN)] {
        let pixel = move |x: usize, _| (0.5f32, if x == 1 { value } else { 0.5 }, 0.5f32);
        exr::prelude::write_rgb_file(here.path().join(name), 2, 1, pixel).unwrap();
    }
    image::GrayImage::new(16_385, 1).save(here.path().join("long.png")).unwrap();
    for (scene, set, words) in BAD {
        bad(&here, &format!("render {scene} --device cpu --set object.0.material.{set} -o x.png"), 2, words);
    }
    // A fault in a scene file is reported with its line, also where it concerns another file.
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
        (
            has("stages", "stage", "texture_in"),
            has("stages", "stage", "texture_out"),
            buffers[0],
            why("texture_in"),
            why("texture_out"),
        )
    };
    let none = || "no material has a texture".to_owned();
    assert_eq!(plan(""), (false, false, false, none(), none()));
    let texture = "--set object.0.material.texture=builtin:checker --set object.0.material.texture_on";
    let (leaves, enters) =
        ("the texture is for light that leaves".to_owned(), "the texture is for light that enters".to_owned());
    assert_eq!(plan(&format!("{texture}=exit")), (false, true, true, leaves, String::new()));
    assert_eq!(plan(&format!("{texture}=entry")), (true, false, true, String::new(), enters));
    assert_eq!(plan(&format!("{texture}=both")), (true, true, true, String::new(), String::new()));
}
