//! The interpreter and SPIR-V that no compiler makes: it is refused, or runs, and nothing panics.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

use super::interpreter::note;
use milkglass::internals::gpu::{kernel_names, spirv};
use milkglass::measure::interpret::{Kernel, Launched, MOST_BLOCKS, Memory, Part};
use milkglass::measure::statistics::Random;

/// A module with these declarations, after the usual ones, and these functions; `main` is the kernel.
fn assembled(declarations: &str, functions: &str) -> Vec<u32> {
    let text = format!(
        "OpCapability Shader
OpMemoryModel Logical GLSL450
OpEntryPoint GLCompute %main \"main\"
OpExecutionMode %main LocalSize 1 1 1
OpDecorate %WorkgroupId BuiltIn WorkgroupId
%void = OpTypeVoid
%fn = OpTypeFunction %void
%uint = OpTypeInt 32 0
%bool = OpTypeBool
%uvec2 = OpTypeVector %uint 2
%uvec3 = OpTypeVector %uint 3
%0 = OpConstant %uint 0
%1 = OpConstant %uint 1
%true = OpConstantTrue %bool
{declarations}
{functions}
"
    );
    let made = shaderc::Compiler::new().unwrap().assemble(&text, None);
    made.unwrap_or_else(|error| panic!("{error}\n{text}")).as_binary().to_vec()
}

/// A kernel of one block.
fn body(instructions: &str) -> String {
    format!("%main = OpFunction %void None %fn\n%l = OpLabel\n{instructions}\nOpReturn\nOpFunctionEnd")
}

fn decoded(declarations: &str, functions: &str) -> Result<Kernel, String> {
    let words = assembled(declarations, functions);
    Kernel::new("own", &words, &BTreeMap::new()).map_err(|error| error.to_string())
}

/// Dispatches a kernel without buffers.
fn dispatched(kernel: &Kernel, groups: [u32; 3]) -> Result<u64, String> {
    let bound = BTreeMap::new();
    let launched = Launched { groups, push: &[], bound: &bound, memory: &[], subgroup: 32, most_blocks: MOST_BLOCKS };
    kernel.run(&launched).map_err(|error| error.to_string())
}

/// A function that the kernel calls.
fn callee(block: &str) -> String {
    format!("{}\n%other = OpFunction %void None %fn\n{block}\nOpFunctionEnd", body("%2 = OpFunctionCall %void %other"))
}

#[test]
fn what_is_malformed_is_refused_by_what_is_wrong() {
    let merge = |rest: &str| format!("OpSelectionMerge %meet None\n{rest}");
    let cases = [
        ("", body("%2 = OpCompositeConstruct %uvec3 %1 %1"), "makes 3 numbers of 2"),
        ("", body("%2 = OpCompositeConstruct %uvec2 %1 %1 %1"), "makes 2 numbers of 3 or more"),
        ("%2 = OpConstantComposite %uvec3 %1 %1", body(""), "makes 3 numbers of 2"),
        (
            "%in = OpTypePointer Input %uvec2\n%WorkgroupId = OpVariable %in Input",
            body(""),
            "2 numbers for the built-in value 26",
        ),
        ("", body(&merge("")), "OpReturn where ways have to part"),
        ("", callee(&format!("%m = OpLabel\n{}\nOpReturn", merge(""))), "OpReturn where ways have to part"),
        (
            "",
            callee("%m = OpLabel\nOpSelectionMerge %m None\n%3 = OpFunctionCall %void %other\nOpReturn"),
            "where ways",
        ),
        ("", callee("OpReturn"), "OpReturn outside of a block"),
        ("", callee("%m = OpLabel\nOpReturn\nOpReturn"), "OpReturn outside of a block"),
        ("", callee(""), "does not end"),
        ("", callee("%m = OpLabel\nOpNop"), "does not end"),
        ("", callee("%m = OpLabel\n%n = OpLabel\nOpReturn"), "begins twice"),
        ("", callee("%m = OpLabel\nOpBranch %n\n%l = OpLabel\nOpReturn"), "there is no block"),
        ("", callee("%m = OpLabel\nOpSelectionMerge %n None\nOpBranch %m"), "there is no block"),
        ("", callee("%m = OpLabel\n%3 = OpFunctionCall %void %other\nOpReturn"), "call each other too often"),
        (
            "%none = OpTypeStruct\n%to = OpTypePointer Function %none",
            body("%2 = OpVariable %to Function\n%3 = OpAtomicIAdd %uint %2 %1 %0 %1"),
            "OpAtomicIAdd on what is no number",
        ),
    ];
    for (declarations, functions, words) in cases {
        let error = decoded(declarations, &functions).err().unwrap_or_else(|| panic!("{functions} is taken"));
        assert!(error.contains(words), "{functions}: {error}");
    }
}

