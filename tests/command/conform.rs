//! `conform` as build servers run it: results as they come, processes of their own, expectations, baselines.

use std::process::Stdio;
use std::time::{Duration, Instant};

use serde_json::Value;
use tempfile::TempDir;

use crate::shell::{bad, folder, good, program, read, said};

/// The built-in kernel `push` with a replacement in its text.
pub fn planted(here: &TempDir, file: &str, new: &str) {
    let (source, _) = good(here, "shader transport/blocks/push");
    let old = "max(sum, vec3(0))";
    assert!(source.contains(old), "{source}");
    std::fs::write(here.path().join(file), source.replace(old, new)).unwrap();
}

/// The results in a file, which has a line for each or one object with all.
pub fn results(here: &TempDir, name: &str) -> Vec<Value> {
    let text = read(here, name);
    let lines = text.lines().map(|line| serde_json::from_str::<Value>(line).unwrap_or_default());
    let found: Vec<Value> = lines.filter_map(|line| line.get("result").cloned()).collect();
    if !found.is_empty() {
        return found;
    }
    serde_json::from_str::<Value>(&text).unwrap()["results"].as_array().unwrap().clone()
}

/// Fixture and stage of each result, sorted.
pub fn keys(results: &[Value]) -> Vec<String> {
    let mut keys: Vec<String> = results.iter().map(|row| format!("{}/{}", row["fixture"], row["stage"])).collect();
    keys.sort();
    keys
}

/// Writes `slow.comp`, which takes some seconds per 64 `sums` in these groups, if they are few. Its loop is too short
/// for llvmpipe to end it.
pub fn slow(here: &TempDir, groups: &str, sums: usize) {
    planted(here, "slow.comp", &format!("max(sum + ({groups} ? 1e-30 * slow(sum.x) : 0), vec3(0))"));
    let text = read(here, "slow.comp");
    let sum: String = (0..sums).map(|k| format!("y += sin(x + {k}.0 * y); ")).collect();
    let function =
        format!("float slow(float x) {{ float y = x; for (int k = 0; k < 60000; k++) {{ {sum} }} return y; }}\n");
    std::fs::write(here.path().join("slow.comp"), text.replace("void main()", &(function + "void main()"))).unwrap();
}

