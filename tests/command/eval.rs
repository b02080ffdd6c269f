//! `milkglass eval` run as a program, against values computed independently here.

use crate::shell::{bad, close, folder, good, numbers, read};

#[test]
fn eval_profile_is_table_1() {
    let input = "note,r,sigma_s_prime,sigma_a,eta\n\"a, b\",1.5,2.0,0.1,1.3\nfar,12,0.7,0.02,1.5\nzero,0,3,0,1\n";
    let here = folder(&[("in.csv", input)]);
    for (device, relative) in [("--device cpu", 1e-12), ("", 1e-5)] {
        good(&here, &format!("eval profile in.csv -o out.csv {device}"));
        let out = read(&here, "out.csv");
        let mut lines = out.lines();
        assert_eq!(lines.next(), Some("note,r,sigma_s_prime,sigma_a,eta,value"));
        let rows = [("\"a, b\"", 1.5, 2.0, 0.1, 1.3), ("far", 12.0, 0.7, 0.02, 1.5), ("zero", 0.0, 3.0, 0.0, 1.0)];
        for ((note, r, s, a, eta), line) in rows.into_iter().zip(lines) {
            let value: f64 = line.rsplit(',').next().unwrap().parse().unwrap();
            assert!(line.starts_with(note), "{line}");
            assert!(close(value, profile(r, s, a, eta), relative), "{device} {line}: {}", profile(r, s, a, eta));
        }
    }
}

/// R_d(r) of a dipole, written out from the paper.
fn profile(r: f64, s: f64, a: f64, eta: f64) -> f64 {
    let f_dr = -1.440 / (eta * eta) + 0.710 / eta + 0.668 + 0.0636 * eta;
    let (t, boundary) = (s + a, (1.0 + f_dr) / (1.0 - f_dr));
    let sigma = (3.0 * a * t).sqrt();
    let (real, virtual_) = (1.0 / t, 1.0 / t * (1.0 + 4.0 / 3.0 * boundary));
    let source = |z: f64| {
        let d = (r * r + z * z).sqrt();
        z * (1.0 + sigma * d) * (-sigma * d).exp() / (d * d * d)
    };
    s / t / (4.0 * std::f64::consts::PI) * (source(real) + source(virtual_))
}

#[test]
fn eval_form_factor_far_away_is_area_times_profile() {
    let header = "v0x,v0y,v0z,v1x,v1y,v1z,v2x,v2y,v2z,xox,xoy,xoz,sigma_s_prime,sigma_a,eta";
    let here = folder(&[("in.csv", &format!("{header},id\n0,0,0,0.02,0,0,0,0.02,0,4,0,0,1,0.05,1.3,7\n"))]);
    good(&here, "eval form-factor in.csv -o out.csv --device cpu");
    let (names, rows) = numbers(&read(&here, "out.csv"));
    assert_eq!(names, format!("{header},id,value,value_radial"));
    let expected =
        0.5 * 0.02 * 0.02 * profile(((4.0f64 - 0.02 / 3.0).powi(2) + (0.02f64 / 3.0).powi(2)).sqrt(), 1.0, 0.05, 1.3);
    assert_eq!(rows[0][15], 7.0);
    assert!(close(rows[0][16], expected, 1e-4) && close(rows[0][17], expected, 1e-4), "{rows:?} {expected}");
}

#[test]
fn eval_names_the_line_of_a_bad_row() {
    let header = "r,sigma_s_prime,sigma_a,eta";
    let here = folder(&[]);
    let cases: &[(&str, &[&str])] = &[
        ("1,2,0.1,1.3\n1,x,0.1,1.3\n", &["in.csv:3: sigma_s_prime: ", "\"x\""]),
        ("1,2,0.1,1.3\n1,2\n", &["in.csv:3: "]),
        ("-1,2,0.1,1.3\n", &["in.csv:2: r: out of range"]),
        ("1,0,0,1.3\n", &["in.csv:2: ", "neither scatters nor absorbs"]),
    ];
    for (rows, words) in cases {
        std::fs::write(here.path().join("in.csv"), format!("{header}\n{rows}")).unwrap();
        bad(&here, "eval profile in.csv -o out.csv --device cpu", 2, words);
    }
    for text in ["", "r,eta\n"] {
        std::fs::write(here.path().join("in.csv"), text).unwrap();
        bad(&here, "eval profile in.csv -o out.csv --device cpu", 2, &["in.csv:1: ", "column is missing"]);
    }
}

#[test]
fn eval_cdrf_is_the_periodic_convolution() {
    let here =
        folder(&[("in.csv", "sigma,cos_theta\n0,0.5\n0.3,-0.2\n0.3,1\n0.05,0\n1,-1\n2.5,0.3\n1e30,0.9\n0,-1\n")]);
    for (device, error) in [("--device cpu", 1e-9), ("", 5e-6)] {
        good(&here, &format!("eval cdrf in.csv -o out.csv {device}"));
        let (header, rows) = numbers(&read(&here, "out.csv"));
        assert_eq!((header.as_str(), rows.len()), ("sigma,cos_theta,value", 8));
        for row in rows {
            let [sigma, cosine, value] = row[..] else { panic!("{row:?}") };
            let expected = convolution(cosine.acos(), sigma);
            assert!((value - expected).abs() < error, "{device} {sigma} {cosine}: {value} {expected}");
        }
    }
    for (row, word) in [("0,1.5", "cos_theta: out of range"), ("-1,0", "sigma: out of range"), ("x,0", "sigma: ")] {
        std::fs::write(here.path().join("in.csv"), format!("sigma,cos_theta\n{row}\n")).unwrap();
        bad(&here, "eval cdrf in.csv -o b.csv", 2, &["in.csv:2: ", word]);
    }
    std::fs::write(here.path().join("in.csv"), "sigma\n1\n").unwrap();
    bad(&here, "eval cdrf in.csv -o b.csv", 2, &["in.csv:1: cos_theta: ", "column is missing"]);
}

/// Periodic convolution of max(cos, 0) with a Gaussian, by the trapezium rule.
fn convolution(theta: f64, sigma: f64) -> f64 {
    use std::f64::consts::{PI, TAU};
    if sigma == 0.0 {
        return theta.cos().max(0.0);
    }
    if sigma > 100.0 {
        return 1.0 / PI;
    }
    let steps = 400_000;
    let width = (20.0 * sigma).max(TAU);
    let at = |k: i32| {
        let t = width * (f64::from(k) / f64::from(steps) - 0.5);
        (theta - t).cos().max(0.0) * (-0.5 * (t / sigma).powi(2)).exp()
    };
    (0..=steps).map(at).sum::<f64>() * width / f64::from(steps) / (TAU.sqrt() * sigma)
}
