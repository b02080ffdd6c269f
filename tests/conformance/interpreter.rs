//! The interpreter, class by class of instructions, against values computed by hand. Each kernel is compiled with and
//! without optimization: without, it has variables, functions and calls.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Mutex, PoisonError};

use spirq::spirv::{GLOp, Op};

use milkglass::measure::interpret::{Finding, Kernel, Launched, MOST_BLOCKS, Memory, Part};

/// Invocations of a subgroup.
const SUBGROUP: u32 = 32;

/// A kernel's SPIR-V, with lines of its GLSL.
pub fn compiled(text: &str, level: shaderc::OptimizationLevel) -> Vec<u32> {
    compiled_for((shaderc::EnvVersion::Vulkan1_2, shaderc::SpirvVersion::V1_5), text, level)
}

/// The same for a version of Vulkan and SPIR-V.
fn compiled_for(
    (vulkan, spirv): (shaderc::EnvVersion, shaderc::SpirvVersion),
    text: &str,
    level: shaderc::OptimizationLevel,
) -> Vec<u32> {
    let compiler = shaderc::Compiler::new().unwrap();
    let mut options = shaderc::CompileOptions::new().unwrap();
    options.set_target_env(shaderc::TargetEnv::Vulkan, vulkan as u32);
    options.set_target_spirv(spirv);
    options.set_optimization_level(level);
    options.set_generate_debug_info();
    let made = compiler.compile_into_spirv(text, shaderc::ShaderKind::Compute, "own.comp", "main", Some(&options));
    made.unwrap_or_else(|error| panic!("{error}\n{text}")).as_binary().to_vec()
}

/// What is bound and given to a kernel.
#[derive(Clone, Default)]
pub struct Given<'a> {
    /// Words of the buffers at 0, 1, ...
    pub buffers: Vec<Vec<u32>>,
    /// Groups.
    pub groups: [u32; 3],
    /// Push constants.
    pub push: &'a [u32],
    /// Specialization constants.
    pub special: &'a [(u32, u32)],
    /// Whether sums take products in one step.
    pub contracts: bool,
}

/// Runs a kernel, and watches it if asked to; returns its buffers, and what is wrong.
pub fn run(words: &[u32], given: &Given<'_>, watched: bool) -> (Vec<Vec<u32>>, Vec<Finding>) {
    note(words);
    let kernel = Kernel::with("own", words, &given.special.iter().copied().collect(), given.contracts).unwrap();
    let own: Vec<Memory> = given.buffers.iter().map(|words| Memory::of(bytemuck::cast_slice(words))).collect();
    let part = |(memory, words): (usize, &Vec<u32>)| (memory as u32, Part { memory, first: 0, count: words.len() });
    let bound: BTreeMap<u32, Part> = given.buffers.iter().enumerate().map(part).collect();
    let memory: Vec<&Memory> = own.iter().collect();
    let push = bytemuck::cast_slice(given.push);
    let (groups, bound, memory) = (given.groups, &bound, &memory[..]);
    let launched = Launched { groups, push, bound, memory, subgroup: SUBGROUP, most_blocks: MOST_BLOCKS };
    let findings = match watched {
        true => kernel.findings(&launched).unwrap(),
        false => {
            assert!(kernel.run(&launched).unwrap() > 0);
            Vec::new()
        }
    };
    let mut after = given.buffers.clone();
    own.iter().zip(&mut after).for_each(|(memory, words)| memory.write(bytemuck::cast_slice_mut(words)));
    (after, findings)
}

/// A kernel with groups of 64, words to read at binding 0, and words to write at binding 1; `a`, `b`, ... are the first
/// words that it reads.
pub fn kernel(before: &str, body: &str) -> String {
    format!(
        "#version 460
#extension GL_EXT_scalar_block_layout : require
#extension GL_KHR_shader_subgroup_arithmetic : require
#extension GL_KHR_shader_subgroup_ballot : require
#extension GL_KHR_shader_subgroup_vote : require
#extension GL_KHR_shader_subgroup_shuffle : require
#extension GL_KHR_shader_subgroup_shuffle_relative : require
#extension GL_KHR_shader_subgroup_clustered : require
#extension GL_KHR_shader_subgroup_quad : require
#extension GL_KHR_memory_scope_semantics : require
layout(local_size_x = 64) in;
layout(binding = 0, scalar) buffer Words {{ uint x[]; }};
layout(binding = 1, scalar) buffer Out {{ uint o[]; }};
float f(uint k) {{ return uintBitsToFloat(x[k]); }}
int i(uint k) {{ return int(x[k]); }}
uint w(float v) {{ return floatBitsToUint(v); }}
{before}
void main() {{
    uint lane = gl_LocalInvocationIndex, a = x[0], b = x[1];
{body}
}}
"
    )
}

