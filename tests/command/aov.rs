//! The layers of `render --aov`: their names, and that each pixel agrees with what `solve` writes for its triangle.

use std::collections::BTreeMap;
use std::path::Path;

use crate::shell::{bad, close, folder, good, numbers, read};
use exr::prelude::*;

const BALL: &str = "sphere --set object.0.detail=2";
const SIZE: (usize, usize) = (40, 30);

/// Every channel of every layer as floats, by the name `layer.channel`.
fn layers(path: &Path) -> BTreeMap<String, Vec<f64>> {
    let image = read_all_flat_layers_from_file(path).unwrap();
    let mut all = BTreeMap::new();
    for layer in &image.layer_data {
        assert_eq!((layer.size.width(), layer.size.height()), SIZE);
        let name = layer.attributes.layer_name.as_ref().unwrap().to_string();
        for channel in &layer.channel_data.list {
            let values = match &channel.sample_data {
                FlatSamples::F32(values) => values.iter().map(|x| f64::from(*x)).collect(),
                FlatSamples::U32(values) => values.iter().map(|x| f64::from(*x)).collect(),
                FlatSamples::F16(_) => panic!("half floats in {name}"),
            };
            all.insert(format!("{name}.{}", channel.name), values);
        }
    }
    all
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn layers_tell_what_solve_tells() {
    let here = folder(&[]);
    // The last case has two channel groups: link counts are summed over both.
    let two = "--set light.0.irradiance=[3,0,0]";
    for how in ["--device cpu", "", "--set transport.scheme=links --device cpu", two] {
        good(&here, &format!("render {BALL} {how} --aov -o a.exr --size {}x{}", SIZE.0, SIZE.1));
        good(&here, &format!("render {BALL} {how} -o plain.exr --size {}x{}", SIZE.0, SIZE.1));
        good(&here, &format!("solve {BALL} {how} -o a.csv"));
        let layers = layers(&here.path().join("a.exr"));
        let (header, rows) = numbers(&read(&here, "a.csv"));
        let estimated = !how.contains("links");
        assert_eq!(
            (layers.contains_key("error_estimate.R"), header.contains("err_r")),
            (estimated, estimated),
            "{how}"
        );

        let none = f64::from(u32::MAX);
        let mut seen = 0;
        let pixels = 0..SIZE.0 * SIZE.1;
        for pixel in pixels {
            let channel = |name: &str| layers[name][pixel];
            if channel("triangle.id") == none {
                assert_eq!((channel("object.id"), channel("links.count"), channel("irradiance.R")), (none, 0.0, 0.0));
                assert!(channel("depth.Z").is_infinite() && channel("normal.X") == 0.0);
                continue;
            }
            seen += 1;
            let row = &rows[channel("triangle.id") as usize];
            for (k, c) in ["R", "G", "B"].iter().enumerate() {
                assert!(close(channel(&format!("irradiance.{c}")), row[5 + k], 1e-6), "{how}");
                assert!(channel(&format!("radiosity.{c}")) >= 0.0);
                if estimated {
                    assert!(close(channel(&format!("error_estimate.{c}")), row[12 + k], 1e-5), "{how}");
                }
            }
            // The ball has radius 5 and its centre at the origin, so normals are about face centres over 5.
            let n = ["X", "Y", "Z"].map(|axis| channel(&format!("normal.{axis}")));
            assert!(close(n.iter().map(|x| x * x).sum(), 1.0, 1e-5) && channel("object.id") == 0.0);
            assert!((n[0] - row[1] / 5.0).abs() < 0.3 && (n[1] - row[2] / 5.0).abs() < 0.3, "{n:?} {row:?}");
            assert!(channel("depth.Z") > 5.0 && channel("depth.Z") < 100.0 && channel("links.count") >= 1.0);
        }
        assert!(seen > 100 && seen < SIZE.0 * SIZE.1, "{how}: {seen} pixels show the ball");

        // The picture layer equals the picture rendered without layers.
        let plain = read_all_flat_layers_from_file(here.path().join("plain.exr")).unwrap();
        for channel in &plain.layer_data[0].channel_data.list {
            let FlatSamples::F32(values) = &channel.sample_data else { panic!("not floats") };
            let own = &layers[&format!("picture.{}", channel.name)];
            assert!(values.iter().zip(own).all(|(a, b)| f64::from(*a) == *b), "{how}");
        }
    }
}

#[test]
fn the_layer_of_shadows_is_the_share_of_rays_that_arrive() {
    let here = folder(&[]);
    // Two suns, from the right and the left: of the two rays of each triangle one arrives, at the border maybe none.
    let sun = "{type='directional',direction=[1,0,0],irradiance=1}";
    let lights = format!("--set light=[{sun},{{type='directional',direction=[-1,0,0],irradiance=1}}]");
    let size = format!("--size {}x{}", SIZE.0, SIZE.1);
    for device in ["--device cpu", ""] {
        good(&here, &format!("render {BALL} {lights} {device} --aov -o a.exr {size}"));
        let all = layers(&here.path().join("a.exr"));
        let (lit, seen) = (&all["shadows.lit"], &all["triangle.id"]);
        let values: Vec<f64> = (0..lit.len()).filter(|at| seen[*at] != f64::from(u32::MAX)).map(|at| lit[at]).collect();
        assert!(values.len() > 100 && values.iter().all(|lit| [0.0, 0.5].contains(lit)), "{values:?}");
        assert!(values.iter().sum::<f64>() > 0.4 * values.len() as f64, "{values:?}");
        assert!((0..lit.len()).all(|at| seen[at] != f64::from(u32::MAX) || lit[at] == 0.0));
    }
    good(&here, &format!("render {BALL} --set light.0.shadows=false --aov -o a.exr {size}"));
    assert!(!layers(&here.path().join("a.exr")).contains_key("shadows.lit"), "no light casts shadows");
}

#[test]
fn only_openexr_has_layers() {
    let here = folder(&[]);
    bad(&here, &format!("render {BALL} --aov -o a.png"), 2, &["--aov", "only OpenEXR has layers", "-o FILE.exr"]);
    good(&here, "render sphere --set object.0.detail=1 --set light=[] --aov -o dark.exr --device cpu --size 8x8");
}