#[test]
pub fn instructions_that_few_compilers_make_have_the_values_computed_by_hand() {
    let store = |k: u32, id: &str| format!("%o{k} = OpAccessChain %to %out %0 %k{k}\nOpStore %o{k} {id}\n");
    let mut declarations = "OpDecorate %array ArrayStride 4
OpMemberDecorate %block 0 Offset 0
OpDecorate %out Binding 0
%array = OpTypeRuntimeArray %uint
%block = OpTypeStruct %array
%to_block = OpTypePointer StorageBuffer %block
%to = OpTypePointer StorageBuffer %uint
%out = OpVariable %to_block StorageBuffer
%pair = OpTypeStruct %uint %uint
%other = OpTypeStruct %uint %uint
"
    .to_string();
    (0..12).for_each(|k| writeln!(declarations, "%k{k} = OpConstant %uint {k}").unwrap());
    declarations += "%v = OpConstantComposite %uvec3 %k2 %k3 %k5\n%p = OpConstantComposite %pair %k3 %k7\n\
                     %q = OpConstantComposite %pair %k4 %k8\n%false = OpConstantFalse %bool\n\
                     %on = OpSpecConstantTrue %bool\n%null = OpConstantNull %uvec3";
    let parts = [
        "%a = OpVectorInsertDynamic %uvec3 %v %k7 %k1\n%a1 = OpVectorExtractDynamic %uint %a %k1\n".into(),
        store(0, "%a1") + "%a2 = OpCompositeExtract %uint %a 2\n" + &store(1, "%a2"),
        "%b = OpCopyObject %other %p\n%b1 = OpCompositeExtract %uint %b 1\n".into(),
        store(2, "%b1") + "%o3 = OpAccessChain %to %out %0 %k3\nOpCopyMemory %o3 %o1\n",
        "%c = OpCompositeInsert %uvec3 %k9 %v 0\n%d = OpVectorShuffle %uvec2 %c %v 0 4\n".into(),
        "%d0 = OpCompositeExtract %uint %d 0\n%d1 = OpCompositeExtract %uint %d 1\n".into(),
        store(4, "%d0") + &store(5, "%d1") + "%o6 = OpAccessChain %to %out %0 %k6\n",
        "OpAtomicStore %o6 %k1 %k0 %k9\n%e = OpAtomicLoad %uint %o6 %k1 %k0\n".into(),
        store(7, "%e") + "%f = OpAtomicIIncrement %uint %o6 %k1 %k0\n%g = OpAtomicIIncrement %uint %o6 %k1 %k0\n",
        store(8, "%g") + "%h = OpAtomicIDecrement %uint %o6 %k1 %k0\n%i = OpSelect %pair %false %p %q\n",
        "%j = OpCompositeExtract %uint %i 1\n".to_string() + &store(9, "%j"),
        "OpNop\n%m = OpIAdd %uvec3 %v %null\n%m1 = OpCompositeExtract %uint %m 1\n%n = OpCopyObject %uint %m1\n".into(),
        "%or = OpLogicalOr %bool %false %on\n%r = OpSelect %uint %or %n %0\n".into(),
        "%o10 = OpInBoundsAccessChain %to %out %0 %k10\nOpStore %o10 %r\nOpSelectionMerge %end None\n".into(),
        "OpBranchConditional %on %end %never\n%never = OpLabel\nOpUnreachable\n%end = OpLabel\n".into(),
        // A block may stand before those that lead to it.
        "%rt = OpIEqual %bool %e %k9\nOpSelectionMerge %meet None\nOpBranchConditional %rt %first %second\n".into(),
        "%late = OpLabel\nOpBranch %meet\n%first = OpLabel\nOpBranch %late\n%second = OpLabel\nOpBranch %meet\n".into(),
        "%meet = OpLabel\n%way = OpPhi %uint %k4 %late %k8 %second\n".to_string() + &store(11, "%way"),
    ];
    let mut words = assembled(&declarations, &body(&parts.concat()));
    // The assembler has no OpCopyLogical.
    words.iter_mut().find(|word| **word == 0x4_0053).into_iter().for_each(|word| *word = 0x4_0190);
    note(&words);
    let kernel = Kernel::new("own", &words, &BTreeMap::new()).unwrap();
    let (memory, part) = (Memory::of(&[0; 4 * 12]), Part { memory: 0, first: 0, count: 12 });
    let (bound, memory) = (BTreeMap::from([(0, part)]), [&memory]);
    let launched =
        Launched { groups: [1; 3], push: &[], bound: &bound, memory: &memory, subgroup: 32, most_blocks: MOST_BLOCKS };
    kernel.run(&launched).unwrap();
    let found: Vec<u32> = (0..12).map(|word| memory[0].get(word)).collect();
    assert_eq!(found, [7, 5, 7, 5, 9, 3, 10, 9, 10, 8, 3, 4]);
}

/// Types made of each other: `%t1` of `%t0`, and so on.
fn nested(first: &str, count: u32, declared: impl Fn(u32) -> String) -> String {
    let mut text = format!("{first}\n");
    for k in 1..count {
        writeln!(text, "%t{k} = {}", declared(k - 1)).unwrap();
    }
    text
}

