//! `profile` with intervals, and its comparisons: with a file, with another build, of several devices.

use serde_json::Value;

use crate::shell::{bad, folder, good, program, read, said};

const SMALL: &str = "sphere --set object.0.detail=1 --set camera.size=[16,12]";

fn json(here: &tempfile::TempDir, name: &str) -> Value {
    serde_json::from_str(&read(here, name)).unwrap()
}

#[test]
fn a_run_is_saved_and_compared() {
    let here = folder(&[]);
    let (out, _) = good(&here, &format!("profile {SMALL} --device cpu --frames 20 --save a.json"));
    assert!(out.contains("+-") && out.contains("half its 95 % interval"), "{out}");
    let saved = json(&here, "a.json");
    let samples = &saved["samples"];
    let warm_up = samples["warm_up"].as_u64().unwrap();
    assert!(warm_up <= 10 && samples["seed"] == 1 && samples["orders"].as_array().unwrap().len() == 20, "{samples}");
    let stages = samples["variants"][0]["stages"].as_array().unwrap();
    assert!(stages.iter().any(|stage| stage["stage"] == "gather"));
    assert!(stages.iter().all(|stage| stage["ms"].as_array().unwrap().len() == 20), "{stages:?}");
    for row in saved["stages"].as_array().unwrap() {
        let [low, value, high] = ["low", "value", "high"].map(|key| row["interval_ms"][key].as_f64().unwrap());
        assert!(low <= value && value <= high, "{row}");
    }
    // Two files, then a file with a new run.
    let (out, _) = good(&here, "profile --compare a.json a.json");
    let verdict = match warm_up {
        0 => "no difference shows; a change of stages by ".to_string(),
        short => format!("undecided: about {short} more round"),
    };
    assert!(out.contains(&format!("B against A: {verdict}")), "{out}");
    assert!(out.contains("timed at different times") && out.contains("1.000"), "{out}");
    let (out, _) = good(&here, &format!("profile {SMALL} --device cpu --frames 20 --compare a.json"));
    assert!(out.contains("this run") && out.contains("B ms") && out.contains("bootstrap"), "{out}");
}

/// A saved run with all times multiplied.
fn slowed(value: &mut Value, factor: f64) {
    match value {
        Value::Object(all) => all.iter_mut().filter(|(key, _)| *key != "interval_ms").for_each(|(key, value)| {
            match value.as_array_mut() {
                Some(list) if key.ends_with("ms") => {
                    list.iter_mut().for_each(|ms| *ms = (factor * ms.as_f64().unwrap()).into());
                }
                _ => slowed(value, factor),
            }
        }),
        Value::Array(all) => all.iter_mut().for_each(|value| slowed(value, factor)),
        _ => {}
    }
}

#[test]
fn a_comparison_fails_beyond_its_limit() {
    let here = folder(&[]);
    good(&here, &format!("profile {SMALL} --device cpu --frames 64 --save a.json"));
    let mut slow = json(&here, "a.json");
    slowed(&mut slow, 3.0);
    std::fs::write(here.path().join("slow.json"), slow.to_string()).unwrap();
    let compare = "profile --compare a.json slow.json --fail-slower 5% --junit a.xml";
    let output = program(&here, compare).output().unwrap();
    let (out, err) = said(&output);
    assert!(output.status.code() == Some(1) && err.contains("% slower; --fail-slower allows 5 %"), "{out}{err}");
    let xml = read(&here, "a.xml");
    for words in [
        "<testsuite name=\"B against A\"",
        "<property name=\"A\" value=\"milkglass ",
        "<testcase name=\"frame\" classname=\"B against A\">",
        "<failure message=\"B against A: frame is at least ",
    ] {
        assert!(xml.contains(words), "{words}: {xml}");
    }
    assert!(err.contains("B against A: frame is at least") && err.contains("B against A: stages is at least"), "{err}");
    good(&here, "profile --compare slow.json a.json --fail-slower 5% --undecided fail --junit b.xml");
    let xml = read(&here, "b.xml");
    assert!(xml.contains("<testcase name=\"frame\"") && !xml.contains("<failure"), "{xml}");
    bad(&here, "profile --compare a.json a.json --junit c.xml", 2, &["--junit", "nothing is held to a limit"]);
    // A range of 0.01 % is too narrow to be sure of.
    let strict = "profile --compare a.json a.json --fail-slower 0.01%";
    good(&here, strict);
    bad(
        &here,
        &format!("{strict} --undecided fail"),
        1,
        &["may be more than 0.01 % slower", "more --frames decide it"],
    );
    bad(&here, "profile sphere --fail-slower 2%", 2, &["--fail-slower", "nothing is compared"]);
    bad(&here, "profile --compare a.json a.json --fail-work 1%", 2, &["--replace"]);
}