/// What a kernel's invocations write, for these words to read: in one group, with and without optimization, watched or
/// not; nothing may be wrong.
fn written(before: &str, body: &str, words: &[u32], count: usize) -> Vec<u32> {
    let given = Given { buffers: vec![words.to_vec(), vec![0; count]], groups: [1; 3], ..Given::default() };
    check(&kernel(before, body), &given)
}

fn check(text: &str, given: &Given<'_>) -> Vec<u32> {
    use shaderc::OptimizationLevel::{Performance, Zero};
    let all = [(Zero, false), (Performance, false), (Performance, true)].map(|(level, watched)| {
        let (after, findings) = run(&compiled(text, level), given, watched);
        assert!(findings.is_empty(), "{text}\n{findings:#?}");
        after[1].clone()
    });
    assert_eq!(all[0], all[1], "{text}");
    assert_eq!(all[0], all[2], "{text}");
    all[0].clone()
}

/// Invocation 0 writes each expression; checks their values.
fn values(before: &str, words: &[u32], cases: &[(&str, u32)]) {
    let one = |(k, (expression, _)): (usize, &(&str, u32))| format!("        o[{k}] = {expression};\n");
    let body: String = cases.iter().enumerate().map(one).collect();
    let found = written(before, &format!("    if (lane == 0) {{\n{body}    }}"), words, cases.len());
    for ((expression, expected), found) in cases.iter().zip(found) {
        let [left, right] = [found, *expected].map(f32::from_bits);
        assert_eq!(found, *expected, "{expression}: {found:#x} or {left:e}, not {expected:#x} or {right:e}");
    }
}

fn bits(value: f32) -> u32 {
    value.to_bits()
}

#[test]
fn integers() {
    let words = [7, 3, -7i32 as u32, u32::MAX, 0xabcd, 33];
    values(
        "uint high(uint p, uint q) { uint h, l; umulExtended(p, q, h, l); return h; }\n\
         uint carry(uint p, uint q) { uint c; return uaddCarry(p, q, c) + 100 * c; }\n\
         uint borrow(uint p, uint q) { uint c; return usubBorrow(p, q, c) + c; }\n\
         uint signed_high(int p, int q) { int h, l; imulExtended(p, q, h, l); return uint(h); }",
        &words,
        &[
            ("a + b", 10),
            ("b - a", -4i32 as u32),
            ("a * x[3]", -7i32 as u32),
            ("a / b", 2),
            ("a % b", 1),
            ("uint(i(2) / 3)", -2i32 as u32),
            ("uint(-i(2))", 7),
            ("~a", !7),
            ("a << 2", 28),
            ("x[3] >> 28", 15),
            ("uint(i(2) >> 1)", -4i32 as u32),
            ("a & b", 3),
            ("a | 8", 15),
            ("a ^ b", 4),
            ("uint(bitCount(x[4]))", 10),
            ("uint(findLSB(a << 3))", 3),
            ("uint(findMSB(x[4]))", 15),
            ("uint(findMSB(i(2)))", 2),
            ("bitfieldReverse(a)", 0xe000_0000),
            ("bitfieldExtract(x[4], 4, 8)", 0xbc),
            ("uint(bitfieldExtract(int(x[4]), 8, 4))", -5i32 as u32),
            ("bitfieldInsert(x[3], a, 4, 4)", 0xffff_ff7f),
            ("high(x[3], 16)", 15),
            ("signed_high(i(2), 5)", u32::MAX),
            ("carry(x[3], a)", 106),
            ("borrow(b, a)", -3i32 as u32),
            ("min(a, b) + max(a, b) + clamp(a, 1, 2)", 12),
            ("uint(min(i(2), 3) + max(i(2), 3) + clamp(i(2), -2, 2) + abs(i(2)) + sign(i(2)))", 0),
        ],
    );
}

