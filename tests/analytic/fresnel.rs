//! Walsh's closed form against quadrature of the directional transmittance, and against the polynomial.

use super::materials::MATERIALS;
use milkglass::internals::dipole::form_factor::gauss::legendre;
use milkglass::internals::lighting::fresnel::*;

/// `1 - 2 int T(mu) mu dmu` above the critical angle's cosine, substituted to remove the square root there.
fn diffuse_reflectance(eta: f64) -> f64 {
    let critical = if eta < 1.0 { (1.0 - eta * eta).sqrt() } else { 0.0 };
    let rule = legendre(64);
    let mut sum = 0.0;
    // Panels shrink towards the critical cosine, where eta near 1 makes a thin layer.
    let mut high = 1.0;
    for level in 0..40 {
        let low = if level == 39 { 0.0 } else { high * 0.5 };
        for node in &rule {
            let x = 0.5 * (low + high) + 0.5 * (high - low) * node.x;
            let mu = critical + (1.0 - critical) * x * x;
            let jacobian = 2.0 * x * (1.0 - critical) * 0.5 * (high - low);
            sum += node.weight * jacobian * 2.0 * mu * transmittance(eta, mu);
        }
        high = low;
    }
    1.0 - sum
}

#[test]
fn closed_form_is_the_integral() {
    for eta in [1.0001, 1.0009, 1.0011, 1.01, 1.1, 1.3, 1.5, 2.0, 2.42, 4.0, 20.0] {
        let (external, internal) = (diffuse_external_exact(eta), diffuse_internal_exact(eta));
        let slack = 1e-12 + if eta < 1.1 { 1e-9 * external } else { 0.0 };
        assert!((external - diffuse_reflectance(eta)).abs() < slack, "{eta} outside");
        assert!((internal - diffuse_reflectance(1.0 / eta)).abs() < slack, "{eta} inside");
        // Below 1, inside and outside swap.
        assert!((diffuse_internal_exact(1.0 / eta) - external).abs() < 1e-11, "{eta}");
        assert!((diffuse_external_exact(1.0 / eta) - internal).abs() < 1e-11, "{eta}");
    }
}

#[test]
fn polynomial_is_near_in_its_range_only() {
    let error = |eta: f64| boundary(diffuse_internal_polynomial(eta)) / boundary(diffuse_internal_exact(eta)) - 1.0;
    for step in 0..=100 {
        let eta = 1.0 + 0.01 * f64::from(step);
        assert!(error(eta).abs() < 4e-3, "{eta}: {}", error(eta));
    }
    assert!(error(3.0) > 0.2);
    for step in 0..50 {
        let eta = 0.5 + 0.01 * f64::from(step);
        let gap = diffuse_internal_polynomial(eta) - diffuse_internal_exact(eta);
        assert!(gap.abs() < 1.5e-3, "{eta}: {gap}");
    }
}

#[test]
fn the_materials_boundary_terms() {
    // The published A follows from the polynomial; the exact A differs by less than 0.4 %.
    for material in &MATERIALS {
        let published = if material.eta == 1.5 { 3.959_497_4 } else { 2.602_064_4 };
        let polynomial = boundary(diffuse_internal_polynomial(material.eta));
        assert!((polynomial - published).abs() < 1e-6);
        let exact = boundary(diffuse_internal_exact(material.eta));
        assert!((exact / published - 1.0).abs() < 4e-3, "{}", exact / published - 1.0);
    }
}
