//! What instructions compute, number by number. Additions, multiplications, divisions and square roots round to
//! nearest, as the specification has them or allows; nothing is contracted unless that is asked for; `Fma` rounds once;
//! every other function is evaluated in 64 bits and rounded once.

use spirq::spirv::{GLOp, Op};

use super::code::Function::{self, One, Three, Two};
use super::code::OfTwo;

/// The float of these bits.
pub(super) fn f(bits: u32) -> f32 {
    f32::from_bits(bits)
}

fn wide(bits: u32) -> f64 {
    f64::from(f32::from_bits(bits))
}

fn i(bits: u32) -> i32 {
    bits as i32
}

/// The number that is rounded from 64 bits.
fn rounded(value: f64) -> u32 {
    (value as f32).to_bits()
}

/// An operation, applied to each component. Integers divided by 0 are all ones.
pub(super) fn operation(op: Op) -> Option<Function> {
    Some(match op {
        Op::FNegate => One(|a| (-f(a)).to_bits()),
        Op::SNegate => One(u32::wrapping_neg),
        Op::Not => One(|a| !a),
        Op::LogicalNot => One(|a| u32::from(a == 0)),
        Op::ConvertFToS => One(|a| f(a) as i32 as u32),
        Op::ConvertFToU => One(|a| f(a) as u32),
        Op::ConvertSToF => One(|a| (i(a) as f32).to_bits()),
        Op::ConvertUToF => One(|a| (a as f32).to_bits()),
        Op::IsNan => One(|a| f(a).is_nan().into()),
        Op::IsInf => One(|a| f(a).is_infinite().into()),
        Op::BitCount => One(u32::count_ones),
        Op::BitReverse => One(u32::reverse_bits),
        Op::IAdd => Two(u32::wrapping_add),
        Op::ISub => Two(u32::wrapping_sub),
        Op::IMul => Two(u32::wrapping_mul),
        Op::UDiv => Two(|a, b| a.checked_div(b).unwrap_or(u32::MAX)),
        Op::SDiv => Two(|a, b| if b == 0 { u32::MAX } else { i(a).wrapping_div(i(b)) as u32 }),
        Op::UMod => Two(|a, b| a.checked_rem(b).unwrap_or(u32::MAX)),
        Op::SRem => Two(|a, b| if b == 0 { u32::MAX } else { i(a).wrapping_rem(i(b)) as u32 }),
        Op::SMod => Two(|a, b| if b == 0 { u32::MAX } else { modulo(i(a), i(b)) as u32 }),
        Op::FAdd => Two(|a, b| (f(a) + f(b)).to_bits()),
        Op::FSub => Two(|a, b| (f(a) - f(b)).to_bits()),
        Op::FMul => Two(|a, b| (f(a) * f(b)).to_bits()),
        Op::FDiv => Two(|a, b| (f(a) / f(b)).to_bits()),
        Op::FRem => Two(|a, b| (f(a) % f(b)).to_bits()),
        Op::FMod => Two(|a, b| (f(a) - f(b) * (f(a) / f(b)).floor()).to_bits()),
        Op::ShiftRightLogical => Two(|a, b| a.checked_shr(b).unwrap_or(0)),
        Op::ShiftRightArithmetic => Two(|a, b| (i(a) >> b.min(31)) as u32),
        Op::ShiftLeftLogical => Two(|a, b| a.checked_shl(b).unwrap_or(0)),
        Op::BitwiseOr => Two(|a, b| a | b),
        Op::BitwiseXor => Two(|a, b| a ^ b),
        Op::BitwiseAnd => Two(|a, b| a & b),
        // The field's value, its first bit, its length.
        Op::BitFieldUExtract => Three(|a, first, count| shifted_down(a, first) & ones(count)),
        Op::BitFieldSExtract => Three(|a, first, count| {
            let field = shifted_down(a, first) & ones(count);
            let sign = count > 0 && field.checked_shr(count.wrapping_sub(1)).unwrap_or(0) & 1 == 1;
            if sign { field | !ones(count) } else { field }
        }),
        _ => return compared(op),
    })
}

