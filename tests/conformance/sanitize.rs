//! `conform --sanitize`: each planted fault is found by its kind and its line of GLSL, and built-in kernels have none.

use milkglass::internals::gpu::{Given as Constants, replacements, source};
use milkglass::internals::layout::BufferId;
use milkglass::measure::fixtures::{EVERY_KERNEL, fixture};
use milkglass::measure::interpret::stage::Interpreter;
use milkglass::measure::interpret::{Finding, Kind, POISON};
use milkglass::measure::interpreted::{Sanitized, conform_interpreted};
use shaderc::OptimizationLevel;

use super::interpreter::{Given, compiled, kernel, run};

/// The line of a text that has these words, counted from 1.
fn line(text: &str, words: &str) -> u32 {
    let found = text.lines().position(|line| line.contains(words));
    found.unwrap_or_else(|| panic!("{words} is not in\n{text}")) as u32 + 1
}

/// Asserts that findings are of these kinds, files and lines: each of them, and nothing else.
fn assert_found(findings: &[Finding], expected: &[(Kind, &str, u32)], name: &str) {
    let fits = |finding: &Finding, (kind, file, line): &(Kind, &str, u32)| {
        finding.kind == *kind && finding.site.file.ends_with(file) && finding.site.line == *line
    };
    let all = expected.iter().all(|own| findings.iter().any(|finding| fits(finding, own)));
    let sole = findings.iter().all(|finding| expected.iter().any(|own| fits(finding, own)));
    assert!(all && sole, "{name}: not {expected:?}: {findings:#?}");
}

/// An atomic load of the first word.
const LOADED: &str = "#define LOADED atomicLoad(o[0], gl_ScopeDevice, gl_StorageSemanticsBuffer, gl_SemanticsRelaxed)";

/// Kernels with a fault in the line that says `here`: its kind, what comes before `main`, and the body. One that names
/// its group runs in two of them.
const FAULTS: &[(Kind, &str, &str)] = &[
    (Kind::Race, "shared uint s[64];", "s[lane] = lane;\no[lane] = s[(lane + 1) % 64]; // here"),
    (Kind::Race, "", "o[lane / 2] = lane; // here"),
    (Kind::Race, "", "if (lane == 0) o[0] = gl_WorkGroupID.x; // here"),
    // A barrier orders shared memory only.
    (Kind::Race, "", "o[lane] = lane;\nbarrier();\nif (a > 0) o[lane + 64] = o[63 - lane]; // here"),
    (
        Kind::Race,
        "",
        "o[1 + lane] = 1;\nif (lane > 0 && atomicAdd(o[0], 1) == 62) {\nuint sum = 0;\n\
         for (uint k = 1; k < 64; ++k) sum += o[1 + k]; // here\no[200] = sum; }",
    ),
    (
        Kind::Race,
        "shared uint s[2];",
        "if (lane == 0) s[0] = 0;\nbarrier();\natomicAdd(s[0], 1);\nif (lane == 9) s[0] = 3; // here",
    ),
    (Kind::Bounds, "", "o[lane] = x[lane + 64]; // here"),
    (Kind::Bounds, "", "o[lane + 250] = 1; // here"),
    (Kind::Bounds, "shared uint s[64];", "s[lane + a] = 1; // here\nbarrier();\no[lane] = s[63];"),
    (Kind::Bounds, "", "uint p[4] = uint[4](0, 0, 0, 0);\np[(lane + a) % 5] = lane; // here\no[lane] = p[b];"),
    (Kind::Undefined, "", "uint v;\nif (a > 100) v = 1;\nif (v == lane) // here\no[lane] = 1;"),
    (Kind::Undefined, "shared uint s[64];", "if (lane < 63) s[lane] = 1;\nbarrier();\no[lane] = s[lane]; // here"),
    (Kind::Undefined, "", "o[lane] = 2 * x[lane]; // here"),
    (Kind::Undefined, "shared uint s[2];", "atomicAdd(s[0], lane); // here"),
    (Kind::Undefined, "", "if (lane > 1) o[lane] = atomicMax(x[lane], 5); // here"),
    (Kind::Undefined, "", "atomicCompSwap(o[lane], x[lane], 5); // here"),
    (Kind::Undefined, "", "atomicCompSwap(o[lane], 0, x[lane]); // here"),
    (
        Kind::Undefined,
        "",
        "o[lane] = atomicLoad(x[lane], gl_ScopeDevice, gl_StorageSemanticsBuffer, gl_SemanticsRelaxed); // here",
    ),
    (Kind::Undefined, "", "uint v = subgroupAdd(x[lane]);\no[lane] = v; // here"),
    (Kind::Undefined, "", "uint v = subgroupInclusiveMax(x[lane]);\nif (lane >= 40) o[lane] = v; // here"),
    (Kind::Undefined, "", "bool v = subgroupAny(x[lane] > 30); // here\no[lane] = uint(v);"),
    (Kind::Undefined, "", "bool v = subgroupAll(x[lane] > 30); // here\no[lane] = uint(v);"),
    (Kind::Undefined, "", "bool v = subgroupAllEqual(x[lane]); // here\no[lane] = uint(v);"),
    (Kind::Undefined, "", "uvec4 v = subgroupBallot(x[lane] > 30); // here\no[lane] = v.x;"),
    (Kind::Undefined, "", "uint v = subgroupBallotBitCount(uvec4(x[lane])); // here\no[lane] = v;"),
    (Kind::Undefined, "", "bool v = subgroupInverseBallot(uvec4(x[lane])); // here\no[lane] = uint(v);"),
    (Kind::Race, "", "atomicCompSwap(x[2], 3, 5);\no[lane] = x[2]; // here"),
    (
        Kind::Race,
        "",
        "if (lane == 0) o[0] = 1;\nuint v = atomicCompSwap(o[0], 9, 5); // here\nif (v < 5) o[1 + lane] = v;",
    ),
    (Kind::Race, LOADED, "if (lane == 0) o[0] = 1;\nuint v = LOADED; // here\nif (v < 5) o[1 + lane] = v;"),
    // One that only loads hands nothing over.
    (
        Kind::Race,
        LOADED,
        "o[1 + lane] = 1;\nmemoryBarrierBuffer();\nuint v = LOADED;\nmemoryBarrierBuffer();\n\
         if (v == 0) o[70 + lane] = o[64 - lane]; // here",
    ),
    (Kind::Divergence, "", "if (lane < 32)\nbarrier(); // here"),
    (Kind::Divergence, "", "if (lane == a) return;\nbarrier(); // here\no[lane] = 1;"),
    (
        Kind::Divergence,
        "",
        "if (lane % 2 == 0) {\nuint v = subgroupShuffle(lane, gl_SubgroupInvocationID + 1); // here\no[lane] = v; }",
    ),
    (Kind::Divergence, "", "if (lane % 2 == 0) {\nbool v = subgroupAll(lane < b); // here\no[lane] = uint(v); }"),
];

