//! `--transport octree` run as a program: accurate to its threshold on the CPU and on a device, and listed in the plan.

use crate::shell::{bad, folder, good, numbers, read};

const DEVICES: [&str; 2] = ["--device cpu", ""];

#[test]
fn its_radiosity_is_near_brute_force() {
    let here = folder(&[]);
    for device in DEVICES {
        for scene in ["sphere --set object.0.detail=4", "slab"] {
            let (out, _) = good(&here, &format!("solve {scene} --transport octree --verify 100 --times {device}"));
            let worst = out.lines().find(|line| line.starts_with("worst")).unwrap_or_default();
            let l2: f64 = worst.split_whitespace().nth(1).unwrap().parse().unwrap();
            assert!(l2 < 0.05 && l2 > 1e-6, "{scene} {device}: {out}");
            let stages: Vec<_> = out.lines().filter_map(|line| line.split_whitespace().next()).take(7).collect();
            assert_eq!(stages, ["stage", "refit", "widen", "shadow", "irradiance", "octree", "total"], "{out}");
        }
    }
}

#[test]
fn a_smaller_angle_comes_nearer() {
    let here = folder(&[]);
    let error = |angle: &str| {
        let sets = format!("--set object.0.detail=3 --set object.0.size=1 --set transport.octree_angle={angle}");
        good(&here, &format!("solve sphere {sets} --transport octree --device cpu -o own.csv"));
        let (_, own) = numbers(&read(&here, "own.csv"));
        good(&here, &format!("solve sphere {sets} --transport brute --device cpu -o all.csv"));
        let (_, all) = numbers(&read(&here, "all.csv"));
        // B_g of every face.
        let rows = || own.iter().zip(&all).map(|(own, all)| (own[9], all[9]));
        (rows().map(|(a, b)| (a - b).powi(2)).sum::<f64>() / rows().map(|(_, b)| b * b).sum::<f64>()).sqrt()
    };
    let (coarse, fine) = (error("2"), error("0.05"));
    assert!(fine < coarse && fine < 0.02, "{coarse} {fine}");
}

#[test]
fn a_picture_shows_its_light() {
    let here = folder(&[]);
    let pixels = |transport: &str, device: &str| {
        let line = "render sphere --size 32x32 --set object.0.detail=4 -o a.png";
        good(&here, &format!("{line} --transport {transport} {device}"));
        image::open(here.path().join("a.png")).unwrap().into_rgb8().into_raw()
    };
    for device in DEVICES {
        let (own, all) = (pixels("octree", device), pixels("hierarchy", device));
        let off = own.iter().zip(&all).map(|(a, b)| a.abs_diff(*b)).max().unwrap();
        assert!(off <= 6 && all.iter().any(|&x| x > 100), "{device}: {off}");
    }
}

#[test]
fn the_plan_says_where_it_runs_and_a_dark_scene_needs_none() {
    let here = folder(&[("dark.toml", "[[object]]\nshape = 'sphere'\ndetail = 1\nmaterial = { preset = 'marble' }\n")]);
    let (out, _) = good(&here, "plan sphere --transport octree --device cpu --json plan.json");
    for words in ["in native code on the host", "Jensen and Buhler 2002", "the octree carries the light"] {
        assert!(out.contains(words), "{words}\n{out}");
    }
    assert!(read(&here, "plan.json").contains("irradiance octree"));
    let (out, _) = good(&here, "plan dark.toml --transport octree --device cpu");
    assert!(!out.contains("irradiance octree"), "{out}");
    good(&here, "solve dark.toml --transport octree --device cpu -o dark.csv");
    assert!(numbers(&read(&here, "dark.csv")).1.iter().all(|row| row[8..11] == [0.0; 3]));
}

#[test]
fn what_it_cannot_do_is_refused() {
    let here = folder(&[]);
    for command in ["solve sphere -o a.csv", "render sphere -o a.png", "plan sphere"] {
        let line = format!("{command} --transport octree --device cpu --set object.0.detail=1");
        bad(&here, &format!("{line} --set transport.distance=table1"), 2, &["transport.distance: ", "found table1"]);
        bad(&here, &format!("{line} --set transport.octree_angle=0"), 2, &["transport.octree_angle: out of range"]);
    }
    bad(&here, "plan sphere --transport octtree", 2, &["octree"]);
}

#[test]
fn opaque_objects_give_back_their_albedo_on_a_device_too() {
    let here = folder(&[]);
    let scene = "sphere --set object.0.detail=2 --set object.1={shape='sphere',detail=1,size=5,position=[20,0,0],\
                 material={opaque=true,albedo=0.5}}";
    good(&here, &format!("solve {scene} --transport octree -o a.csv"));
    let (header, rows) = numbers(&read(&here, "a.csv"));
    let column = |name: &str| header.split(',').position(|word| word == name).unwrap();
    let (object, light, given) = (column("object"), column("E_r"), column("B_r"));
    let opaque: Vec<_> = rows.iter().filter(|row| row[object] == 1.0).collect();
    assert!(opaque.iter().any(|row| row[light] > 0.1));
    assert!(opaque.iter().all(|row| (row[given] - 0.5 * row[light]).abs() <= 1e-6 * row[light]));
}
