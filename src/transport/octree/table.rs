//! The dipole without roots and exponentials: `R_d` as a polynomial in each half octave of `d^2 + offset`, for AVX-512.
//!
//! 32 coefficients fit two registers, so that a lane looks up its own in one instruction, and 32 half octaves cover
//! distances from one mean free path to 256. The three channels share the distance, the half octave and the position
//! in it: 20 instructions per channel instead of 45. There is no table where the fit is not good enough: for an
//! object larger than that, or one so dense that light dies out within a half octave.

use std::arch::x86_64::{
    __m512, __m512i, _mm512_and_si512, _mm512_castps_si512, _mm512_castsi512_ps, _mm512_fmadd_ps, _mm512_or_si512,
    _mm512_permutex2var_ps, _mm512_set1_epi32, _mm512_set1_ps, _mm512_srli_epi32, _mm512_sub_ps,
};
use std::f64::consts::PI;

use fearless_simd::{Avx512, f32x16, prelude::*};

use super::Source;
use crate::dipole::profile::Dipole;

/// Degree of the polynomials: with 5 the error is 6e-6 everywhere, with 6 it is below 3e-6 except in the far tail.
const DEGREE: usize = 6;

/// Largest relative error of a fit. Only the far tail comes near it.
const TOLERANCE: f64 = 2e-5;

/// Bits of an `f32` below those that number the half octaves: all of the mantissa except one.
const SHIFT: u32 = 22;

/// Polynomials of three channels.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub struct Table {
    /// For each channel and power, the coefficients by half octave: exponent and first bit of the mantissa, modulo 32.
    coefficients: [[[f32; 32]; DEGREE + 1]; 3],
    /// Added to the squared distance, so that distances near 0 do not span too many octaves: length^2.
    offset: f32,
}

impl Table {
    /// The table up to the squared distance `farthest2`; none where that is too far, or where a fit is not good
    /// enough.
    pub fn new(dipoles: &[Dipole; 3], farthest2: f64) -> Option<Self> {
        let offset = dipoles.iter().map(|dipole| dipole.z_real * dipole.z_real).fold(f64::INFINITY, f64::min) as f32;
        // A little farther, to allow for the rounding of the distance.
        let farthest = ((f64::from(offset) + farthest2) * (1.0 + 1e-5)) as f32;
        if !(offset.is_normal() && farthest.is_normal()) {
            return None;
        }
        let halves = offset.to_bits() >> SHIFT..=farthest.to_bits() >> SHIFT;
        if halves.end() - halves.start() >= 32 {
            return None;
        }
        let mut table = Self { coefficients: [[[0.0; 32]; DEGREE + 1]; 3], offset };
        for half in halves {
            let [low, high] = [half, half + 1].map(|bits| f64::from(f32::from_bits(bits << SHIFT)));
            // The last interval ends at the largest distance, but not before its middle, so that the fit stays well
            // determined.
            let end = (2.0 * (f64::from(farthest) - low) / (high - low) - 1.0).clamp(0.0, 1.0);
            for (dipole, channel) in dipoles.iter().zip(&mut table.coefficients) {
                let at = |u: f64| dipole.radial(0.5 * (low + high) + 0.5 * (high - low) * u - f64::from(offset));
                let polynomial = fit(at, end)?;
                for (power, row) in channel.iter_mut().enumerate() {
                    // Rescale u from [-1, 1] to [-1/4, 1/4], which is what the mantissa gives.
                    row[half as usize % 32] = (polynomial[power] * 4f64.powi(power as i32)) as f32;
                }
            }
        }
        Some(table)
    }
}

/// The polynomial on [-1, `end`] with the least relative squared error, lowest power first; none where its error
/// exceeds the tolerance.
fn fit(f: impl Fn(f64) -> f64, end: f64) -> Option<[f64; DEGREE + 1]> {
    const N: usize = DEGREE + 1;
    const POINTS: usize = 32;
    let points: [(f64, f64); POINTS] = std::array::from_fn(|j| {
        let u = 0.5 * (1.0 + end) * (1.0 + (PI * j as f64 / (POINTS - 1) as f64).cos()) - 1.0;
        (u, f(u))
    });

    // Normal equations, solved by elimination: they are positive definite and small.
    let mut rows = [[0.0; N + 1]; N];
    for (u, value) in points {
        let basis: [f64; N] = std::array::from_fn(|k| u.powi(k as i32) / value);
        for (row, own) in rows.iter_mut().zip(basis) {
            for k in 0..N {
                row[k] += own * basis[k];
            }
            row[N] += own;
        }
    }
    for i in 0..N {
        let pivot = rows[i];
        for (j, row) in rows.iter_mut().enumerate() {
            let factor = row[i] / pivot[i];
            if j != i {
                row.iter_mut().zip(pivot).for_each(|(x, p)| *x -= factor * p);
            }
        }
    }
    let polynomial: [f64; N] = std::array::from_fn(|i| rows[i][N] / rows[i][i]);
    let good = |&(u, value): &(f64, f64)| {
        let sum = polynomial.iter().rev().fold(0.0, |sum, c| sum * u + c);
        (sum / value - 1.0).abs() <= TOLERANCE
    };
    points.iter().all(good).then_some(polynomial)
}

