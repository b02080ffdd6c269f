//! The dipole for 16 receivers at once: `R_d = strength (z_r p(s_r) + z_v p(s_v))`, each term with its own root and
//! exponential. Runs on every processor.

use std::f64::consts::LOG2_E;

use fearless_simd::{Level, Simd, f32x16, i32x16, prelude::*};

use super::Source;
use crate::dipole::profile::Dipole;

/// The dipole of one channel, prepared for the sum.
#[derive(Clone, Copy, Debug)]
pub struct Channel {
    sigma: f32,
    /// `-sigma / ln 2`: the exponential is one of base 2.
    rate: f32,
    terms: [Term; 2],
}

/// The real or the virtual source.
#[derive(Clone, Copy, Debug)]
struct Term {
    z2: f32,
    /// Strength times depth.
    weight: f32,
}

impl Channel {
    /// Rounds a dipole to `f32`.
    pub fn new(dipole: &Dipole) -> Self {
        Self {
            sigma: dipole.sigma as f32,
            rate: (-dipole.sigma * LOG2_E) as f32,
            terms: dipole.depths().map(|z| Term { z2: (z * z) as f32, weight: (dipole.strength * z) as f32 }),
        }
    }
}

/// Adds the listed sources to the radiosity of 16 receivers.
#[inline(always)]
pub fn evaluate<S: Simd>(
    simd: S,
    channels: &[Channel; 3],
    sources: &[Source],
    list: &[u32],
    at: &[f32x16<S>; 3],
    sum: &mut [f32x16<S>; 3],
) {
    let mut listed = [f32x16::splat(simd, 0.0); 3];
    for &index in list {
        let source = &sources[index as usize];
        let (x, y, z) = (at[0] - source.place[0], at[1] - source.place[1], at[2] - source.place[2]);
        let d2 = x.mul_add(x, y.mul_add(y, z * z));
        for k in 0..3 {
            let [real, image] = &channels[k].terms;
            let reflectance = kernel(simd, &channels[k], real, d2) * real.weight;
            let reflectance = kernel(simd, &channels[k], image, d2).mul_add(image.weight, reflectance);
            listed[k] = reflectance.mul_add(source.power[k], listed[k]);
        }
    }
    for k in 0..3 {
        sum[k] += listed[k];
    }
}

/// `p(s) = (1 + sigma s) e^(-sigma s) / s^3`.
#[inline(always)]
fn kernel<S: Simd>(simd: S, channel: &Channel, term: &Term, d2: f32x16<S>) -> f32x16<S> {
    let s2 = d2 + term.z2;
    let inverse = inverse_root(simd, s2);
    let s = s2 * inverse;
    let decay = s.mul_add(channel.sigma, 1.0) * exp2(simd, s * channel.rate);
    (inverse * inverse) * (inverse * decay)
}

/// `2^t` for `t` at most 0, within 3e-7; not below 2^-126.
#[inline(always)]
fn exp2<S: Simd>(simd: S, t: f32x16<S>) -> f32x16<S> {
    // Adding 1.5 * 2^23 rounds to a whole number, which is then in the low bits.
    let round = f32x16::splat(simd, 12_582_912.0);
    let t = t.max(-126.0);
    let whole = t + round;
    let part = t - (whole - round);
    let power = part
        .mul_add(1.339_887e-3, 9.618_437e-3)
        .mul_add(part, 5.550_329_3e-2)
        .mul_add(part, 2.402_264_7e-1)
        .mul_add(part, 6.931_472e-1)
        .mul_add(part, 1.0);
    (power.bitcast::<i32x16<S>>() + (whole.bitcast::<i32x16<S>>() << 23)).bitcast()
}

/// `1 / sqrt(x)`: the processor's estimate and one Newton step, or exactly where it has no estimate.
#[inline(always)]
fn inverse_root<S: Simd>(simd: S, x: f32x16<S>) -> f32x16<S> {
    let estimate = match simd.level() {
        #[cfg(target_arch = "x86_64")]
        Level::Avx512(avx512) => f32x16::simd_from(simd, estimate::wide(avx512, x.into())),
        #[cfg(target_arch = "x86_64")]
        Level::Avx2(avx2) => f32x16::simd_from(simd, estimate::halves(avx2, x.into())),
        _ => return 1.0 / x.sqrt(),
    };
    let error = (-(x * estimate)).mul_add(estimate, 1.0);
    (estimate * 0.5).mul_add(error, estimate)
}

/// Estimates of `1 / sqrt(x)`: within 2^-14 for AVX-512, within 1.5 * 2^-12 for AVX2.
#[cfg(target_arch = "x86_64")]
mod estimate {
    use std::arch::x86_64::{__m256, __m512, _mm256_rsqrt_ps, _mm512_rsqrt14_ps};

    use fearless_simd::{Avx2, Avx512, f32x8, f32x16, prelude::*};

    fearless_simd::kernel!(
        #[inline]
        fn root16(_token: Avx512, x: __m512) -> __m512 {
            _mm512_rsqrt14_ps(x)
        }
    );

    fearless_simd::kernel!(
        #[inline]
        fn root8(_token: Avx2, x: __m256) -> __m256 {
            _mm256_rsqrt_ps(x)
        }
    );

    #[inline(always)]
    pub fn wide(token: Avx512, x: [f32; 16]) -> [f32; 16] {
        let x: f32x16<Avx512> = x.simd_into(token);
        let y: f32x16<Avx512> = root16(token, x.into()).simd_into(token);
        y.into()
    }

    #[inline(always)]
    pub fn halves(token: Avx2, x: [f32; 16]) -> [f32; 16] {
        let x: f32x16<Avx2> = x.simd_into(token);
        let (low, high) = x.split();
        let low: f32x8<Avx2> = root8(token, low.into()).simd_into(token);
        let high: f32x8<Avx2> = root8(token, high.into()).simd_into(token);
        low.combine(high).into()
    }
}
