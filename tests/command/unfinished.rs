//! A dispatch that does not end, by a hang, a crash or a signal, becomes a case that is replayed; and devices of the
//! same name.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use tempfile::TempDir;

use super::amber;
use super::conform::{planted, results, slow};
use crate::shell::{bad, folder, good, names, program, said};

/// The only folder in this one.
fn only(here: &TempDir, name: &str) -> PathBuf {
    let folder = here.path().join(name);
    let all = names(&folder);
    assert_eq!(all.len(), 1, "{all:?}");
    folder.join(&all[0])
}

/// Replays a dump with the faulty kernel, which must give this verdict, and with the sound one.
fn replayed(here: &TempDir, name: &str, verdict: &str, why: &str) {
    let output = program(here, &format!("replay {name} --no-validation")).output().unwrap();
    let (out, err) = said(&output);
    assert_eq!(output.status.code(), Some(1), "{out}{err}");
    assert!(out.contains(verdict) && err.contains(why) && err.contains("1 case fails"), "{out}{err}");
    planted(here, "sound.comp", "max(sum, vec3(0))");
    let sound = "--no-validation --replace transport/blocks/push=sound.comp";
    let (out, _) = good(here, &format!("replay {name} {sound}"));
    assert!(out.contains("passes"), "{out}");
}