#[test]
fn floats() {
    let nan = f32::NAN;
    let list = [1.5f32, 2.25, -1.5, 2.0, 1e30, nan, 0.25, 3.0, 1e-40, 1.0 + 2.0 * f32::EPSILON];
    let words: Vec<u32> = list.map(f32::to_bits).into();
    let none = |expression| (expression, 0u32);
    values(
        // Without `precise` the optimizer contracts this.
        "float in_two(float v) { precise float square = v * v; precise float rest = square - 1.0; return rest; }",
        &words,
        &[
            ("w(f(0) + f(1))", bits(3.75)),
            ("w(f(0) - f(1))", bits(-0.75)),
            ("w(f(0) * f(1))", bits(3.375)),
            ("w(f(0) / f(7))", bits(0.5)),
            ("w(f(3) / f(7))", 0x3f2a_aaab),
            ("w(-f(0))", bits(-1.5)),
            ("w(f(4) * f(4))", 0x7f80_0000),
            // A denormal number stays what it is.
            ("w(f(8) * f(3))", 2 * bits(1e-40)),
            // One rounding, and two.
            ("w(fma(f(9), f(9), -1.0))", 0x3500_0001),
            ("w(in_two(f(9)))", 0x3500_0000),
            ("w(sqrt(f(3)))", 0x3fb5_04f3),
            ("w(inversesqrt(f(6)))", bits(2.0)),
            ("w(exp(f(3) - 1.0))", 0x402d_f854),
            ("w(exp2(f(7)))", bits(8.0)),
            ("w(log2(f(6)))", bits(-2.0)),
            ("w(log(f(3)))", 0x3f31_7218),
            ("w(pow(f(3), 10.0))", bits(1024.0)),
            ("w(sin(f(8) * 0.0))", 0),
            ("w(atan(f(3), f(3)))", 0x3f49_0fdb),
            ("w(floor(f(2)))", bits(-2.0)),
            ("w(ceil(f(2)))", bits(-1.0)),
            ("w(trunc(f(2)))", bits(-1.0)),
            ("w(fract(f(2)))", bits(0.5)),
            ("w(roundEven(f(3) + 0.5))", bits(2.0)),
            ("w(mod(f(2), f(7)))", bits(1.5)),
            ("w(abs(f(2)) + sign(f(2)))", bits(0.5)),
            ("w(min(f(0), f(1)) + max(f(0), f(1)))", bits(3.75)),
            ("w(clamp(f(1), 0.0, 2.0))", bits(2.0)),
            ("w(mix(f(0), f(7), f(6)))", bits(1.875)),
            ("w(step(f(3), f(0)))", 0),
            ("w(smoothstep(0.0, f(3), f(0) - 0.5))", bits(0.5)),
            ("uint(f(1)) + 10 * uint(int(f(2)) + 2)", 12),
            ("w(float(x[0] >> 23))", bits(127.0)),
            ("w(float(int(x[0] >> 23) - 130))", bits(-3.0)),
            ("uint(isnan(f(5))) + 2 * uint(isinf(f(4) * f(4)))", 3),
            none("uint(f(5) == f(5))"),
            ("uint(f(5) != f(5))", 1),
            none("uint(f(5) < f(0))"),
            ("uint(f(0) < f(1)) + 2 * uint(f(0) <= f(0)) + 4 * uint(f(1) > f(0)) + 8 * uint(f(0) >= f(0))", 15),
        ],
    );
}

#[test]
fn vectors_and_matrices() {
    let words: Vec<u32> = [1f32, 2.0, 3.0, 4.0, 0.0].map(f32::to_bits).into();
    values(
        "vec3 v() { return vec3(f(0), f(1), f(2)); }\nmat2 m() { return mat2(f(0), f(1), f(2), f(3)); }\n\
         uint two(vec2 v) { return uint(v.x) + 100 * uint(v.y); }",
        &words,
        &[
            ("w(dot(v(), v()))", bits(14.0)),
            ("w(length(vec2(f(2), f(3))))", bits(5.0)),
            ("w(distance(vec2(f(2), f(3)), vec2(0)))", bits(5.0)),
            ("w(normalize(vec3(0, f(2), f(3))).y)", bits(0.6)),
            ("w(cross(v(), v().yzx).x)", bits(-7.0)),
            ("w(reflect(vec2(f(0), -f(1)), vec2(0, 1)).y)", bits(2.0)),
            ("w((v() * f(1)).zyx.x)", bits(6.0)),
            ("w(v()[x[4] + 2])", bits(3.0)),
            // (1 3; 2 4) by rows.
            ("two(m() * vec2(f(0), f(1)))", 1007),
            ("two(vec2(f(0), f(1)) * m())", 1105),
            ("two((m() * m())[1])", 2215),
            ("two(transpose(m())[0])", 301),
            ("two(outerProduct(vec2(f(0), f(1)), vec2(f(2), f(3)))[1])", 804),
            ("two((m() * f(1))[0])", 402),
            ("uint(all(lessThan(v(), vec3(4)))) + 2 * uint(any(equal(v(), vec3(9))))", 1),
            ("w(mix(v(), vec3(0), bvec3(true, false, true)).y)", bits(2.0)),
        ],
    );
}

