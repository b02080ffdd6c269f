//! `dump`, `conform --dump` and `replay`: a stage that differs becomes files that repeat the difference.

use std::path::Path;

use milkglass::internals::layout::BufferId;

use super::amber;
use crate::shell::{bad, folder, good, names, program, read, said};

/// The built-in kernel `push` with a replacement in its text.
fn planted(here: &tempfile::TempDir, file: &str, old: &str, new: &str) {
    let (source, _) = good(here, "shader transport/blocks/push");
    assert!(source.contains(old), "{source}");
    std::fs::write(here.path().join(file), source.replace(old, new)).unwrap();
}

/// The only folder in this one.
fn only(folder: &Path) -> std::path::PathBuf {
    let all = names(folder);
    assert_eq!(all.len(), 1, "{all:?}");
    folder.join(&all[0])
}

/// Writes a bug report of a case that fails.
fn a_bug_report_says_all(here: &tempfile::TempDir, replay: &str) {
    let output = program(here, &format!("{replay} --bug bug.md")).output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", said(&output).1);
    let text = read(here, "bug.md");
    for words in ["# A compute shader differs", "words beyond tolerance: radiosity[", "- driver: ", "- system: "] {
        assert!(text.contains(words), "no {words:?} in {text}");
    }
    assert!(text.contains("milkglass replay off/") && text.contains("- transport/blocks/push ["), "{text}");
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_planted_fault_is_dumped_and_replayed() {
    let here = folder(&[]);
    planted(&here, "swap.comp", "max(sum, vec3(0))", "max(sum.yxz, vec3(0))");
    planted(&here, "off.comp", "max(sum, vec3(0))", "max(1.0001 * sum, vec3(0))");
    planted(
        &here,
        "lane.comp",
        "max(sum, vec3(0))",
        "max(sum, vec3(0)) * ((gl_LocalInvocationIndex & 3u) == 1 ? 0.5 : 1)",
    );
    planted(&here, "sound.comp", "max(sum, vec3(0))", "max(sum, vec3(0))");
    for fault in ["swap", "off", "lane"] {
        let kernel = format!("--replace transport/blocks/push={fault}.comp");
        let line = format!("conform --only oblique --stage push --no-validation {kernel} --dump {fault}");
        let output = program(&here, &line).output().unwrap();
        let (out, err) = said(&output);
        assert_eq!(output.status.code(), Some(1), "{out}{err}");
        assert!(err.contains("1 dispatch") && err.contains("differs: push of object 0 beyond tolerance"), "{err}");
        if fault == "lane" {
            assert!(err.contains("; wrong: 6 of 24 elements, all of them 1 modulo 4 [.#...#"), "{err}");
        }
        // The scheme as published does not run this stage.
        let case = only(&here.path().join(fault));
        let script = amber::read(&case);
        assert!(script.expectations > 30 && script.runs.len() == 2, "{}", script.expectations);
        bad(&here, &format!("replay {fault} --no-validation"), 1, &["radiosity[", "beyond tolerance", "1 case fails"]);
        let replay = format!("replay {} --no-validation", case.strip_prefix(here.path()).unwrap().display());
        good(&here, &format!("{replay} --replace transport/blocks/push=sound.comp"));
        bad(&here, &replay, 1, &["1 case fails"]);
        if fault == "off" {
            a_bug_report_says_all(&here, &replay);
        }
        // The least of it shows the same.
        let least = line.replace(&format!("--dump {fault}"), &format!("--dump {fault}-least --minimize"));
        assert_eq!(program(&here, &least).output().unwrap().status.code(), Some(1));
        amber::read(&only(&here.path().join(format!("{fault}-least"))));
        let replay = format!("replay {fault}-least --no-validation");
        bad(&here, &replay, 1, &["1 case fails"]);
        good(&here, &format!("{replay} --replace transport/blocks/push=sound.comp"));
    }
    a_missing_barrier_is_repeated(&here);
    planted(&here, "sound.comp", "max(sum, vec3(0))", "max(sum, vec3(0))");
    // Of many groups, the one that fails.
    planted(&here, "one.comp", "max(sum, vec3(0))", "max(sum, vec3(0)) * (group == 7 ? 0.5 : 1)");
    let kernel = "--replace transport/blocks/push=one.comp";
    let mut command = program(&here, &format!("dump push -o one --no-validation --minimize {kernel} --fixture"));
    let output = command.arg("sphere with holes").output().unwrap();
    let (out, err) = said(&output);
    assert!(out.contains("group 8 of 20") && out.contains("20 groups,") && out.contains("-> 1 group,"), "{out}{err}");
    amber::read(&here.path().join("one"));
    let size = |name: &str| std::fs::metadata(here.path().join("one").join(name)).unwrap().len();
    assert!(size("received.before") < 12 * 1269 && size("object_params.before") == 4, "{out}");
    bad(&here, "replay one --no-validation", 1, &["192 words", "radiosity[448]"]);
    good(&here, "replay one --no-validation --replace transport/blocks/push=sound.comp");
    // Its SPIR-V is a kernel like any other.
    let spirv = only(&here.path().join("swap")).join("transport-blocks-push.spv");
    std::fs::copy(spirv, here.path().join("swap.spv")).unwrap();
    good(&here, "dump push --fixture sliver -o good --no-validation");
    bad(&here, "replay good --no-validation --replace transport/blocks/push=swap.spv", 1, &["radiosity["]);
    bad(&here, "replay good --no-validation --replace transport/blocks/pull=swap.spv", 2, &["--replace"]);
}

/// A barrier is missing within a kernel.
fn a_missing_barrier_is_repeated(here: &tempfile::TempDir) {
    let kernel = "transport/blocks/coarse_solve/root";
    let (source, _) = good(here, &format!("shader {kernel}"));
    std::fs::write(here.path().join("sound.comp"), &source).unwrap();
    std::fs::write(here.path().join("bare.comp"), source.replace("barrier();", "")).unwrap();
    let line = "conform --filter ^sphere.with.holes$ --no-validation";
    let output = program(here, &format!("{line} --replace {kernel}=bare.comp --dump bare")).output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{:?}", said(&output));
    amber::read(&only(&here.path().join("bare")));
    bad(here, "replay bare --no-validation", 1, &["reference_level[0]", "1 case fails"]);
    good(here, &format!("replay bare --no-validation --replace {kernel}=sound.comp"));
}

#[test]
fn what_passes_is_dumped_too() {
    let here = folder(&[]);
    let (out, _) = good(&here, "dump push --fixture sliver -o case --no-validation");
    assert!(out.contains("push of object 0 on sliver, conforms"), "{out}");
    let files = names(&here.path().join("case"));
    for file in
        ["case.amber", "replay.json", "radiosity.expected", "transport-blocks-push.spv", "transport-blocks-push.spvasm"]
    {
        assert!(files.iter().any(|known| known == file), "{file} in {files:?}");
    }
    let text = std::fs::read_to_string(here.path().join("case/transport-blocks-push.spvasm")).unwrap();
    assert!(text.contains("OpEntryPoint GLCompute") && text.contains("OpFunctionEnd"), "{text}");
    amber::read(&here.path().join("case"));
    good(&here, "replay case --no-validation --bug bug.md");
    let text = read(&here, "bug.md");
    let again = "milkglass replay case --device 0 --no-validation --times 2\ncd case && amber ";
    assert!(text.starts_with("# A compute shader conforms on ") && text.contains(again), "{text}");
    bad(&here, "replay case --bug case/replay.json", 2, &["--bug", "ends in .md"]);
    // A second time over it.
    good(&here, "dump pull --fixture sliver -o case --no-validation");
    good(&here, "replay case --no-validation");
    bad(&here, "dump pushh --fixture sliver -o b", 2, &["no such stage", "found pushh"]);
    bad(&here, "dump push --fixture slivr -o b", 2, &["no such fixture", "found slivr"]);
    bad(
        &here,
        "dump relief --fixture sliver -o b --no-validation",
        2,
        &["does not run this stage", "found relief", "push"],
    );
    std::fs::create_dir(here.path().join("mine")).unwrap();
    std::fs::write(here.path().join("mine/notes"), "x").unwrap();
    bad(&here, "dump push --fixture sliver -o mine --no-validation", 2, &["-o", "not written over"]);
    bad(&here, "dump push --fixture sliver -o b --device cpu", 2, &["--device"]);
}

#[test]
fn a_broken_case_is_named() {
    let here = folder(&[]);
    good(&here, "dump push --fixture sliver -o case --no-validation");
    let case = here.path().join("case");
    let json = std::fs::read_to_string(case.join("replay.json")).unwrap();
    bad(&here, "replay none", 2, &["none", "not a folder"]);
    good(&here, "replay . --no-validation");
    let number = BufferId::blocks as usize;
    let [bound, unbound] = [number, number - 1].map(|number| format!("\"binding\": {number}"));
    let found = format!("found {number}");
    for (old, new, words) in [
        ("\"milkglass_case\": 1", "\"milkglass_case\": 9", &["milkglass_case", "found 9", "expected 1"][..]),
        ("\"stage\": \"push\"", "\"stages\": \"push\"", &["replay.json:4", "unknown field `stages`"]),
        ("radiosity.before", "../radiosity.before", &["not the name of a file"]),
        ("radiosity.before", "nowhere", &["nowhere", "could not be read"]),
        ("radiosity.before", "received.before", &["received.before", "it has 48 bytes", "expected 112 bytes"]),
        (&bound, &unbound, &["bindings", &found]),
        ("transport-blocks-push.spv", "radiosity.before", &["radiosity.before", "no SPIR-V"]),
        ("\"name\": \"blocks\"", "\"name\": \"received\"", &["two have the same name", "found received"]),
        ("\"constants\": [", "\"constants\": [1,", &["constants", "found 3", "expected 2"]),
        ("\"push_constants\": [", "\"push_constants\": [1,", &["push_constants", "found 12", "expected 8"]),
        (
            "\"bytes\": 48,\n          \"writes\"",
            "\"bytes\": 52,\n          \"writes\"",
            &["bindings.bytes", "found 52", "4 to 48"],
        ),
        ("float radius", "half radius", &["buffers.element", "found half radius"]),
    ] {
        assert!(json.contains(old), "{old} in {json}");
        std::fs::write(case.join("replay.json"), json.replacen(old, new, 1)).unwrap();
        bad(&here, "replay case --no-validation", 2, words);
    }
    std::fs::write(case.join("replay.json"), &json[..json.len() / 2]).unwrap();
    bad(&here, "replay case --no-validation", 2, &["replay.json:"]);
    std::fs::write(case.join("replay.json"), &json).unwrap();
    let spirv = std::fs::read(case.join("transport-blocks-push.spv")).unwrap();
    std::fs::write(case.join("transport-blocks-push.spv"), &spirv[..spirv.len() / 8 * 4]).unwrap();
    bad(&here, "replay case --no-validation", 2, &["transport-blocks-push.spv"]);
}
