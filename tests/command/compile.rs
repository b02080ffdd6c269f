//! `compile`: what RADV makes of kernels for GPUs that are not here. Left out where RADV is not installed.

use super::conform::planted;
use crate::shell::{bad, folder, good, program, read, said as said_by};

/// In a folder with a baseline `a.csv` of two families, and a kernel.
fn wrong_calls_are_refused(here: &tempfile::TempDir) {
    for (line, code, words) in [
        ("compile --for navi21", 2, &["no scene is given", "or --all"][..]),
        ("compile sphere --for navi21,,vega10", 2, &["--for", "not the name of a family"]),
        ("compile sphere --for navi21 --device 0", 2, &["--device", "--for here only"]),
        ("compile sphere --for here --device cpu", 2, &["--device", "no compiler"]),
        ("compile sphere --for polaris10 --baseline a.csv", 2, &["a.csv", "found polaris10"]),
        ("compile sphere --for navi21 --csv a.csv --baseline a.csv", 2, &["--csv", "the same file as --baseline"]),
        ("compile sphere --for navi21 --baseline spill.comp", 2, &["spill.comp", "not what compile writes"]),
        ("compile sphere --for navi21 --replace view/shade=spill.comp", 2, &["spill.comp"]),
    ] {
        bad(here, line, code, words);
    }
}

/// Compares with a baseline `a.csv` that may not be written.
fn a_protected_baseline_is_read(here: &tempfile::TempDir) {
    let path = here.path().join("a.csv");
    let before = std::fs::metadata(&path).unwrap().permissions();
    let mut protected = before.clone();
    protected.set_readonly(true);
    std::fs::set_permissions(&path, protected).unwrap();
    good(here, "compile sphere --set object.0.detail=2 --for navi21 --baseline a.csv");
    std::fs::set_permissions(path, before).unwrap();
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_spill_is_found_without_the_gpu() {
    let here = folder(&[]);
    let line = "compile sphere --set object.0.detail=2 --for";
    let (_, err) = said_by(&program(&here, &format!("{line} nonsense")).output().unwrap());
    if err.contains("there is no RADV") {
        println!("not tested: RADV is not installed");
        return;
    }
    // Without a file of the others: it would be a baseline that lacks this one. `bad` looks for files.
    bad(&here, &format!("{line} navi21,nonsense --csv a.csv"), 1, &["nonsense: ", "a compiler failed"]);
    let (out, _) = good(&here, &format!("{line} navi21,vega10 --csv a.csv --json a.json --isa code"));
    let json = read(&here, "a.json");
    assert!(json.contains("\"device\": \"Null hardware (RADV VEGA10)") && json.contains("\"VGPRs\": "), "{json}");
    for family in ["navi21", "vega10"] {
        let code = read(&here, &format!("code/{family}/geometry-refit-block.txt"));
        assert!(code.contains("==== Assembly") && code.contains("s_endpgm"), "{code}");
    }
    for words in
        ["navi21: Null hardware", "vega10: Null hardware", "registers", "waves", "transport/blocks/gather/direct"]
    {
        assert!(out.contains(words), "{words}: {out}");
    }
    let rows = read(&here, "a.csv");
    assert!(rows.starts_with("compiler,kernel,constants,statistic,value\n"), "{rows}");
    let (again, _) = good(&here, &format!("{line} navi21,vega10 --csv b.csv --baseline a.csv"));
    assert!(rows == read(&here, "b.csv") && again.contains("transport/blocks/push"), "{again}");
    a_protected_baseline_is_read(&here);
    // A table of its own for each invocation, too large for registers.
    planted(&here, "spill.comp", "max(sum + held(sum), vec3(0))");
    let text = read(&here, "spill.comp").replacen(
        "void main()",
        "vec3 held(vec3 sum) {\n    float many[999];\n    for (uint i = 0u; i < 999u; i++) many[(i * 7u) % 999u] = sum.x * float(i);\n    \
         return vec3(many[uint(abs(sum.y)) % 999u]);\n}\n\nvoid main()",
        1,
    );
    std::fs::write(here.path().join("spill.comp"), &text).unwrap();
    let spilt = format!("{line} navi21 --baseline a.csv --replace transport/blocks/push=spill.comp");
    let said = bad(
        &here,
        &spilt,
        1,
        &["navi21: transport/blocks/push [ALIVE = 7", "]: scratch 0 -> ", "worse than those of the baseline"],
    );
    assert!(!said.contains("gather/direct"), "{said}");
    let (out, _) = good(&here, &format!("{line} navi21 --replace transport/blocks/push=spill.comp"));
    let change = out.lines().find(|line| line.contains("built-in -> yours: ")).unwrap_or_default();
    assert!(change.starts_with("transport/blocks/push [") && change.contains("scratch 0 -> "), "{out}");
    bad(&here, &format!("{line} navi21 --baseline none.csv"), 2, &["none.csv", "could not be read"]);
    wrong_calls_are_refused(&here);
    // A compiler that takes too long over a kernel: minutes over this table.
    std::fs::write(here.path().join("long.comp"), text.replace("999", "200000000")).unwrap();
    let module = "compile-navi21-transport-blocks-push.spv";
    // On a machine that is busy it may not come as far as this kernel in a few seconds.
    let ends = |seconds: u32| {
        let long = format!("{line} navi21 --timeout {seconds} --replace transport/blocks/push=long.comp");
        let output = program(&here, &long).output().unwrap();
        assert_eq!(output.status.code(), Some(1));
        said_by(&output).1.contains(&format!("its module is {module}"))
    };
    assert!([6, 12, 24].into_iter().any(ends), "no time was enough");
    let words = std::fs::read(here.path().join(module)).unwrap();
    assert_eq!(words[..4], 0x0723_0203_u32.to_le_bytes());
}

#[test]
#[ignore = "slow: compiles the pipelines of all built-in scenes and every other kernel"]
fn all_built_in_scenes_compile() {
    let here = folder(&[]);
    let output = program(&here, "compile --all --for vega10 --csv a.csv").output().unwrap();
    let (out, err) = said_by(&output);
    if err.contains("there is no RADV") {
        println!("not tested: RADV is not installed");
        return;
    }
    assert!(output.status.success(), "{out}{err}");
    let count = out.lines().find_map(|line| line.split_once(" pipelines of ")).unwrap();
    let kernels: Vec<&str> = count.1.split(' ').collect();
    assert!(count.0.parse::<usize>().unwrap() > 200 && kernels[0] == kernels[2], "{out}");
    assert!(read(&here, "a.csv").contains("vega10,layers/relief"), "{out}");
}
