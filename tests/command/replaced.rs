//! `--replace` with kernels whose interface is not the built-in one's, and `--constants`.

use tempfile::TempDir;

use crate::shell::{bad, folder, good, program, read, said};

/// A ball small enough to compare quickly.
const BALL: &str = "[camera]\nsize = [16, 12]\n[[object]]\nshape = 'sphere'\ndetail = 1\nsize = 10\n\
                    material = { preset = 'marble' }\n[[light]]\ntype = 'directional'\ndirection = [1, 1, 1]\n\
                    irradiance = 3\n[transport]\nreceivers = 'faces'\n";
const KERNEL: &str = "transport/blocks/push";
/// The value that the built-in kernel writes, as its source has it.
const VALUE: &str = "max(sum, vec3(0))";

/// A folder with the ball and, in each of these files, the built-in kernel with the file's replacements.
fn kernels(files: &[(&str, &[(&str, &str)])]) -> TempDir {
    let here = folder(&[("a.toml", BALL)]);
    let (text, _) = good(&here, &format!("shader {KERNEL}"));
    for (name, changes) in files {
        let mut text = text.clone();
        for (from, to) in *changes {
            assert!(text.contains(from), "{from}");
            text = text.replace(from, to);
        }
        std::fs::write(here.path().join(name), text).unwrap();
    }
    here
}

fn constants(here: &TempDir, text: &str) {
    std::fs::write(here.path().join("c.toml"), format!("[\"{KERNEL}\"]\n{text}\n")).unwrap();
}

/// The comparison with the reference, with constants from `c.toml` or without.
fn line(file: &str, more: &str) -> String {
    format!("conform a.toml --replace {KERNEL}={file}{more}")
}

