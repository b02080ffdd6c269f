//! `--transport diffusion` and `auto` run as a program: what they say and refuse.

use crate::shell::{bad, folder, good};

const TWO: &str = "sphere --set object.0.detail=2 --set object.1={shape='sphere',detail=2,position=[30,0,0],material={sigma_s_prime=0.05,sigma_a=1}}";

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn auto_says_which_objects_have_the_dipole() {
    let here = folder(&[]);
    let (out, err) = good(&here, &format!("plan {TWO} --transport auto --json plan.json"));
    let why = "object 1, the dipole serves instead: the reduced albedo is 0.05, below 0.15";
    assert!(out.lines().any(|line| line.starts_with("diffusion ") && line.contains(why)), "{out}");
    assert!(err.contains("object 1: the dipole, not diffusion"), "{err}");
    assert!(crate::shell::read(&here, "plan.json").contains(why));
    // Both keep the tolerance; the table is of both together.
    for device in ["--device cpu", ""] {
        let (out, err) = good(&here, &format!("solve {TWO} --transport auto --verify 60 {device}"));
        assert!(
            out.contains("worst") && err.contains("object 0") && !err.contains("object 1: diffusion"),
            "{out}{err}"
        );
    }
}

#[test]
fn doubts_are_told() {
    let here = folder(&[]);
    let skin = "sphere --set object.0.detail=2 --set object.0.material.preset=skin1 --set object.0.size=1";
    let (_, err) = good(&here, &format!("solve {skin} --transport diffusion --times"));
    let line = err.lines().find(|line| line.contains("diffusion may be off")).unwrap_or_default();
    assert!(
        line.contains("albedo below 0.8 (b 0.68)") && line.contains("thinner than a mean free path (r 100 %"),
        "{err}"
    );
    let (_, err) = good(&here, "solve sphere --transport diffusion --set object.0.detail=2 --times");
    assert!(!err.contains("may be off"), "{err}");
}

#[test]
fn keys_of_links_and_open_meshes_are_refused() {
    let here = folder(&[]);
    let links = "solve sphere --transport auto --set transport.scheme=links --times";
    bad(&here, links, 2, &["transport.scheme", "--transport hierarchy"]);
    let both = "solve sphere --set object.0.material.two_sided=true --times --transport";
    bad(&here, &format!("{both} diffusion"), 2, &["two_sided"]);
    assert!(good(&here, &format!("{both} auto")).1.contains("the dipole, not diffusion: light enters from both sides"));
}
