//! Fresnel terms of a smooth dielectric boundary: directional, diffuse, and the dipole's `A`.
//!
//! The diffuse terms are Walsh's closed form (1926) of the hemispherical average of the Fresnel
//! equations. The polynomial `F_dr` of Mertens et al. 2003 (Table 1; Egan and Hilgeman 1973) is kept
//! beside it: it is within 0.4 % of `A` for an index of 1.0 to 2.0 and breaks down above 2.2.
//! Everywhere `eta` is the relative index, inside over outside, and must be positive.

/// Unpolarised Fresnel transmittance into the medium, in [0, 1].
///
/// `eta`: index inside over outside, positive. `cos_theta`: cosine between the normal and the
/// direction outside, in [0, 1]; nothing passes at 0 or below. At `eta` = 1 all passes.
#[must_use]
pub fn transmittance(eta: f64, cos_theta: f64) -> f64 {
    if cos_theta <= 0.0 {
        return 0.0;
    }
    if eta == 1.0 {
        return 1.0;
    }
    // Snell's law; beyond the critical angle (eta < 1 only) all is reflected.
    let cos_out = cos_theta.min(1.0);
    let cos2 = cos_out * cos_out - (1.0 - eta) * (1.0 + eta);
    if cos2 <= 0.0 {
        return 0.0;
    }
    let cos_in = cos2.sqrt() / eta;
    // One minus the reflectance of both polarisations, from positive terms only.
    let (across, along) = (cos_out + eta * cos_in, eta * cos_out + cos_in);
    (2.0 * eta * (cos_out / across * (cos_in / across) + cos_out / along * (cos_in / along))).min(1.0)
}

/// Diffuse reflectance of the boundary seen from inside, in [0, 1): `F_int`, exact.
///
/// The average of the Fresnel reflectance over directions inside, weighted by the cosine.
/// By reciprocity `F_int = 1 - (1 - F_ext) / eta^2`; for `eta` < 1 inside and outside swap.
#[must_use]
pub fn diffuse_internal_exact(eta: f64) -> f64 {
    if eta > 1.0 {
        from_thin(eta - 1.0) * inverse_square(eta) + gap(eta)
    } else if eta < 1.0 {
        from_thin((1.0 - eta) / eta)
    } else {
        0.0
    }
}

/// Diffuse reflectance of the boundary seen from outside, in [0, 1): `F_ext`, exact.
///
/// `eta`: index inside over outside, positive.
#[must_use]
pub fn diffuse_external_exact(eta: f64) -> f64 {
    if eta > 1.0 {
        from_thin(eta - 1.0)
    } else if eta < 1.0 {
        let inverse = 1.0 / eta;
        from_thin((1.0 - eta) / eta) * inverse_square(inverse) + gap(inverse)
    } else {
        0.0
    }
}

/// The square of the cosine at which facets of GGX's distribution are seen where the surface is seen edge-on: a fit for
/// indices of 1 and more.
#[must_use]
pub fn facet_tilt(alpha: f64) -> f64 {
    (2.0 * alpha / (1.0 + 3.0 * alpha)).powi(2)
}

/// The cosine to the eye of the facets that let light out of a surface, from the cosine of the surface itself. Their
/// [`transmittance`] is within 0.08 of the mean over the facets that the eye sees for indices of 1.05 to 2.5, and
/// within 0.03 for indices of 1.3 to 1.8 and alpha of 0.1 to 0.6.
#[must_use]
pub fn facet_cosine(cosine: f64, tilt: f64) -> f64 {
    if tilt > 0.0 { (cosine * cosine * (1.0 - tilt) + tilt).sqrt() } else { cosine }
}

/// At least 1: the factor that leaving light lacks if each direction gets its transmittance of it. For a smooth surface
/// `1 / (1 - F_ext)`, because its directional transmittances average to `1 - F_ext`. `eta`: index inside over outside,
/// positive.
#[must_use]
pub fn exit(eta: f64, tilt: f64) -> f64 {
    if tilt == 0.0 {
        return 1.0 / (1.0 - diffuse_external_exact(eta));
    }
    let steps = 1024;
    let square = |k: u32| (f64::from(k) + 0.5) / f64::from(steps);
    f64::from(steps) / (0..steps).map(|k| transmittance(eta, facet_cosine(square(k).sqrt(), tilt))).sum::<f64>()
}

/// The paper's `F_dr`: diffuse internal reflectance as a polynomial in the index.
///
/// Meant for `eta` in about 0.5 to 2.2. For `eta` >= 1 this is Table 1 of Mertens et al. 2003; below
/// 1, where that polynomial is negative, the companion fit of Egan and Hilgeman is used.
#[must_use]
pub fn diffuse_internal_polynomial(eta: f64) -> f64 {
    let inverse = 1.0 / eta;
    if eta >= 1.0 {
        -1.440 * inverse * inverse + 0.710 * inverse + 0.668 + 0.0636 * eta
    } else {
        -0.4399 + inverse * (0.7099 + inverse * (-0.3319 + inverse * 0.0636))
    }
}