#[test]
fn branches_and_loops() {
    let body = "
    uint sum = 0;
    for (uint k = 0; k < lane; ++k) {
        if (k % 3 == 1) continue;
        if (k > 40) break;
        for (uint n = k; n > 0; n /= 2) sum += n & 1;
    }
    switch (lane % 4) {
    case 0: sum += 1000;
    case 1: sum += 100; break;
    case 2: sum = early(sum); break;
    default: sum += lane > 30 ? 7 : 5;
    }
    do { ++sum; } while (sum % 2 == 0 && sum < 50);
    o[lane] = sum;";
    let early = "uint early(uint v) { for (uint k = 0; k < 9; ++k) { if (k == v % 9) return 10 * k; } return 1; }";
    let found = written(early, body, &[0; 2], 64);
    for (lane, found) in (0u32..).zip(found) {
        let mut sum = (0..lane.min(41)).filter(|k| k % 3 != 1).map(u32::count_ones).sum::<u32>();
        sum = match lane % 4 {
            0 => sum + 1100,
            1 => sum + 100,
            2 => 10 * (sum % 9),
            _ => sum + if lane > 30 { 7 } else { 5 },
        };
        sum += 1;
        while sum % 2 == 0 && sum < 50 {
            sum += 1;
        }
        assert_eq!(found, sum, "{lane}");
    }
}

#[test]
fn memory_of_all_kinds() {
    let before = "
struct Pair { uint first; float second[3]; };
layout(binding = 0, scalar) buffer Pairs { Pair given[]; };
shared Pair pairs[64];
shared uint turned[64];
uint own[8];
void fill(out uint list[4], inout uint n) { for (uint k = 0; k < 4; ++k) list[k] = k * n; ++n; }";
    let body = "
    for (uint k = 0; k < 8; ++k) own[k] = k * k;
    uint list[4], n = lane;
    fill(list, n);
    Pair pair = Pair(lane, float[3](1.0, float(lane), 3.0));
    pairs[lane] = pair;
    turned[63 - lane] = lane + n;
    barrier();
    pair = pairs[(lane + 1) % 64];
    pair.second[lane % 3] += 1.0;
    o[lane] = own[lane % 8] + 100 * pair.first + list[lane % 4];
    o[64 + lane] = uint(pair.second[lane % 3]) + 1000 * turned[lane];
    o[128 + lane] = uint(x.length()) + uint(o.length());
    pair = given[0];
    o[192 + lane] = pair.first + w(pair.second[lane % 3]);";
    let found = written(before, body, &[5, 6, 7, 8], 256);
    for lane in 0..64u32 {
        let (next, back) = ((lane + 1) % 64, 63 - lane);
        assert_eq!(found[lane as usize], (lane % 8).pow(2) + 100 * next + lane % 4 * lane, "{lane}");
        let second = [1, next, 3][lane as usize % 3] + 1;
        assert_eq!(found[64 + lane as usize], second + 1000 * (2 * back + 1), "{lane}");
        assert_eq!(found[128 + lane as usize], 4 + 256, "{lane}");
        assert_eq!(found[192 + lane as usize], 5 + 6 + lane % 3, "{lane}");
    }
}