/// What the kernels read: 1, 2, ..., and a word that nothing has written.
fn given(groups: u32) -> Given<'static> {
    let mut words: Vec<u32> = (1..=64).collect();
    words[40] = POISON;
    Given { buffers: vec![words, vec![0; 300]], groups: [groups, 1, 1], ..Given::default() }
}

#[test]
fn planted_faults_are_found_by_kind_and_line() {
    for (kind, before, body) in FAULTS {
        let text = kernel(before, body);
        for level in [OptimizationLevel::Zero, OptimizationLevel::Performance] {
            let groups = if body.contains("gl_WorkGroupID") { 2 } else { 1 };
            let (_, findings) = run(&compiled(&text, level), &given(groups), true);
            assert_found(&findings, &[(*kind, "own.comp", line(&text, "here"))], body);
            let invocations = findings.iter().all(|finding| finding.what.contains("invocation"));
            assert!(invocations, "{findings:#?}");
        }
    }
}

/// The same kernels without their fault.
#[test]
fn what_is_ordered_is_no_fault() {
    for (before, body) in [
        ("shared uint s[64];", "s[lane] = lane;\nbarrier();\no[64 * gl_WorkGroupID.x + lane] = s[(lane + 1) % 64];"),
        (
            "",
            "uint at = 128 * gl_WorkGroupID.x;\no[at + lane] = lane;\nmemoryBarrierBuffer();\nbarrier();\n\
             o[at + lane + 64] = o[at + 63 - lane];",
        ),
        (
            "",
            "if (gl_WorkGroupID.x > 0) return;\no[1 + lane] = 1;\nmemoryBarrierBuffer();\n\
             if (lane > 0 && atomicAdd(o[0], 1) == 62) {\nmemoryBarrierBuffer();\nuint sum = 0;\n\
             for (uint k = 1; k < 64; ++k) sum += o[1 + k];\no[200] = sum; }",
        ),
        // Nothing is written where the word is another one than the compared.
        ("", "atomicCompSwap(x[0], 9, 5);\no[64 * gl_WorkGroupID.x + lane] = x[0];"),
        // A value that does not matter.
        ("", "uint v = x[lane];\nif (lane < 40) o[64 * gl_WorkGroupID.x + lane] = v;"),
        (LOADED, "uint v = LOADED + o[0];\no[1 + 64 * gl_WorkGroupID.x + lane] = v;"),
        // The sum before a value that nothing wrote is one.
        ("", "uint v = subgroupExclusiveAdd(x[lane]);\nif (lane <= 40) o[64 * gl_WorkGroupID.x + lane] = v;"),
        (
            "",
            "atomicMax(o[0], lane);\nif (lane % 2 == 0) o[1 + lane + 64 * gl_WorkGroupID.x] = subgroupShuffle(lane, gl_SubgroupInvocationID ^ 2);",
        ),
    ] {
        let (_, findings) = run(&compiled(&kernel(before, body), OptimizationLevel::Performance), &given(2), true);
        assert!(findings.is_empty(), "{body}\n{findings:#?}");
    }
}

