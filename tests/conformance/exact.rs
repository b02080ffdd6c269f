//! Kernels that must give the same bits on every device: no operation that a device may round in its own way.

use milkglass::internals::gpu::spirv;
use spirq::spirv::Op;

const KERNELS: [&str; 5] = [
    "transport/walk/clearance",
    "transport/walk/random_walk/start",
    "transport/walk/random_walk/fly",
    "transport/walk/entry_sums/face",
    "transport/walk/entry_sums/most",
];
/// The decoration that keeps a product and a sum apart.
const NO_CONTRACTION: u32 = 42;
/// Instructions of GLSL.std.450 that do not round: absolute values, floor, least, largest, clamped, highest bit.
const EXACT: [u32; 9] = [4, 8, 37, 38, 40, 41, 43, 44, 75];

/// What may differ between devices in a kernel, and how many sums and products it has.
fn inexact(words: &[u32]) -> (Vec<String>, usize) {
    let instructions = || {
        let mut at = 5;
        std::iter::from_fn(move || {
            let length = (words.get(at)? >> 16) as usize;
            at += length;
            Some(&words[at - length..at])
        })
    };
    let apart: std::collections::BTreeSet<u32> = instructions()
        .filter(|i| i[0] & 0xffff == Op::Decorate as u32 && i[2] == NO_CONTRACTION)
        .map(|i| i[1])
        .collect();
    let (mut found, mut count) = (Vec::new(), 0);
    for i in instructions() {
        match Op::from_u32(i[0] & 0xffff) {
            Some(op @ (Op::FAdd | Op::FSub | Op::FMul | Op::VectorTimesScalar)) => {
                count += 1;
                if !apart.contains(&i[2]) {
                    found.push(format!("{op:?} {}", i[2]));
                }
            }
            Some(op @ (Op::FDiv | Op::FRem | Op::FMod | Op::Dot | Op::MatrixTimesVector)) => {
                found.push(format!("{op:?} {}", i[2]));
            }
            Some(Op::ExtInst) if !EXACT.contains(&i[4]) => found.push(format!("function {} of GLSL", i[4])),
            _ => {}
        }
    }
    (found, count)
}

#[test]
fn the_walk_adds_and_multiplies_only() {
    for kernel in KERNELS {
        let words: Vec<u32> = bytemuck::pod_collect_to_vec(spirv(kernel).unwrap());
        let (found, count) = inexact(&words);
        assert!(found.is_empty(), "{kernel}: {found:?}");
        assert!(count > 0, "{kernel}");
    }
    // A kernel whose values are compared within a tolerance.
    let words: Vec<u32> = bytemuck::pod_collect_to_vec(spirv("transport/walk/exit_radiosity").unwrap());
    assert!(!inexact(&words).0.is_empty());
}
