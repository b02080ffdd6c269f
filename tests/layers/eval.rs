//! `milkglass eval layered` run as a program.

use glam::DVec3;
use milkglass::internals::layers::slab::{Lamp, SlabLayer, radiance};

use crate::shell::{bad, close, folder, good, read};

const HEADER: &str = "light,layers,thickness1,sigma_s1,sigma_t1,g1,thickness2,sigma_s2,sigma_t2,g2,\
                      lx,ly,lz,intensity,wox,woy,woz";

#[test]
fn a_slab_is_its_closed_form_on_every_back_end() {
    let rows = "directional,1,2,1,1.5,0.3,,,,,0,0,2,3,0,0,1\n\
                point,2,0.3,2,2.5,0.25,4,0.5,1,-0.5,1,2,3,40,0.2,-0.4,0.8\n\
                directional,2,0.01,9,9,0,1000,0.001,0.002,0.9,-3,1,0.5,1,1,0,0.3\n";
    let here = folder(&[("in.csv", &format!("{HEADER}\n{rows}"))]);
    let layer = |thickness, sigma_s, sigma_t, g| SlabLayer { sigma_s, sigma_t, g, thickness };
    let unit = |x: f64, y: f64, z: f64| DVec3::new(x, y, z).normalize();
    // One layer seen and lit from above: sigma_s p E (1 - e^(-2 tau)) / (2 sigma_t).
    let first = 3.0 * (1.0 - 0.09) / (4.0 * std::f64::consts::PI * 1.3 * 1.3) * (1.0 - (-6f64).exp()) / 3.0;
    let two = [layer(0.3, 2.0, 2.5, 0.25), layer(4.0, 0.5, 1.0, -0.5)];
    let second = radiance(&two, Lamp::Point(DVec3::new(1.0, 2.0, 3.0), 40.0), unit(0.2, -0.4, 0.8));
    let far = [layer(0.01, 9.0, 9.0, 0.0), layer(1000.0, 0.001, 0.002, 0.9)];
    let third = radiance(&far, Lamp::Directional(unit(-3.0, 1.0, 0.5), 1.0), unit(1.0, 0.0, 0.3));
    for (device, relative) in [("--device cpu", 1e-9), ("", 2e-5)] {
        good(&here, &format!("eval layered in.csv -o out.csv {device}"));
        let text = read(&here, "out.csv");
        assert_eq!(text.lines().next(), Some(&*format!("{HEADER},value")));
        let values: Vec<f64> =
            text.lines().skip(1).map(|line| line.rsplit(',').next().unwrap().parse().unwrap()).collect();
        for (value, expected) in values.iter().zip([first, second, third]) {
            assert!(close(*value, expected, relative), "{device}: {value}, not {expected}");
        }
        assert_eq!(values.len(), 3);
    }
}

#[test]
fn directions_may_be_of_any_length() {
    let value = |light: &str, eye: &str| {
        let row = format!("directional,1,2,1,1.5,0.3,,,,,{light},3,{eye}\n");
        let here = folder(&[("in.csv", &format!("{HEADER}\n{row}"))]);
        good(&here, "eval layered in.csv -o out.csv --device cpu");
        let text = read(&here, "out.csv");
        text.trim().rsplit(',').next().unwrap().parse::<f64>().unwrap()
    };
    let expected = value("1,2,3", "0,1,2");
    assert!(expected > 0.0);
    for (light, eye) in [("1e200,2e200,3e200", "0,1e-200,2e-200"), ("1e-300,2e-300,3e-300", "0,1e300,2e300")] {
        assert!(close(value(light, eye), expected, 1e-12), "{light} {eye}");
    }
    let here = folder(&[("in.csv", &format!("{HEADER}\npoint,1,2,1,1.5,0.3,,,,,0,0,1e200,3,0,0,1\n"))]);
    bad(&here, "eval layered in.csv -o out.csv --device cpu", 2, &["light", "too far away", "1e100"]);
}

#[test]
fn a_bad_row_is_named() {
    let good = "directional,1,2,1,1.5,0.3,,,,,0,0,2,3,0,0,1";
    let cases = [
        (
            good.replace("1.5", "0.5"),
            "sigma_t1: extinction is less than scattering; found 0.5; expected at least sigma_s1",
        ),
        (good.replace("0.3", "1"), "g1: out of range; found 1"),
        (good.replace("1.5", "x"), "sigma_t1: not a finite number; found \"x\""),
        (
            good.replacen(",1,", ",5,", 1),
            "layers: not a number of layers; found \"5\"; expected a whole number from 1 to 4",
        ),
        (good.replacen(",1,", ",2,", 1), "thickness2: not a finite number; found \"\""),
        (good.replacen(",1,", ",3,", 1).replace(",,,,", ",1,1,1,0"), "thickness3: this column is missing"),
        (good.replace("0,0,2", "0,0,-2"), "lz: the light is not above the slab; found -2"),
        (good.replace("0,0,1", "0,1,0"), "woz: the eye is not above the slab; found 0"),
        (good.replace("directional", "spot"), "light: not a kind of light; found \"spot\""),
        (good.replace("2,1,1.5", "-2,1,1.5"), "thickness1: out of range; found -2"),
    ];
    for (row, message) in cases {
        let here = folder(&[("in.csv", &format!("{HEADER}\n{good}\n{row}\n"))]);
        bad(&here, "eval layered in.csv -o out.csv --device cpu", 2, &["in.csv:3", message]);
    }
    let here = folder(&[("in.csv", "light,layers\n")]);
    bad(&here, "eval layered in.csv -o out.csv --device cpu", 2, &["in.csv:1: lx: this column is missing"]);
}