#[test]
fn atomic_operations() {
    let before = "shared uint all[2];";
    let body = "
    if (lane == 0) { all[0] = 0; all[1] = 0; }
    barrier();
    atomicAdd(all[0], lane);
    uint place = atomicAdd(all[1], 1);
    atomicMin(o[0], lane + 5); atomicMax(o[1], lane); atomicOr(o[2], 1u << (lane % 32)); atomicXor(o[3], 1);
    atomicAnd(o[4], ~(1u << (lane % 8)));
    atomicCompSwap(o[5], lane, lane + 1);
    if (lane == 0) { o[6] = atomicExchange(o[7], 9); o[8] = place; }
    barrier();
    if (lane == 0) {
        o[9] = all[0] + 10000 * all[1];
        atomicStore(o[10], 7u, gl_ScopeDevice, gl_StorageSemanticsBuffer, gl_SemanticsRelaxed);
        memoryBarrierBuffer();
        o[11] = atomicLoad(o[10], gl_ScopeDevice, gl_StorageSemanticsBuffer, gl_SemanticsRelaxed) + 1;
    }";
    let start = [99, 0, 0, 1, 0xffff, 0, 0, 4, 0, 0, 0, 0];
    let given = Given { buffers: vec![vec![0; 2], start.to_vec()], groups: [1; 3], ..Given::default() };
    let found = check(&kernel(before, body), &given);
    assert_eq!(found, [5, 63, u32::MAX, 1, 0xff00, 64, 4, 9, 0, 642_016, 7, 8]);
}

/// What groups load by atomic operations does not depend on how many processors there are.
#[test]
fn groups_that_load_what_others_change_run_in_order() {
    let body = "
    if (lane == 0) {
        atomicMax(o[0], gl_WorkGroupID.x + 1);
        o[1 + gl_WorkGroupID.x] = atomicLoad(o[0], gl_ScopeDevice, gl_StorageSemanticsBuffer, gl_SemanticsRelaxed);
    }";
    let given = Given { buffers: vec![vec![0; 2], vec![0; 201]], groups: [200, 1, 1], ..Given::default() };
    let found = check(&kernel("", body), &given);
    assert!((0u32..).zip(&found[1..]).all(|(group, found)| *found == group + 1), "{found:?}");
}

#[test]
fn subgroups() {
    let body = "
    uint at = 16 * lane;
    o[at] = subgroupShuffle(lane, gl_SubgroupInvocationID ^ 5);
    o[at + 1] = subgroupShuffleXor(lane, 3);
    o[at + 2] = subgroupBroadcast(lane, 4);
    o[at + 3] = subgroupBroadcastFirst(lane);
    o[at + 4] = uint(subgroupElect()) + 2 * uint(subgroupAll(lane < 32)) + 4 * uint(subgroupAny(lane == 40));
    o[at + 5] = subgroupBallot(lane % 5 == 0).x;
    o[at + 6] = subgroupBallotExclusiveBitCount(subgroupBallot(lane % 2 == 0));
    o[at + 7] = subgroupBallotFindMSB(subgroupBallot(lane % 32 < 9));
    o[at + 8] = subgroupAdd(lane);
    o[at + 9] = subgroupInclusiveAdd(1);
    o[at + 10] = subgroupExclusiveMax(lane);
    o[at + 11] = subgroupClusteredAdd(lane, 4);
    o[at + 12] = subgroupQuadSwapHorizontal(lane);
    o[at + 13] = gl_SubgroupSize + 100 * gl_SubgroupID + 1000 * gl_NumSubgroups;
    o[at + 14] = uint(subgroupInverseBallot(uvec4(0xff))) + 2 * uint(subgroupAllEqual(lane / 32));
    o[at + 15] = bitCount(gl_SubgroupLtMask.x);";
    let found = written("", body, &[0; 2], 1024);
    for lane in 0..64u32 {
        let (own, first) = (lane % 32, lane / 32 * 32);
        let multiples = (first..first + 32).filter(|k| k % 5 == 0).fold(0, |bits, k| bits | 1u32 << (k - first));
        let expected = [
            first + (own ^ 5),
            lane ^ 3,
            first + 4,
            first,
            u32::from(own == 0) + if first == 0 { 2 } else { 4 },
            multiples,
            own.div_ceil(2),
            8,
            first * 32 + 496,
            own + 1,
            if own == 0 { 0 } else { lane - 1 },
            lane / 4 * 16 + 6,
            lane ^ 1,
            32 + 100 * (lane / 32) + 2000,
            u32::from(own < 8) + 2,
            own,
        ];
        assert_eq!(found[16 * lane as usize..][..16], expected, "{lane}");
    }
}

