//! Files that an earlier version wrote: `tests/results/N` has those of version N of their formats, as it first was.
//! Whoever changes a format in a way that these cannot be read adds a number, and a folder.

use std::path::Path;

use crate::shell::{bad, folder, good, read};

#[test]
fn files_of_the_first_version_are_read() {
    let old = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/results/1");
    let results = std::fs::read_to_string(old.join("results.jsonl")).unwrap();
    let other = results.replace("\"verdict\":\"conforms\"", "\"verdict\":\"differs\"");
    let here = folder(&[("other.jsonl", &other)]);
    let old = old.display();
    bad(&here, &format!("compare {old}/results.jsonl other.jsonl"), 1, &["3 new failures"]);
    let (out, _) = good(&here, &format!("profile --compare {old}/profile.json {old}/profile.json"));
    assert!(out.contains("gather"), "{out}");
    let (out, _) = good(&here, &format!("replay {old}/case --no-validation"));
    assert!(out.contains("passes"), "{out}");
    // Three courses: another kernel, and times by kernel, are drawn by themselves.
    good(&here, &format!("report -o r --device cpu --only history --history {old}/history.jsonl"));
    let page = read(&here, "r/index.html");
    assert!(page.matches("<svg").count() == 3 && page.contains(", transport/blocks/push=sound.comp</h3>"), "{page}");
}

#[test]
fn files_of_a_version_to_come_are_refused() {
    let old = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/results/1");
    let text = |file: &str| std::fs::read_to_string(old.join(file)).unwrap();
    let results = text("results.jsonl").replace("\"schema\":1", "\"schema\":2");
    let profile = text("profile.json").replace("\"schema\": 1", "\"schema\": 2");
    let history = text("history.jsonl").replace("\"schema\":1", "\"schema\":2");
    let here = folder(&[("results.jsonl", &results), ("profile.json", &profile), ("history.jsonl", &history)]);
    std::fs::create_dir(here.path().join("case")).unwrap();
    let case = text("case/replay.json").replace("\"milkglass_case\": 1", "\"milkglass_case\": 2");
    std::fs::write(here.path().join("case/replay.json"), case).unwrap();
    bad(&here, "compare results.jsonl results.jsonl", 2, &["version of the format", "found 2"]);
    bad(&here, "profile --compare profile.json profile.json", 2, &["version of the format", "found 2"]);
    bad(&here, "profile sphere --history history.jsonl", 2, &["history.jsonl:1: schema: ", "version of the format"]);
    bad(&here, "replay case --no-validation", 2, &["found 2"]);
}
