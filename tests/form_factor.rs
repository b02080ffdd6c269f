//! Single form factors as `milkglass eval form-factor` computes them (stage `evaluate`), on every device: the scaled
//! error |F - F_ref| / R_full over seeded pairs of triangle and receiver, and over closed meshes.
//!
//! Without a device this fails, unless `MILKGLASS_NO_DEVICE=1` waives it, and then it says so.

mod devices;
mod population;
#[path = "analytic/seeded.rs"]
mod seeded;

use devices::on_devices;
use glam::DVec3;
use milkglass::measure::stress::factor::{Pair, evaluated};
use milkglass::scene::Scene;
use population::{heights, population};
use seeded::{Seeded, percentile};

/// Scaled errors of a device, channel by channel.
fn scaled(pairs: &[Pair], values: &[[f32; 3]], exact: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let error = |((pair, value), exact): ((&Pair, &[f32; 3]), &[f64; 3])| {
        let dipoles = pair.dipoles();
        [0, 1, 2].map(|c| (f64::from(value[c]) - exact[c]).abs() / dipoles[c].total())
    };
    pairs.iter().zip(values).zip(exact).map(error).collect()
}

#[test]
fn a_population_keeps_within_its_error() {
    let pairs = population(2003, 6000);
    let exact: Vec<_> = pairs.iter().map(Pair::exact).collect();
    let heights: Vec<_> = pairs.iter().map(heights).collect();
    on_devices(|device| {
        let values = evaluated(&pairs, Some(device)).unwrap();
        for (k, &x) in values.iter().flatten().enumerate() { if !(x.is_finite() && x >= 0.0) {
            let p = &pairs[k / 3]; let d = p.dipoles()[k % 3]; let l = population::longest(p.triangle);
            println!("{x} sl {:.2e} zr/L {:.2e} h {:.2e} dist/L {:.2e} exact {:.2e} area/L2 {:.1e}", d.sigma*l, d.z_real/l, heights[k/3][k%3], p.point.distance(p.triangle[0])/l, exact[k/3][k%3],
              milkglass::dipole::form_factor::vector_area(&p.triangle).length()/l/l);
        } }
        let errors = scaled(&pairs, &values, &exact);
        let (mut within, mut nearer) = (Vec::new(), Vec::new());
        for (k, (&error, &height)) in errors.iter().flatten().zip(heights.iter().flatten()).enumerate() {
            if height > 1e-4 {
                within.push(error);
                if error > 3e-4 { 
            let p = &pairs[k / 3]; let d = p.dipoles()[k % 3]; let l = population::longest(p.triangle);
            println!("ERR {error:.1e} sl {:.2e} zr/L {:.2e} h {:.2e} dist/L {:.2e} exact {:.2e} area/L2 {:.1e}", d.sigma*l, d.z_real/l, heights[k/3][k%3], p.point.distance(p.triangle[0])/l, exact[k/3][k%3],
              milkglass::dipole::form_factor::vector_area(&p.triangle).length()/l/l);
 }
            } else {
                nearer.push(error);
            }
        }
        let (p99, worst) = (percentile(&mut within, 0.99), percentile(&mut within, 1.0));
        let p99_nearer = percentile(&mut nearer, 0.99);
        let (many, few) = (within.len(), nearer.len());
        println!("{}: {many} pairs: p99 {p99:.1e}, largest {worst:.1e}; {few} nearer: p99 {p99_nearer:.1e}", device.name());
        assert!(p99 <= 1e-4 && worst <= 1e-3, "{}: p99 {p99:e}, largest {worst:e}", device.name());
    });
}