#[test]
fn a_history_of_runs_is_drawn() {
    let here = folder(&[]);
    for line in [SMALL, "sphere --set object.0.detail=0 --set camera.size=[8,8]", SMALL] {
        good(&here, &format!("profile {line} --device cpu --frames 3 --history h.jsonl"));
    }
    let text = read(&here, "h.jsonl");
    assert!(text.lines().count() == 3 && !text.contains("samples") && text.contains("\"what\":\"stages\""), "{text}");
    good(&here, "report -o r --device cpu --only history --history h.jsonl");
    let page = read(&here, "r/index.html");
    assert!(page.matches("<svg").count() == 2 && page.contains("median, ms"), "{page}");
    let csv = read(&here, "r/history-1.csv");
    let runs: Vec<&str> = csv.lines().map(|line| line.split(',').next().unwrap()).collect();
    assert_eq!(runs, ["run", "1", "3"], "{csv}");
    bad(
        &here,
        "report -o q --device cpu --only history",
        2,
        &["--only: this section shows what a file has", "--history FILE"],
    );
    bad(
        &here,
        "report -o q --device cpu --only devices --history h.jsonl",
        2,
        &["--history: no section shows", "h.jsonl"],
    );
    std::fs::write(here.path().join("h.jsonl"), format!("{text}[]\n")).unwrap();
    bad(&here, "report -o q --device cpu --only history --history h.jsonl", 2, &["h.jsonl:4: not a run"]);
}

#[test]
fn no_line_is_appended_to_another_file() {
    let (scene, _) = good(&folder(&[]), "scenes sphere");
    let here = folder(&[("s.toml", &scene), ("torn.jsonl", "{}")]);
    let set = "--set object.0.detail=0 --set camera.size=[8,8] --device cpu --frames 1";
    for (line, words) in [
        (
            "s.toml --history s.toml",
            &["s.toml:1: not a run", "expected lines that `milkglass profile --history` writes"][..],
        ),
        ("sphere --history torn.jsonl", &["torn.jsonl:1: not a run"]),
        ("sphere --history no/such.jsonl", &["no/such.jsonl: could not be written"]),
        ("sphere --save a --history a", &["--history: the same file as --json", "found a"]),
    ] {
        // Found before anything is measured.
        let err = bad(&here, &format!("profile {line} {set}"), 2, words);
        assert_eq!(err.lines().count(), 1, "{err}");
    }
    assert!(read(&here, "s.toml") == scene && read(&here, "torn.jsonl") == "{}");
}

#[cfg(unix)]
#[test]
fn a_line_is_appended_in_a_folder_that_takes_no_file() {
    use std::os::unix::fs::{MetadataExt, PermissionsExt};
    use std::os::unix::process::CommandExt;
    let here = folder(&[("h.jsonl", "")]);
    let mode = |path: &std::path::Path, mode| {
        std::fs::set_permissions(path, std::fs::Permissions::from_mode(mode)).unwrap();
    };
    mode(&here.path().join("h.jsonl"), 0o666);
    mode(here.path(), 0o555);
    let line =
        "profile sphere --set object.0.detail=0 --set camera.size=[8,8] --device cpu --frames 1 --history h.jsonl";
    let mut command = program(&here, line);
    // To the superuser permissions mean nothing.
    if here.path().metadata().unwrap().uid() == 0 {
        command.uid(65534);
    }
    let output = match command.output() {
        Ok(output) => output,
        Err(error) => return println!("waived: another user can't run the program: {error}"),
    };
    mode(here.path(), 0o755);
    assert!(output.status.success(), "{:?}", said(&output));
    assert_eq!(read(&here, "h.jsonl").lines().count(), 1);
}