/// Whether the kernel with these constants conforms to the reference.
fn conforms(here: &TempDir, file: &str, text: &str) -> bool {
    constants(here, text);
    let output = program(here, &line(file, " --constants c.toml")).output().unwrap();
    let (out, err) = said(&output);
    match output.status.code() {
        Some(0) => true,
        Some(1) if err.contains("radiosity") => false,
        code => panic!("{file}, {text}: {code:?}\n{out}{err}"),
    }
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_kernel_may_have_specialization_constants_of_its_own() {
    let here = kernels(&[(
        "own.comp",
        &[
            (
                "void main() {",
                "layout(constant_id = 7) const float SCALE = 1.0;\nlayout(constant_id = 8) const bool DARK = false;\n\
                 layout(constant_id = 9) const int SHIFT = -2;\nlayout(constant_id = 10) const uint LENGTH = 64;\n\
                 shared float kept[2 * LENGTH];\nvoid main() {\n    kept[gl_LocalInvocationIndex] = 1.0;",
            ),
            (VALUE, "(DARK ? 0.0 : SCALE) * (kept[gl_LocalInvocationIndex] + float(SHIFT + 2)) * max(sum, vec3(0))"),
        ],
    )]);
    good(&here, &line("own.comp", ""));
    for (text, right) in [
        ("", true),
        ("SCALE = 1", true),
        ("SCALE = 1.5", false),
        ("7 = 1.5", false),
        ("DARK = true", false),
        ("SHIFT = -1", false),
        ("SHIFT = -2\nLENGTH = 128", true),
    ] {
        assert_eq!(conforms(&here, "own.comp", text), right, "{text}");
    }
    // A dumped case has the values as plain constants.
    constants(&here, "SCALE = 1.5");
    good(
        &here,
        &format!("dump push --fixture sliver -o case --no-validation --replace {KERNEL}=own.comp --constants c.toml"),
    );
    assert_eq!(program(&here, "replay case --no-validation").output().unwrap().status.code(), Some(1));
    good(&here, &format!("replay case --no-validation --replace {KERNEL}=own.comp"));
    let (out, err) = good(&here, &format!("profile a.toml --frames 2 --replace {KERNEL}=own.comp"));
    assert!(out.contains("ratio") && err.contains("conform to the reference"), "{out}{err}");
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_kernel_may_take_other_push_constants() {
    let block = "layout(push_constant, scalar) uniform push_block { Range range; };";
    let other = |members: &str, range: &str| {
        let length = "uint(blocks.length())";
        format!(
            "layout(push_constant, scalar) uniform push_block {{ {members} }};\n#define range Range({range}, {length})"
        )
    };
    let (more, indexed) = (
        block.replace("range;", "range; vec3 tint; float more[2]; uint bits;"),
        block.replace("range;", "range; float more[4];"),
    );
    let (less, half) = (other("uint first;", "first"), other("uint first; vec2 rest[4];", "first"));
    let none = "#define range Range(0, uint(blocks.length()))";
    let all_alive = ("layout(constant_id = 0) const uint ALIVE", "const uint ALIVE");
    let tinted = "(vec3(1) + tint) * (1.0 + more[0] - more[1]) * max(sum, vec3(0)) + float(bits)";
    let here = kernels(&[
        ("more.comp", &[(block, &more), (VALUE, tinted)]),
        ("less.comp", &[(block, &less)]),
        ("none.comp", &[(block, none), all_alive]),
        ("indexed.comp", &[(block, &indexed), (VALUE, "(1.0 + more[self.face % 4u]) * max(sum, vec3(0))")]),
        ("half.comp", &[(block, &half), (VALUE, "rest[3].xyx")]),
    ]);
    // What the program does not set is 0, unless the file says otherwise.
    for file in ["more.comp", "less.comp", "none.comp"] {
        good(&here, &line(file, ""));
    }
    for (text, right) in [
        ("tint = [0, 0, 0.5]", false),
        ("more = [0.25, 0.25]\nbits = 0", true),
        ("more = [0.25, 0]", false),
        ("bits = 1", false),
    ] {
        assert_eq!(conforms(&here, "more.comp", text), right, "{text}");
    }
    bad(
        &here,
        &line("indexed.comp", ""),
        2,
        &["indexed.comp: ", "24 bytes of push constants", "constants for indices"],
    );
    bad(&here, &line("half.comp", ""), 2, &["half.comp: ", "the program sets the first bytes only", "byte 8"]);
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_file_of_constants_is_checked() {
    let own = "layout(constant_id = 7) const float SCALE = 1.0;\nlayout(constant_id = 8) const bool DARK = false;\n\
               layout(constant_id = 9) const int SHIFT = 0;\nlayout(constant_id = 10) const uint COUNT = 1;\nvoid main() {";
    let used = "(DARK ? 0.0 : SCALE) * float(COUNT) * max(sum, vec3(0)) + float(SHIFT) + tint";
    let here = kernels(&[
        ("own.comp", &[("void main() {", own), (VALUE, used), ("{ Range range; }", "{ Range range; vec3 tint; }")]),
        ("own200.comp", &[("void main() {", &own.replace("= 7", "= 207")), (VALUE, "SCALE * max(sum, vec3(0))")]),
        ("plain.comp", &[]),
    ]);
    let own = line("own.comp", " --constants c.toml");
    for (text, words) in [
        ("SCALE = 'x'", &["c.toml:2: SCALE: ", "found \"x\"", "expected a number"][..]),
        ("SCALE = true", &["found true", "expected a number"]),
        ("SCALE = 1e300", &["found 1000000", "expected a number up to 3.4e38"]),
        ("\nDARK = 1", &["c.toml:3: DARK: ", "found 1", "true or false"]),
        ("COUNT = -1", &["found -1", "from 0 to 4294967295"]),
        ("SHIFT = 2147483648", &["from -2147483648 to 2147483647"]),
        ("SHIFT = 0.5", &["found 0.5", "a whole number"]),
        ("tint = [1, 2]", &["tint: ", "found 2", "expected 3 values"]),
        ("COUNT = [1, 2]", &["found 2", "expected 1 value"]),
        ("SCALES = 1", &["SCALES: no such constant", "SCALE, DARK, SHIFT, COUNT, tint"]),
        ("ALIVE = 7", &["ALIVE: the program sets this constant", "SCALE, DARK"]),
        ("range = 7", &["range: the program sets this constant"]),
        ("SCALE = 1\n7 = 1", &["has a value already"]),
        ("SCALE 1", &["c.toml:2: "]),
        (
            "[\"transport/blocks/pull\"]",
            &["c.toml:2: transport/blocks/pull: no shader replaces this kernel", "expected transport/blocks/push"],
        ),
    ] {
        constants(&here, text);
        bad(&here, &own, 2, words);
    }
    constants(&here, "SCALE = 1");
    bad(
        &here,
        &line("plain.comp", " --constants c.toml"),
        2,
        &["SCALE: no such constant", "has no constants of its own"],
    );
    bad(&here, &line("own200.comp", ""), 2, &["own200.comp: ", "SCALE with the id 207", "ids below 200"]);
    std::fs::write(here.path().join("c.toml"), "SCALE = 1\n").unwrap();
    bad(&here, &own, 2, &["c.toml:1: SCALE: not the table of a kernel", "transport/blocks/push"]);
    bad(&here, &line("own.comp", " --constants nowhere.toml"), 2, &["nowhere.toml: ", "could not be read"]);
    bad(&here, "conform a.toml --constants c.toml", 2, &["--replace"]);
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_kernel_may_declare_what_the_device_has() {
    let version = "#version 460";
    let wide = format!("{version}\n#extension GL_EXT_shader_explicit_arithmetic_types_int64 : require");
    let half = format!("{version}\n#extension GL_EXT_shader_explicit_arithmetic_types_float16 : require");
    let add = format!("{version}\n#extension GL_EXT_shader_atomic_float : require");
    let here = kernels(&[
        // An index by way of 64 bits, which the device is not opened with otherwise.
        (
            "wide.comp",
            &[(version, &wide), ("radiosity[self.face] =", "radiosity[uint((int64_t(self.face) << 20) >> 20)] =")],
        ),
        // 1, by way of 16 bits.
        (
            "half.comp",
            &[(version, &half), (VALUE, "float(min(float16_t(self.face + 1u), float16_t(1))) * max(sum, vec3(0))")],
        ),
        // A capability for which the program knows no feature.
        (
            "add.comp",
            &[(version, &add), ("void main() {", "shared float total;\nvoid main() {\n    atomicAdd(total, 1.0);")],
        ),
    ]);
    let (out, err) = good(&here, &format!("profile a.toml --frames 2 --replace {KERNEL}=wide.comp"));
    assert!(out.contains("ratio") && err.contains("conform to the reference"), "{out}{err}");
    // A replay opens the device with the same features: the validation layer, where there is one, reports nothing.
    good(&here, &format!("dump push --fixture sliver -o case --no-validation --replace {KERNEL}=wide.comp"));
    let output = program(&here, "replay case").output().unwrap();
    let (out, err) = said(&output);
    assert!(output.status.success() || err.contains("layer is not"), "{out}{err}");
    bad(&here, &line("add.comp", ""), 2, &["add.comp", "no feature for its capability", "found AtomicFloat32Add"]);
    let output = program(&here, &line("half.comp", "")).output().unwrap();
    let (out, err) = said(&output);
    match output.status.code() {
        Some(0) => assert!(out.contains("all conform"), "{out}{err}"),
        Some(3) => assert!(err.contains("Float16 needs the feature shaderFloat16"), "{out}{err}"),
        code => panic!("{code:?}\n{out}{err}"),
    }
}

/// The oracle of links, which five kernels include, and copies of it, one of which splits emitters of 100 times the
/// solid angle only.
#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn an_oracle_is_replaced_wherever_it_is_included() {
    const ORACLE: &str = "transport/links/refine/decide.glsl";
    let here = folder(&[("a.toml", BALL)]);
    let (text, _) = good(&here, &format!("shader {ORACLE}"));
    let put = |name: &str, from: &str, to: &str| {
        assert!(text.contains(from), "{from}");
        std::fs::write(here.path().join(name), text.replace(from, to)).unwrap();
    };
    put("same.glsl", "emitter.area >", "emitter.area >");
    put("coarser.glsl", "emitter.area >", "0.01 * emitter.area >");
    put("wrong.glsl", "emitter.area >", "emitter.aria >");
    let conform = "conform a.toml --set transport.scheme=links --no-validation";
    let (out, _) = good(&here, &format!("{conform} --replace {ORACLE}=same.glsl"));
    assert!(out.contains("refine") && out.contains("all conform"), "{out}");
    let (out, err) = said(&program(&here, &format!("{conform} --replace {ORACLE}=coarser.glsl")).output().unwrap());
    assert!(err.contains("stage:   refine"), "{out}{err}");
    let sweep = format!("pareto a.toml --quick --methods links --samples 20 --replace {ORACLE}=");
    bad(&here, &format!("{sweep}coarser.glsl"), 1, &["the replaced stage refine gives other values"]);
    let (out, err) = good(&here, &format!("{sweep}coarser.glsl --unchecked --csv a.csv --svg a.svg"));
    let first = "refine: other values than the reference, so what follows is unproved: refine of object 0";
    assert!(err.contains(first), "{out}{err}");
    assert!(out.contains("links, unproved") && read(&here, "a.svg").contains("links, unproved (angle)"), "{out}");
    let text = read(&here, "a.csv");
    let mut rows = csv::Reader::from_reader(text.as_bytes());
    let head = rows.headers().unwrap().clone();
    let place = |name: &str| head.iter().position(|column| column == name).unwrap();
    let (method, links, error) = (place("method"), place("links_per_face"), place("own_l2"));
    let rows: Vec<csv::StringRecord> = rows.records().map(|row| row.unwrap()).collect();
    // What conforms is proved, whatever was allowed.
    let (out, _) = good(&here, &format!("{sweep}same.glsl --unchecked"));
    assert!(out.contains("links, replaced") && !out.contains("unproved"), "{out}");
    let values = |name: &str, column: usize| -> Vec<f64> {
        rows.iter().filter(|row| &row[method] == name).map(|row| row[column].parse().unwrap()).collect()
    };
    let (before, after) = (values("links", links), values("links, unproved", links));
    assert!(before.len() == 4 && after.len() == 4 && before[0] > after[0], "{before:?} {after:?}");
    let (before, after) = (values("links", error), values("links, unproved", error));
    assert!(before[0] < after[0] && after[0] < 2.0, "{before:?} {after:?}");
    bad(&here, &format!("{sweep}wrong.glsl --unchecked"), 2, &["wrong.glsl:", "aria"]);
    bad(&here, "pareto a.toml --unchecked", 2, &["--replace"]);
    bad(&here, &format!("conform a.toml --replace {ORACLE}=same.glsl"), 2, &["a.toml does not run this kernel"]);
    let twice = format!("{sweep}same.glsl --replace transport/links/refine/count=same.glsl");
    bad(&here, &twice, 2, &["replaced twice", "found transport/links/refine/count"]);
    std::fs::write(here.path().join("a.spv"), [0; 8]).unwrap();
    bad(&here, &format!("{sweep}a.spv"), 2, &["is a part of kernels", "found SPIR-V"]);
    // A header and an entry point, `one`.
    let words = [0x0723_0203, 0x1_0300, 0, 9, 0, 4 << 16 | 15, 5, 1, u32::from_le_bytes(*b"one\0")];
    std::fs::write(here.path().join("b.spv"), words.map(u32::to_le_bytes).concat()).unwrap();
    let words = ["b.spv: its entry points", "found one", "expected a single one, main"];
    bad(&here, &format!("conform a.toml --replace {KERNEL}=b.spv"), 2, &words);
}

/// The edge form is in kernels of several methods, and only that of blocks has its nodes as a constant.
#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_file_is_proved_in_the_kernels_of_every_method() {
    const EDGE: &str = "dipole/form_factor/edge.glsl";
    let here = folder(&[("a.toml", BALL)]);
    let (text, _) = good(&here, &format!("shader {EDGE}"));
    let end = "    return 2 * k < NODES";
    assert!(text.contains(end), "{text}");
    let others = format!("#ifdef NODES\n    outer *= 0.9;\n#endif\n{end}");
    std::fs::write(here.path().join("others.glsl"), text.replace(end, &others)).unwrap();
    std::fs::write(here.path().join("same.glsl"), text).unwrap();
    let sweep = format!("pareto a.toml --quick --methods blocks --samples 20 --replace {EDGE}=");
    let err = bad(&here, &format!("{sweep}others.glsl"), 1, &["gather: ", "words conform", "stage:   brute"]);
    // Nothing but `eval` runs this one.
    let idle = err.lines().find(|line| line.contains("as nothing here runs it: ")).unwrap();
    assert!(idle.contains("transport/evaluate") && !idle.contains("transport/brute/near"), "{idle}");
    let (out, err) = good(&here, &format!("{sweep}same.glsl"));
    assert!(out.contains("blocks, replaced") && err.contains("brute: "), "{out}{err}");
}
