//! The program announces what takes long: rays towards many light samples, and long, thin triangles.

use std::f64::consts::TAU;
use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};

use crate::shell::{folder, good, program, read};
use tempfile::TempDir;

/// A cone of thin triangles around a vertex.
fn fan(count: usize) -> String {
    let rim = |k: usize| (TAU * k as f64 / count as f64).sin_cos();
    let rim: String = (0..count).map(|k| format!("v {} {} 0\n", rim(k).1, rim(k).0)).collect();
    let faces: String = (0..count).map(|k| format!("f 1 {} {}\n", k + 2, (k + 1) % count + 2)).collect();
    format!("v 0 0 0.3\n{rim}{faces}")
}

/// A ball on an opaque floor, under a sky and a panel.
fn lit(occlusion: u32, samples: u32) -> String {
    format!(
        "[camera]\nposition = [0, 30, 60]\ntarget = [0, 0, 0]\nsize = [400, 300]\n\
         [[light]]\ntype = 'environment'\nradiance = 1\nocclusion = {occlusion}\n\
         [[light]]\ntype = 'area'\nposition = [0, 40, 0]\nedge_u = [10, 0, 0]\nedge_v = [0, 0, 10]\nradiance = 5\n\
         two_sided = true\nsamples = {samples}\n\
         [[object]]\nshape = 'sphere'\ndetail = 2\nsize = 20\nmaterial = {{ preset = 'marble' }}\n\
         [[object]]\nshape = 'plane'\ndetail = 1\nsize = 900\nposition = [0, -10, 0]\n\
         material = {{ opaque = true, albedo = [0.5, 0.5, 0.5] }}\n"
    )
}

/// The first notice of long work; the run is stopped there.
fn first_notice(command: &mut Command) -> Option<String> {
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let lines = BufReader::new(child.stderr.take().unwrap()).lines();
    let found = lines.map_while(Result::ok).find(|line| line.contains("long: "));
    drop(child.kill());
    child.wait().unwrap();
    found
}

fn plan(folder: &TempDir, name: &str) -> serde_json::Value {
    good(folder, &format!("plan {name} --device cpu --json plan.json"));
    serde_json::from_str(&read(folder, "plan.json")).unwrap()
}

#[test]
fn thin_triangles_are_named_before_they_take_minutes() {
    let folder = folder(&[("fan.obj", &fan(8000)), ("few.obj", &fan(100))]);
    let said =
        first_notice(&mut program(&folder, "solve fan.obj -o a.csv --device cpu --set transport.receivers=faces"))
            .unwrap();
    assert!(said.contains("of 8,000 triangles for each receiver") && said.contains("long and thin"), "{said}");
    assert!(said.contains("remesh"), "{said}");
    // A picture by rays only.
    let line = "render fan.obj -o a.png --transport cdrf --size 1600x1200 --device cpu";
    let said = first_notice(&mut program(&folder, line)).unwrap();
    assert!(said.contains("visibility") && said.contains("long and thin"), "{said}");
    // Short work is not announced, nor that of an even mesh of as many triangles, which has no such neighbours.
    let (_, err) = good(&folder, "solve few.obj -o a.csv --device cpu");
    assert!(!err.contains("long: "), "{err}");
    let (out, _) = good(&folder, "plan sphere --set object.0.detail=5 --device cpu");
    let near = out.lines().find(|line| line.starts_with("near a receiver")).unwrap();
    let count: f64 = near.split_whitespace().nth(4).unwrap().parse().unwrap();
    assert!((3.0..20.0).contains(&count), "{near}");
}

#[test]
fn many_samples_of_lights_are_announced_with_the_key_that_spares_them() {
    let folder = folder(&[("many.toml", &lit(1024, 8)), ("few.toml", &lit(8, 2)), ("panel.toml", &lit(8, 64))]);
    let said = first_notice(&mut program(&folder, "render many.toml -o a.png --device cpu")).unwrap();
    assert!(said.contains("pixel_shadow") && said.contains("light.0.occlusion below 1024"), "{said}");
    assert!(said.contains("120,000 pixels x 1088 light samples"), "{said}");
    let said = first_notice(&mut program(&folder, "render panel.toml -o a.png --device cpu")).unwrap();
    assert!(said.contains("light.1.samples below 64"), "{said}");
    let (_, err) = good(&folder, "render few.toml -o a.png --size 40x30 --device cpu");
    assert!(!err.contains("long: "), "{err}");
}

#[test]
fn a_plan_counts_rays() {
    let folder = folder(&[("a.toml", &lit(64, 3))]);
    let (out, _) = good(&folder, "plan a.toml --device cpu");
    let rows: Vec<_> = out.lines().filter(|line| line.contains("73 light samples")).collect();
    assert!(rows.len() == 2 && rows[0].contains("320 triangles x") && rows[1].contains("8,760,000"), "{out}");
    let rays = &plan(&folder, "a.toml")["rays"];
    let number = |k: usize, key: &str| rays[k][key].as_f64().unwrap();
    assert_eq!((number(0, "rays"), number(1, "rays"), number(2, "rays")), (320.0 * 73.0, 120_000.0, 120_000.0 * 73.0));
    // Every pixel whose ray descends shows the floor, which sends its rays to the sky upwards.
    assert!((0.6..=1.0).contains(&number(2, "cast")), "{rays}");
}

#[test]
fn a_large_picture_says_how_long_it_takes_before_it_starts() {
    let folder = folder(&[("a.toml", &lit(32, 2))]);
    let said = first_notice(&mut program(&folder, "render a.toml -o a.png --size 1400x1050 --samples 64")).unwrap();
    let seconds = said.split("the picture takes about ").nth(1).and_then(|rest| rest.split(" s").next()).unwrap();
    assert!(seconds.parse::<f64>().unwrap() >= 5.0 && said.contains("a smaller --size"), "{said}");
    assert!(!folder.path().join("a.png").exists());
}