fearless_simd::kernel!(
    /// Adds the listed sources to the radiosity of 16 receivers.
    pub fn evaluate(
        token: Avx512,
        table: &Table,
        sources: &[Source],
        list: &[u32],
        at: &[[f32; 16]; 3],
        sum: &mut [[f32; 16]; 3],
    ) {
        let at = [load(token, &at[0]), load(token, &at[1]), load(token, &at[2])];
        let mut own = [_mm512_set1_ps(0.0); 3];

        // Two sources at a time: each register of the table is loaded once for both.
        let mut pairs = list.chunks_exact(2);
        for pair in &mut pairs {
            let (a, b) = (&sources[pair[0] as usize], &sources[pair[1] as usize]);
            let (half_a, u_a) = locate(token, table.offset, at, a);
            let (half_b, u_b) = locate(token, table.offset, at, b);
            for (k, (own, rows)) in own.iter_mut().zip(&table.coefficients).enumerate() {
                let (low, high) = row(token, &rows[DEGREE]);
                let mut value_a = _mm512_permutex2var_ps(low, half_a, high);
                let mut value_b = _mm512_permutex2var_ps(low, half_b, high);
                for power in (0..DEGREE).rev() {
                    let (low, high) = row(token, &rows[power]);
                    value_a = _mm512_fmadd_ps(value_a, u_a, _mm512_permutex2var_ps(low, half_a, high));
                    value_b = _mm512_fmadd_ps(value_b, u_b, _mm512_permutex2var_ps(low, half_b, high));
                }
                *own = _mm512_fmadd_ps(value_a, _mm512_set1_ps(a.power[k]), *own);
                *own = _mm512_fmadd_ps(value_b, _mm512_set1_ps(b.power[k]), *own);
            }
        }
        if let [last] = pairs.remainder() {
            let a = &sources[*last as usize];
            let (half, u) = locate(token, table.offset, at, a);
            for (k, (own, rows)) in own.iter_mut().zip(&table.coefficients).enumerate() {
                let mut value = _mm512_set1_ps(0.0);
                for coefficients in rows.iter().rev() {
                    let (low, high) = row(token, coefficients);
                    value = _mm512_fmadd_ps(value, u, _mm512_permutex2var_ps(low, half, high));
                }
                *own = _mm512_fmadd_ps(value, _mm512_set1_ps(a.power[k]), *own);
            }
        }
        for (sum, own) in sum.iter_mut().zip(own) {
            let own: f32x16<Avx512> = own.simd_into(token);
            (own + f32x16::simd_from(token, *sum)).store_slice(sum);
        }
    }
);

fearless_simd::kernel!(
    /// For the squared distances to a source: the half octaves, in the low bits, and the positions in them, -1/4 to
    /// 1/4.
    #[inline]
    fn locate(_token: Avx512, offset: f32, at: [__m512; 3], source: &Source) -> (__m512i, __m512) {
        let mut x = _mm512_set1_ps(offset);
        for (at, place) in at.into_iter().zip(source.place) {
            let d = _mm512_sub_ps(at, _mm512_set1_ps(place));
            x = _mm512_fmadd_ps(d, d, x);
        }
        let bits = _mm512_castps_si512(x);
        let mantissa = _mm512_and_si512(bits, _mm512_set1_epi32((1 << SHIFT) - 1));
        let place = _mm512_castsi512_ps(_mm512_or_si512(mantissa, _mm512_set1_epi32(0x3f80_0000)));
        (_mm512_srli_epi32::<SHIFT>(bits), _mm512_sub_ps(place, _mm512_set1_ps(1.25)))
    }
);

#[inline(always)]
fn load(token: Avx512, x: &[f32; 16]) -> __m512 {
    f32x16::load_array_ref(token, x).into()
}

#[inline(always)]
fn row(token: Avx512, row: &[f32; 32]) -> (__m512, __m512) {
    let (low, high) = row.split_at(16);
    (f32x16::from_slice(token, low).into(), f32x16::from_slice(token, high).into())
}
