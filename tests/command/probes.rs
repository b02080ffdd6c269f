//! What `conform` says of a device beside its comparisons: probes, and why values that are far off conform.

use serde_json::Value;
use tempfile::TempDir;

use super::conform::{keys, results};
use crate::shell::{bad, folder, good, program, read, said};

/// The kernel of the probes with a replacement in its text.
fn probes(here: &TempDir, old: &str, new: &str) {
    let (source, _) = good(here, "shader measure/probe");
    assert!(source.contains(old), "{source}");
    std::fs::write(here.path().join("probe.comp"), source.replace(old, new)).unwrap();
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn probes_are_part_of_a_run() {
    let here = folder(&[]);
    let line = "conform --fixture sliver --no-validation --stage push";
    for more in ["", " --isolate"] {
        let (out, _) = good(&here, &format!("{line} --json a.json{more}"));
        assert!(out.contains("of 15 probes of") && out.contains("1 comparisons, all conform"), "{out}");
        let whole: Value = serde_json::from_str(&read(&here, "a.json")).unwrap();
        let probes = whole["run"]["devices"][0]["probes"].as_array().unwrap();
        assert!(probes.len() == 15 && probes.iter().all(|probe| probe["needed"] == false || probe["right"] == true));
        // The guide's table has them all.
        let guide = include_str!("../../src/guide/drivers.md");
        for probe in probes {
            assert!(guide.contains(&format!("| `{}` |", probe["name"].as_str().unwrap())), "{probe}");
        }
    }
    // A wrong answer that kernels rely on is a failure; results have it as any other.
    let own = format!("{line} --replace measure/probe=probe.comp");
    probes(
        &here,
        "precise float rest = product + terms[2]",
        "precise float rest = product + terms[2] + 1.0 / 16777216.0",
    );
    for more in ["", " --isolate"] {
        let output = program(&here, &format!("{own} --jsonl b.jsonl --json b.json{more}")).output().unwrap();
        let (out, err) = said(&output);
        assert_eq!(output.status.code(), Some(1), "{out}{err}");
        assert!(err.contains("the device lacks what kernels rely on") && err.contains("fused in 64 of 64"), "{err}");
        assert!(err.contains("repeat:  milkglass devices --probe"), "{err}");
        let found = results(&here, "b.jsonl");
        assert_eq!(keys(&found), ["\"probes\"/\"no-contraction\"", "\"sliver\"/\"push\""]);
        assert_eq!(found, results(&here, "b.json"));
    }
    std::fs::write(here.path().join("known.toml"), "[[known]]\nfixture = \"probes\"\nwhy = \"bug 8\"\n").unwrap();
    good(&here, &format!("{own} --expect known.toml"));
    // Mended, it is no longer known to fail.
    let line = format!("{line} --expect known.toml");
    std::fs::write(here.path().join("c.xml"), "").unwrap();
    for more in ["", " --isolate --junit c.xml"] {
        bad(&here, &format!("{line}{more}"), 1, &["--expect: fixture probes (bug 8): it conforms now"]);
    }
    assert!(read(&here, "c.xml").contains("a known failure is gone"));
    // One that they avoid is not a failure, and is named.
    probes(&here, "answer = pushed[number(0) % 32]", "answer = pushed[number(0) % 31]");
    let (out, _) = good(&here, &own);
    assert!(out.contains("avoided: ") && out.contains("push-constants"), "{out}");
    // Where the process that probes does not end well, the run goes on.
    probes(&here, "counts[k] = groups[k]", "counts[k] = k < 2 ? 65535 : 1");
    let mut command = program(&here, &format!("{own} --isolate --timeout 3 --json c.json"));
    let output = command.output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{:?}", said(&output));
    let found = results(&here, "c.json");
    assert!(found.len() == 2 && found[0]["verdict"] == "hung" && found[0]["fixture"] == "probes", "{found:?}");
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn each_probe_tells_its_own_fault() {
    let here = folder(&[]);
    let (mut source, _) = good(&here, "shader measure/probe");
    for (old, new) in [
        ("uint(parts[k] == gl_SubgroupID)", "uint(parts[k] == gl_SubgroupID && k % 2 == 0)"),
        ("if (count >= last)", "if (count > last)"),
        ("before < 0 ? 7u", "before < 0 ? 8u"),
        ("found * 5 + k", "found * 5"),
    ] {
        assert!(source.contains(old), "{source}");
        source = source.replace(old, new);
    }
    std::fs::write(here.path().join("probe.comp"), source).unwrap();
    let line = "conform --fixture sliver --no-validation --stage push --json a.json --replace measure/probe=probe.comp";
    assert_eq!(program(&here, line).output().unwrap().status.code(), Some(1));
    let whole: Value = serde_json::from_str(&read(&here, "a.json")).unwrap();
    let probes = whole["run"]["devices"][0]["probes"].as_array().unwrap();
    for (name, found) in [
        ("full-subgroups", "partly filled in 64 of 64"),
        ("loop-bounds", "wrong in "),
        ("guarded-reads", "wrong in 1 of 64 lanes: lane 0 has 0x8, not 0x7"),
        ("private-arrays", "wrong in 64 of 64"),
    ] {
        let probe = probes.iter().find(|probe| probe["name"] == name).unwrap();
        assert!(probe["found"].as_str().unwrap().starts_with(found), "{probe}");
    }
}

#[test]
fn values_far_off_that_conform_explain_themselves() {
    let here = folder(&[]);
    let line = "conform --filter ^oblique.slivers$ --no-validation --stage pull,refit --json a.json";
    let (out, _) = good(&here, line);
    assert!(out.contains("* far off") && out.contains("by the floor") && out.contains("of its own element"), "{out}");
    let row = results(&here, "a.json").into_iter().find(|row| row["stage"] == "pull").unwrap();
    let why = row["farthest"].as_str().unwrap();
    assert!(why.starts_with("second_moments[") && why.contains("allowed"), "{why}");
    let marked = out.lines().find(|line| line.contains("  pull  ")).unwrap();
    assert!(marked.contains(">1e6*"), "{marked}");
}
