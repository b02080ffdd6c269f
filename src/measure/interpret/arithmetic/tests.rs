//! Every operation against values computed by hand; one that has none is named.

use std::f32::consts::{E, FRAC_PI_2, FRAC_PI_4, LN_2, PI, SQRT_2};
use std::fmt::Debug;

use spirq::spirv::{GLOp, Op};

use super::{atomic, double, folded, function, operation};
use crate::measure::interpret::code::{Function, OfTwo};

const NAN: u32 = 0x7fc0_0000;
const INFINITE: u32 = 0x7f80_0000;
const ALL: u32 = u32::MAX;
const LOWEST: u32 = 1 << 31;

/// The bits of a float.
const fn b(value: f32) -> u32 {
    value.to_bits()
}

/// The bits of an integer.
const fn n(value: i32) -> u32 {
    value as u32
}

/// What an operation makes of its operands.
type Case<T> = (T, &'static [u32], u32);

/// Operations of SPIR-V with numbers, bits and logic.
const NUMBERS: &[Case<Op>] = &[
    (Op::FNegate, &[b(1.5)], b(-1.5)),
    (Op::SNegate, &[5], n(-5)),
    (Op::SNegate, &[LOWEST], LOWEST),
    (Op::Not, &[0xf0], 0xffff_ff0f),
    (Op::LogicalNot, &[0], 1),
    (Op::LogicalNot, &[1], 0),
    (Op::ConvertFToS, &[b(-2.75)], n(-2)),
    (Op::ConvertFToU, &[b(3.99)], 3),
    (Op::ConvertSToF, &[n(-3)], b(-3.0)),
    (Op::ConvertUToF, &[ALL], 0x4f80_0000),
    (Op::IsNan, &[NAN], 1),
    (Op::IsNan, &[INFINITE], 0),
    (Op::IsInf, &[NAN], 0),
    (Op::IsInf, &[INFINITE | LOWEST], 1),
    (Op::BitCount, &[0xf1], 5),
    (Op::BitReverse, &[3], 0xc000_0000),
    (Op::IAdd, &[ALL, 2], 1),
    (Op::ISub, &[1, 2], ALL),
    (Op::IMul, &[0x1_0001, 0x1_0001], 0x2_0001),
    (Op::UDiv, &[ALL, 2], 0x7fff_ffff),
    (Op::UDiv, &[7, 0], ALL),
    (Op::SDiv, &[n(-7), 2], n(-3)),
    (Op::SDiv, &[LOWEST, ALL], LOWEST),
    (Op::SDiv, &[7, 0], ALL),
    (Op::UMod, &[7, 4], 3),
    (Op::UMod, &[7, 0], ALL),
    (Op::SRem, &[n(-7), 4], n(-3)),
    (Op::SRem, &[7, n(-4)], 3),
    (Op::SMod, &[n(-7), 4], 1),
    (Op::SMod, &[7, n(-4)], n(-1)),
    (Op::SMod, &[8, n(-4)], 0),
    (Op::FAdd, &[b(1.5), b(2.25)], b(3.75)),
    (Op::FSub, &[b(1.5), b(2.25)], b(-0.75)),
    (Op::FMul, &[b(1.5), b(-2.0)], b(-3.0)),
    (Op::FDiv, &[b(1.0), b(3.0)], 0x3eaa_aaab),
    (Op::FRem, &[b(-5.5), b(2.0)], b(-1.5)),
    (Op::FMod, &[b(-5.5), b(2.0)], b(0.5)),
    (Op::ShiftRightLogical, &[LOWEST, 31], 1),
    (Op::ShiftRightArithmetic, &[LOWEST, 31], ALL),
    (Op::ShiftLeftLogical, &[3, 4], 48),
    (Op::BitwiseOr, &[5, 2], 7),
    (Op::BitwiseXor, &[6, 3], 5),
    (Op::BitwiseAnd, &[6, 3], 2),
    // 0xabcd: the second byte from the fourth bit on, and the highest half byte, which is negative.
    (Op::BitFieldUExtract, &[0xabcd, 4, 8], 0xbc),
    (Op::BitFieldUExtract, &[0xabcd, 0, 32], 0xabcd),
    (Op::BitFieldUExtract, &[0xabcd, 4, 0], 0),
    (Op::BitFieldSExtract, &[0xabcd, 12, 4], n(-6)),
    (Op::BitFieldSExtract, &[0xabcd, 0, 3], n(-3)),
    (Op::BitFieldSExtract, &[0xabcd, 4, 0], 0),
];

/// What comparisons make of the pairs of their class below.
const COMPARED: &[(Op, [u32; 4])] = &[
    (Op::LogicalOr, [0, 1, 1, 1]),
    (Op::LogicalAnd, [0, 0, 0, 1]),
    (Op::LogicalEqual, [1, 0, 0, 1]),
    (Op::LogicalNotEqual, [0, 1, 1, 0]),
    (Op::IEqual, [0, 1, 0, 0]),
    (Op::INotEqual, [1, 0, 1, 1]),
    (Op::UGreaterThan, [1, 0, 0, 1]),
    (Op::UGreaterThanEqual, [1, 1, 0, 1]),
    (Op::ULessThan, [0, 0, 1, 0]),
    (Op::ULessThanEqual, [0, 1, 1, 0]),
    (Op::SGreaterThan, [0, 0, 1, 1]),
    (Op::SGreaterThanEqual, [0, 1, 1, 1]),
    (Op::SLessThan, [1, 0, 0, 0]),
    (Op::SLessThanEqual, [1, 1, 0, 0]),
    (Op::FOrdEqual, [0, 1, 0, 0]),
    (Op::FUnordEqual, [0, 1, 0, 1]),
    (Op::FOrdNotEqual, [1, 0, 1, 0]),
    (Op::FUnordNotEqual, [1, 0, 1, 1]),
    (Op::FOrdLessThan, [1, 0, 0, 0]),
    (Op::FUnordLessThan, [1, 0, 0, 1]),
    (Op::FOrdGreaterThan, [0, 0, 1, 0]),
    (Op::FUnordGreaterThan, [0, 0, 1, 1]),
    (Op::FOrdLessThanEqual, [1, 1, 0, 0]),
    (Op::FUnordLessThanEqual, [1, 1, 0, 1]),
    (Op::FOrdGreaterThanEqual, [0, 1, 1, 0]),
    (Op::FUnordGreaterThanEqual, [0, 1, 1, 1]),
];
const LOGIC: [[u32; 2]; 4] = [[0, 0], [0, 1], [1, 0], [1, 1]];
const INTEGERS: [[u32; 2]; 4] = [[n(-1), 1], [1, 1], [1, n(-1)], [4, 3]];
const FLOATS: [[u32; 2]; 4] = [[b(-2.0), b(-1.0)], [b(0.0), b(-0.0)], [b(-1.0), b(-2.0)], [NAN, b(1.0)]];

/// Atomic operations: the old word and the operand, which is 1 where the instruction has none.
const ATOMIC: &[Case<Op>] = &[
    (Op::AtomicExchange, &[5, 9], 9),
    (Op::AtomicIAdd, &[ALL, 3], 2),
    (Op::AtomicIIncrement, &[5, 1], 6),
    (Op::AtomicISub, &[1, 3], n(-2)),
    (Op::AtomicIDecrement, &[5, 1], 4),
    (Op::AtomicSMin, &[1, n(-3)], n(-3)),
    (Op::AtomicUMin, &[1, n(-3)], 1),
    (Op::AtomicSMax, &[1, n(-3)], 1),
    (Op::AtomicUMax, &[1, n(-3)], n(-3)),
    (Op::AtomicAnd, &[6, 3], 2),
    (Op::AtomicOr, &[6, 3], 7),
    (Op::AtomicXor, &[6, 3], 5),
];

/// What a subgroup folds: two values.
const FOLDED: &[Case<Op>] = &[
    (Op::GroupNonUniformIAdd, &[ALL, 3], 2),
    (Op::GroupNonUniformFAdd, &[b(1.5), b(2.25)], b(3.75)),
    (Op::GroupNonUniformIMul, &[0x1_0001, 0x1_0001], 0x2_0001),
    (Op::GroupNonUniformFMul, &[b(1.5), b(-2.0)], b(-3.0)),
    (Op::GroupNonUniformSMin, &[1, n(-3)], n(-3)),
    (Op::GroupNonUniformUMin, &[1, n(-3)], 1),
    (Op::GroupNonUniformFMin, &[b(1.0), b(-3.0)], b(-3.0)),
    (Op::GroupNonUniformSMax, &[1, n(-3)], 1),
    (Op::GroupNonUniformUMax, &[1, n(-3)], n(-3)),
    (Op::GroupNonUniformFMax, &[b(1.0), b(-3.0)], b(1.0)),
    (Op::GroupNonUniformBitwiseAnd, &[6, 3], 2),
    (Op::GroupNonUniformBitwiseOr, &[6, 3], 7),
    (Op::GroupNonUniformBitwiseXor, &[6, 3], 5),
    (Op::GroupNonUniformLogicalAnd, &[1, 0], 0),
    (Op::GroupNonUniformLogicalOr, &[1, 0], 1),
    (Op::GroupNonUniformLogicalXor, &[1, 1], 0),
];

/// Functions of GLSL.std.450. Digits are those of the function's value, rounded.
const FUNCTIONS: &[Case<GLOp>] = &[
    (GLOp::Round, &[b(2.5)], b(2.0)),
    (GLOp::RoundEven, &[b(3.5)], b(4.0)),
    (GLOp::Trunc, &[b(-1.75)], b(-1.0)),
    (GLOp::FAbs, &[b(-1.5)], b(1.5)),
    (GLOp::SAbs, &[n(-5)], 5),
    (GLOp::FSign, &[b(-2.5)], b(-1.0)),
    (GLOp::FSign, &[b(-0.0)], 0),
    (GLOp::SSign, &[n(-5)], n(-1)),
    (GLOp::Floor, &[b(-1.5)], b(-2.0)),
    (GLOp::Ceil, &[b(-1.5)], b(-1.0)),
    (GLOp::Fract, &[b(-1.25)], b(0.75)),
    (GLOp::Radians, &[b(180.0)], b(PI)),
    (GLOp::Degrees, &[b(1.0)], b(57.295_78)),
    (GLOp::Sin, &[b(1.0)], b(0.841_470_96)),
    (GLOp::Cos, &[b(1.0)], b(0.540_302_3)),
    (GLOp::Tan, &[b(1.0)], b(1.557_407_7)),
    (GLOp::Asin, &[b(1.0)], b(FRAC_PI_2)),
    (GLOp::Acos, &[b(-1.0)], b(PI)),
    (GLOp::Atan, &[b(1.0)], b(FRAC_PI_4)),
    (GLOp::Sinh, &[b(1.0)], b(1.175_201_2)),
    (GLOp::Cosh, &[b(1.0)], b(1.543_080_7)),
    (GLOp::Tanh, &[b(1.0)], b(0.761_594_2)),
    (GLOp::Asinh, &[b(1.0)], b(0.881_373_6)),
    (GLOp::Acosh, &[b(2.0)], b(1.316_958)),
    (GLOp::Atanh, &[b(0.5)], b(0.549_306_15)),
    (GLOp::Exp, &[b(1.0)], b(E)),
    (GLOp::Log, &[b(2.0)], b(LN_2)),
    (GLOp::Exp2, &[b(-3.0)], b(0.125)),
    (GLOp::Log2, &[b(8.0)], b(3.0)),
    (GLOp::Sqrt, &[b(2.0)], b(SQRT_2)),
    (GLOp::InverseSqrt, &[b(4.0)], b(0.5)),
    (GLOp::FindILsb, &[0x18], 3),
    (GLOp::FindILsb, &[0], ALL),
    (GLOp::FindUMsb, &[0x18], 4),
    (GLOp::FindUMsb, &[0], ALL),
    (GLOp::FindSMsb, &[n(-7)], 2),
    (GLOp::FindSMsb, &[ALL], ALL),
    (GLOp::Atan2, &[b(1.0), b(-1.0)], b(2.356_194_5)),
    (GLOp::Pow, &[b(2.0), b(0.5)], b(SQRT_2)),
    (GLOp::FMin, &[b(1.0), b(-3.0)], b(-3.0)),
    (GLOp::NMin, &[NAN, b(-3.0)], b(-3.0)),
    (GLOp::UMin, &[1, n(-3)], 1),
    (GLOp::SMin, &[1, n(-3)], n(-3)),
    (GLOp::FMax, &[b(1.0), b(-3.0)], b(1.0)),
    (GLOp::NMax, &[b(1.0), NAN], b(1.0)),
    (GLOp::UMax, &[1, n(-3)], n(-3)),
    (GLOp::SMax, &[1, n(-3)], 1),
    (GLOp::Step, &[b(2.0), b(1.5)], 0),
    (GLOp::Step, &[b(2.0), b(2.0)], b(1.0)),
    (GLOp::Ldexp, &[b(1.5), n(-3)], b(0.1875)),
    (GLOp::FClamp, &[b(5.0), b(-1.0), b(2.0)], b(2.0)),
    (GLOp::NClamp, &[NAN, b(-1.0), b(2.0)], b(-1.0)),
    (GLOp::UClamp, &[n(-3), 1, 4], 4),
    (GLOp::SClamp, &[n(-3), 1, 4], 1),
    (GLOp::FMix, &[b(1.0), b(3.0), b(0.25)], b(1.5)),
    (GLOp::SmoothStep, &[b(0.0), b(2.0), b(0.5)], b(0.15625)),
    // 1.0000002 squared, less 1: with one rounding the square of the last bit remains.
    (GLOp::Fma, &[0x3f80_0002, 0x3f80_0002, b(-1.0)], 0x3500_0001),
];

/// Checks operations that are applied in this way, and that each of `every` that can be is in the table.
fn check<T: Copy + Debug + PartialEq>(
    every: impl Iterator<Item = T>,
    cases: &[Case<T>],
    apply: impl Fn(T, &[u32]) -> Option<u32>,
) {
    for (op, operands, expected) in cases {
        let found = apply(*op, operands).unwrap_or_else(|| panic!("{op:?} of {} numbers", operands.len()));
        assert_eq!(found, *expected, "{op:?} of {operands:x?}: {found:#x}, not {expected:#x}");
    }
    let left: Vec<T> = every.filter(|op| cases.iter().all(|(known, ..)| known != op)).collect();
    let left: Vec<&T> = left.iter().filter(|op| (1..4).any(|count| apply(**op, &[1; 3][..count]).is_some())).collect();
    assert!(left.is_empty(), "nothing computes {left:?} by hand");
}

/// All operations that there are.
fn operations() -> impl Iterator<Item = Op> {
    (0..0x1_0000).filter_map(Op::from_u32)
}

/// The value of a function of as many numbers.
fn applied(f: Function, operands: &[u32]) -> Option<u32> {
    let of = [0, 1, 2].map(|k| operands.get(k).copied().unwrap_or_default());
    (f.depends() == operands.len()).then(|| f.value(of))
}

#[test]
fn each_operation_of_numbers_has_the_value_computed_by_hand() {
    let is_compared = |op: &Op| COMPARED.iter().any(|(known, _)| known == op);
    check(operations().filter(|op| !is_compared(op)), NUMBERS, |op, operands| applied(operation(op)?, operands));
    for (op, expected) in COMPARED {
        let pairs = match format!("{op:?}").chars().next() {
            Some('L') => LOGIC,
            Some('F') => FLOATS,
            _ => INTEGERS,
        };
        let f = operation(*op).unwrap();
        assert_eq!(pairs.map(|[a, b]| f.value([a, b, 0])), *expected, "{op:?} of {pairs:x?}");
    }
    let functions = (0..200).filter_map(GLOp::from_u32);
    check(functions, FUNCTIONS, |what, operands| applied(function(what)?, operands));
}

#[test]
fn each_operation_with_others_has_the_value_computed_by_hand() {
    let pair = |f: OfTwo, operands: &[u32]| if let [a, b] = *operands { Some(f(a, b)) } else { None };
    check(operations(), ATOMIC, |op, operands| pair(atomic(op)?, operands));
    check(operations(), FOLDED, |op, operands| pair(folded(op)?.0, operands));
    // What a fold begins with changes nothing.
    for (op, operands, _) in FOLDED {
        let (f, first) = folded(*op).unwrap();
        operands.iter().for_each(|own| assert_eq!(f(first, *own), *own, "{op:?}"));
    }
    let doubles: &[Case<Op>] = &[
        (Op::IAddCarry, &[ALL, 3], 2),
        (Op::ISubBorrow, &[1, 3], n(-2)),
        (Op::UMulExtended, &[ALL, 2], n(-2)),
        (Op::SMulExtended, &[ALL, 2], n(-2)),
    ];
    let seconds = [1, 1, 1, ALL];
    check(operations(), doubles, |op, operands| pair(double(op)?[0], operands));
    for ((op, operands, _), second) in doubles.iter().zip(seconds) {
        assert_eq!(pair(double(*op).unwrap()[1], operands), Some(second), "{op:?}");
    }
}