#[test]
fn results_come_as_lines_and_as_one_object() {
    let here = folder(&[]);
    let line = "conform --fixture sliver --no-validation --stage push,gather --jsonl a.jsonl --json a.json";
    let (out, _) = good(&here, line);
    assert!(out.contains("2 comparisons, all conform"), "{out}");
    assert_eq!(results(&here, "a.jsonl"), results(&here, "a.json"));
    let whole: Value = serde_json::from_str(&read(&here, "a.json")).unwrap();
    let run = &whole["run"];
    assert_eq!((&run["schema"], &run["version"]), (&1.into(), &env!("CARGO_PKG_VERSION").into()));
    assert!(run["command"].as_str().unwrap().contains("--stage push,gather"), "{run}");
    assert!(run["date"].as_str().unwrap().ends_with('Z') && run["date"].as_str().unwrap().len() == 20, "{run}");
    // In a checkout the build asks git; cargo gives tests the same variable.
    assert_eq!(run["commit"].as_str(), option_env!("MILKGLASS_COMMIT"), "{run}");
    let whole_hash = |commit: &str| commit.trim_end_matches('+').len() == 40;
    assert!(!std::path::Path::new(".git").exists() || run["commit"].as_str().is_some_and(whole_hash), "{run}");
    let device = &run["devices"][0];
    assert!(device["vendor_id"].as_u64() > Some(0) && device["driver_version"].as_u64() > Some(0), "{device}");
    assert!(device["limits"]["binding_bytes"].as_u64() > Some(1 << 20), "{device}");
    for row in whole["results"].as_array().unwrap() {
        assert_eq!(row["verdict"], "conforms");
        assert!(row["seconds"].as_f64() > Some(0.0) && row["of_tolerance"].as_f64() < Some(1.0), "{row}");
        assert!(row["tolerance"].as_object().unwrap().contains_key("received") || row["stage"] == "push", "{row}");
        let hash = row["hashes"].as_object().unwrap().values().next().unwrap().as_str().unwrap();
        assert!(hash.len() == 16 && u64::from_str_radix(hash, 16).is_ok(), "{row}");
    }
    // The guide explains every key.
    let guide = include_str!("../../src/guide/drivers.md");
    let (run, row) = (run.as_object().unwrap(), whole["results"][0].as_object().unwrap());
    let (device, probe) = (device.as_object().unwrap(), device["probes"][0].as_object().unwrap());
    for key in run.keys().chain(device.keys()).chain(row.keys()).chain(probe.keys()).chain([&"farthest".to_string()]) {
        assert!(guide.contains(&format!("`{key}`")), "the guide does not explain {key}");
    }
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn four_parts_make_the_whole() {
    let here = folder(&[]);
    let (all, _) = good(&here, "conform --list");
    let mut parts = Vec::new();
    for part in 1..=4 {
        let (list, _) = good(&here, &format!("conform --list --shard {part}/4"));
        parts.extend(list.lines().map(str::to_string));
    }
    let mut all: Vec<String> = all.lines().map(str::to_string).collect();
    assert!(all.len() > 60, "{all:?}");
    all.sort();
    parts.sort();
    assert_eq!(all, parts);
    let line = "conform --filter ^sl(iver|ab,).* --stage shade,push,refit --no-validation";
    good(&here, &format!("{line} --json whole.json"));
    let mut parts = Vec::new();
    for part in 1..=4 {
        good(&here, &format!("{line} --shard {part}/4 --json part.json"));
        parts.extend(results(&here, "part.json"));
    }
    let whole = results(&here, "whole.json");
    assert!(whole.len() > 8, "{whole:?}");
    assert_eq!(keys(&whole), keys(&parts));
    bad(&here, "conform --shard 0/4 --list", 2, &["--shard", "found 0/4", "I/N"]);
    bad(&here, "conform --filter ( --list", 2, &["--filter", "unclosed group"]);
    bad(&here, "conform --filter nonsense --list", 2, &["--filter", "found nonsense", "sliver"]);
    bad(&here, "conform --fixture slivr --list", 2, &["--fixture", "found slivr", "sliver"]);
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_hang_and_a_lost_device_are_verdicts() {
    let here = folder(&[]);
    slow(&here, "true", 64);
    let kernel = "--replace transport/blocks/push=slow.comp --no-validation";
    let start = Instant::now();
    let line = format!("conform --filter ^(sliver|sphere.with.holes)$ --isolate --timeout 6 --jsonl a.jsonl {kernel}");
    let (sliver, holes) = ("--fixture sliver", "holes");
    let output = program(&here, &line).output().unwrap();
    let (out, err) = said(&output);
    assert_eq!(output.status.code(), Some(1), "{out}{err}");
    assert!(start.elapsed() < Duration::from_secs(60), "{:?}", start.elapsed());
    let found = results(&here, "a.jsonl");
    let row = found.iter().find(|row| row["fixture"] == "sphere with holes").unwrap();
    assert_eq!((&row["verdict"], &row["stage"]), (&"hung".into(), &"push".into()), "{row}");
    assert!(out.contains("HUNG") && err.contains("within 6 s") && err.contains(holes), "{out}{err}");
    let repeat = row["repeat"].as_str().unwrap();
    assert!(repeat.contains("--fixture 'sphere with holes'") && repeat.contains("--stage push"), "{repeat}");
    assert!(repeat.ends_with("--isolate --timeout 6"), "{repeat}");
    assert!(!repeat.contains(sliver) && found.len() == 2, "{found:?}");

    // The device's own limit ends it, here and in a replay.
    let mut command = program(&here, &format!("conform --isolate --jsonl b.jsonl --junit b.xml --dump b {kernel}"));
    let output = command.args(["--fixture", "sphere with holes"]).env("MILKGLASS_TIMEOUT", "0.5").output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{:?}", said(&output));
    let row = results(&here, "b.jsonl").swap_remove(0);
    assert_eq!((&row["verdict"], &row["stage"]), (&"device-failed".into(), &"push".into()), "{row}");
    let text = read(&here, "b.xml");
    assert!(text.contains("errors=\"1\"") && text.contains("device failed") && text.contains("repeat: "), "{text}");
    let output = program(&here, "replay b --no-validation").env("MILKGLASS_TIMEOUT", "0.5").output().unwrap();
    let (out, err) = said(&output);
    assert!(output.status.code() == Some(1) && out.contains("DEVICE FAILED"), "{out}{err}");
    planted(&here, "sound.comp", "max(sum, vec3(0))");
    good(&here, "replay b --no-validation --replace transport/blocks/push=sound.comp");
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_killed_run_leaves_what_was_done() {
    let here = folder(&[]);
    let mut run =
        program(&here, "conform --no-validation --isolate --jsonl a.jsonl").stdout(Stdio::null()).spawn().unwrap();
    let start = Instant::now();
    let lines = || std::fs::read_to_string(here.path().join("a.jsonl")).unwrap_or_default().lines().count();
    while lines() < 60 && start.elapsed() < Duration::from_secs(60) {
        std::thread::sleep(Duration::from_millis(20));
    }
    run.kill().unwrap();
    run.wait().unwrap();
    let done = results(&here, "a.jsonl");
    assert!(done.len() > 20, "{}", done.len());
    let (out, _) = good(&here, "compare a.jsonl a.jsonl");
    assert_eq!(out, "nothing has changed\n");
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn known_failures_are_no_failures_and_stale_ones_are() {
    let here = folder(&[]);
    planted(&here, "swap.comp", "max(sum.yxz, vec3(0))");
    let line = "conform --fixture sliver --stage push --no-validation";
    let wrong = format!("{line} --replace transport/blocks/push=swap.comp");
    let expect = |text: &str| std::fs::write(here.path().join("known.toml"), text).unwrap();
    expect("[[known]]\nfixture = \"sliver\"\nstage = \"push\"\ndevice = \"LLVMpipe\"\nwhy = \"bug 7\"\n");
    let (out, _) = good(&here, &format!("{wrong} --expect known.toml --junit a.xml"));
    assert!(out.contains("DIFFERS (known)") && out.contains("1 known failures"), "{out}");
    let text = read(&here, "a.xml");
    assert!(text.contains("skipped=\"1\"") && text.contains("known: DIFFERS, bug 7"), "{text}");
    let root = text.lines().find(|line| line.starts_with("<testsuites ")).unwrap();
    let names: Vec<&str> = root.split("=\"").filter_map(|part| part.rsplit(' ').next()).collect();
    assert_eq!(names[..names.len() - 1], ["name", "tests", "failures", "errors"], "{root}");
    bad(&here, &format!("{line} --expect known.toml"), 1, &["fixture sliver, stage push", "bug 7", "conforms now"]);
    expect("[[known]]\nstage = \"push\"\nwhy = \"bug 7\"\nflaky = true\n");
    good(&here, &format!("{line} --expect known.toml"));
    good(&here, &format!("{wrong} --expect known.toml"));
    expect("[[known]]\nfixture = \"dark\"\nwhy = \"not run here\"\n");
    good(&here, &format!("{line} --expect known.toml"));
    bad(&here, &format!("{wrong} --expect known.toml"), 1, &["beyond tolerance"]);
    expect("[[known]]\nstages = \"push\"\nwhy = \"x\"\n");
    bad(&here, &format!("{line} --expect known.toml"), 2, &["known.toml:2", "unknown field `stages`"]);
    expect("[[known]]\nstage = \"push\"\n");
    bad(&here, &format!("{line} --expect known.toml"), 2, &["known.toml:1", "why"]);
    bad(&here, &format!("{line} --expect none.toml"), 2, &["none.toml", "could not be read"]);
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn changes_are_shown_though_within_tolerance() {
    let here = folder(&[]);
    planted(&here, "off.comp", "max((1 + 1.5e-6) * sum, vec3(0))");
    planted(&here, "wrong.comp", "max(1.0001 * sum, vec3(0))");
    let line = "conform --no-validation --stage push";
    let only = "--filter ^(sliver|sphere.with.holes)$";
    good(&here, &format!("{line} {only} --json sound.json"));
    let (out, _) = good(&here, &format!("{line} {only} --jsonl off.jsonl --replace transport/blocks/push=off.comp"));
    assert!(out.contains("all conform"), "{out}");
    let (out, _) = good(&here, "compare sound.json off.jsonl");
    assert!(out.contains("shift") && out.contains("the mean error of radiosity is +1.5e-6"), "{out}");
    assert!(out.contains("other bits: 2") && !out.contains("failure"), "{out}");
    let (out, _) = good(&here, "compare sound.json off.jsonl --mean 1e-5 --used 1 --beyond 1");
    assert!(!out.contains("shift") && out.contains("other bits: 2"), "{out}");
    let wrong = "--replace transport/blocks/push=wrong.comp";
    let output =
        program(&here, &format!("{line} {only} {wrong} --json wrong.json --baseline sound.json")).output().unwrap();
    let (out, err) = said(&output);
    assert!(output.status.code() == Some(1) && out.contains("new failure: 2"), "{out}{err}");
    bad(&here, "compare sound.json wrong.json", 1, &["2 new failures"]);
    let (out, _) = good(&here, "compare wrong.json sound.json");
    assert!(out.contains("mended: 2"), "{out}");
    good(&here, &format!("{line} --fixture sliver --json one.json"));
    let (out, _) = good(&here, "compare sound.json one.json");
    // A report names where it failed: the device's numbers, the driver's version, the system, the layer.
    let (told, _) = good(&here, &format!("{line} --fixture sliver"));
    for words in [" (0x", "(version 0x", "\non ", "; no validation layer\n"] {
        assert!(told.contains(words), "{words}: {told}");
    }
    assert_eq!(out, "no comparison that both have has changed\nonly in the first: 1 (of sphere with holes)\n");
    std::fs::write(here.path().join("bad.json"), "{\"run\":{}}").unwrap();
    bad(&here, "compare sound.json bad.json", 2, &["bad.json:1", "missing field"]);
    bad(&here, "compare sound.json none.json", 2, &["none.json", "could not be read"]);
    let newer = read(&here, "sound.json").replace("\"schema\": 1", "\"schema\": 2");
    std::fs::write(here.path().join("newer.json"), newer).unwrap();
    bad(&here, "compare newer.json sound.json", 2, &["schema", "found 2", "expected 1"]);
    bad(&here, "conform --baseline newer.json --fixture sliver", 2, &["newer.json", "schema"]);
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn scenes_and_dumps_go_to_processes_of_their_own() {
    let here = folder(&[]);
    planted(&here, "swap.comp", "max(sum.yxz, vec3(0))");
    let line = "conform sphere --set object.0.detail=2 --set camera.size=[8,8] --stage push --isolate --no-validation";
    let (out, _) = good(&here, line);
    assert!(out.contains("1 comparisons, all conform"), "{out}");
    let wrong = format!("{line} --replace transport/blocks/push=swap.comp --dump d --minimize --junit a.xml");
    let output = program(&here, &wrong).output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{:?}", said(&output));
    bad(&here, "replay d --no-validation", 1, &["radiosity["]);
    bad(&here, &line.replace("push", "relief"), 2, &["--stage: no scene runs this stage"]);
    bad(&here, &line.replace("detail=2", "detail=x"), 2, &["object.0.detail"]);
    bad(&here, &format!("{line} --timeout 0"), 2, &["--timeout", "0.001"]);
}

#[cfg(feature = "shaderc")]
#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn coverage_is_of_what_ran() {
    let here = folder(&[]);
    planted(&here, "rare.comp", "rare(sum)");
    // A loop that no receiver enters.
    let rare =
        "vec3 rare(vec3 s) { for (int k = 0; s.x > 1e30 && k < 9; k++) s.x -= sinh(s.y); return max(s, 0.0); }\n";
    let text = read(&here, "rare.comp").replace("void main()", &format!("{rare}void main()"));
    std::fs::write(here.path().join("rare.comp"), text).unwrap();
    let line = "conform --fixture sliver --no-validation --stage push --replace transport/blocks/push=rare.comp";
    let (out, _) = good(&here, &format!("{line} --coverage c.csv"));
    let unreached = out.lines().find(|line| line.starts_with("instruction of GLSL.std.450, not reached: "));
    assert!(out.contains("coverage of ") && unreached.is_some_and(|line| line.contains("Sinh")), "{out}");
    let text = read(&here, "c.csv");
    let mut reader = csv::Reader::from_reader(text.as_bytes());
    let rows: Vec<csv::StringRecord> = reader.records().map(|row| row.unwrap()).collect();
    let state = |kind: &str, name: &str| {
        let row = rows.iter().find(|row| &row[1] == kind && &row[2] == name);
        row.map(|row| [row[3].to_string(), row[5].to_string()]).unwrap_or_else(|| panic!("{kind} {name}: {text}"))
    };
    assert_eq!(state("instruction", "OpFMul"), ["executed", "sliver"]);
    assert_eq!(state("capability", "Shader"), ["executed", "sliver"]);
    assert_eq!(state("instruction of GLSL.std.450", "Sinh"), ["not reached", ""]);
    assert_eq!(state("instruction", "OpImageWrite"), ["in no kernel that ran", ""]);
    assert!(state("limit", "bytes of push constants")[0].contains(" of "), "{text}");
    assert!(state("limit", "groups of a direct dispatch, first dimension")[0].contains(" of "), "{text}");
    assert_eq!(state("feature", "scalarBlockLayout"), ["in use", ""]);
    bad(&here, &format!("{line} --coverage c.csv --isolate"), 2, &["--coverage", "--isolate"]);
}
