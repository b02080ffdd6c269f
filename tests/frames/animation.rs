//! Animated glTF: joints, morph targets and nodes.

use crate::shell::{bad, bytes, folder, good, numbers, read};
use tempfile::TempDir;

/// A tetrahedron over a triangle at y = 0 that stands still, with its apex at (0, 2, 0). The apex follows a joint at
/// y = 1, which turns by a quarter about z within a second; a morph target lifts it by 1 more. A second part, a copy of
/// the first one without joints, moves along z.
const JSON: &str = r#"{"asset":{"version":"2.0"},
    "nodes":[{"mesh":0,"skin":0},{"children":[2]},{"translation":[0,1,0]},{"mesh":1,"translation":[5,0,0]}],
    "meshes":[{"primitives":[{"attributes":{"POSITION":0,"JOINTS_0":2,"WEIGHTS_0":3},"indices":1,"material":0,
        "targets":[{"POSITION":4}]}]},
        {"primitives":[{"attributes":{"POSITION":0},"indices":1}]}],
    "materials":[{"pbrMetallicRoughness":{"roughnessFactor":0.5}}],
    "skins":[{"joints":[1,2],"inverseBindMatrices":5}],
    "animations":[{"name":"Lean","samplers":[{"input":6,"output":7},{"input":6,"output":8,"interpolation":"STEP"},
        {"input":6,"output":9}],
        "channels":[{"sampler":0,"target":{"node":2,"path":"rotation"}},
            {"sampler":1,"target":{"node":0,"path":"weights"}},
            {"sampler":2,"target":{"node":3,"path":"translation"}}]}],
    "accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"},
        {"bufferView":0,"byteOffset":48,"componentType":5125,"count":12,"type":"SCALAR"},
        {"bufferView":0,"byteOffset":96,"componentType":5121,"count":4,"type":"VEC4"},
        {"bufferView":0,"byteOffset":112,"componentType":5126,"count":4,"type":"VEC4"},
        {"bufferView":0,"byteOffset":176,"componentType":5126,"count":4,"type":"VEC3"},
        {"bufferView":0,"byteOffset":224,"componentType":5126,"count":2,"type":"MAT4"},
        {"bufferView":0,"byteOffset":352,"componentType":5126,"count":2,"type":"SCALAR"},
        {"bufferView":0,"byteOffset":360,"componentType":5126,"count":2,"type":"VEC4"},
        {"bufferView":0,"byteOffset":392,"componentType":5126,"count":2,"type":"SCALAR"},
        {"bufferView":0,"byteOffset":400,"componentType":5126,"count":2,"type":"VEC3"}],
    "bufferViews":[{"buffer":0,"byteLength":424}],"buffers":[{"byteLength":424,"uri":"a.bin"}]}"#;

fn buffer() -> Vec<u8> {
    let floats = |values: &[f32]| values.iter().flat_map(|x| x.to_le_bytes()).collect::<Vec<u8>>();
    let unit = |lift: f32| floats(&[1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, lift, 0.0, 1.0]);
    let half = std::f32::consts::FRAC_1_SQRT_2;
    let faces: [u32; 12] = [0, 1, 2, 0, 3, 1, 1, 3, 2, 2, 3, 0];
    [
        floats(&[1.0, 0.0, 0.0, -1.0, 0.0, 1.0, -1.0, 0.0, -1.0, 0.0, 2.0, 0.0]),
        faces.iter().flat_map(|x| x.to_le_bytes()).collect(),
        vec![0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0],
        floats(&[1.0, 0.0, 0.0, 0.0].repeat(4)),
        floats(&[0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0, 0.0]),
        unit(0.0),
        unit(-1.0),
        floats(&[0.0, 1.0]),
        floats(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, half, half]),
        floats(&[0.0, 0.5]),
        floats(&[5.0, 0.0, 0.0, 5.0, 0.0, 3.0]),
    ]
    .concat()
}

const SCENE: &str = "animation = 'lean'\nfps = 4\n[camera]\nposition = [4, 3, 19]\ntarget = [2, 1, 0]\n\
    size = [30, 24]\n\n\
    [[light]]\ntype = 'directional'\ndirection = [1, 2, 3]\nirradiance = 2\n\n\
    [[object]]\nmesh = 'a.gltf'\npart = 0\nmaterial = { preset = 'marble' }\n\n\
    [[object]]\nmesh = 'a.gltf'\npart = 1\nmaterial = { preset = 'marble' }\n";

fn here() -> TempDir {
    let here = folder(&[("a.gltf", JSON), ("m.toml", SCENE)]);
    std::fs::write(here.path().join("a.bin"), buffer()).unwrap();
    here
}

/// Sums of the three corners of each triangle of both objects.
fn sums(here: &TempDir, arguments: &str) -> Vec<[f64; 3]> {
    good(here, &format!("solve m.toml --device cpu -o a.csv {arguments}"));
    let (header, rows) = numbers(&read(here, "a.csv"));
    let first = header.split(',').position(|name| name == "cx").unwrap();
    rows.into_iter().map(|row| [0, 1, 2].map(|k| 3.0 * row[first + k])).collect()
}

