//! `vary`: what it refuses, proves, times and writes.

use serde_json::Value;

use crate::shell::{bad, folder, good, names, read};

const SMALL: &str = "sphere --set object.0.detail=1 --set camera.size=[16,12]";

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn variants_are_proved_timed_and_written() {
    let here = folder(&[]);
    let axes = "--axis barriers=every,events --axis subgroup --axis queues";
    let (out, _) = good(&here, &format!("vary {SMALL} {axes} --frames 12 --seed 3 --json v.json --svg v.svg"));
    for words in [
        "barriers=every: bit for bit the default's: ",
        "barriers=events: bit for bit the default's: ",
        "queues=apart: bit for bit the default's: ",
        "12 rounds in 3 starts",
        "stage             barriers=elided ms",
        "variant",
        "gather",
    ] {
        assert!(out.contains(words), "{words}: {out}");
    }
    // No device has every size of subgroups.
    assert!(out.contains(": not run: it "), "{out}");
    let json: Value = serde_json::from_str(&read(&here, "v.json")).unwrap();
    let axes = json["axes"].as_array().unwrap();
    assert_eq!(
        axes.iter().map(|axis| axis["axis"].as_str().unwrap()).collect::<Vec<_>>(),
        ["barriers", "subgroup", "queues"]
    );
    assert!(json["schema"] == "milkglass-vary-1" && json["seed"] == 3 && json["scene"] == "sphere");
    let barriers = &axes[0];
    assert_eq!(barriers["default"], "elided");
    let timed = barriers["samples"]["variants"].as_array().unwrap();
    assert!(timed.len() == 3 && timed.iter().all(|one| one["frame_ms"].as_array().unwrap().len() == 12), "{timed:?}");
    for one in barriers["comparison"].as_array().unwrap() {
        let rows = one["rows"].as_array().unwrap();
        assert!(
            rows.iter().any(|row| row["what"] == "gather" && row["ratio"]["value"].as_f64().unwrap() > 0.0),
            "{one}"
        );
    }
    assert!(axes[1]["variants"].as_array().unwrap().iter().any(|one| one["lacks"].is_string()), "{}", axes[1]);
    let svg = read(&here, "v.svg");
    assert!(svg.contains("<svg") && svg.contains("barriers: how") && svg.contains("gather"), "{svg}");
    assert_eq!(names(here.path()), ["v.json", "v.svg"]);
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn the_pipeline_cache_is_timed_by_first_frames() {
    let here = folder(&[]);
    let (out, _) = good(&here, &format!("vary {SMALL} --axis cache=none,warm,disk --frames 1"));
    for words in ["cache=disk: bit for bit", "pipelines", "first frame", "second frame"] {
        assert!(out.contains(words), "{words}: {out}");
    }
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_group_of_one_stage_is_varied() {
    let here = folder(&[]);
    let (out, _) = good(&here, &format!("vary {SMALL} --axis group.push=32,128 --frames 1"));
    assert!(out.contains("group.push=32: bit for bit") && out.contains("group.push=128: bit for bit"), "{out}");
}

#[test]
fn axes_are_listed() {
    let here = folder(&[]);
    let (out, _) = good(&here, "vary --list");
    for words in ["descriptors: how", "push constants (default)", "lacks", "it has subgroups of"] {
        assert!(out.contains(words), "{words}: {out}");
    }
    let (out, _) = good(&here, "vary --list --axis memory --device cpu");
    assert!(out.contains("dedicated") && !out.contains("descriptors"), "{out}");
}

#[test]
fn what_is_no_axis_is_refused() {
    let here = folder(&[]);
    for (line, words) in [
        ("vary", &["SCENE", "a scene to run, or --list"][..]),
        ("vary sphere --axis barrier", &["--axis", "found barrier", "barriers"]),
        ("vary sphere --axis barriers=none", &["--axis", "found none", "elided, every"]),
        ("vary sphere --axis group.nothing=32", &["--axis", "found nothing", "gather"]),
        ("vary sphere --axis memory.gather=cached", &["only the axis group"]),
        ("vary sphere --device cpu", &["--device", "found the CPU"]),
        ("vary sphere --json nowhere/a.json", &["nowhere"]),
        ("vary nowhere.obj", &["nowhere.obj"]),
    ] {
        bad(&here, line, 2, words);
    }
    assert!(names(here.path()).is_empty());
}
