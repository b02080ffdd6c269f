//! The command line run as a program: what each command writes, its error messages, and its exit codes.

use std::path::Path;
use std::process::Command;

use crate::shell::{bad, bytes, close, folder, good, names, numbers, program, read, said};

const TRIANGLE: &str = "v 0 0 0\nv 4 0 0\nv 0 2 0\nf 1 2 3\n";
const BALL: &str = "[[object]]\nshape = 'sphere'\ndetail = 1\nsize = 10\nmaterial = { preset = 'marble' }\n";
const SUN: &str = "[[light]]\ntype = 'directional'\ndirection = [0, 0, 1]\nirradiance = 3\n";
/// Makes a built-in scene small and fast.
const SMALL: &str = "sphere --set object.0.detail=1 --device cpu";

/// Width, height and the red, green and blue of all pixels of an OpenEXR file.
fn exr(path: &Path) -> (usize, usize, Vec<[f32; 3]>) {
    use exr::prelude::*;
    let image = read_first_rgba_layer_from_file(
        path,
        |size, _| (size, vec![[0f32; 3]; size.area()]),
        |(size, pixels), at, (r, g, b, _): (f32, f32, f32, f32)| pixels[at.y() * size.width() + at.x()] = [r, g, b],
    );
    let (size, pixels) = image.unwrap().layer_data.channel_data.pixels;
    (size.width(), size.height(), pixels)
}

#[test]
fn a_printed_scene_is_a_scene_file() {
    let here = folder(&[]);
    for (name, detail) in [("sphere", 1), ("slab", 2), ("lotus", 16)] {
        std::fs::write(here.path().join("copy.toml"), good(&here, &format!("scenes {name}")).0).unwrap();
        let rest = format!("--set object.0.detail={detail} --size 16x12 --device cpu");
        good(&here, &format!("render copy.toml -o copy.png {rest}"));
        good(&here, &format!("render {name} -o own.png {rest}"));
        assert_eq!(bytes(&here, "copy.png"), bytes(&here, "own.png"), "{name}");
    }
}

#[test]
fn render_writes_a_png_and_nothing_else() {
    let here = folder(&[]);
    let (out, err) = good(&here, &format!("render {SMALL} -o a.png --size 16x12"));
    assert!(
        out.is_empty() && err.starts_with("a.png: 16 x 12, on the CPU, ") && err.lines().count() == 1,
        "{out}{err}"
    );
    assert_eq!(names(here.path()), ["a.png"]);
    let png = bytes(&here, "a.png");
    assert_eq!((&png[1..4], &png[16..24]), (&b"PNG"[..], &[0, 0, 0, 16, 0, 0, 0, 12][..]));
    let (out, _) = good(&here, &format!("render {SMALL} -o b.png --size 1x1 --times"));
    assert!(out.starts_with("stage") && out.contains("total"), "{out}");
    // Wall time beside the stages, phase by phase, adds up to all of it.
    let ms = |row: &str| -> f64 {
        let line = out.lines().find(|line| line.starts_with(row)).unwrap_or_else(|| panic!("{row}: {out}"));
        line.split_whitespace().last().unwrap().parse().unwrap()
    };
    let phases = ["building shapes", "building trees", "preparing the scene", "opening the session"];
    let frames = ["frames, without their stages", "writing the picture", "opening the device", "loading the scene"];
    let all = ms("all, with the stages");
    let sum: f64 = phases.iter().chain(&frames).map(|row| ms(row)).sum::<f64>() + ms("the rest") + ms("total");
    // Stages that run side by side may take more than their frame.
    assert!(sum > 0.99 * all && phases.iter().chain(&frames).all(|row| ms(row) <= all), "{sum} of {all}: {out}");
    // Every sample counts, and there is no frame beside them.
    let (out, _) = good(&here, &format!("render {SMALL} -o c.png --size 2x1 --times --set camera.samples=3"));
    let steps = |stage: &str| -> usize {
        let line = out.lines().find(|line| line.starts_with(stage)).unwrap();
        line.split_whitespace().nth(1).unwrap().parse().unwrap()
    };
    assert_eq!((steps("visibility"), steps("refit"), steps("shade")), (3, 1, 3), "{out}");
    assert_eq!(&bytes(&here, "b.png")[16..24], &[0, 0, 0, 1, 0, 0, 0, 1]);
}

