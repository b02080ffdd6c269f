//! Lights in scene files and settings: which are refused and with what message, and which stages a plan leaves out.

use crate::shell::{bad, close, folder, good, numbers, read};

const BALL: &str = "[[object]]\nshape = 'sphere'\ndetail = 1\nsize = 10\nmaterial = { preset = 'marble' }\n";
const SMALL: &str = "sphere --set object.0.detail=1 --device cpu";

/// A small ball under this light.
fn ball(light: &str) -> String {
    format!("[[light]]\n{light}\n{BALL}")
}

#[test]
fn bad_lights_are_named() {
    let spot = "type = 'spot'\nposition = [0, 0, 9]\nintensity = 1\n";
    let area = "type = 'area'\nposition = [0, 0, 9]\nradiance = 1\nedge_u = [2, 0, 0]\n";
    let cases: &[(String, &[&str])] = &[
        (
            format!("{spot}direction = [0, 0, 0]\nouter = 20"),
            &["a.toml:5: light.0.direction", "length zero", "[0, 0, 0]"],
        ),
        (
            format!("{spot}direction = [0, 0, -1]\nouter = 20\ninner = 25"),
            &["a.toml:7: light.0.inner: out of range; found 25; expected 0 to 19 degrees"],
        ),
        (format!("{spot}direction = [0, 0, -1]\nouter = 180"), &["a.toml:6: light.0.outer", "found 180", "1 to 90"]),
        (format!("{area}edge_v = [4, 0, 0]"), &["a.toml:6: light.0.edge_v: the rectangle has no area"]),
        (format!("{area}edge_v = [0, 4, 0]\nsamples = 65"), &["light.0.samples", "found 65", "from 1 to 64"]),
        (format!("{area}edge_v = [0, 4, 0]\nimage = 'a.exr'"), &["light.0.image: an area light has no such key"]),
        ("type = 'environment'".into(), &["light.0.image: neither an image nor a radiance"]),
        (
            "type = 'environment'\nimage = 'gone.exr'".into(),
            &["a.toml:3: light.0.image", "gone.exr: the image cannot be"],
        ),
        ("type = 'environment'\nimage = 'a.toml'".into(), &["not the name of an environment", ".exr or .hdr"]),
        ("type = 'environment'\nimage = 'nan.exr'".into(), &["nan.exr: pixel (3, 1)", "found [1, NaN, 1]"]),
        ("type = 'environment'\nradiance = 1\noclusion = 3".into(), &["did you mean `occlusion`?"]),
        (
            "type = 'point'\nposition = [1, 0, 0]\nintensity = 1".into(),
            &[
                "a.toml:3: light.0.position: the light stands in the medium; found a light at [1, 0, 0]",
                "two_sided = true",
            ],
        ),
        (format!("{area}edge_v = [0, 4, 0]").replace("0, 0, 9", "0, 0, 4"), &["stands in the medium"]),
    ];
    let here = folder(&[]);
    let pixel = |x: usize, y: usize| (1f32, if (x, y) == (3, 1) { f32::NAN } else { 1.0 }, 1f32);
    exr::prelude::write_rgb_file(here.path().join("nan.exr"), 4, 2, pixel).unwrap();
    for (light, words) in cases {
        std::fs::write(here.path().join("a.toml"), ball(light)).unwrap();
        bad(&here, "solve a.toml -o a.csv --device cpu", 2, words);
    }
    let lights: String = (0..5)
        .map(|_| "[[light]]\ntype = 'area'\nposition = [0, 0, 9]\nradiance = 1\nedge_u = [1, 0, 0]\nedge_v = [0, 1, 0]\nsamples = 64\n")
        .collect();
    std::fs::write(here.path().join("a.toml"), format!("{lights}{BALL}")).unwrap();
    bad(&here, "solve a.toml -o a.csv --device cpu", 2, &["light: too many samples", "found 20480", "at most 16384"]);
    let sky = "type = 'environment'\nradiance = 1\n[[light]]\ntype = 'environment'\nradiance = 1";
    std::fs::write(here.path().join("a.toml"), ball(sky)).unwrap();
    bad(&here, "solve a.toml -o a.csv --device cpu", 2, &["a.toml:5: light.1.type: a second environment"]);
}

