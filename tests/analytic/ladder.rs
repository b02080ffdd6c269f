//! Each quadrature rule meets the tolerance that its distance was chosen for, on well-shaped triangles.

use super::materials::channels;
use super::quadrature::Area;
use crate::population::seeded::{Seeded, percentile};
use glam::DVec3;
use milkglass::internals::dipole::form_factor::{Distance, vector_area};
use milkglass::internals::dipole::form_factor::{ladder, ladder::Ladder, points};
use milkglass::internals::dipole::profile::Dipole;
use milkglass::internals::transport::links::reach;

/// A random triangle of extent about 1, all angles above 30 degrees, centred at the origin.
fn well_shaped(random: &mut Seeded) -> [DVec3; 3] {
    loop {
        let corners = [(); 3].map(|()| random.direction() * random.between(0.3, 1.0));
        let centre = corners.iter().sum::<DVec3>() / 3.0;
        let corners = corners.map(|c| c - centre);
        let angle = |k: usize| {
            let [a, b, c] = [0, 1, 2].map(|j| corners[(k + j) % 3]);
            (b - a).angle_between(c - a).to_degrees()
        };
        if (0..3).all(|k| angle(k) > 30.0) {
            return corners;
        }
    }
}

fn rule(rung: usize, triangle: &[DVec3; 3], x_o: DVec3, dipole: &Dipole) -> f64 {
    let sampled = |rule| points::sampled(triangle, x_o, dipole, Distance::Radial, rule);
    match rung {
        0 => points::midpoint_moment(triangle, x_o, dipole, Distance::Radial),
        1 => sampled(&points::THREE),
        2 => sampled(&points::SIX),
        _ => sampled(&points::TWELVE),
    }
}

/// The form factor by the area integral, which stays relatively accurate far away.
fn reference(area: &Area, triangle: &[DVec3; 3], x_o: DVec3, dipole: &Dipole) -> f64 {
    let normal = vector_area(triangle).normalize();
    let delta = (x_o - triangle[0]).dot(normal);
    let one = |z: f64| z * area.integral(*triangle, x_o - delta * normal, delta.hypot(z), dipole.sigma);
    dipole.strength * dipole.depths().map(one).iter().sum::<f64>()
}

#[test]
fn every_rung_keeps_its_tolerance() {
    let channels: Vec<_> = channels().collect();
    let area = Area::new();
    let mut worst = Vec::new();
    for tolerance in [1e-1, 1e-2, 1e-3, 1e-4] {
        let made = Ladder::new(tolerance);
        for rung in 0..ladder::RUNGS {
            let mut random = Seeded(rung as u64 + 7);
            let mut errors = Vec::new();
            while errors.len() < 4000 {
                // A triangle from far below to far above the mean free path, and a receiver at the reach of the rule.
                let (_, unit, _) = &channels[random.bits() as usize % channels.len()];
                let triangle = well_shaped(&mut random);
                let size = random.log_between(1e-3, 1e3);
                // The triangle keeps its extent of 1; the medium's lengths are scaled instead.
                let scale = size * unit.z_real;
                let dipole = Dipole {
                    sigma: unit.sigma * scale,
                    z_real: unit.z_real / scale,
                    z_virtual: unit.z_virtual / scale,
                    ..*unit
                };
                let reach = reach::reach2(points::trace(&triangle), &dipole, made.chi[rung], false);
                // Skip where any distance is accepted, or where the radius is cut off because e^-20 is negligible.
                let cut = dipole.sigma * (reach + dipole.z_real * dipole.z_real).sqrt() > 19.999;
                if reach == 0.0 || cut {
                    continue;
                }
                let x_o = random.direction() * reach.sqrt();
                let exact = reference(&area, &triangle, x_o, &dipole);
                // Smaller values approach the end of the range of f64.
                if exact > 1e-280 {
                    errors.push((rule(rung, &triangle, x_o, &dipole) / exact - 1.0).abs());
                }
            }
            let (p99, max) = (percentile(&mut errors, 0.99), percentile(&mut errors, 1.0));
            println!("tolerance {tolerance:e}, rung {rung}, chi {:.4}: p99 {p99:.2e}, max {max:.2e}", made.chi[rung]);
            if p99 > tolerance {
                worst.push((tolerance, rung, p99));
            }
        }
    }
    assert!(worst.is_empty(), "{worst:?}");
}