#[test]
fn a_crash_becomes_a_case() {
    let here = folder(&[]);
    // Reads far beyond the end of shared memory, which llvmpipe does not prevent.
    planted(&here, "crash.comp", "max(sum + wild(sum.x), vec3(0))");
    let text = std::fs::read_to_string(here.path().join("crash.comp")).unwrap();
    let wild = "shared float wide[64];\nfloat wild(float x) { wide[gl_LocalInvocationIndex] = x; barrier();\n\
                return 1e-30 * wide[uint(1e9 * (2.0 + min(x, 1)))]; }\nvoid main()";
    std::fs::write(here.path().join("crash.comp"), text.replace("void main()", wild)).unwrap();
    let line = "conform --fixture sliver --isolate --no-validation --dump d --json a.json --device llvmpipe";
    let kernel = "--replace transport/blocks/push=crash.comp";
    let output = program(&here, &format!("{line} {kernel}")).output().unwrap();
    assert_eq!(output.status.code(), Some(1), "{:?}", said(&output));
    assert_eq!(results(&here, "a.json")[0]["verdict"], "crashed");
    let script = amber::read(&only(&here, "d"));
    assert!(script.expectations > 0 && script.fence.is_some());
    replayed(&here, "d", "CRASHED", "signal 11 ended it");
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_process_that_is_killed_leaves_a_case_and_the_run_goes_on() {
    let here = folder(&[]);
    slow(&here, "true", 64);
    let line = "conform --filter ^(sphere.with.holes|sliver)$ --isolate --timeout 6 --no-validation";
    let mut parent =
        program(&here, &format!("{line} --jsonl c.jsonl --dump d --replace transport/blocks/push=slow.comp"))
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .unwrap();
    let children = format!("/proc/{0}/task/{0}/children", parent.id());
    let begun = "{\"begins\":[\"sphere with holes\",\"push\"]}";
    let (start, mut killed) = (Instant::now(), false);
    while parent.try_wait().unwrap().is_none() {
        assert!(start.elapsed() < Duration::from_secs(100));
        std::thread::sleep(Duration::from_millis(20));
        let lines = std::fs::read_to_string(here.path().join("c.jsonl")).unwrap_or_default();
        if !killed && lines.contains(begun) {
            let child = std::fs::read_to_string(&children).unwrap();
            assert!(Command::new("kill").args(["-9", child.trim()]).status().unwrap().success(), "{child}");
            killed = true;
        }
    }
    let found = results(&here, "c.jsonl");
    assert!(killed && found.len() == 2, "{found:?}");
    let row = found.iter().find(|row| row["fixture"] == "sphere with holes").unwrap();
    assert_eq!((&row["verdict"], &row["stage"]), (&"crashed".into(), &"push".into()), "{row}");
    assert!(row["faults"][0].as_str().unwrap().contains("signal 9"), "{row}");
    assert!(amber::read(&only(&here, "d")).expectations > 0);
    replayed(&here, "d", "HUNG", "did not end within 6 s");
}

#[test]
fn a_step_leaves_the_case_of_all_that_it_may_not_end() {
    let here = folder(&[]);
    good(&here, "dump push --fixture sliver -o sound --no-validation");
    let (out, _) = good(&here, "replay sound --no-validation --timeout 60");
    assert!(out.contains("passes"), "{out}");
    bad(&here, "replay sound --no-validation --timeout 0", 2, &["--timeout", "0.001"]);
    let output = program(&here, "replay sound --no-validation --timeout 0.001").output().unwrap();
    assert!(output.status.code() == Some(1) && said(&output).0.contains("HUNG"), "{:?}", said(&output));
    std::fs::create_dir(here.path().join("cases")).unwrap();
    let step = "conform --child --device llvmpipe --fixture sliver --stage push --no-validation --unfinished 0";
    good(&here, &format!("{step} --dump cases"));
    // A case written before the dispatch, and one before the whole step in one submission.
    assert_eq!(names(&here.path().join("cases")), ["0", "1"]);
    good(&here, "replay cases --no-validation");
}

/// The manifest of an installed llvmpipe.
fn manifest() -> String {
    let listed = std::env::var("VK_DRIVER_FILES").unwrap_or_default();
    let folder = Path::new("/usr/share/vulkan/icd.d");
    let installed = names(folder).into_iter().map(|name| folder.join(name).display().to_string());
    let mut all = listed.split(':').map(str::to_string).chain(installed);
    all.find(|path| path.contains("lvp")).expect("a manifest of llvmpipe")
}

#[test]
fn devices_of_the_same_name_are_told_apart() {
    let here = folder(&[]);
    planted(&here, "swap.comp", "max(sum.yxz, vec3(0))");
    let first = manifest();
    let other = here.path().join("lvp.json").display().to_string();
    std::fs::copy(&first, &other).unwrap();
    let run = |line: &str| {
        let both = format!("{first}:{other}");
        program(&here, line).env("VK_DRIVER_FILES", &both).env("VK_ICD_FILENAMES", &both).output().unwrap()
    };
    let line = "conform --fixture sliver --stage push --no-validation --replace transport/blocks/push=swap.comp";
    let output = run(&format!("{line} --dump d --json a.json --junit a.xml"));
    let (out, err) = said(&output);
    assert_eq!(output.status.code(), Some(1), "{out}{err}");
    let found = results(&here, "a.json");
    let devices: Vec<&str> = found.iter().map(|row| row["device"].as_str().unwrap()).collect();
    assert!(devices.len() == 2 && devices[0].ends_with(" #0") && devices[1].ends_with(" #1"), "{devices:?}");
    assert!(found.iter().all(|row| row["repeat"].as_str().unwrap().contains(row["device"].as_str().unwrap())));
    assert_eq!(names(&here.path().join("d")).len(), 2);
    let text = std::fs::read_to_string(here.path().join("a.xml")).unwrap();
    assert!(devices.iter().all(|name| text.contains(*name)) && text.matches("<testcase").count() == 2, "{text}");
    let (out, err) = said(&run("devices"));
    assert!(devices.iter().all(|name| out.contains(*name)), "{out}{err}");
    let one = run("conform --fixture sliver --stage push --no-validation --json b.json --device 1");
    assert_eq!((one.status.code(), results(&here, "b.json")[0]["device"].as_str()), (Some(0), Some(devices[1])));
}

mod rare {
    use super::*;

    #[test]
    #[ignore = "rare: part of .ci/full, `cargo test --release -- --include-ignored`"]
    fn a_hang_becomes_a_case_of_the_group_that_hangs() {
        let here = folder(&[]);
        slow(&here, "group == 7", 600);
        let line = "conform --filter ^(sliver|sphere.with.holes)$ --isolate --timeout 6 --no-validation";
        let kernel = "--replace transport/blocks/push=slow.comp";
        let output = program(&here, &format!("{line} {kernel} --dump d --minimize --json a.json")).output().unwrap();
        let (out, err) = said(&output);
        assert_eq!(output.status.code(), Some(1), "{out}{err}");
        let verdicts: Vec<_> = results(&here, "a.json").iter().map(|row| row["verdict"].clone()).collect();
        assert_eq!(verdicts, ["conforms", "hung"], "{out}{err}");
        assert!(err.contains("push of object 0 on sphere with holes, does not end well"), "{err}");
        assert!(
            err.contains("killed, group 8 of 20") && err.contains("20 groups,") && err.contains("-> 1 group,"),
            "{err}"
        );
        let case = only(&here, "d");
        let script = amber::read(&case);
        assert_eq!((script.fence, script.runs[0].1), (Some(3000), [1, 1, 1]));
        let files = names(&case);
        assert!(
            files.contains(&"radiosity.expected".into()) && !files.contains(&"radiosity.device".into()),
            "{files:?}"
        );
        replayed(&here, "d", "HUNG", "did not end within 6 s");
        // The reader may change the time.
        let json = std::fs::read_to_string(case.join("replay.json")).unwrap();
        assert!(json.contains("\"seconds\": 6.0"), "{json}");
        std::fs::write(case.join("replay.json"), json.replace("\"seconds\": 6.0", "\"seconds\": -1.0")).unwrap();
        bad(&here, "replay d --no-validation", 2, &["replay.json", "seconds", "found -1"]);
    }
}