/// Faults in parts of built-in kernels: the file, the stage, what replaces what, the kind, and words of the line.
type Planted = (&'static str, &'static str, [&'static str; 2], Kind, &'static str);

const PLANTED: &[Planted] = &[
    (
        "geometry/shaft.glsl",
        "shadow",
        ["        exchange_in_subgroup();\n        for", "        for"],
        Kind::Race,
        "pool[meet ? place",
    ),
    (
        "geometry/shaft.glsl",
        "shadow",
        ["        exchange_in_subgroup();\n    }", "    }"],
        Kind::Race,
        "uint node = top",
    ),
    (
        "geometry/shaft.glsl",
        "shadow",
        ["top = WIDE * way.tops;", "pool[self.stack] = WIDE * way.tops;"],
        Kind::Race,
        "pool[self.stack] =",
    ),
    ("scan.glsl", "link", ["        barrier();\n        SUM near", "        SUM near"], Kind::Race, "SUM near"),
    ("scan.glsl", "link", ["sums[self - step] :", "sums[self - step - 1] :"], Kind::Bounds, "SUM near"),
    (
        "transport/blocks/direct.glsl",
        "gather",
        ["        barrier();\n        for", "        for"],
        Kind::Race,
        "all += sums[",
    ),
    (
        "transport/blocks/direct.glsl",
        "gather",
        ["BLOCK_RECEIVERS + slot] = sum;", "BLOCK_RECEIVERS + slot + 1] = sum;"],
        Kind::Bounds,
        "+ slot + 1] = sum;",
    ),
    (
        "transport/blocks/gather/direct",
        "gather",
        [
            "all_errors;\n    if (!sum_of_runs(self, all, all_errors)) return;\n    received[self.face] = only_group(all,",
            "all_errors, other;\n    if (!sum_of_runs(self, all, all_errors)) return;\n    received[self.face] = only_group(other,",
        ],
        Kind::Undefined,
        "received[self.face] = only_group",
    ),
    (
        "transport/blocks/push",
        "push",
        ["max(sum, vec3(0)),", "max(sum, vec3(0)) / (sum - sum),"],
        Kind::NotFinite,
        "radiosity[self.face] =",
    ),
    (
        "transport/blocks/push",
        "push",
        ["radiosity[self.face] =", "radiosity[self.face + 1] ="],
        Kind::Bounds,
        "radiosity[self.face + 1] =",
    ),
];

/// What else these faults lead to: what is planted, the kind, the end of the file's name, and words of the line.
const FURTHER: &[(&str, Kind, &str, &str)] = &[
    ("    }", Kind::Race, "lighting/shadow", "uint face = pool["),
    ("pool[self.stack] = WIDE * way.tops;", Kind::Race, "own.glsl", "uint node = top"),
    ("        SUM near", Kind::Race, "own.glsl", "SUM middle"),
    ("        SUM near", Kind::Race, "own.glsl", "SUM far"),
    ("sums[self - step - 1] :", Kind::Race, "transport/blocks/link/scan", "near[at.y] = i;"),
    ("sums[self - step - 1] :", Kind::Race, "transport/blocks/link/write.comp", "entries[first + place[j]]"),
    (
        "BLOCK_RECEIVERS + slot + 1] = sum;",
        Kind::Undefined,
        "transport/blocks/gather/direct",
        "received[self.face] = only_group(",
    ),
];

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn faults_planted_in_built_in_kernels_are_found_by_kind_and_line() {
    let [strip, sphere] = ["strip of 33 triangles (65 nodes)", "stiff sphere"].map(|name| fixture(name).unwrap());
    let here = tempfile::tempdir().unwrap();
    for (name, stage, [from, to], kind, words) in PLANTED {
        let text = source(name).unwrap();
        assert!(text.contains(from), "{name} lacks {from}");
        let text = text.replacen(from, to, 1);
        let file = here.path().join("own.glsl");
        std::fs::write(&file, &text).unwrap();
        let interpreter = Interpreter::new(replacements(name, &file, &Constants::default()).unwrap());
        let mut all = Sanitized::default();
        // Lists of a shaft go on in a second round where it meets many triangles.
        let fixture = if name.contains("shaft") { &sphere } else { &strip };
        all.add(&interpreter, fixture, &[(*stage).to_string()]).unwrap();
        let findings: Vec<Finding> = all.findings.into_iter().map(|(finding, _)| finding).collect();
        let mut expected = vec![(*kind, "own.glsl", line(&text, words))];
        for (_, kind, file, words) in FURTHER.iter().filter(|(fault, ..)| fault == to) {
            let other = source(file.trim_end_matches(".comp"));
            expected.push((*kind, file, line(other.as_deref().unwrap_or(&text), words)));
        }
        assert_found(&findings, &expected, &format!("{name}, {to}"));
        assert!(findings.iter().all(|finding| finding.kernel.contains(stage)), "{findings:#?}");
    }
}

/// Runs all stages of these fixtures; nothing may be wrong.
fn is_sound(names: &[&str]) {
    let (interpreter, mut all) = (Interpreter::default(), Sanitized::default());
    for name in names {
        let found = all.add(&interpreter, &fixture(name).unwrap(), &[]).unwrap();
        assert!(found.is_empty(), "{name}: {found:#?}");
    }
    assert!(all.dispatches > 5 * names.len() && all.executed > 1_000_000);
}

#[test]
fn built_in_kernels_have_no_fault_on_a_sliver() {
    is_sound(&["sliver"]);
}

#[test]
fn counts_of_groups_are_told_if_nothing_wrote_them_and_refused_if_no_device_has_so_many() {
    let fixture = fixture("sliver").unwrap();
    let first = fixture.steps.iter().position(|step| step.stage.name == "gather").unwrap();
    let mut state = fixture.state.clone();
    fixture.steps[..first].iter().for_each(|step| step.reference(&mut state));
    let [nothing, many] = [POISON, 70_000].map(|count| {
        let mut state = state.clone();
        bytemuck::cast_slice_mut::<u8, u32>(state.data.bytes_mut(BufferId::near_groups)).fill(count);
        Interpreter::default().run(&state, fixture.steps[first], true)
    });
    let findings = nothing.unwrap().findings(&state);
    let told = |finding: &&Finding| finding.kind == Kind::Undefined && finding.what.contains("near_groups");
    assert!(findings.iter().filter(told).count() > 1, "{findings:#?}");
    assert!(many.err().unwrap().to_string().contains("at most 65535"));
}

/// Of the fixtures that run every kernel, those that take more than ten seconds.
const LONG: &[&str] = &[
    "diffusion in two objects, the dipole in a third",
    "sphere, brute force",
    "three objects, receivers at pixels",
    "three objects, two of them with joints",
    "walk through clear and dark media",
];

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn built_in_kernels_have_no_fault() {
    assert!(LONG.iter().all(|name| EVERY_KERNEL.contains(name)));
    let overflow = ["links that overflow", "entries that overflow"];
    let short: Vec<&str> = EVERY_KERNEL.iter().copied().filter(|name| !LONG.contains(name)).chain(overflow).collect();
    is_sound(&short);
}

mod rare {
    #[test]
    #[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
    fn built_in_kernels_have_no_fault_in_long_runs() {
        super::is_sound(super::LONG);
    }
}

#[test]
fn the_interpreter_conforms_bit_for_bit_where_stages_are_exact() {
    let mut rows = Vec::new();
    let fixture = fixture("sliver").unwrap();
    conform_interpreted(&Interpreter::default(), &fixture, &[], &mut |event| {
        if let milkglass::measure::conform::Event::Ends(row) = event {
            rows.push(row.clone());
        }
    })
    .unwrap();
    let wrong: Vec<&String> = rows.iter().flat_map(|row| &row.faults).collect();
    assert!(wrong.is_empty(), "{wrong:#?}");
    // Lists of links are decisions, which have one result.
    let link = rows.iter().find(|row| row.stage == "link").unwrap();
    assert!(link.distances.words > 1000 && link.distances.ulp == 0, "{link:?}");
}
