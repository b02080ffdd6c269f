//! Single form factors as `milkglass eval form-factor` computes them (stage `evaluate`), on every device: the scaled
//! error |F - F_ref| / R_full over seeded triangle-receiver pairs, and over closed meshes.
//!
//! Fails without a device, unless `MILKGLASS_NO_DEVICE=1` waives it, which is printed.

use crate::devices::on_devices;
use crate::population::seeded::{Seeded, percentile};
use crate::population::{heights, longest, medium, population};
use glam::DVec3;
use milkglass::internals::dipole::form_factor::Distance;
use milkglass::internals::dipole::form_factor::exact::{edge_form_exact, edge_form_fine};
use milkglass::internals::dipole::profile::Dipole;
use milkglass::measure::stress::factor::{Pair, evaluated};
use milkglass::scene::Scene;
use rayon::prelude::*;

/// The bounds hold where the nearer source is farther than this from the plane, in longest edges. Below it, rounding a
/// corner to `f32` moves the corner by a significant part of the source's height.
const HEIGHT: f64 = 1e-4;

/// The form factor of a triangle with these vertex indices at a point.
type Form = fn(&[DVec3; 3], [u32; 3], DVec3, &Dipole, Distance) -> f64;

/// Scaled errors of a device's values, per channel.
fn scaled(pairs: &[Pair], values: &[[f32; 3]], exact: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let error = |((pair, value), exact): ((&Pair, &[f32; 3]), &[f64; 3])| {
        let dipoles = pair.dipoles();
        [0, 1, 2].map(|c| (f64::from(value[c]) - exact[c]).abs() / dipoles[c].total())
    };
    pairs.iter().zip(values).zip(exact).map(error).collect()
}

#[test]
fn with_6_nodes_a_panel_the_edge_form_has_lost_no_digit_that_counts() {
    let distances = [Distance::Radial, Distance::Table1 { clamp: true }];
    let mut worst = 0.0f64;
    for pair in population(1975, 3000) {
        for (dipole, distance) in pair.dipoles().iter().flat_map(|dipole| distances.map(|distance| (dipole, distance)))
        {
            let form = |form: Form| form(&pair.triangle, [0, 1, 2], pair.point, dipole, distance);
            let (fine, exact) = (form(edge_form_fine), form(edge_form_exact));
            worst = worst.max((fine - exact).abs() / dipole.total());
        }
    }
    println!("largest scaled error {worst:.1e}");
    assert!(worst > 0.0 && worst < 1e-8, "{worst:e}");
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_population_keeps_within_its_error() {
    let pairs = population(2003, 6000);
    let exact: Vec<_> = pairs.par_iter().map(Pair::exact).collect();
    let heights: Vec<_> = pairs.iter().map(heights).collect();
    on_devices(|device| {
        let values = evaluated(&pairs, Some(device)).unwrap();
        assert!(values.iter().flatten().all(|x| x.is_finite() && *x >= 0.0), "{}", device.name());
        let errors = scaled(&pairs, &values, &exact);
        let (mut within, mut nearer) = (Vec::new(), Vec::new());
        for (&error, &height) in errors.iter().flatten().zip(heights.iter().flatten()) {
            let list = if height > HEIGHT { &mut within } else { &mut nearer };
            list.push(error);
        }
        let (p99, worst) = (percentile(&mut within, 0.99), percentile(&mut within, 1.0));
        let (many, few, p99_nearer) = (within.len(), nearer.len(), percentile(&mut nearer, 0.99));
        let name = device.name();
        println!("{name}: {many} pairs: p99 {p99:.1e}, largest {worst:.1e}; {few} nearer: p99 {p99_nearer:.1e}");
        assert!(many > 10_000 && few > 300, "{many} and {few} pairs are a poor test");
        assert!(p99 <= 1e-4 && worst <= 1e-3, "{name}: p99 {p99:e}, largest {worst:e}");
    });
}

/// All faces of a closed shape paired with each of 24 receivers: at centroids, corners and edge midpoints, half of them
/// off the surface.
fn closed(shape: &str, detail: u32, random: &mut Seeded) -> (usize, Vec<Pair>) {
    let mesh = Scene::load_with(shape, &[format!("object.0.detail={detail}")]).unwrap().objects[0].mesh.clone();
    let faces: Vec<[DVec3; 3]> = (0..mesh.triangles.len()).filter_map(|face| mesh.corners(face)).collect();
    let mut pairs = Vec::new();
    for k in 0..24 {
        let [a, b, c] = faces[(random.bits() % faces.len() as u64) as usize];
        let length = longest([a, b, c]);
        let base = [(a + b + c) / 3.0, a, 0.5 * (b + c)][k % 3];
        let height = if k < 12 { 0.0 } else { length * random.log_between(1e-3, 10.0) };
        let side = if random.bits().is_multiple_of(2) { height } else { -height };
        let point = base + side * (b - a).cross(c - a).normalize();
        let media = [0; 3].map(|_| medium(random, length));
        pairs.extend(faces.iter().map(|&triangle| Pair { triangle, point, media }));
    }
    (faces.len(), pairs)
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn over_a_closed_mesh_they_add_up() {
    let mut random = Seeded(17);
    for (shape, detail) in [("sphere", 3), ("slab", 8)] {
        let (faces, pairs) = closed(shape, detail, &mut random);
        let exact: Vec<_> = pairs.par_iter().map(Pair::exact).collect();
        on_devices(|device| {
            let values = evaluated(&pairs, Some(device)).unwrap();
            let (mut worst, mut sums) = (0.0f64, 0);
            let receivers = pairs.chunks(faces).zip(values.chunks(faces)).zip(exact.chunks(faces));
            for ((pairs, values), exact) in receivers {
                // Skip channels where any face has a source nearer than `HEIGHT`, as in the population.
                for (c, dipole) in pairs[0].dipoles().iter().enumerate() {
                    if pairs.iter().any(|pair| heights(pair)[c] <= HEIGHT) {
                        continue;
                    }
                    let error: f64 =
                        values.iter().zip(exact).map(|(value, exact)| f64::from(value[c]) - exact[c]).sum();
                    worst = worst.max(error.abs() / dipole.total());
                    sums += 1;
                }
            }
            println!("{}: {sums} sums over the {faces} faces of the {shape}: largest {worst:.1e}", device.name());
            assert!(sums > 40 && worst <= 1e-4, "{}, {shape}: {worst:e} of {sums}", device.name());
        });
    }
}