#[test]
fn exr_holds_linear_light() {
    let here = folder(&[]);
    let set = "--set camera.background=[0.25,0.5,4]";
    good(&here, &format!("render {SMALL} {set} -o a.exr --size 16x12"));
    let (width, height, pixels) = exr(&here.path().join("a.exr"));
    assert_eq!((width, height), (16, 12));
    assert_eq!(pixels[0], [0.25, 0.5, 4.0], "the background is stored as it is");
    assert!(pixels.iter().flatten().all(|x| x.is_finite() && *x >= 0.0));
    // Twice the irradiance gives twice the radiance on the ball.
    good(&here, &format!("render {SMALL} {set} --set light.0.irradiance=[6.4,6,5.4] -o b.exr --size 16x12"));
    let (_, _, twice) = exr(&here.path().join("b.exr"));
    let middle = 6 * 16 + 8;
    assert!(pixels[middle][0] > 0.0 && close(twice[middle][0].into(), 2.0 * f64::from(pixels[middle][0]), 1e-5));
}

#[test]
fn solve_writes_one_row_a_face() {
    let quads = "v 0 0 0\nv 4 0 0\nv 4 2 0\nv 0 2 0\nv 8 0 0\nv 8 2 0\nf 1 2 3 4\nf 2 5 6 3\n";
    let scene = format!("unit = 'cm'\n{SUN}[[object]]\nmesh = 'm.obj'\nmaterial = {{ preset = 'marble' }}\n");
    let here = folder(&[("m.obj", quads), ("a.toml", &scene)]);
    good(&here, "solve a.toml -o a.csv --device cpu");
    let (header, rows) = numbers(&read(&here, "a.csv"));
    assert_eq!(header, "face,cx,cy,cz,area,E_r,E_g,E_b,B_r,B_g,B_b,input_face,err_r,err_g,err_b");
    assert_eq!(rows.len(), 4);
    let centers = [[8.0 / 3.0, 2.0 / 3.0], [4.0 / 3.0, 4.0 / 3.0], [20.0 / 3.0, 2.0 / 3.0], [16.0 / 3.0, 4.0 / 3.0]];
    for (face, row) in rows.iter().enumerate() {
        assert_eq!((row[0], row[11]), (face as f64, (face / 2) as f64), "a fan for each input face, in order");
        assert!((row[1] - centers[face][0]).abs() < 1e-6 && (row[2] - centers[face][1]).abs() < 1e-6, "{row:?}");
        assert!(row[3] == 0.0 && close(row[4], 4.0, 1e-6), "{row:?}");
        assert!(row[5] > 2.5 && row[5] < 3.0, "irradiance after Fresnel, head on: {row:?}");
        assert!(
            row[12..].iter().all(|err| *err > 0.0 && *err < 0.1 * row[8]),
            "an estimate in the scene's units: {row:?}"
        );
        assert!(row[8] > 0.0 && row[8] < row[5], "{row:?}");
    }
}

#[test]
fn solve_writes_ply_and_verifies() {
    let here = folder(&[]);
    let (out, _) = good(&here, &format!("solve {SMALL} -o a.ply --verify 20"));
    assert!(
        out.starts_with("channel") && out.contains("worst") && out.contains("the estimate is above the error at"),
        "{out}"
    );
    let ply = read(&here, "a.ply");
    let (header, body) = ply.split_once("end_header\n").unwrap();
    assert!(header.starts_with("ply\nformat ascii 1.0\n"), "{header}");
    assert!(header.contains("element vertex 42\n") && header.contains("element face 80\n"), "{header}");
    let lines: Vec<Vec<f64>> = body.lines().map(|line| line.split(' ').map(|x| x.parse().unwrap()).collect()).collect();
    assert_eq!(lines.len(), 42 + 80);
    assert!(lines[..42].iter().all(|vertex| vertex.len() == 9));
    assert!(lines[42..].iter().all(|face| face.len() == 13 && face[0] == 3.0 && face[1..4].iter().all(|&v| v < 42.0)));
    bad(&here, &format!("solve {SMALL} --verify 0"), 2, &["--verify"]);
    bad(&here, &format!("solve {SMALL}"), 2, &["nothing to do", "-o FILE"]);
}