#[test]
fn a_setting_at_fault_is_named() {
    let here = folder(&[]);
    let inside = "--set light.0.type=point --set light.0.direction=[1,0,0]";
    bad(&here, &format!("solve {SMALL} {inside} -o a.csv"), 2, &["light.0.direction"]);
    let lamp = "--set light.1={type='point',position=[0,1,0],intensity=1}";
    bad(&here, &format!("solve {SMALL} {lamp} -o a.csv"), 2, &["the light stands in the medium", "[0, 1, 0]"]);
    good(&here, &format!("solve {SMALL} {lamp} --set object.0.material.two_sided=true -o a.csv"));
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_plan_leaves_out_what_no_light_needs() {
    let here = folder(&[]);
    let plan = |sets: &str| {
        good(&here, &format!("plan {SMALL} {sets} --json a.json"));
        let plan: serde_json::Value = serde_json::from_str(&read(&here, "a.json")).unwrap();
        let names = |list: &str, key: &str| {
            let rows = plan[list].as_array().unwrap().iter();
            rows.map(|row| row[key].as_str().unwrap().to_string()).collect::<Vec<_>>()
        };
        (names("stages", "stage"), names("buffers", "buffer"), names("left_out", "because"))
    };
    let has = |list: &[String], name: &str| list.iter().any(|other| other == name);
    let (stages, buffers, why) = plan("");
    assert!(has(&stages, "shadow") && has(&buffers, "lit") && !has(&stages, "environment"), "{stages:?}");
    assert!(!has(&buffers, "harmonics") && has(&why, "no light is an environment"), "{buffers:?} {why:?}");
    let (stages, buffers, why) = plan("--set light.0.shadows=false");
    assert!(!has(&stages, "shadow") && !has(&buffers, "lit") && !has(&buffers, "cut_short"), "{buffers:?}");
    assert!(why.iter().any(|why| why.starts_with("no light casts shadows")), "{why:?}");
    let (stages, buffers, _) = plan("--set light.0={type='environment',radiance=1}");
    assert!(!has(&stages, "shadow") && has(&stages, "environment") && has(&buffers, "harmonics"), "{stages:?}");
    let (stages, buffers, _) = plan("--set light.0={type='environment',radiance=1,occlusion=9}");
    assert!(has(&stages, "shadow") && has(&buffers, "lit"), "{stages:?}");
    for dark in ["light.0.irradiance=0", "light.0={type='environment',radiance=0,occlusion=9}"] {
        let (stages, buffers, why) = plan(&format!("--set {dark}"));
        assert!(!has(&stages, "shadow") && !has(&stages, "environment") && !has(&buffers, "lit"), "{stages:?}");
        assert!(why.iter().any(|why| why.starts_with("no light shines")), "{why:?}");
    }
}

#[test]
fn devices_agree_on_every_kind_of_light() {
    let lights = "[[light]]\ntype = 'spot'\nposition = [9, 2, 3]\ndirection = [-9, -2, -3]\nouter = 40\nintensity = 9\n\
                  [[light]]\ntype = 'area'\nposition = [0, 9, 0]\nedge_u = [2, 0, 0]\nedge_v = [0, 0, -2]\nradiance = 1\ntwo_sided = true\n\
                  [[light]]\ntype = 'environment'\nimage = 'builtin:sky'\nocclusion = 16\n";
    let here = folder(&[("a.toml", &format!("{lights}{BALL}"))]);
    good(&here, "solve a.toml -o a.csv --device cpu");
    good(&here, "solve a.toml -o b.csv");
    let (a, b) = (numbers(&read(&here, "a.csv")).1, numbers(&read(&here, "b.csv")).1);
    assert!(a.iter().zip(&b).all(|(a, b)| (5..8).all(|k| a[k] > 0.0 && close(a[k], b[k], 1e-4))));
}