#[test]
fn subgroups_in_their_rarer_ways() {
    let body = "
    uint at = 12 * lane;
    uvec4 fifths = subgroupBallot(lane % 5 == 2);
    o[at] = subgroupShuffleUp(lane, 2);
    o[at + 1] = subgroupShuffleDown(lane, 3);
    o[at + 2] = subgroupQuadBroadcast(lane, 2);
    o[at + 3] = subgroupQuadSwapVertical(lane);
    o[at + 4] = subgroupQuadSwapDiagonal(lane);
    o[at + 5] = subgroupBallotFindLSB(fifths);
    o[at + 6] = subgroupBallotInclusiveBitCount(fifths);
    o[at + 7] = subgroupBallotBitCount(fifths);
    o[at + 8] = uint(subgroupBallotBitExtract(fifths, 7));
    o[at + 9] = subgroupMul(lane % 32 < 3 ? 3 : 1);
    o[at + 10] = subgroupExclusiveOr(1u << gl_SubgroupInvocationID);
    o[at + 11] = subgroupClusteredMin(lane ^ 5, 8);";
    let given = Given { buffers: vec![vec![0; 2], vec![0; 768]], groups: [1; 3], ..Given::default() };
    for level in [shaderc::OptimizationLevel::Zero, shaderc::OptimizationLevel::Performance] {
        let (after, _) = run(&compiled(&kernel("", body), level), &given, false);
        for lane in 0..64u32 {
            let (own, first) = (lane % 32, lane / 32 * 32);
            let fifths: Vec<u32> = (0..32).filter(|k| (first + k) % 5 == 2).collect();
            let expected = [
                // One that takes from nobody keeps its own.
                if own < 2 { lane } else { lane - 2 },
                if own > 28 { lane } else { lane + 3 },
                lane / 4 * 4 + 2,
                lane ^ 2,
                lane ^ 3,
                fifths[0],
                fifths.iter().filter(|k| **k <= own).count() as u32,
                fifths.len() as u32,
                u32::from(fifths.contains(&7)),
                27,
                (1 << own) - 1,
                lane / 8 * 8,
            ];
            assert_eq!(after[1][12 * lane as usize..][..12], expected, "{lane}");
        }
    }
}

#[test]
fn what_a_dispatch_gives() {
    let text = "#version 460
#extension GL_EXT_scalar_block_layout : require
layout(local_size_x = 4, local_size_y = 2, local_size_x_id = 3) in;
layout(constant_id = 0) const uint SCALE = 1;
layout(constant_id = 1) const bool SHIFT = false;
const uint WIDTH = SCALE * 2 + gl_WorkGroupSize.x;
layout(push_constant, scalar) uniform Push { uint first; vec3 more; uint list[2]; } push;
layout(binding = 1, scalar) buffer Out { uint o[]; };
shared uint room[WIDTH];
void main() {
    room[gl_LocalInvocationID.x] = 1;
    uvec2 size = gl_NumWorkGroups.xy * gl_WorkGroupSize.xy;
    uint at = gl_GlobalInvocationID.y * size.x + gl_GlobalInvocationID.x;
    o[at] = push.first + uint(push.more.y) + push.list[gl_LocalInvocationID.y] * 100 + WIDTH * 10000
          + gl_WorkGroupID.y * 1000000 + (SHIFT ? gl_LocalInvocationIndex : 0);
}
";
    let push = [3, bits(1.0), bits(2.0), bits(4.0), 5, 6];
    let special = [(0, 7), (1, 1), (3, 8)];
    let (buffers, groups) = (vec![vec![0; 2], vec![0; 96]], [2, 3, 1]);
    let given = Given { buffers, groups, push: &push, special: &special, contracts: false };
    use shaderc::OptimizationLevel::{Performance, Zero};
    // From version 1.6 on, constants say how large a group is.
    let latest = compiled_for((shaderc::EnvVersion::Vulkan1_3, shaderc::SpirvVersion::V1_6), text, Zero);
    for words in [compiled(text, Zero), compiled(text, Performance), latest] {
        let (after, _) = run(&words, &given, false);
        for (at, found) in (0u32..).zip(&after[1]) {
            let (x, y) = (at % 16, at / 16);
            let index = y % 2 * 8 + x % 8;
            assert_eq!(*found, 5 + (5 + y % 2) * 100 + 22 * 10_000 + y / 2 * 1_000_000 + index, "{at}");
        }
    }
}