#[test]
fn plan_prints_and_writes_json() {
    let here = folder(&[]);
    let (out, _) = good(&here, &format!("plan {SMALL} --json a.json"));
    for part in ["stages\n", "buffers\n", "left out\n", "80 triangles"] {
        assert!(out.contains(part), "{out}");
    }
    let plan: serde_json::Value = serde_json::from_str(&read(&here, "a.json")).unwrap();
    assert_eq!((plan["triangles"].as_u64(), plan["nodes"].as_u64()), (Some(80), Some(159)));
    assert!(plan["error_estimate"].is_null() && out.contains("not requested"), "{out}");
    let (layers, _) = good(&here, &format!("plan {SMALL} --aov --json b.json"));
    assert!(layers.contains("light is carried once more, at tolerance 0.000125"), "{layers}");
    let second: serde_json::Value = serde_json::from_str(&read(&here, "b.json")).unwrap();
    assert_eq!(second["error_estimate"]["tolerance"].as_f64(), Some(1.25e-4));
    assert!(plan["stages"].as_array().is_some_and(|stages| !stages.is_empty()));
    assert_eq!(names(here.path()), ["a.json", "b.json"]);
}

#[test]
fn preset_names_ignore_case() {
    let here = folder(&[]);
    good(&here, &format!("solve {SMALL} --set object.0.material.preset=KETCHUP -o a.csv"));
    good(&here, &format!("solve {SMALL} --set object.0.material.preset=ketchup -o b.csv"));
    assert_eq!(read(&here, "a.csv"), read(&here, "b.csv"));
}

