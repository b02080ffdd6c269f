//! `milkglass fit-cdrf` run as a program.

use crate::shell::{bad, folder, good, read};

/// The three numbers of the line that starts with these words.
fn list(text: &str, words: &str) -> Vec<f64> {
    let line = text.lines().find(|line| line.starts_with(words)).unwrap_or_else(|| panic!("no {words:?} in {text}"));
    let inner = line.split_once('[').unwrap().1.trim_end_matches(']');
    inner.split(", ").map(|number| number.parse().unwrap()).collect()
}

#[test]
fn bad_input_is_named() {
    let here = folder(&[]);
    bad(&here, "fit-cdrf marbel", 2, &["no material of this name", "marbel"]);
    bad(&here, "fit-cdrf marble --radii 1,x", 2, &["--radii", "1,x"]);
    bad(&here, "fit-cdrf marble --radii 0", 2, &["--radii"]);
    bad(&here, "fit-cdrf marble --photons 0", 2, &["--photons", "out of range"]);
}

mod rare {
    use super::*;

    #[test]
    #[ignore = "rare: part of .ci/full, `cargo test --release -- --include-ignored`"]
    fn a_fit_tells_sigma_0_and_draws() {
        let here = folder(&[]);
        let (out, _) = good(&here, "fit-cdrf marble --radii 10,20,40 --photons 4000 --svg marble.svg");
        // On balls of many mean free paths, the fit is larger than on the usual ones.
        let (dipole, usual) = (list(&out, "fitted to the dipole"), list(&out, "without material.sigma_0"));
        let walk = list(&out, "fitted to the random walk");
        for c in 0..3 {
            assert!((1.2..2.0).contains(&(dipole[c] / usual[c])), "{out}");
            assert!((walk[c] / dipole[c] - 1.0).abs() < 0.3, "{out}");
        }
        // The usual one is the fit over the usual balls.
        let (few, _) = good(&here, "fit-cdrf marble --photons 100");
        let (fitted, told) = (list(&few, "fitted to the dipole"), list(&few, "without material.sigma_0"));
        (0..3).for_each(|c| assert!((fitted[c] - told[c]).abs() < 2e-4 && told == usual, "{few}"));
        assert!(dipole[0] > dipole[1] && dipole[1] > dipole[2], "red goes farthest: {out}");
        let picture = read(&here, "marble.svg");
        assert!(picture.starts_with("<svg") && picture.trim_end().ends_with("</svg>") && picture.contains("sigma_0"));
        let (again, _) = good(&here, "fit-cdrf MARBLE --radii 10,20,40 --photons 4000");
        assert_eq!(again, out);
        assert_ne!(good(&here, "fit-cdrf marble --radii 10,20,40 --photons 4000 --seed 2").0, out);
    }
}