/// A comparison or an operation of logic.
fn compared(op: Op) -> Option<Function> {
    Some(match op {
        Op::LogicalOr => Two(|a, b| u32::from(a != 0 || b != 0)),
        Op::LogicalAnd => Two(|a, b| u32::from(a != 0 && b != 0)),
        Op::LogicalEqual => Two(|a, b| u32::from((a != 0) == (b != 0))),
        Op::LogicalNotEqual => Two(|a, b| u32::from((a != 0) != (b != 0))),
        Op::IEqual => Two(|a, b| u32::from(a == b)),
        Op::INotEqual => Two(|a, b| u32::from(a != b)),
        Op::UGreaterThan => Two(|a, b| u32::from(a > b)),
        Op::UGreaterThanEqual => Two(|a, b| u32::from(a >= b)),
        Op::ULessThan => Two(|a, b| u32::from(a < b)),
        Op::ULessThanEqual => Two(|a, b| u32::from(a <= b)),
        Op::SGreaterThan => Two(|a, b| u32::from(i(a) > i(b))),
        Op::SGreaterThanEqual => Two(|a, b| u32::from(i(a) >= i(b))),
        Op::SLessThan => Two(|a, b| u32::from(i(a) < i(b))),
        Op::SLessThanEqual => Two(|a, b| u32::from(i(a) <= i(b))),
        Op::FOrdEqual => Two(|a, b| u32::from(f(a) == f(b))),
        Op::FUnordEqual => Two(|a, b| u32::from(f(a) == f(b) || unordered(a, b))),
        Op::FOrdNotEqual => Two(|a, b| u32::from(f(a) != f(b) && !unordered(a, b))),
        Op::FUnordNotEqual => Two(|a, b| u32::from(f(a) != f(b))),
        Op::FOrdLessThan => Two(|a, b| u32::from(f(a) < f(b))),
        Op::FUnordLessThan => Two(|a, b| u32::from(f(a) < f(b) || unordered(a, b))),
        Op::FOrdGreaterThan => Two(|a, b| u32::from(f(a) > f(b))),
        Op::FUnordGreaterThan => Two(|a, b| u32::from(f(a) > f(b) || unordered(a, b))),
        Op::FOrdLessThanEqual => Two(|a, b| u32::from(f(a) <= f(b))),
        Op::FUnordLessThanEqual => Two(|a, b| u32::from(f(a) <= f(b) || unordered(a, b))),
        Op::FOrdGreaterThanEqual => Two(|a, b| u32::from(f(a) >= f(b))),
        Op::FUnordGreaterThanEqual => Two(|a, b| u32::from(f(a) >= f(b) || unordered(a, b))),
        _ => return None,
    })
}

/// Both words of a result that has two.
pub(super) fn double(op: Op) -> Option<[OfTwo; 2]> {
    Some(match op {
        Op::IAddCarry => [u32::wrapping_add, |a, b| a.overflowing_add(b).1.into()],
        Op::ISubBorrow => [u32::wrapping_sub, |a, b| u32::from(a < b)],
        Op::UMulExtended => [u32::wrapping_mul, |a, b| ((u64::from(a) * u64::from(b)) >> 32) as u32],
        Op::SMulExtended => [u32::wrapping_mul, |a, b| ((i64::from(i(a)) * i64::from(i(b))) >> 32) as u32],
        _ => return None,
    })
}