/// The boundary term `A = (1 + F) / (1 - F)` of the dipole, at least 1 for `fresnel` in [0, 1).
///
/// `fresnel`: a diffuse internal reflectance, exact or polynomial. A value of 1 gives infinity.
#[must_use]
pub fn boundary(fresnel: f64) -> f64 {
    (1.0 + fresnel) / (1.0 - fresnel)
}

fn inverse_square(n: f64) -> f64 {
    1.0 / (n * n)
}

/// `1 - 1/n^2` without cancellation near 1.
fn gap(n: f64) -> f64 {
    (n - 1.0) * (n + 1.0) / (n * n)
}

/// Diffuse reflectance from the thin side onto an index `n = 1 + excess`, `excess` > 0: Walsh.
///
/// The closed form loses two digits for each power of ten in `excess`; below 0.001 its series
/// (with the logarithm kept, next term `excess^5`) is the better one.
fn from_thin(excess: f64) -> f64 {
    if excess < 1e-3 {
        let e = excess;
        let log = (0.5 * e).ln();
        let tail = -79.0 / 60.0 + e * (37.0 / 160.0 - 0.625 * log);
        return e * (1.0 / 3.0 + e * (0.5 * log + 19.0 / 24.0 + e * tail));
    }
    let n = 1.0 + excess;
    let n2 = n * n;
    // Above this the powers overflow before the value reaches its limit 1.
    if n > 1e15 {
        return 1.0;
    }
    let (minus, plus) = (excess * (n + 1.0), n2 + 1.0);
    let fourth = minus * plus;
    let ratio = minus / plus;
    0.5 + excess * (3.0 * n + 1.0) / (6.0 * (n + 1.0) * (n + 1.0))
        + n2 / plus * ratio * ratio * (excess / (n + 1.0)).ln()
        - 2.0 * n * n2 * (n2 + 2.0 * n - 1.0) / (plus * fourth)
        + 8.0 * (n2 / fourth) * (n2 / fourth) * ((n2 * n2 + 1.0) / plus) * excess.ln_1p()
}

#[cfg(test)]
mod tests {
    use crate::lighting::fresnel::*;

    #[test]
    fn normal_incidence_is_the_textbook_value() {
        assert!((transmittance(1.5, 1.0) - 0.96).abs() < 1e-15);
        assert_eq!(transmittance(1.0, 0.3), 1.0);
        assert_eq!(transmittance(1.0, 0.0), 0.0);
        assert_eq!(transmittance(0.5, 0.1), 0.0);
    }

    #[test]
    fn series_meets_the_closed_form() {
        let (below, above) = (from_thin(0.000_999_999_999), from_thin(0.001));
        assert!(((above - below) / above - 1e-9).abs() < 1e-9);
        assert_eq!(diffuse_internal_exact(1.0), 0.0);
        assert_eq!(boundary(diffuse_internal_exact(1.0)), 1.0);
    }

    /// The transmittance of GGX's facets, each by how large the eye sees it, by quadrature over their distribution.
    fn through_facets(eta: f64, alpha: f64, cosine: f64) -> f64 {
        let (steps, turns) = (400, 200);
        let (mut sum, mut whole) = (0.0, 0.0);
        for k in 0..steps * turns {
            // Of equal shares of the facets' area in the plane, D cos.
            let share = (f64::from(k / turns) + 0.5) / f64::from(steps);
            let turn = std::f64::consts::TAU * f64::from(k % turns) / f64::from(turns);
            let tangent = alpha * (share / (1.0 - share)).sqrt();
            // (o.h) / (n.h)
            let seen = (cosine + (1.0 - cosine * cosine).sqrt() * tangent * turn.cos()).max(0.0);
            sum += seen * transmittance(eta, seen / tangent.hypot(1.0));
            whole += seen;
        }
        sum / whole
    }

    #[test]
    fn light_leaves_a_rough_surface_through_the_facets_that_the_eye_sees() {
        for eta in [1.05, 1.3, 1.5, 1.8, 2.5] {
            for alpha in [0.02, 0.1, 0.3, 0.6, 1.0] {
                for cosine in [0.0, 0.05, 0.2, 0.5, 1.0] {
                    let found = transmittance(eta, facet_cosine(cosine, facet_tilt(alpha)));
                    let exact = through_facets(eta, alpha, cosine);
                    let usual = (1.3..=1.8).contains(&eta) && (0.1..=0.6).contains(&alpha);
                    let most = if usual { 0.03 } else { 0.08 };
                    assert!((found - exact).abs() < most, "{eta}, {alpha}, {cosine}: {found} {exact}");
                }
            }
        }
        assert!(through_facets(1.5, 0.3, 0.05) > 0.8 && transmittance(1.5, 0.05) < 0.26);
        assert_eq!([0.3, 1.0].map(|cosine| facet_cosine(cosine, facet_tilt(0.0))), [0.3, 1.0]);
    }

    #[test]
    fn known_transmitted_parts() {
        // 1 - F_ext at the two indices of the measured materials.
        assert!((1.0 - diffuse_external_exact(1.3) - 0.9389).abs() < 5e-5);
        assert!((1.0 - diffuse_external_exact(1.5) - 0.9082).abs() < 5e-5);
    }
}
