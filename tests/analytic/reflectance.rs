//! Total diffuse reflectance: closed form, quadrature, published figures, and one very large triangle.

use super::materials::channels;
use super::quadrature::on_line;
use glam::DVec3;
use milkglass::internals::dipole::form_factor::gauss::legendre;
use milkglass::internals::dipole::form_factor::{Distance, edge::edge_form, exact::edge_form_exact};
use std::f64::consts::PI;

#[test]
fn closed_form_is_the_plane_integral() {
    for (name, dipole, _) in channels() {
        // The integral beyond `far` is known: g(s), summed over the sources.
        let far = 1e3 * dipole.z_virtual;
        let disc = on_line(0.0, far, 0.5 * dipole.z_real, |r| 2.0 * PI * r * dipole.reflectance(r));
        let rest: f64 = dipole.depths().map(|z| z * (-dipole.sigma * far.hypot(z)).exp() / far.hypot(z)).iter().sum();
        let numeric = disc + 2.0 * PI * dipole.strength * rest;
        assert!((numeric / dipole.total() - 1.0).abs() < 1e-8, "{name}");
    }
}

#[test]
fn thirty_five_of_the_printed_reflectances() {
    let off: Vec<_> = channels()
        .filter(|(_, dipole, printed)| (dipole.total() - printed).abs() > 0.01)
        .map(|(name, ..)| name)
        .collect();
    assert_eq!(off, ["Chicken1 B"]);
}

#[test]
fn a_huge_triangle_is_the_plane() {
    let rule = legendre(24);
    for (name, dipole, _) in channels() {
        // Without absorption, the part outside the triangle falls only as 1 / size.
        let size = 1e7 * dipole.z_virtual;
        let corners = [0.0, 2.0, 4.0].map(|k: f64| {
            let angle = k * PI / 3.0;
            size * DVec3::new(angle.cos(), angle.sin(), 0.0)
        });
        let slack = if dipole.sigma == 0.0 { 1e-6 } else { 1e-12 };
        let exact = edge_form_exact(&corners, [0, 1, 2], DVec3::ZERO, &dipole, Distance::Radial);
        assert!((exact / dipole.total() - 1.0).abs() < slack, "{name}: {exact}");
        // A size that the quadrature is designed for.
        let near = corners.map(|c| c * 1e-5);
        let exact = edge_form_exact(&near, [0, 1, 2], DVec3::ZERO, &dipole, Distance::Radial);
        let quick = edge_form(&near, [0, 1, 2], DVec3::ZERO, &dipole, Distance::Radial, &rule);
        assert!((quick - exact).abs() < 1e-4, "{name}: {quick} {exact}");
    }
}
