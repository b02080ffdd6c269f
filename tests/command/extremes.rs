//! Materials and lights at the limits of a scene file, run as a program: `solve` and `render` stay finite.

use std::path::Path;

use crate::shell::{bad, close, folder, good, numbers, read};

const DEVICES: [&str; 2] = ["--device cpu", ""];
const BALL: &str = "sphere --set object.0.detail=2 --set object.0.size=1";

/// E and B of every face; checks that all numbers are finite and at least 0, and that every face has radiosity.
fn solved(sets: &str) -> Vec<[f64; 6]> {
    let here = folder(&[]);
    good(&here, &format!("solve {BALL} {sets} -o a.csv"));
    let (_, rows) = numbers(&read(&here, "a.csv"));
    let light: Vec<[f64; 6]> = rows.iter().map(|row| row[5..11].try_into().unwrap()).collect();
    assert_eq!(light.len(), 320);
    let estimates = rows.iter().flat_map(|row| &row[12..]);
    assert!(light.iter().flatten().chain(estimates).all(|x| x.is_finite() && *x >= 0.0), "{sets}");
    for of in [3, 4, 5] {
        assert!(light.iter().all(|row| row[of] > 0.0), "{sets}: a face without radiosity");
    }
    light
}

/// A point light of this intensity and position; the ball's radius is 0.5. No spaces, since lines are split at them.
fn lamp(intensity: f64, [x, y, z]: [f64; 3]) -> String {
    format!("--set light.0={{type='point',position=[{x},{y},{z}],intensity={intensity:e}}}")
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn every_index_gives_numbers() {
    for device in DEVICES {
        for eta in ["0.5", "0.7", "0.999", "1", "5"] {
            for scheme in ["blocks", "links"] {
                solved(&format!("--set object.0.material.eta={eta} --set transport.scheme={scheme} {device}"));
            }
            solved(&format!("--set object.0.material.eta={eta} --transport brute {device}"));
        }
    }
}

#[test]
fn below_an_index_of_1_nothing_enters_beyond_the_critical_angle() {
    for device in DEVICES {
        let dark = |eta: &str| {
            let rows = solved(&format!("--set object.0.material.eta={eta} {device}"));
            rows.iter().filter(|row| row[0] == 0.0).count()
        };
        let (air, thin) = (dark("1"), dark("0.7"));
        assert!(thin > air + 10 && thin < 320, "{air} and {thin} of 320 faces take no light");
    }
}

#[test]
fn light_of_any_strength_scales() {
    for device in DEVICES {
        let one = solved(&format!("{} {device}", lamp(1.0, [0.0, 0.0, 2.0])));
        for strength in [1e30, 1e-30] {
            let scaled = solved(&format!("{} {device}", lamp(strength, [0.0, 0.0, 2.0])));
            for (row, one) in scaled.iter().flatten().zip(one.iter().flatten()) {
                // Light is rescaled internally by powers of two, so the results differ by rounding only.
                assert!(close(*row, one * strength, 1e-4), "{row:e} and {one:e} at {strength:e}");
            }
        }
    }
}

#[test]
fn a_strong_lamp_right_at_the_surface_saturates_pictures_and_files() {
    let here = folder(&[]);
    for device in DEVICES {
        // 1e-6 of the ball's diameter above the centroid of a face.
        good(&here, &format!("solve {BALL} {device} -o a.csv"));
        let (_, rows) = numbers(&read(&here, "a.csv"));
        let lamp = lamp(1e30, [1, 2, 3].map(|k| rows[0][k] * (1.0 + 2e-6)));
        let brightest = solved(&format!("{lamp} {device}")).iter().flatten().copied().fold(0.0, f64::max);
        assert!(brightest > f64::from(f32::MAX), "{brightest:e} would fit: a poor test");
        good(&here, &format!("solve {BALL} {lamp} {device} -o a.ply"));
        assert!(!read(&here, "a.ply").contains("inf") && !read(&here, "a.ply").contains("NaN"));
        good(&here, &format!("render {BALL} {lamp} {device} --size 32x32 --aov -o a.exr"));
        let layers = exr::prelude::read_all_flat_layers_from_file(here.path().join(Path::new("a.exr"))).unwrap();
        for layer in layers.layer_data {
            for channel in layer.channel_data.list {
                // Only depth is infinite, where a pixel shows no object.
                if channel.name.to_string() != "Z" {
                    assert!(
                        channel.sample_data.values_as_f32().all(f32::is_finite),
                        "{:?}",
                        layer.attributes.layer_name
                    );
                }
            }
        }
    }
}

#[test]
fn beyond_the_ends_is_refused_by_name() {
    let here = folder(&[]);
    let line = |set: &str| format!("solve {BALL} --device cpu -o a.csv --set {set}");
    for eta in ["0.49", "5.01"] {
        let words = ["object.0.material.eta: out of range", "expected numbers from 0.5 to 5"];
        bad(&here, &line(&format!("object.0.material.eta={eta}")), 2, &words);
    }
    let words = ["object.0.material.eta: out of range", "at most 3.8", "exact"];
    bad(&here, &line("object.0.material={preset='marble',eta=4,fresnel='paper'}"), 2, &words);
    let words = ["light.0.irradiance: out of range", "expected numbers from 0 to 1e30"];
    bad(&here, &line("light.0.irradiance=1.1e30"), 2, &words);
}
