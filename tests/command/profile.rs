//! `profile`, `shader`, `--replace`, and the output of `conform` and `plan`, as users run them.

use super::conform::planted;
use crate::shell::{bad, folder, good, program, read, said};
use milkglass::measure::statistics::median;
use serde_json::Value;

const SMALL: &str = "sphere --set object.0.detail=1 --set camera.size=[16,12]";

/// A ball small enough to compare quickly.
const BALL: &str = "[camera]\nsize = [16, 12]\n[[object]]\nshape = 'sphere'\ndetail = 1\nsize = 10\nmaterial = { preset = 'marble' }\n\
                    [[light]]\ntype = 'directional'\ndirection = [1, 1, 1]\nirradiance = 3\n[transport]\nreceivers = 'faces'\n";

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_profile_is_printed_and_written() {
    let here = folder(&[]);
    let (out, _) = good(&here, &format!("profile {SMALL} --frames 3 --csv a.csv --json a.json --trace t.json"));
    for words in ["G FMA/s", "device memory at most", "gather", "counted by the kernels"] {
        assert!(out.contains(words), "{words}: {out}");
    }
    let json: serde_json::Value = serde_json::from_str(&read(&here, "a.json")).unwrap();
    let stages = json["stages"].as_array().unwrap();
    assert!(json["rates"]["copy_bytes_per_s"].as_f64().unwrap() > 0.0 && json["frames"] == 3);
    assert!(stages.iter().all(|row| row["work"]["invocations"].as_u64().unwrap() > 0), "{stages:?}");
    let mut csv = csv::Reader::from_path(here.path().join("a.csv")).unwrap();
    let column = csv.headers().unwrap().iter().position(|name| name == "share_fma").unwrap();
    let rows: Vec<_> = csv.records().map(Result::unwrap).collect();
    assert_eq!(rows.len(), stages.len());
    assert!(rows.iter().all(|row| row[column].parse::<f64>().unwrap() >= 0.0));

    // Every step lies within its frame, whichever way the clocks are aligned.
    let trace: serde_json::Value = serde_json::from_str(&read(&here, "t.json")).unwrap();
    let events: Vec<_> = trace["traceEvents"].as_array().unwrap().iter().filter(|event| event["ph"] == "X").collect();
    let frames: Vec<_> = events.iter().filter(|event| event["name"] == "frame").collect();
    let span = |event: &serde_json::Value| (event["ts"].as_f64().unwrap(), event["dur"].as_f64().unwrap());
    assert_eq!(frames.len(), 3);
    assert!(events.len() > 3 * stages.len());
    let clocks = trace["otherData"]["clocks"].as_str().unwrap();
    let off = clocks.strip_prefix("calibrated timestamps: the device's times are known by the host's to ");
    match off.map(|rest| rest.trim_end_matches(" us").parse::<f64>().unwrap()) {
        Some(off) => assert!(off < 1e3, "{clocks}"),
        None => assert!(!json["device"].as_str().unwrap().contains("llvmpipe"), "{clocks}"),
    }
    for event in &events {
        let (params, own) = (span(frames[event["args"]["frame"].as_u64().unwrap() as usize]), span(event));
        assert!(own.0 >= params.0 - 1.0 && own.0 + own.1 <= params.0 + params.1 + 1.0, "{event} in {params:?}");
    }
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_solver_is_profiled_as_far_as_it_goes() {
    let here = folder(&[]);
    let solve = format!("{SMALL} --transport diffusion --set transport.tolerance=0.1");
    let (out, _) = good(&here, &format!("profile {solve} --frames 3 --json a.json"));
    assert!(out.contains("counted by the kernels") && !out.contains("not counted"), "{out}");
    let json: serde_json::Value = serde_json::from_str(&read(&here, "a.json")).unwrap();
    let stages = json["stages"].as_array().unwrap();
    let dispatches =
        |stage: &str| stages.iter().find(|row| row["stage"] == stage).unwrap()["dispatches"].as_u64().unwrap();
    // A step of the solver takes two rounds of two and four more; there are up to 30 steps.
    assert!((6..90).contains(&dispatches("krylov_step")), "{}", dispatches("krylov_step"));
}

#[test]
fn a_frame_is_predicted_for_another_device() {
    let here = folder(&[]);
    let (out, _) = good(&here, &format!("profile {SMALL} --as h100 --by kernel --csv a.csv"));
    for words in ["as on NVIDIA H100 SXM: predicted, not measured; counted on", "submissions: 1, 20 us", "bound by"] {
        assert!(out.contains(words), "{words}: {out}");
    }
    let mut csv = csv::Reader::from_path(here.path().join("a.csv")).unwrap();
    let heads = csv.headers().unwrap().clone();
    let rows: Vec<_> = csv.records().map(Result::unwrap).collect();
    let row =
        |kernel: &str| rows.iter().find(|row| &row[3] == kernel).unwrap_or_else(|| panic!("no {kernel}: {rows:?}"));
    let cell = |kernel: &str, head: &str| -> f64 {
        row(kernel)[heads.iter().position(|known| known == head).unwrap()].parse().unwrap()
    };
    // The device at hand shares its work as the other one does: 128 invocations walk for each block.
    let count = "transport/blocks/link/count";
    assert!(cell(count, "invocations") >= 128.0 && cell(count, "longest_shared") > 0.0, "{out}");
    for kernel in [count, "transport/blocks/gather/direct", "lighting/irradiance"] {
        assert!(
            cell(kernel, "longest_steps") > 0.0 && cell(kernel, "longest_loads") > 0.0 && cell(kernel, "us") > 2.0,
            "{kernel}: {out}"
        );
    }
    // What the host waits for step by step has its rows, too.
    let (out, _) =
        good(&here, &format!("profile {SMALL} --transport walk --set transport.walks=500 --as h100 --by kernel"));
    assert!(out.contains("random_walk/fly"), "{out}");
    let one = format!("profile {SMALL} --as");
    bad(&here, &format!("{one} h100 --transport octree"), 2, &["--as: predicts what a device runs", "found octree"]);
    bad(&here, &format!("{one} h200"), 2, &["--as: no such device", "found h200", "expected h100, navi21"]);
    bad(&here, &format!("{one} h100 --device cpu"), 2, &["--as: measures a Vulkan device"]);
    bad(&here, &format!("{one} h100 --why"), 2, &["--as", "--why"]);
    bad(&here, &format!("{one} h100 --fail-work 1%"), 2, &["--as", "--fail-work"]);
}

#[cfg(feature = "shaderc")]
#[test]
fn a_kernel_of_the_users_own_is_predicted_beside_the_built_in_one() {
    let here = folder(&[]);
    let (source, _) = good(&here, "shader transport/blocks/push");
    // The work twice: the second write has the same values.
    let own = source.replacen("void main()", "void once()", 1) + "void main() { once(); once(); }\n";
    std::fs::write(here.path().join("own.comp"), own).unwrap();
    let line = format!("profile {SMALL} --as h100 --by kernel --replace transport/blocks/push=own.comp");
    let (out, _) = good(&here, &line);
    let told = out.lines().find(|line| line.starts_with("with the built-in kernels: ")).unwrap();
    assert!(told.contains("us; transport/blocks/push ") && !told.contains(','), "{out}");
    let words = ["--replace: kernels are compared by stage", "found --by kernel"];
    bad(&here, &line.replace("--as h100 ", ""), 2, &words);
}

#[cfg(feature = "shaderc")]
#[test]
fn a_stage_in_turn_runs_in_the_frame_and_is_replaced() {
    let here = folder(&[]);
    let (source, _) = good(&here, "shader transport/blocks/gather/edge");
    std::fs::write(here.path().join("same.comp"), &source).unwrap();
    let line = format!("profile {SMALL} --alternate gather --replace transport/blocks/gather/edge=same.comp");
    let words = ["--alternate: no kernel of this stage is replaced", "found link", "expected gather"];
    bad(&here, &line.replace("--alternate gather", "--alternate link"), 2, &words);
    let words = ["--alternate: a frame does not run this stage", "found gather", "expected shade, visibility"];
    bad(&here, &format!("{line} --change view"), 2, &words);
    bad(&here, &format!("profile {SMALL} --alternate gather"), 2, &["--replace <KERNEL=FILE>"]);
    bad(&here, &format!("{line} --as h100"), 2, &["--alternate", "--as"]);
    bad(&here, &format!("{line} --device cpu"), 2, &["--alternate: measures a Vulkan device", "found the CPU"]);
}

#[cfg(feature = "shaderc")]
#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_stage_is_timed_by_both_kernels_in_turn() {
    let here = folder(&[]);
    let (source, _) = good(&here, "shader transport/blocks/gather/edge");
    std::fs::write(here.path().join("same.comp"), &source).unwrap();
    // Each triangle is added once more, by a number that no compiler knows, and that sum is dropped.
    let again = "void add(uint k) {\n    vec3 s = sum;\n    once(k + uint(s.x < -1.0));\n    \
                 sum = mix(s, sum, lessThan(sum, vec3(-1)));\n    once(k);\n}\n\nvoid main";
    let more = source.replacen("void add(", "void once(", 1).replacen("void main", again, 1);
    std::fs::write(here.path().join("more.comp"), more).unwrap();
    let line = format!("profile {SMALL} --frames 27 --alternate gather --replace transport/blocks/gather/edge=");
    let (out, err) = good(&here, &format!("{line}same.comp --fail-slower 50% --junit a.xml --json a.json"));
    for words in
        ["27 rounds in 9 starts", "gather (replaced)", "its interval holds with 95 %", "gather: the same: flop"]
    {
        assert!(out.contains(words), "{words}: {out}");
    }
    assert!(!out.contains("all other rows") && err.contains("9 starts of 3 rounds"), "{out}{err}");
    let json: serde_json::Value = serde_json::from_str(&read(&here, "a.json")).unwrap();
    let rows = json["comparison"][0]["rows"].as_array().unwrap();
    assert!(rows.len() == 1 && rows[0]["what"] == "gather" && rows[0]["missing_rounds"] == 0, "{rows:?}");
    // All rounds of both kernels are kept: their starts' medians, without what warmed up, have the told median.
    let variants = &json["rounds"]["variants"];
    let warm_up = json["rounds"]["warm_up"].as_u64().unwrap() as usize;
    for k in 0..2 {
        let times = variants[k]["stages"][0]["ms"].as_array().unwrap();
        let start = |times: &[Value]| median(times[warm_up..].iter().map(|ms| ms.as_f64().unwrap()).collect());
        let own = median(times.chunks(3).map(start).collect());
        let told = rows[0]["ms"][k]["value"].as_f64().unwrap();
        assert!(times.len() == 27 && (own - told).abs() < 1e-9, "{own} {told} {warm_up} {variants}");
    }
    assert!(read(&here, "a.xml").contains("tests=\"1\""), "{}", read(&here, "a.xml"));
    let words = ["gather is at least", "slower; --fail-slower allows 5 %"];
    // Enough starts that other work during two of them decides nothing.
    let line = line.replace("--frames 27", "--frames 60");
    bad(&here, &format!("{line}more.comp --fail-slower 5%"), 1, &words);
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_profile_times_each_kernel() {
    let here = folder(&[]);
    good(&here, &format!("profile {SMALL} --frames 3 --by kernel --json k.json --trace t.json"));
    good(&here, &format!("profile {SMALL} --frames 3 --json s.json"));
    let rows = |file: &str| {
        let json: serde_json::Value = serde_json::from_str(&read(&here, file)).unwrap();
        json["stages"].as_array().unwrap().clone()
    };
    let (kernels, stages) = (rows("k.json"), rows("s.json"));
    // What a stage's kernels do is what the stage does; each has a time of its own.
    for key in ["dispatches", "flops"] {
        let number = |row: &serde_json::Value| row.get(key).unwrap_or(&row["work"][key]).as_u64().unwrap();
        let of = |rows: &[serde_json::Value], name: &str| {
            let of_stage = |row: &&serde_json::Value| row["stage"].as_str().unwrap().contains(name);
            rows.iter().filter(of_stage).map(number).sum::<u64>()
        };
        assert_eq!(of(&kernels, "blocks/link/"), of(&stages, "link"), "{key}");
        assert_eq!(of(&kernels, "blocks/gather/"), of(&stages, "gather"), "{key}");
    }
    let time = |name: &str| kernels.iter().find(|row| row["stage"] == name).unwrap()["device_ms"]["median"].clone();
    assert!(time("transport/blocks/link/count").as_f64().unwrap() > 0.0);
    assert!(read(&here, "t.json").contains("transport/blocks/gather/direct"));
    // A dispatch by itself, such as each level of a tree on a processor; together they are all.
    good(&here, &format!("profile {SMALL} --frames 3 --by dispatch --json d.json"));
    let parts = rows("d.json");
    let total: u64 = stages.iter().map(|row| row["dispatches"].as_u64().unwrap()).sum();
    assert_eq!(parts.len() as u64, total, "{parts:?}");
    assert!(parts.iter().any(|row| row["stage"] == "transport/blocks/gather/direct #1"), "{parts:?}");
    for key in ["flops", "instructions", "other_instructions", "shared_words", "bytes_loaded"] {
        let number = |row: &serde_json::Value| row["work"][key].as_u64().unwrap();
        let of = |rows: &[serde_json::Value]| rows.iter().map(number).sum::<u64>();
        assert_eq!((of(&parts), of(&stages)), (of(&kernels), of(&kernels)), "{key}");
    }
    // The roofline has each kernel that counts floats.
    good(&here, &format!("profile {SMALL} --frames 3 --by kernel --roofline r.svg"));
    let drawing = read(&here, "r.svg");
    assert!(["flop a byte", "G flop/s", "gather/edge"].iter().all(|words| drawing.contains(words)));
    for (line, words) in [
        (format!("profile {SMALL} --by kernel --device cpu"), "a device that"),
        (format!("profile {SMALL} --by kernel --device cpu --device cpu"), "one device only"),
    ] {
        bad(&here, &line, 2, &["--by kernel", words]);
    }
}

#[test]
fn a_profile_on_the_cpu_has_times_only() {
    let here = folder(&[]);
    let (out, _) = good(&here, &format!("profile {SMALL} --frames 1 --device cpu --csv a.csv"));
    assert!(out.contains("the reference in f64") && !out.contains("FMA/s"), "{out}");
    assert!(read(&here, "a.csv").contains(",gather,"));
    // The missing texture coordinates are generated.
    let blur = "--transport texture-blur --set transport.blur_texture=16";
    let (out, _) = good(&here, &format!("profile {SMALL} {blur} --frames 1 --device cpu"));
    assert!(out.contains("texture_blur"), "{out}");
    bad(&here, "profile sphere --frames 0", 2, &["--frames"]);
    bad(&here, "profile nowhere.toml", 2, &["nowhere.toml"]);
    // Before anything is measured.
    let drawn = format!("profile {SMALL} --frames 1 --roofline r.svg");
    let cpu = bad(&here, &format!("{drawn} --device cpu"), 2, &["--roofline: measures a Vulkan device; found the CPU"]);
    assert_eq!(cpu.lines().count(), 1, "{cpu}");
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_shader_is_printed_and_taken_back() {
    let here = folder(&[("a.toml", BALL)]);
    let (names, _) = good(&here, "shader");
    assert!(names.lines().any(|name| name == "transport/blocks/gather/direct") && names.contains("layout.glsl"));
    bad(&here, "shader transport/blocks/pus", 2, &["there is no such shader", "transport/blocks/push"]);
    let (layout, _) = good(&here, "shader layout.glsl");
    assert!(layout.contains("struct ObjectParams {"));
    let line = "profile a.toml --frames 2 --fail-work 1% --replace";
    planted(&here, "more.comp", "max(sum + min(exp(sum), vec3(0)), vec3(0))");
    let more = ["conform to the reference", "push: exp 0 -> ", "--fail-work allows 1 % more"];
    bad(&here, &format!("{line} transport/blocks/push=more.comp"), 1, &more);
    let (text, _) = good(&here, "shader transport/blocks/gather/direct");
    std::fs::write(here.path().join("my.comp"), text).unwrap();
    let (out, err) = good(&here, &format!("{line} transport/blocks/gather/direct=my.comp"));
    assert!(out.contains("ratio") && err.contains("conform to the reference"), "{out}{err}");
    assert!(out.contains(": the same: flop ") && !out.contains("undecided"), "{out}");
    good(&here, "conform a.toml --no-validation --replace transport/blocks/gather/direct=my.comp");
    // A group of 8 x 8: subgroups of 16, as of lavapipe with 512 bits, can't be asked to be full there.
    let shared = "transport/blocks/direct.glsl";
    let (part, _) = good(&here, &format!("shader {shared}"));
    let (text, _) = good(&here, "shader transport/blocks/gather/direct");
    let square = text
        .replace(&format!("#include \"{shared}\""), &part)
        .replace("local_size_x = GROUP_SIZE, local_size_x_id = GROUP_ID", "local_size_x = 8, local_size_y = 8")
        .replace("gl_WorkGroupSize.x", "64");
    let alone = square.replace("#include \"layout.glsl\"", "#define WITHOUT_SUBGROUPS\n#include \"layout.glsl\"");
    assert!(square.contains("local_size_y") && alone.contains("#define"), "{alone}");
    for (text, code, words) in [(square, 3, "#define WITHOUT_SUBGROUPS"), (alone, 0, "all conform")] {
        std::fs::write(here.path().join("square.comp"), text).unwrap();
        let line = "conform a.toml --stage gather --replace transport/blocks/gather/direct=square.comp";
        let mut command = program(&here, line);
        command.env("LP_NATIVE_VECTOR_WIDTH", "512").env("MESA_SHADER_CACHE_DISABLE", "true");
        let output = command.output().unwrap();
        let (out, err) = said(&output);
        assert!(output.status.code() == Some(code) && (out.contains(words) || err.contains(words)), "{out}{err}");
    }
    let (out, _) = good(
        &here,
        "pareto a.toml --quick --methods blocks --samples 20 --replace transport/blocks/gather/direct=my.comp",
    );
    assert!(out.contains("replaced ms"), "{out}");
}

#[test]
fn a_bug_in_a_shader_is_caught_and_located() {
    let here = folder(&[("a.toml", BALL)]);
    let (text, _) = good(&here, "shader transport/blocks/push");
    // 1 % too bright from receiver 40 on.
    let wrong = text.replace("max(sum, vec3(0))", "max(sum, vec3(0)) * (self.face < 40 ? 1.0 : 1.01)");
    assert_ne!(text, wrong);
    std::fs::write(here.path().join("my.comp"), wrong).unwrap();
    for line in ["conform a.toml --no-validation", "profile a.toml", "pareto a.toml --quick"] {
        let words = [
            "stage:   push",
            "radiosity[40].0: reference",
            "(0x",
            "repeat:  milkglass",
            "--replace transport/blocks/push=my.comp",
        ];
        bad(&here, &format!("{line} --replace transport/blocks/push=my.comp"), 1, &words);
    }
    // The printed repeat command, without the device's name.
    let output = program(&here, "conform a.toml --no-validation --stage push --replace transport/blocks/push=my.comp")
        .output()
        .unwrap();
    assert_eq!(output.status.code(), Some(1), "{}", said(&output).1);
    bad(&here, "conform a.toml --stage pushh", 2, &["--stage", "there is no such stage", "push"]);
}

#[cfg(feature = "shaderc")]
#[test]
fn a_shader_that_does_not_fit_is_named() {
    let here = folder(&[("a.toml", BALL)]);
    let (text, _) = good(&here, "shader transport/blocks/push");
    let line = text.lines().position(|line| line.contains("max(sum, vec3(0))")).unwrap() + 1;
    let put = |name: &str, from: &str, to: &str| {
        assert!(text.contains(from), "{from}");
        std::fs::write(here.path().join(name), text.replace(from, to)).unwrap();
    };
    put("syntax.comp", "max(sum, vec3(0))", "maximum(sum, vec3(0))");
    put("reads.comp", "WRITES(radiosity)", "UPDATES(radiosity)\nUPDATES(irradiance)");
    let reads = std::fs::read_to_string(here.path().join("reads.comp")).unwrap();
    std::fs::write(here.path().join("reads.comp"), reads.replace("max(sum, vec3(0))", "max(sum, irradiance[0])"))
        .unwrap();
    put("include.comp", "#include \"layout.glsl\"", "#include \"layout.glsl\"\n#include \"mine.glsl\"");
    let cases = [
        ("transport/blocks/push=syntax.comp", vec![format!("syntax.comp:{line}: error: 'maximum'")]),
        (
            "transport/blocks/push=reads.comp",
            vec!["can't take the place of transport/blocks/push".into(), "binds irradiance".into()],
        ),
        ("transport/blocks/push=include.comp", vec!["mine.glsl".into(), "neither beside".into()]),
        ("transport/blocks/push=none.comp", vec!["none.comp: the shader could not be read".into()]),
        ("transport/blocks/pish=syntax.comp", vec!["no such kernel".into(), "transport/blocks/push".into()]),
        ("transport/blocks/push", vec!["not a kernel and a file".into()]),
        ("view/texture_out=exit.comp", vec!["a.toml does not run this kernel".into(), "transport/blocks/push".into()]),
    ];
    std::fs::write(here.path().join("exit.comp"), good(&here, "shader view/texture_out").0).unwrap();
    for (pair, words) in cases {
        let words: Vec<&str> = words.iter().map(String::as_str).collect();
        bad(&here, &format!("conform a.toml --no-validation --replace {pair}"), 2, &words);
    }
    bad(&here, "profile a.toml --device cpu --replace view/texture_out=exit.comp", 2, &["Vulkan device only"]);
}

#[test]
fn conform_counts_distances() {
    let here = folder(&[("a.toml", BALL)]);
    let (out, _) = good(&here, "conform a.toml --no-validation --stage gather,push --json a.json");
    assert!(out.contains("units in the last place") && out.contains("all conform"), "{out}");
    let rows: serde_json::Value = serde_json::from_str(&read(&here, "a.json")).unwrap();
    for row in rows["results"].as_array().unwrap() {
        assert!(["gather", "push"].contains(&row["stage"].as_str().unwrap()), "{row}");
        let floats: u64 = row["histogram"].as_array().unwrap().iter().map(|count| count.as_u64().unwrap()).sum();
        assert!(floats > 0 && floats <= row["words"].as_u64().unwrap(), "{row}");
    }
}

#[test]
fn conform_says_what_it_did_not_compare() {
    let here = folder(&[("my scene.toml", BALL)]);
    let words = ["--stage: no scene runs this stage", "found relief"];
    bad(&here, "conform sphere --set object.0.detail=0 --set camera.size=[8,8] --stage shade,relief", 2, &words);
    bad(&here, "conform --only nonsense", 2, &["no fixture has this in its name; found nonsense"]);
    bad(&here, "conform sphere --only ball", 2, &["--only"]);
    bad(&here, "conform --set camera.fov=9", 2, &["--set"]);
    // `deform` runs at frame 30 but not at frame 0; then a scene without light transport.
    let small = "--set object.0.detail=2 --set camera.size=[8,8] --stage";
    let (out, _) = good(&here, &format!("conform twist --frame 30 {small} deform"));
    assert!(out.contains("deform"), "{out}");
    bad(&here, &format!("conform twist {small} deform"), 2, &["found deform"]);
    good(&here, &format!("conform sphere --transport cdrf {small} cdrf"));
}

#[cfg(feature = "shaderc")]
#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_failure_is_repeated_by_its_own_words() {
    let here = folder(&[("my scene.toml", BALL)]);
    let (text, _) = good(&here, "shader transport/blocks/push");
    std::fs::write(here.path().join("my.comp"), text.replace("max(sum, vec3(0))", "(2.0 * sum)")).unwrap();
    let arguments =
        ["profile", "my scene.toml", "--set", "object.0.detail=2", "--replace", "transport/blocks/push=my.comp"];
    let (out, err) = said(&program(&here, "").args(arguments).output().unwrap());
    let line =
        err.lines().find_map(|line| line.strip_prefix("repeat:  milkglass ")).unwrap_or_else(|| panic!("{out}{err}"));
    assert!(line.starts_with(
        "profile 'my scene.toml' --set object.0.detail=2 --replace transport/blocks/push=my.comp --device"
    ));
    let own = format!("exec \"$0\" {line}");
    let mut shell = std::process::Command::new("sh");
    let again = shell.current_dir(here.path()).args(["-c", &own, env!("CARGO_BIN_EXE_milkglass")]).output().unwrap();
    let differs = |text: &str| text.lines().find(|line| line.starts_with("differs:")).map(String::from);
    assert!(again.status.code() == Some(1) && differs(&said(&again).1) == differs(&err), "{err}");
    // A kernel that no picture of this scene runs, but a method of the sweep does.
    std::fs::write(here.path().join("far.comp"), good(&here, "shader transport/brute/far").0).unwrap();
    let sweep = "pareto sphere --set object.0.detail=1 --quick --methods brute --replace transport/brute/far=far.comp";
    let (out, err) = good(&here, sweep);
    assert!(err.contains("brute: ") && err.contains("conform to the reference"), "{out}{err}");
}

#[test]
fn a_plan_tells_what_another_scene_needs_otherwise() {
    let here = folder(&[("a.toml", BALL)]);
    let (out, _) = good(&here, "plan a.toml --device cpu --set light.0.shadows=false --diff a.toml");
    for words in ["lighting/shadow", "cut_short", "no light casts shadows"] {
        assert!(out.contains(words), "{words}: {out}");
    }
    assert!(!out.contains("transport/blocks/push"), "{out}");
    let (out, _) = good(&here, "plan a.toml --device cpu --diff a.toml");
    assert!(out.contains("need the same"), "{out}");
    let (out, _) = good(&here, "plan a.toml --device cpu --json a.json");
    assert!(out.contains("specialization constants") && out.contains("CHANNELS = 7, ORDER = 2"), "{out}");
    let plan: serde_json::Value = serde_json::from_str(&read(&here, "a.json")).unwrap();
    let gather = plan["stages"].as_array().unwrap().iter().find(|row| row["stage"] == "gather").unwrap().clone();
    assert_eq!(gather["dispatches"], 4);
    assert_eq!(gather["kernels"][0]["constants"]["CHANNELS"], 7);
    bad(&here, "plan a.toml --device cpu --diff nowhere.toml", 2, &["nowhere.toml"]);
    bad(&here, "plan a.toml --device cpu --diff a.toml --json b.json", 2, &["--json"]);
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_page_says_why_a_frame_takes_so_long() {
    let here = folder(&[]);
    let (out, _) = good(&here, &format!("profile {SMALL} --frames 5 --why --save a.json --trace t.json"));
    for words in
        ["bound by", "on the device: dispatch", "submission and wait", "ms to create", "the driver lacks VK_KHR"]
    {
        assert!(out.contains(words), "{words}: {out}");
    }
    let widest = out.lines().map(|line| line.chars().count()).max().unwrap();
    assert!(out.lines().count() <= 40 && widest <= 100, "{widest} columns\n{out}");
    let json: serde_json::Value = serde_json::from_str(&read(&here, "a.json")).unwrap();
    let why = &json["why"];
    for cost in ["dispatch", "dispatch_host", "submission"] {
        let interval = &why["overheads_us"][cost];
        let [value, low, high] = ["value", "low", "high"].map(|key| interval[key].as_f64().unwrap());
        assert!(0.0 < value && low <= value && value <= high, "{cost}: {interval}");
    }
    let sum = |of: &serde_json::Value| of.as_object().unwrap().values().map(|v| v.as_f64().unwrap()).sum::<f64>();
    let (parts, wall) = (&why["frame_ms"], why["frame_ms"]["wall"].as_f64().unwrap());
    assert!((sum(parts) - 2.0 * wall).abs() < 1e-6 * wall, "{parts}");
    let stages = why["stages"].as_array().unwrap();
    assert_eq!(stages.len(), json["stages"].as_array().unwrap().len());
    for stage in stages {
        assert!((sum(&stage["bounds"]) - 1.0).abs() < 1e-9, "{stage}");
        assert!(stage["pipelines"].as_u64().unwrap() > 0 && stage["creation_ms"].as_f64().unwrap() > 0.0, "{stage}");
        let row = json["stages"].as_array().unwrap().iter().find(|row| row["stage"] == stage["stage"]).unwrap();
        assert_eq!(stage["dispatches"], row["dispatches"]);
    }
    assert!(stages.iter().map(|stage| stage["barriers"].as_u64().unwrap()).sum::<u64>() > 0);

    // Counters go up with each step and down again after it.
    let trace: serde_json::Value = serde_json::from_str(&read(&here, "t.json")).unwrap();
    let events = trace["traceEvents"].as_array().unwrap();
    for (track, key) in [("memory, MB", "MB"), ("links", "links"), ("Gflop/s", "Gflop/s"), ("GB/s", "GB/s")] {
        let of_track = |event: &&serde_json::Value| event["ph"] == "C" && event["name"] == track;
        let values: Vec<f64> =
            events.iter().filter(of_track).map(|event| event["args"][key].as_f64().unwrap()).collect();
        assert!(values.len() >= 5 && values.iter().any(|value| *value > 0.0), "{track}: {values:?}");
    }
    bad(&here, &format!("profile {SMALL} --frames 1 --device cpu --why"), 2, &["--why", "found the CPU"]);
}