#[test]
fn what_does_not_fit_is_refused_at_once() {
    let begin = Instant::now();
    let pair = |k: u32| format!("OpTypeStruct %t{k} %t{k}");
    let deep = nested("%t0 = OpTypeStruct %uint", 70, |k| format!("OpTypeStruct %t{k}"));
    let wide = nested("%t0 = OpTypeStruct %uint", 40, pair);
    let long = "%large = OpConstant %uint 65536\n%t = OpTypeArray %uint %large\n".to_string();
    let nulls = |text: &str| (0..300).fold(long.clone(), |all, k| format!("{all}%n{k} = {text}\n"));
    let copies = (0..300).map(|k| format!("%c{k} = OpCopyObject %t %n\n")).collect::<String>();
    for (declarations, functions, words) in [
        (deep, body(""), "types within each other"),
        (wide, body(""), "more than 256 KiB"),
        (nulls("OpConstantNull %t"), body(""), "too many numbers"),
        (format!("{long}%n = OpConstantNull %t"), body(&copies), "too many numbers"),
        (format!("{long}%n = OpConstantNull %t"), body("%2 = OpIAdd %t %n %n"), "more than a matrix"),
    ] {
        let error = decoded(&declarations, &functions).err().expect(words);
        assert!(error.contains(words), "{error}");
    }
    // As many as 2^60 parts without a number.
    let empty = nested("%t0 = OpTypeStruct", 60, pair) + "%to = OpTypePointer Function %t59";
    let kernel = decoded(&empty, &body("%2 = OpVariable %to Function\n%3 = OpLoad %t59 %2")).unwrap();
    assert!(dispatched(&kernel, [2, 1, 1]).is_ok());
    for (groups, words) in [([65_536, 1, 1], "at most 65535"), ([65_535; 3], "too many")] {
        let error = dispatched(&kernel, groups).unwrap_err();
        assert!(error.contains(words), "{error}");
    }
    assert!(begin.elapsed() < Duration::from_secs(20), "{:?}", begin.elapsed());
}

/// A module with some of its words changed: to another word, to one near it, by a bit, or to a number of the module's
/// ids; or with its end cut off.
fn mutant(words: &[u32], random: &mut Random) -> Vec<u32> {
    let mut words = words.to_vec();
    for _ in 0..1 + random.below(4) {
        let (at, other) = (5 + random.below(words.len() - 5), 5 + random.below(words.len() - 5));
        words[at] = match random.below(6) {
            0 => words[other],
            1 => words[at].wrapping_add(1),
            2 => words[at].wrapping_sub(1),
            3 => words[at] ^ 1 << random.below(32),
            4 => random.below(words[3] as usize) as u32,
            _ => [0, u32::MAX, 1 << 16, 1 << 31][random.below(4)],
        };
    }
    if random.below(20) == 0 {
        words.truncate(5 + random.below(words.len() - 5));
    }
    words
}

/// Decodes and runs a module as far as it goes; whether it is one.
fn tried(words: &[u32]) -> bool {
    let Ok(kernel) = Kernel::new("own", words, &BTreeMap::new()) else { return false };
    let memory = Memory::of(&[1; 4 * 64]);
    let part = Part { memory: 0, first: 0, count: 64 };
    let bound: BTreeMap<u32, Part> = (0..200).map(|binding| (binding, part)).collect();
    let (push, memory) = ([1; 256], [&memory]);
    let launched =
        Launched { groups: [2, 1, 1], push: &push, bound: &bound, memory: &memory, subgroup: 32, most_blocks: 300 };
    drop((kernel.findings(&launched), kernel.run(&launched)));
    true
}

/// Tries so many mutants of each of these kernels; none may panic, nor take long.
fn survives(names: &[&str], count: u64) {
    let mut taken = 0;
    for name in names {
        let words: Vec<u32> = bytemuck::pod_collect_to_vec(spirv(name).unwrap());
        assert!(tried(&words), "{name}");
        for seed in 0..count {
            let words = mutant(&words, &mut Random::of(seed));
            let begin = Instant::now();
            let ended = catch_unwind(AssertUnwindSafe(|| tried(&words)));
            taken += usize::from(ended.unwrap_or_else(|_| panic!("mutant {seed} of {name} panics")));
            let took = begin.elapsed();
            assert!(took < Duration::from_secs(60), "mutant {seed} of {name} took {took:?}");
        }
    }
    // Most are refused, but not all.
    let all = names.len() * count as usize;
    assert!(taken > all / 20 && taken < all, "{taken} of {all}");
}

/// The names of kernels, those of the fewest words first.
fn by_size() -> Vec<&'static str> {
    let mut names: Vec<&str> = kernel_names().collect();
    names.sort_by_key(|name| spirv(name).map(<[u8]>::len));
    names
}

#[test]
fn every_built_in_kernel_is_decoded() {
    for name in kernel_names() {
        let words: Vec<u32> = bytemuck::pod_collect_to_vec(spirv(name).unwrap());
        let error = Kernel::new(name, &words, &BTreeMap::new()).err();
        assert!(error.is_none(), "{error:?}");
    }
}

#[test]
fn no_mutant_of_a_small_kernel_panics() {
    survives(&by_size()[..12], 200);
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn no_mutant_of_a_kernel_panics() {
    survives(&by_size(), 60);
}