/// What an atomic operation makes of a word and its operand.
pub(super) fn atomic(op: Op) -> Option<OfTwo> {
    Some(match op {
        Op::AtomicExchange => |_, new| new,
        Op::AtomicIAdd | Op::AtomicIIncrement => u32::wrapping_add,
        Op::AtomicISub | Op::AtomicIDecrement => u32::wrapping_sub,
        Op::AtomicSMin => |old, new| i(old).min(i(new)) as u32,
        Op::AtomicUMin => u32::min,
        Op::AtomicSMax => |old, new| i(old).max(i(new)) as u32,
        Op::AtomicUMax => u32::max,
        Op::AtomicAnd => |old, new| old & new,
        Op::AtomicOr => |old, new| old | new,
        Op::AtomicXor => |old, new| old ^ new,
        _ => return None,
    })
}

/// What a subgroup folds its values with, and what it begins with.
pub(super) fn folded(op: Op) -> Option<(OfTwo, u32)> {
    const ONE: u32 = 0x3f80_0000;
    Some(match op {
        Op::GroupNonUniformIAdd => (u32::wrapping_add, 0),
        Op::GroupNonUniformFAdd => (|a, b| (f(a) + f(b)).to_bits(), 0),
        Op::GroupNonUniformIMul => (u32::wrapping_mul, 1),
        Op::GroupNonUniformFMul => (|a, b| (f(a) * f(b)).to_bits(), ONE),
        Op::GroupNonUniformSMin => (|a, b| i(a).min(i(b)) as u32, i32::MAX as u32),
        Op::GroupNonUniformUMin => (u32::min, u32::MAX),
        Op::GroupNonUniformFMin => (|a, b| f(a).min(f(b)).to_bits(), f32::INFINITY.to_bits()),
        Op::GroupNonUniformSMax => (|a, b| i(a).max(i(b)) as u32, i32::MIN as u32),
        Op::GroupNonUniformUMax => (u32::max, 0),
        Op::GroupNonUniformFMax => (|a, b| f(a).max(f(b)).to_bits(), f32::NEG_INFINITY.to_bits()),
        Op::GroupNonUniformBitwiseAnd => (|a, b| a & b, u32::MAX),
        Op::GroupNonUniformBitwiseOr | Op::GroupNonUniformLogicalOr => (|a, b| a | b, 0),
        Op::GroupNonUniformBitwiseXor | Op::GroupNonUniformLogicalXor => (|a, b| a ^ b, 0),
        Op::GroupNonUniformLogicalAnd => (|a, b| a & b, 1),
        _ => return None,
    })
}

/// A function of GLSL.std.450, applied to each component.
pub(super) fn function(function: GLOp) -> Option<Function> {
    Some(match function {
        GLOp::Round | GLOp::RoundEven => One(|a| f(a).round_ties_even().to_bits()),
        GLOp::Trunc => One(|a| f(a).trunc().to_bits()),
        GLOp::FAbs => One(|a| f(a).abs().to_bits()),
        GLOp::SAbs => One(|a| i(a).wrapping_abs() as u32),
        GLOp::FSign => One(|a| if f(a) == 0.0 || f(a).is_nan() { 0 } else { f(a).signum().to_bits() }),
        GLOp::SSign => One(|a| i(a).signum() as u32),
        GLOp::Floor => One(|a| f(a).floor().to_bits()),
        GLOp::Ceil => One(|a| f(a).ceil().to_bits()),
        GLOp::Fract => One(|a| (f(a) - f(a).floor()).to_bits()),
        GLOp::Radians => One(|a| rounded(wide(a).to_radians())),
        GLOp::Degrees => One(|a| rounded(wide(a).to_degrees())),
        GLOp::Sin => One(|a| rounded(wide(a).sin())),
        GLOp::Cos => One(|a| rounded(wide(a).cos())),
        GLOp::Tan => One(|a| rounded(wide(a).tan())),
        GLOp::Asin => One(|a| rounded(wide(a).asin())),
        GLOp::Acos => One(|a| rounded(wide(a).acos())),
        GLOp::Atan => One(|a| rounded(wide(a).atan())),
        GLOp::Sinh => One(|a| rounded(wide(a).sinh())),
        GLOp::Cosh => One(|a| rounded(wide(a).cosh())),
        GLOp::Tanh => One(|a| rounded(wide(a).tanh())),
        GLOp::Asinh => One(|a| rounded(wide(a).asinh())),
        GLOp::Acosh => One(|a| rounded(wide(a).acosh())),
        GLOp::Atanh => One(|a| rounded(wide(a).atanh())),
        GLOp::Exp => One(|a| rounded(wide(a).exp())),
        GLOp::Log => One(|a| rounded(wide(a).ln())),
        GLOp::Exp2 => One(|a| rounded(wide(a).exp2())),
        GLOp::Log2 => One(|a| rounded(wide(a).log2())),
        GLOp::Sqrt => One(|a| f(a).sqrt().to_bits()),
        GLOp::InverseSqrt => One(|a| rounded(1.0 / wide(a).sqrt())),
        GLOp::FindILsb => One(|a| if a == 0 { u32::MAX } else { a.trailing_zeros() }),
        GLOp::FindUMsb => One(highest),
        GLOp::FindSMsb => One(|a| highest(if i(a) < 0 { !a } else { a })),
        _ => return of_several(function),
    })
}