fn near(a: &[[f64; 3]], b: &[[f64; 3]]) -> bool {
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| (0..3).all(|k| (a[k] - b[k]).abs() < 1e-5))
}

/// The sums with the apex of the first part at `apex`, and the second part moved by `z` along z.
fn expected(apex: [f64; 2], z: f64) -> Vec<[f64; 3]> {
    let part = |apex: [f64; 2], shift: [f64; 2]| {
        let places = [[1.0, 0.0, 0.0], [-1.0, 0.0, 1.0], [-1.0, 0.0, -1.0], [apex[0], apex[1], 0.0]];
        let places = places.map(|[x, y, z]: [f64; 3]| [x + shift[0], y, z + shift[1]]);
        [[0, 1, 2], [0, 3, 1], [1, 3, 2], [2, 3, 0]]
            .map(|corners| [0, 1, 2].map(|k| corners.map(|c| places[c][k]).iter().sum()))
    };
    [part(apex, [0.0; 2]), part([0.0, 2.0], [5.0, z])].concat()
}

#[test]
fn joints_targets_and_nodes_move_as_published() {
    let here = here();
    assert!(near(&sums(&here, "--frame 0"), &expected([0.0, 2.0], 0.0)));
    // An eighth of a turn at half a second: from (0, 1) above the joint; weights step at the end.
    let lean = std::f64::consts::FRAC_1_SQRT_2;
    assert!(near(&sums(&here, "--frame 2"), &expected([-lean, 1.0 + lean], 1.5)));
    // It repeats after a second, and rests without an animation.
    assert!(near(&sums(&here, "--frame 6"), &sums(&here, "--frame 2")));
    let still = SCENE.replace("animation = 'lean'\nfps = 4\n", "");
    std::fs::write(here.path().join("m.toml"), &still).unwrap();
    assert!(near(&sums(&here, "--frame 2"), &expected([0.0, 2.0], 0.0)));
    assert!(near(&sums(&here, "--frame 2 --animation LEAN --fps 4"), &expected([-lean, 1.0 + lean], 1.5)));
    // Weights move the apex before the joint does.
    let lifted = JSON.replace("\"interpolation\":\"STEP\"", "\"interpolation\":\"LINEAR\"");
    std::fs::write(here.path().join("a.gltf"), lifted).unwrap();
    let (x, y) = (-1.25 * lean, 1.0 + 1.25 * lean);
    assert!(near(&sums(&here, "--frame 2 --animation lean --fps 4"), &expected([x, y], 1.5)));
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn frames_of_an_animation_do_not_depend_on_each_other() {
    let here = here();
    for device in ["--device cpu", ""] {
        good(&here, &format!("render m.toml --frames 1..3 -o f%d.png {device}"));
        for frame in 1..4 {
            good(&here, &format!("render m.toml --frame {frame} -o one.png {device}"));
            assert!(bytes(&here, &format!("f{frame}.png")) == bytes(&here, "one.png"), "{frame} {device:?}");
        }
        assert!(bytes(&here, "f1.png") != bytes(&here, "f2.png"));
    }
    assert!(!good(&here, "plan m.toml --frame 1").0.contains("no object has joints that move"));
}

#[test]
fn subdivided_meshes_go_with_the_vertices_of_the_file() {
    let here = here();
    let fine = "--set transport.hierarchy=butterfly --set transport.levels=2";
    let [rest, now] = [0, 2].map(|frame| sums(&here, &format!("{fine} --frame {frame}")));
    // The second object moves as a whole.
    let moved: Vec<[f64; 3]> = rest[64..].iter().map(|p| [p[0], p[1], p[2] + 4.5]).collect();
    assert!(rest.len() == 128 && near(&now[64..], &moved) && !near(&now[..64], &rest[..64]));
}

#[test]
fn a_file_alone_lists_its_animations_and_plays_them() {
    let here = here();
    let (text, _) = good(&here, "scenes a.gltf");
    assert!(text.starts_with("# --animation \"Lean\": 1.000 s\n") && text.contains("part = 1"), "{text}");
    std::fs::write(here.path().join("copy.toml"), text).unwrap();
    for (scene, name) in [("a.gltf", "a.png"), ("copy.toml", "b.png")] {
        good(&here, &format!("render {scene} --animation Lean --frame 12 -o {name} --size 24x24 --device cpu"));
    }
    assert!(bytes(&here, "a.png") == bytes(&here, "b.png"));
    good(&here, "render a.gltf -o rest.png --size 24x24 --device cpu");
    assert!(bytes(&here, "a.png") != bytes(&here, "rest.png"));
    let run = "render a.gltf -o a.png --device cpu";
    bad(&here, &format!("{run} --animation Leam"), 2, &["did you mean `Lean`?; found Leam; expected Lean"]);
    bad(&here, &format!("{run} --set fps=0"), 2, &["fps: out of range; found 0"]);
    bad(&here, &format!("{run} --animation Lean --fps 0"), 2, &["fps: out of range; found 0; expected 0.001"]);
}
