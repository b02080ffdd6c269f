//! The displaced sources of Table 1: equal to the radial convention on a plane, and correct off it.

use super::quadrature::Area;
use crate::population::seeded::Seeded;
use glam::DVec3;
use milkglass::internals::dipole::form_factor::edge::edge_form;
use milkglass::internals::dipole::form_factor::exact::edge_form_exact;
use milkglass::internals::dipole::form_factor::points::{self, midpoint_moment, sampled};
use milkglass::internals::dipole::form_factor::{Distance, gauss};
use milkglass::internals::dipole::profile::Dipole;

const CLAMPED: Distance = Distance::Table1 { clamp: true };
const LITERAL: Distance = Distance::Table1 { clamp: false };
const TRIANGLE: [DVec3; 3] = [DVec3::ZERO, DVec3::X, DVec3::new(0.3, 0.8, 0.0)];

fn marble() -> Dipole {
    Dipole::new(2.62, 0.0041, 3.96)
}

/// Every rule under one convention, the exact form first.
fn all(x_o: DVec3, dipole: &Dipole, distance: Distance) -> [f64; 6] {
    [
        edge_form_exact(&TRIANGLE, [0, 1, 2], x_o, dipole, distance),
        edge_form(&TRIANGLE, [0, 1, 2], x_o, dipole, distance, &gauss::SIX),
        sampled(&TRIANGLE, x_o, dipole, distance, &points::TWELVE),
        sampled(&TRIANGLE, x_o, dipole, distance, &points::SIX),
        sampled(&TRIANGLE, x_o, dipole, distance, &points::THREE),
        midpoint_moment(&TRIANGLE, x_o, dipole, distance),
    ]
}

#[test]
fn on_a_plane_all_conventions_agree() {
    let mut random = Seeded(3);
    for _ in 0..100 {
        let x_o = DVec3::new(random.between(-3.0, 3.0), random.between(-3.0, 3.0), 0.0);
        let radial = all(x_o, &marble(), Distance::Radial);
        for distance in [CLAMPED, LITERAL] {
            for (a, b) in all(x_o, &marble(), distance).into_iter().zip(radial) {
                assert!((a - b).abs() <= 1e-12 * b.abs(), "{x_o} {a} {b}");
            }
        }
    }
}

#[test]
fn off_the_plane_the_sources_move_along_the_normal() {
    let (area, dipole, mut random) = (Area::new(), marble(), Seeded(4));
    for _ in 0..300 {
        let foot = DVec3::new(random.between(-1.0, 2.0), random.between(-1.0, 2.0), 0.0);
        let delta = random.between(-4.0, 4.0);
        let x_o = foot + delta * DVec3::Z;
        for (distance, least) in [(CLAMPED, 1.0), (LITERAL, 0.0)] {
            let mut truth = 0.0;
            for (z, moved) in [(dipole.z_real, delta + dipole.z_real), (dipole.z_virtual, delta - dipole.z_virtual)] {
                let h = moved.abs().max(least * z);
                truth += dipole.strength * z * area.integral(TRIANGLE, foot, h, dipole.sigma);
            }
            let [exact, quick, ..] = all(x_o, &dipole, distance);
            assert!((exact - truth).abs() <= 1e-9 * truth, "{x_o} {exact} {truth}");
            assert!((quick - truth).abs() <= 1e-3 * truth.max(1e-3), "{x_o} {quick} {truth}");
        }
    }
}

#[test]
fn far_away_every_rule_agrees() {
    for distance in [Distance::Radial, CLAMPED] {
        let [exact, rest @ ..] = all(DVec3::new(9.0, 4.0, 3.0), &marble(), distance);
        for (value, slack) in rest.into_iter().zip([1e-9, 1e-9, 1e-7, 1e-3, 1e-3]) {
            assert!((value / exact - 1.0).abs() < slack, "{value} {exact}");
        }
    }
}

#[test]
fn a_source_in_the_triangle_diverges_unless_clamped() {
    let dipole = Dipole { z_real: 0.5, ..marble() };
    let x_o = DVec3::new(0.4, 0.3, -0.5);
    assert_eq!(all(x_o, &dipole, LITERAL)[..2], [f64::INFINITY; 2]);
    let clamped = all(x_o, &dipole, CLAMPED)[1];
    assert!(clamped > 0.0 && clamped < dipole.total());
}