#[cfg(unix)]
#[test]
fn a_line_that_does_not_fit_is_taken_back() {
    let here = folder(&[]);
    let line =
        "profile sphere --set object.0.detail=0 --set camera.size=[8,8] --device cpu --frames 1 --history h.jsonl";
    good(&here, line);
    let before = read(&here, "h.jsonl");
    // No file may be longer than the first line, and a part of the second one.
    let blocks = before.len() / 512 + 1;
    let script = format!("trap '' XFSZ; ulimit -f {blocks}; exec {} {line}", env!("CARGO_BIN_EXE_milkglass"));
    let output = std::process::Command::new("sh").current_dir(here.path()).args(["-c", &script]).output().unwrap();
    let (out, err) = said(&output);
    assert!(output.status.code() == Some(2) && err.contains("h.jsonl: could not be written: "), "{out}{err}");
    assert_eq!(read(&here, "h.jsonl"), before);
    good(&here, line);
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn files_that_do_not_fit_are_refused() {
    let here =
        folder(&[("b.json", "{\"schema\": 1, \"results\": []}"), ("c.json", "{\"schema\": 7}"), ("d.json", "[")]);
    good(&here, &format!("profile {SMALL} --device cpu --frames 1 --save a.json"));
    for (line, words) in [
        ("profile --compare a.json b.json", &["b.json", "missing field", "profile --save"][..]),
        ("profile --compare c.json a.json", &["c.json: schema", "found 7"]),
        ("profile --compare a.json d.json", &["d.json:1", "not JSON"]),
        ("profile --compare a.json nowhere.json", &["nowhere.json", "could not be read"]),
        ("profile --compare a.json", &["SCENE", "no scene is given"]),
        ("profile --compare a.json a.json --history h", &["--history: nothing is measured", "two files of --compare"]),
        ("profile --compare a.json a.json --roofline r.svg", &["--roofline: nothing is measured"]),
        ("profile --compare a.json a.json --save b.json", &["--json: nothing is measured"]),
        ("profile sphere --compare a.json a.json", &["SCENE: nothing is measured", "one of them and a scene"]),
        ("profile", &["SCENE", "no scene is given"]),
        ("profile lotus --device cpu --compare nowhere.json", &["nowhere.json"]),
        ("profile sphere --until 5", &["--until", "0.01% to 50%"]),
        ("profile sphere --until 1% --frames 5", &["--frames", "--until"]),
        ("profile sphere --compare a.json --against b", &["--compare", "--against"]),
        ("profile sphere --device cpu --device cpu --csv a.csv", &["--csv", "one device only", "2 of --device"]),
        ("profile sphere --device cpu --device cpu --against b", &["--against", "one device only"]),
    ] {
        bad(&here, line, 2, words);
    }
    let other = "profile sphere --set object.0.detail=1 --set camera.size=[16,16] --device cpu --frames 1";
    bad(&here, &format!("{other} --compare a.json"), 2, &["--set", "different things", "[16,12]", "[16,16]"]);
    bad(&here, &format!("profile {SMALL} --change light --device cpu --compare a.json"), 2, &["--change", "light"]);
}

#[test]
fn another_build_is_timed_in_turn() {
    let here = folder(&[("not.sh", "#!/bin/sh\necho hello\n"), ("text", "hello")]);
    let own = env!("CARGO_BIN_EXE_milkglass");
    let line = format!("profile {SMALL} --device cpu --frames 12 --against {own} --save a.json");
    let (out, err) = good(&here, &line);
    for words in ["both compute bit for bit the same result", "other build against this build:", "seed 1"] {
        assert!(out.contains(words), "{words}: {out}");
    }
    assert!(err.contains(" starts of 2 rounds, about ") && err.contains("; a verdict takes "), "{err}");
    assert!(!out.contains("undecided") && !out.contains("too few"), "{out}");
    let found = json(&here, "a.json");
    let variants = found["samples"]["variants"].as_array().unwrap();
    let rounds = variants[1]["frame_ms"].as_array().unwrap().len();
    assert!(variants.len() == 2 && rounds >= 18 && out.contains(&format!("{rounds} rounds in {} starts", rounds / 2)));
    let rows = found["comparison"][0]["rows"].as_array().unwrap();
    assert!(rows.iter().any(|row| row["what"] == "gather") && rows.last().unwrap()["what"] == "frame", "{rows:?}");

    for program in ["./nowhere", "./text"] {
        let line = format!("profile {SMALL} --device cpu --against {program}");
        bad(&here, &line, 2, &["--against", "could not be started", program]);
    }
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        let path = here.path().join("not.sh");
        std::fs::set_permissions(path, std::fs::Permissions::from_mode(0o755)).unwrap();
        for program in ["./not.sh", "/bin/true"] {
            let line = format!("profile {SMALL} --device cpu --against {program}");
            bad(&here, &line, 2, &["--against", "has no `profile --serve`", program]);
        }
    }
    // A refusal of both builds is printed once, in their words.
    let wrong = format!("profile sphere --set object.0.detale=1 --against {own}");
    bad(&here, &wrong, 2, &["detale"]);
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn devices_stand_side_by_side() {
    let here = folder(&[]);
    let (out, _) = good(&here, &format!("profile {SMALL} --device cpu --device cpu --device cpu --frames 11"));
    for words in ["cpu, run 3: the f64", "cpu and cpu, run 2 compute bit for bit the same", "cpu, run 3 against cpu:"] {
        assert!(out.contains(words), "{words}: {out}");
    }
    assert!(out.contains("hold together with 95 %") && !out.contains("undecided"), "{out}");
    // A comparison that the budget cuts short has no verdict.
    let (out, err) = good(&here, &format!("profile {SMALL} --device cpu --device cpu --frames 20 --budget 0"));
    assert!(err.contains("--budget ends it after about 1 start, and all rows stay undecided"), "{err}");
    assert!(out.contains("cpu, run 2 against cpu: undecided: about ") && !out.contains("no difference"), "{out}");
}

#[test]
fn frames_are_timed_until_the_interval_is_narrow() {
    let here = folder(&[]);
    let (out, _) = good(&here, &format!("profile {SMALL} --device cpu --until 50% --save a.json"));
    assert!(!out.contains("time ran out"), "{out}");
    assert!(json(&here, "a.json")["frames"].as_u64().unwrap() >= 11);
    let (out, _) = good(&here, &format!("profile {SMALL} --device cpu --until 0.01% --budget 0"));
    assert!(out.contains("time ran out before --until: the interval of") && out.contains("without bound"), "{out}");
}
