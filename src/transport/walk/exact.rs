//! Arithmetic of the walk, in step with `glsl/transport/walk/exact.glsl`: `f32` additions, multiplications and
//! comparisons in the same order, so that every device finds the same bits.

pub use crate::geometry::exact::{inside, inverse, kept_unit, refracted, root, unit};
pub use crate::geometry::random::{about, random4, unit_random};
use crate::layout::LOGARITHM;

/// -ln x for x in (0, 1).
#[must_use]
pub fn minus_log(x: f32) -> f32 {
    let apart = x.to_bits().wrapping_sub(0x3f35_04f3);
    let e = (apart as i32 >> 23) as f32;
    let t = f32::from_bits((apart & 0x007f_ffff) + 0x3f35_04f3) - 1.0;
    let sum = LOGARITHM[..8].iter().rev().fold(LOGARITHM[8], |sum, c| sum * t + c);
    let z = t * t;
    -(t * z * sum - 0.5 * z + t + e * LN_2)
}

/// Rounded as the shader's text is.
const LN_2: f32 = std::f32::consts::LN_2;

/// Fresnel transmittance of a boundary with this index, inner over outer, from its cosines outside and inside.
#[must_use]
pub fn passes(eta: f32, outer: f32, inner: f32) -> f32 {
    let (s, p) = (outer + eta * inner, eta * outer + inner);
    let (by_s, by_p) = (inverse(s.max(1e-6)), inverse(p.max(1e-6)));
    let share = 2.0 * eta * (outer * by_s * (inner * by_s) + outer * by_p * (inner * by_p));
    match outer > 0.0 && inner > 0.0 {
        _ if eta == 1.0 => 1.0,
        true => share.min(1.0),
        false => 0.0,
    }
}

/// The cosine outside for one inside; 0 where nothing passes.
#[must_use]
pub fn outside(eta: f32, inner: f32) -> f32 {
    if eta == 1.0 { inner } else { root(1.0 - eta * eta * (1.0 - inner * inner)) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::geometry::trace::dot;
    use crate::lighting::fresnel;

    fn some() -> impl Iterator<Item = u32> {
        (0..20_000u32).map(|k| random4(k, 7, 1, 3)[2])
    }

    #[test]
    fn arithmetic_is_that_of_double_precision() {
        for x in some().map(unit_random).chain([1.0 - 1.0 / 16_777_216.0, 1.0 / 16_777_216.0]) {
            let wide = f64::from(x);
            assert!((f64::from(minus_log(x)) + wide.ln()).abs() < 4e-7 * (1.0 - wide.ln()), "ln {x}");
            assert!(minus_log(x) > 0.0);
            for scale in [1e-12f32, 1.0, 3e7] {
                let y = x * scale;
                let wide = f64::from(y);
                assert!((f64::from(inverse(y)) * wide - 1.0).abs() < 2e-7, "1 / {y}");
                assert!((f64::from(root(y)) / wide.sqrt() - 1.0).abs() < 3e-7, "root {y}");
            }
        }
        assert_eq!([root(0.0), root(-1.0), root(1e-31)], [0.0; 3]);
    }

    #[test]
    fn the_boundary_is_fresnels() {
        for eta in [0.7f32, 1.0, 1.01, 1.3, 1.5, 2.5] {
            for k in 1..=200 {
                let outer = k as f32 / 200.0;
                let inner = inside(eta, outer);
                let (found, exact) = (passes(eta, outer, inner), fresnel::transmittance(eta.into(), outer.into()));
                assert!((f64::from(found) - exact).abs() < 2e-5, "{eta} {outer}: {found}, {exact}");
                if inner > 0.01 {
                    assert!((outside(eta, inner) - outer).abs() < 1e-4 / outer.max(0.01), "{eta} {outer}");
                }
                // Straight through where nothing refracts, else Snell's law.
                let toward = [(1.0 - outer * outer).max(0.0).sqrt(), 0.0, outer];
                if inner > 0.0 {
                    let way = refracted(eta, toward, [0.0, 0.0, 1.0]);
                    assert!((way[0] + toward[0] / eta).abs() < 1e-6 && (dot(way, way) - 1.0).abs() < 1e-6);
                }
            }
        }
    }

    #[test]
    fn directions_about_an_axis_have_their_cosine() {
        for k in 0..500 {
            let r = random4(k, 1, 2, 3).map(unit_random);
            let axis = about([0.0, 0.0, 1.0], 2.0 * r[0] - 1.0, r[1]);
            let way = about(axis, 2.0 * r[2] - 1.0, r[3]);
            assert!((dot(axis, way) - (2.0 * r[2] - 1.0)).abs() < 1e-6 && (dot(way, way) - 1.0).abs() < 2e-6);
        }
    }

    #[test]
    fn random_numbers_are_even_and_apart() {
        // Means and correlations of four words, of neighbours in number and in flight.
        let count = 100_000u32;
        let close = |sum: f64, about: &str| assert!((sum / f64::from(count)).abs() < 0.004, "{about}: {sum}");
        let at = |number, flight| random4(number, flight, 0, 1).map(|r| f64::from(unit_random(r)) - 0.5);
        let all: Vec<[[f64; 4]; 3]> = (0..count).map(|k| [at(k, 5), at(k + 1, 5), at(k, 6)]).collect();
        for a in 0..4 {
            close(all.iter().map(|r| r[0][a]).sum(), "mean");
            close(all.iter().map(|r| r[0][a] * r[0][a] - 1.0 / 12.0).sum(), "spread");
            for b in 0..4 {
                close(all.iter().map(|r| r[0][a] * r[1][b]).sum(), "next photon");
                close(all.iter().map(|r| r[0][a] * r[2][b]).sum(), "next flight");
                close(all.iter().filter(|_| a != b).map(|r| r[0][a] * r[0][b]).sum(), "words");
            }
        }
    }
}
