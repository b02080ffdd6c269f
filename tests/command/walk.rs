//! `--transport walk` run as a program: what it writes, refuses and says, and how it ends.

use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};

use crate::shell::{bad, bytes, folder, good, numbers, program, read};

const BALL: &str = "sphere --transport walk --set object.0.detail=2 --set object.0.size=4";

#[test]
fn rows_have_standard_errors_and_the_light_is_told() {
    let here = folder(&[]);
    for device in ["--device cpu", ""] {
        let (out, err) = good(&here, &format!("solve {BALL} --set transport.walks=3000 -o w.csv --times {device}"));
        let (header, rows) = numbers(&read(&here, "w.csv"));
        assert!(header.ends_with("input_face,se_r,se_g,se_b"), "{header}");
        let light = |from: usize| rows.iter().map(|row| row[4] * row[from]).sum::<f64>();
        let (entered, left) = (light(5), light(8));
        let told = err.split("left ").nth(1).and_then(|rest| rest.split_whitespace().next()).unwrap();
        assert!((100.0 * left / entered - told.parse::<f64>().unwrap()).abs() < 0.01, "{err}");
        assert!(rows.iter().all(|row| row[12] >= 0.0) && light(12) > 0.0);
        assert!(err.contains("3000 photons a channel") && err.contains("lost 0.000 0.000 0.000"), "{err}");
        assert!(out.contains("random_walk") && out.contains("exit_radiosity"), "{out}");
    }
}

#[test]
fn a_picture_has_a_layer_of_standard_errors() {
    let here = folder(&[]);
    good(&here, &format!("render {BALL} --set transport.walks=3000 --aov -o w.exr --size 24x20"));
    let held = |name: &str| bytes(&here, "w.exr").windows(name.len()).any(|window| window == name.as_bytes());
    assert!(held("standard_error") && !held("error_estimate"));
}

#[test]
fn noise_is_as_small_as_asked() {
    let here = folder(&[]);
    let (_, err) = good(&here, &format!("solve {BALL} --set transport.walk_error=0.1 --device cpu -o w.csv"));
    let noise = err.split("noise ").nth(1).and_then(|rest| rest.split_whitespace().next()).unwrap();
    assert!((0.04..=0.1).contains(&(noise.parse::<f64>().unwrap() / 100.0)), "{err}");
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_profile_tells_photons_a_second() {
    let here = folder(&[]);
    let line = format!("profile {BALL} --set transport.walks=500 --set camera.size=[8,8] --frames 1");
    for device in ["--device cpu", ""] {
        let (out, _) = good(&here, &format!("{line} {device}"));
        let rate = out.split("walk, object 0: 1500 photons in ").nth(1).and_then(|rest| rest.split(" s, ").nth(1));
        let rate = rate.and_then(|rest| rest.split_whitespace().next()).and_then(|word| word.parse::<f64>().ok());
        assert!(rate.is_some_and(|rate| rate > 10.0), "{out}");
    }
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn what_has_no_meaning_or_takes_too_long_is_refused() {
    let here = folder(&[("open.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\n")]);
    bad(&here, "solve open.obj --transport walk -o w.csv", 2, &["object.0", "3 open edges", "closed"]);
    let too_long = format!("solve {BALL} --set transport.walk_error=1e-4 --limit-time 2s -o w.csv --device cpu");
    bad(&here, &too_long, 2, &["--limit-time", "transport.walk_error", "at most 2 s"]);
    let too_many = format!("solve {BALL} --set transport.walks=100000000 -o w.csv --device cpu --limit-time");
    bad(&here, &format!("{too_many} 2s"), 2, &["--limit-time", "transport.walks = 100000000", "at most 2 s"]);
    bad(&here, &format!("{too_many} 0.001s"), 2, &["--limit-time", "first photons", "at most 0.001 s"]);
    let both = format!("solve {BALL} --set object.0.material.two_sided=true -o w.csv");
    bad(&here, &both, 2, &["object.0", "two_sided"]);
    for (set, word) in [
        ("transport.walks=0", "transport.walks: out of range"),
        ("transport.walk_error=2", "transport.walk_error: out of range"),
        ("object.0.material.g=1", "object.0.material.g: out of range"),
    ] {
        bad(&here, &format!("solve {BALL} --set {set} -o w.csv"), 2, &[word]);
    }
    bad(&here, &format!("render {BALL} --limit-time 0 -o w.png"), 2, &["--limit-time"]);
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
#[cfg(target_os = "linux")]
fn a_terminal_shows_how_far_it_is_and_a_pipe_nothing() {
    let here = folder(&[]);
    let line = format!("solve {BALL} --set transport.walk_error=0.06 --device cpu -o w.csv");
    let (_, err) = good(&here, &line);
    assert!(err.lines().all(|line| line.starts_with("walk, object 0: ") || line.starts_with("long: ")), "{err}");
    // `script` runs it on a terminal of its own, which has no size and no kind where the test has no terminal.
    let words = format!("stty cols 120; TERM=xterm {} {line}", env!("CARGO_BIN_EXE_milkglass"));
    let output = Command::new("script").args(["-qec", &words, "/dev/null"]).current_dir(here.path()).output().unwrap();
    let shown = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{shown}");
    for word in ["walk, object 0: error ", " % of 6 %, ", " s left", "walk, object 0: "] {
        assert!(shown.contains(word), "{word}: {shown}");
    }
    // The line at the end stands by itself.
    let last = shown.trim_end().rsplit(['\r', '\n']).next().unwrap().replace("\u{1b}[2K", "");
    assert!(last.starts_with("walk, object 0: "), "{last:?}");
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
#[cfg(unix)]
fn ctrl_c_ends_it_with_what_there_is() {
    let here = folder(&[]);
    let line = format!("solve {BALL} --set transport.walk_error=2e-4 --device cpu -o w.csv");
    let mut child = program(&here, &line).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let mut lines = BufReader::new(child.stderr.take().unwrap()).lines().map_while(Result::ok);
    assert!(lines.any(|line| line.contains("long: object 0 takes")));
    assert!(Command::new("kill").args(["-INT", &child.id().to_string()]).status().unwrap().success());
    let rest: Vec<String> = lines.collect();
    assert_eq!(child.wait().unwrap().code(), Some(0), "{rest:?}");
    assert!(rest.iter().any(|line| line.contains("stopped before its end")), "{rest:?}");
    assert_eq!(numbers(&read(&here, "w.csv")).1.len(), 320);
}