/// A function of two or three numbers.
fn of_several(function: GLOp) -> Option<Function> {
    Some(match function {
        GLOp::Atan2 => Two(|a, b| rounded(wide(a).atan2(wide(b)))),
        GLOp::Pow => Two(|a, b| rounded(wide(a).powf(wide(b)))),
        GLOp::FMin | GLOp::NMin => Two(|a, b| f(a).min(f(b)).to_bits()),
        GLOp::UMin => Two(u32::min),
        GLOp::SMin => Two(|a, b| i(a).min(i(b)) as u32),
        GLOp::FMax | GLOp::NMax => Two(|a, b| f(a).max(f(b)).to_bits()),
        GLOp::UMax => Two(u32::max),
        GLOp::SMax => Two(|a, b| i(a).max(i(b)) as u32),
        GLOp::Step => Two(|edge, a| if f(a) < f(edge) { 0 } else { 1f32.to_bits() }),
        GLOp::Ldexp => Two(|a, b| rounded(wide(a) * f64::from(i(b).clamp(-400, 400)).exp2())),
        GLOp::FClamp | GLOp::NClamp => Three(|a, low, high| f(a).max(f(low)).min(f(high)).to_bits()),
        GLOp::UClamp => Three(|a, low, high| a.max(low).min(high)),
        GLOp::SClamp => Three(|a, low, high| i(a).max(i(low)).min(i(high)) as u32),
        GLOp::FMix => Three(|a, b, t| (f(a) * (1.0 - f(t)) + f(b) * f(t)).to_bits()),
        GLOp::SmoothStep => Three(|low, high, a| {
            let t = ((f(a) - f(low)) / (f(high) - f(low))).clamp(0.0, 1.0);
            (t * t * (3.0 - 2.0 * t)).to_bits()
        }),
        GLOp::Fma => Three(|a, b, c| f(a).mul_add(f(b), f(c)).to_bits()),
        _ => return None,
    })
}

fn unordered(a: u32, b: u32) -> bool {
    f(a).is_nan() || f(b).is_nan()
}

/// The remainder with the sign of the divisor.
fn modulo(a: i32, b: i32) -> i32 {
    let rest = a.wrapping_rem(b);
    if rest != 0 && (rest < 0) != (b < 0) { rest + b } else { rest }
}

/// The number of the highest bit that is set; all ones if none is.
fn highest(a: u32) -> u32 {
    31u32.wrapping_sub(a.leading_zeros())
}

/// So many of the lowest bits.
pub(super) fn ones(count: u32) -> u32 {
    1u32.checked_shl(count).map_or(u32::MAX, |bit| bit - 1)
}

fn shifted_down(a: u32, by: u32) -> u32 {
    a.checked_shr(by).unwrap_or(0)
}

#[cfg(test)]
mod tests;