#[test]
fn odd_scenes_still_give_a_picture() {
    let inside = format!("[camera]\nposition = [0, 0, 0]\ntarget = [0, 0, -1]\n{SUN}{BALL}");
    let here = folder(&[("dark.toml", BALL), ("inside.toml", &inside), ("leaf.obj", TRIANGLE)]);
    let (_, err) = good(&here, "render dark.toml -o dark.exr --size 8x8 --device cpu");
    assert!(err.starts_with("dark: "), "{err}");
    assert!(exr(&here.path().join("dark.exr")).2.iter().flatten().all(|&x| x == 0.0));
    good(&here, "render inside.toml -o inside.exr --size 8x8 --device cpu");
    assert!(exr(&here.path().join("inside.exr")).2.iter().flatten().all(|x| x.is_finite()));
    let (_, err) = good(&here, "render leaf.obj -o leaf.exr --size 8x8 --device cpu");
    assert!(err.starts_with("leaf: y is up") && err.contains("\nopen: 3 edges"), "{err}");
    assert!(exr(&here.path().join("leaf.exr")).2.iter().flatten().any(|&x| x > 0.0));
    good(&here, "solve leaf.obj -o leaf.csv --device cpu");
    assert_eq!(numbers(&read(&here, "leaf.csv")).1.len(), 1);
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn media_may_be_as_dense_or_thin_as_they_like() {
    // Dense: what enters a face leaves the same face, less absorption. Thin: almost nothing comes back.
    let here = folder(&[]);
    for (scale, ratio, off) in
        [("1e4", 0.8303, 1e-3), ("1e30", 0.8303, 1e-3), ("1e-9", 0.0, 1e-9), ("1e-300", 0.0, 1e-9)]
    {
        for device in ["--device cpu", ""] {
            let set = format!("--set object.0.detail=1 --set object.0.material.scale={scale}");
            good(&here, &format!("solve sphere {set} {device} -o a.csv"));
            let row = &numbers(&read(&here, "a.csv")).1[0];
            assert!(row[8] >= 0.0 && (row[8] / row[5] - ratio).abs() < off, "{scale} {device}: {row:?}");
        }
    }
}

#[test]
fn conform_compares_a_device_with_the_cpu() {
    let here = folder(&[("a.toml", &format!("[camera]\nsize = [8, 8]\n{SUN}{BALL}"))]);
    let (out, _) = good(&here, "conform a.toml --no-validation --json a.json");
    assert!(out.contains("all conform"), "{out}");
    let rows: serde_json::Value = serde_json::from_str(&read(&here, "a.json")).unwrap();
    assert!(rows["results"].as_array().is_some_and(|rows| rows.iter().any(|row| row["stage"] == "link")), "{rows}");
    bad(&here, "conform a.toml --device cpu --no-validation", 2, &["the CPU is the reference itself"]);
}

#[test]
fn bad_arguments_are_named() {
    let here = folder(&[("a.toml", &format!("[camera]\nfow = 3\n{BALL}"))]);
    let png = "-o a.png --size 4x4 --device cpu";
    let cases: &[(String, &[&str])] = &[
        (format!("render a.toml {png}"), &["a.toml:2: camera.fow", "did you mean `fov`?"]),
        (format!("render spere {png}"), &["did you mean `sphere`?", "lotus, noise, slab, slab-layers, sphere"]),
        (format!("render gone.toml {png}"), &["neither a built-in scene nor a file", "gone.toml"]),
        (format!("render gone.obj {png}"), &["gone.obj"]),
        (format!("render . {png}"), &["the scene file cannot be read"]),
        (format!("render sphere --set camera.fov {png}"), &["--set camera.fov: not a setting", "key=value"]),
        (format!("render sphere --set camera.fow=3 {png}"), &["--set camera.fow=3", "did you mean `fov`?"]),
        (format!("render sphere --set camera.fov=wide {png}"), &["--set camera.fov=wide", "expected a number"]),
        ("render sphere -o a.png --size 4".into(), &["--size: not a picture size", "WxH"]),
        ("render sphere -o a.png --size 0x4".into(), &["--size: not a picture size"]),
        ("render sphere -o a.jpg".into(), &["-o: ", ".jpg", ".png or .exr"]),
        ("solve sphere -o a.png".into(), &["-o: ", ".csv or .ply"]),
        ("scenes spere".into(), &["neither a built-in scene nor a file", "lotus, noise, slab, slab-layers, sphere"]),
        ("rendr sphere".into(), &["'rendr'", "'render'"]),
        (format!("render {SMALL} -o gone/a.png --size 4x4"), &["gone/a.png: could not be written"]),
    ];
    for (line, words) in cases {
        bad(&here, line, 2, words);
    }
}

#[test]
fn bad_meshes_are_named_with_their_line() {
    let here = folder(&[]);
    for (text, place) in [
        ("v 0 0 nan\nv 1 0 0\nv 0 1 0\nf 1 2 3\n", "m.obj:1: "),
        ("v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 9\n", "m.obj:4: "),
        ("", "m.obj: the mesh has no faces"),
    ] {
        std::fs::write(here.path().join("m.obj"), text).unwrap();
        bad(&here, "render m.obj -o a.png --device cpu", 2, &[place]);
        bad(&here, "solve m.obj -o a.csv --device cpu", 2, &[place]);
    }
}

#[test]
fn a_failed_run_leaves_the_last_result() {
    let here = folder(&[("a.csv", "kept"), ("a.png", "kept"), ("in.csv", "r\n1\n")]);
    bad(&here, "solve sphere --set object.0.detail=99 -o a.csv", 2, &["object.0.detail"]);
    bad(&here, "render sphere --device nosuch -o a.png", 3, &["\"nosuch\"", "there are cpu"]);
    bad(&here, "eval profile in.csv -o a.csv --device cpu", 2, &["in.csv:"]);
    std::fs::create_dir(here.path().join("folder.png")).unwrap();
    bad(&here, &format!("render {SMALL} --size 4x4 -o folder.png"), 2, &["folder.png: could not be written"]);
    assert_eq!((read(&here, "a.csv"), read(&here, "a.png")), ("kept".into(), "kept".into()));
}

#[test]
fn without_a_driver_there_is_the_cpu() {
    let here = folder(&[]);
    let line = "render sphere --set object.0.detail=1 --size 4x4 -o a.exr";
    let run = |rest: &str| {
        let mut command = program(&here, &format!("{line} {rest}"));
        let gone = here.path().join("gone.json");
        said_with_code(command.env("VK_DRIVER_FILES", &gone).env("VK_ICD_FILENAMES", &gone))
    };
    let (code, err) = run("--device 0");
    assert_eq!(code, Some(3), "{err}");
    assert!(err.starts_with("milkglass: ") && names(here.path()).is_empty(), "{err}");
    let (code, err) = run("");
    assert_eq!(code, Some(0), "{err}");
    assert!(err.starts_with("running on the CPU") && err.lines().count() == 2, "{err}");
    let fallback = bytes(&here, "a.exr");
    good(&here, &format!("{line} --device cpu"));
    assert_eq!(bytes(&here, "a.exr"), fallback);
    bad(&here, &format!("{line} --device="), 3, &["looking for device"]);
}

fn said_with_code(command: &mut Command) -> (Option<i32>, String) {
    let output = command.output().unwrap();
    (output.status.code(), said(&output).1)
}

#[test]
fn no_estimate_no_columns() {
    let here = folder(&[]);
    for how in ["--set transport.scheme=links", "--transport brute"] {
        let (out, _) = good(&here, &format!("solve {SMALL} {how} -o a.csv --verify 9"));
        assert!(!out.contains("estimate"), "{out}");
        assert_eq!(numbers(&read(&here, "a.csv")).0, "face,cx,cy,cz,area,E_r,E_g,E_b,B_r,B_g,B_b,input_face");
    }
}