/// Whether a sum takes a product in one step where it may: not where it, or the product, is precise.
#[test]
fn products_are_contracted_as_asked() {
    let body = "
    precise float square = f(0) * f(0);
    precise float rest = f(0) * f(0) - 1.0;
    o[0] = w(f(0) * f(0) - 1.0); o[1] = w(1.0 - f(0) * f(0)); o[2] = w(-1.0 + f(0) * f(0));
    o[3] = w(dot(vec2(f(0), 1.0), vec2(f(0), -1.0))); o[4] = w(square - 1.0); o[5] = w(rest);";
    let words = compiled(&kernel("", &format!("if (lane > 0) return;\n{body}")), shaderc::OptimizationLevel::Zero);
    let buffers = vec![vec![bits(1.0 + 2.0 * f32::EPSILON), 0], vec![0; 6]];
    // The square of 1 + 2^-22 is 1 + 2^-21 + 2^-44: in two steps the last term is lost.
    let two = 0x3500_0000u32;
    for (contracts, one) in [(false, two), (true, two + 1)] {
        let given = Given { buffers: buffers.clone(), groups: [1; 3], contracts, ..Given::default() };
        let (after, _) = run(&words, &given, false);
        assert_eq!(after[1], [one, one | 1 << 31, one, one, two, two], "{contracts}");
    }
}

#[test]
fn what_it_has_not_is_said() {
    for (body, word) in
        [("o[0] = uint(double(a) / 3.0);", "64 bits"), ("o[0] = packHalf2x16(vec2(f(0)));", "PackHalf2x16")]
    {
        let words = compiled(&kernel("", body), shaderc::OptimizationLevel::Zero);
        let error = Kernel::new("own", &words, &BTreeMap::new()).err().expect("it has no such numbers");
        assert!(error.to_string().contains(word), "{error}");
    }
    for words in [&[][..], &[0x0723_0203, 0, 0, 9, 0, 0x0004_0015, 1], &[0x0723_0203, 0, 0, 9, 0, 0x0003_003d, 1, 2]] {
        assert!(Kernel::new("own", words, &BTreeMap::new()).is_err());
    }
}

/// Instructions and functions of GLSL.std.450 that kernels of these tests have.
static EXECUTED: Mutex<BTreeSet<String>> = Mutex::new(BTreeSet::new());

/// Notes what a kernel is made of.
pub fn note(words: &[u32]) {
    let mut executed = EXECUTED.lock().unwrap_or_else(PoisonError::into_inner);
    let mut rest = &words[5..];
    while let Some(first) = rest.first() {
        let (own, after) = rest.split_at((first >> 16) as usize);
        rest = after;
        let Some(op) = Op::from_u32(first & 0xffff) else { continue };
        executed.insert(format!("Op::{op:?}"));
        match (op, own) {
            (Op::ExtInst, [_, _, _, _, number, ..]) => {
                executed.extend(GLOp::from_u32(*number).map(|function| format!("GLOp::{function:?}")));
            }
            (Op::SpecConstantOp, [_, _, _, number, ..]) => {
                executed.extend(Op::from_u32(*number).map(|op| format!("Op::{op:?}")));
            }
            _ => {}
        }
    }
}

/// The arithmetic has tables of its own: `src/measure/interpret/arithmetic/tests.rs`.
#[test]
fn every_instruction_has_a_test() {
    use super::modules::instructions_that_few_compilers_make_have_the_values_computed_by_hand as few_compilers;
    [integers, floats, vectors_and_matrices, branches_and_loops, memory_of_all_kinds, atomic_operations, subgroups]
        .iter()
        .chain(&[subgroups_in_their_rarer_ways, what_a_dispatch_gives, few_compilers])
        .for_each(|test| test());
    let executed = EXECUTED.lock().unwrap_or_else(PoisonError::into_inner);
    let sources = [
        include_str!("../../src/measure/interpret/builder.rs"),
        include_str!("../../src/measure/interpret/function.rs"),
        include_str!("../../src/measure/interpret/instruction.rs"),
        include_str!("../../src/measure/interpret/pointers.rs"),
        include_str!("../../src/measure/interpret/types.rs"),
    ];
    let words = sources.iter().flat_map(|text| text.split(|c: char| !c.is_alphanumeric() && !":_".contains(c)));
    let known: BTreeSet<&str> = words
        .filter(|word| (word.starts_with("Op::") || word.starts_with("GLOp::")) && !word.ends_with("from_u32"))
        .collect();
    let left: Vec<&&str> = known.iter().filter(|name| !executed.contains(**name)).collect();
    assert!(known.len() > 100 && left.is_empty(), "of {} instructions no test has {left:?}", known.len());
}
