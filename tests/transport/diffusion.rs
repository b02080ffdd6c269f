//! Diffusion on the shape: against closed forms, and against the dense system of the same triangles.

use std::cell::RefCell;

use milkglass::internals::dipole::form_factor::gauss::legendre;
use milkglass::internals::layout::{BUFFER_IDS, Buffers};
use milkglass::internals::pipeline::plan::{Change, Goal, Options, ShadingMethod};
use milkglass::internals::session::run::Session;
use milkglass::internals::state::State;
use milkglass::internals::transport::diffusion::sums::pair;
use milkglass::measure::estimate::Quality;
use milkglass::scene::Scene;
use rayon::prelude::*;

use crate::devices;

pub(super) fn options() -> Options {
    Options { transport: ShadingMethod::Diffusion, goal: Goal::Radiosity, ..Options::default() }
}

pub(super) fn scene(name: &str, sets: &[&str]) -> Scene {
    Scene::load_with(name, &sets.iter().map(ToString::to_string).collect::<Vec<_>>()).unwrap()
}

/// A solved session on the CPU.
fn solved(scene: &Scene) -> Session {
    let mut session = Session::new(scene, None, options()).unwrap();
    session.frame(Change::EVERYTHING).unwrap();
    session
}

fn areas(data: &Buffers) -> Vec<f64> {
    (0..data.triangles.len()).map(|face| f64::from(data.clusters[data.leaves[face] as usize].area)).collect()
}

/// i_l(x), the modified spherical Bessel function of the first kind, by its series.
fn bessel(l: i32, x: f64) -> f64 {
    let first = (1..=l).fold(1.0, |product, n| product * x / f64::from(2 * n + 1));
    let mut term = first;
    let mut sum = first;
    for k in 1..200 {
        term *= 0.5 * x * x / (f64::from(k) * f64::from(2 * l + 2 * k + 1));
        sum += term;
    }
    sum
}

/// Light of this harmonic deposited at a depth below every triangle of a ball: the share of it that leaves.
fn share_of_harmonic(detail: u32, l: i32, depth: f64) -> f64 {
    let detail = format!("object.0.detail={detail}");
    let scene = scene("sphere", &[&detail, "object.0.size=20", "transport.steps=12", "transport.tolerance=1e-4"]);
    let session = solved(&scene);
    let mut state: State = session.state().clone();
    let length = session.prepared().units.length;
    let harmonic = |z: f64| match l {
        0 => 1.0,
        1 => z,
        2 => 1.5 * z * z - 0.5,
        _ => (35.0 * z.powi(4) - 30.0 * z * z + 3.0) / 8.0,
    };
    let faces = state.data.triangles.len();
    let mut light = Vec::new();
    for face in 0..faces {
        let cluster = &state.data.clusters[state.data.leaves[face] as usize];
        let normal = cluster.normal.map(|n| f64::from(n) / f64::from(cluster.area));
        let middle = cluster.center.map(f64::from);
        light.push(harmonic(middle[2] / middle.iter().map(|x| x * x).sum::<f64>().sqrt()));
        let deposit = &mut state.data.deposits[face];
        deposit.red = normal.map(|n| (-n * depth * length) as f32);
        let albedo = 2.19 / 2.1921;
        deposit.light = [(albedo * light[face]) as f32, 0.0, 0.0];
    }
    let steps = session.plan().steps(&state, Change::EVERYTHING);
    let own = ["boundary_integrals", "krylov_step", "krylov_sum"];
    steps.iter().filter(|step| own.contains(&step.stage.name)).for_each(|step| step.reference(&mut state));
    let areas = areas(&state.data);
    let sum = |f: &dyn Fn(usize) -> f64| (0..faces).map(|face| areas[face] * light[face] * f(face)).sum::<f64>();
    sum(&|face| f64::from(state.data.solution[face][0])) / sum(&|face| light[face])
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn harmonics_on_a_ball_have_their_closed_form() {
    // Red marble, radius 10 mm, light deposited a mean free path deep.
    let (a, extinction, sigma_a) = (10.0, 2.1921, 0.0021);
    let (depth, k) = (1.0 / extinction, (3.0f64 * sigma_a * extinction).sqrt());
    let z_b = 2.0 * 3.627_93 / (3.0 * extinction);
    let exact = |l: i32| {
        let slope = (bessel(l, k * a + 1e-4) - bessel(l, k * a - 1e-4)) / 2e-4;
        2.19 / extinction * bessel(l, k * (a - depth)) / (bessel(l, k * a) + z_b * k * slope)
    };
    for (l, known) in [(0, 0.936_623), (1, 0.826_738), (2, 0.726_396), (4, 0.566_480)] {
        assert!((exact(l) - known).abs() < 1e-5, "{l}: {}", exact(l));
        let [coarse, fine] = [2, 3].map(|detail| (share_of_harmonic(detail, l, depth) - known).abs());
        println!("l = {l}: off by {coarse:.1e} with 320 triangles, {fine:.1e} with 1,280");
        assert!(fine < 5e-3 && fine < 0.6 * coarse, "{l}: {coarse:.1e} {fine:.1e}");
    }
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_wide_slab_is_a_slab() {
    // 1.6 mm thick and 8 across, light from all around: in the middle, both sides' light, each by the closed form.
    let (scattering, sigma_a, thick) = (3.0f64, 0.3f64, 1.6f64);
    let extinction = scattering + sigma_a;
    let sets = [
        "object.0.shape=slab",
        "object.0.detail=48",
        "object.0.size=8",
        "object.0.material={ sigma_s_prime = 3, sigma_a = 0.3, eta = 1.5 }",
        "light.0={ type='environment', radiance=1, occlusion=0 }",
    ];
    let scene = scene("sphere", &sets);
    let mut session = solved(&scene);
    let found: Vec<f64> = session
        .faces()
        .unwrap()
        .iter()
        .filter(|face| face.center.truncate().length() < 1.2 && face.center.z.abs() > 0.79)
        .map(|face| face.radiosity[0] / face.irradiance[0])
        .collect();
    let path = 0.884_54 / extinction;
    let tau = thick / path;
    let (albedo, z) = (scattering / extinction * (1.0 - (-tau).exp()), path * (1.0 - tau / tau.exp_m1()));
    let (k, z_b) = ((3.0 * sigma_a * extinction).sqrt(), 2.0 * 3.627_93 / (3.0 * extinction));
    let f = |t: f64| (k * t).sinh() + k * z_b * (k * t).cosh();
    let den = (1.0 + (k * z_b).powi(2)) * (k * thick).sinh() + 2.0 * k * z_b * (k * thick).cosh();
    let exact = albedo * (f(thick - z) + f(z)) / den;
    let mean = found.iter().sum::<f64>() / found.len() as f64;
    assert!(found.len() > 50 && (mean / exact - 1.0).abs() < 4e-3, "{} faces: {mean}, {exact}", found.len());
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn the_double_layer_of_a_closed_surface_is_minus_one_half() {
    for shape in ["sphere", "torus", "slab"] {
        let shape = format!("object.0.shape={shape}");
        let sets = [&shape, "object.0.detail=3", "object.0.material={ sigma_s_prime = 2, sigma_a = 0, eta = 1.4 }"];
        let session = solved(&scene("sphere", &sets));
        let (data, nodes) = (&session.state().data, legendre(12));
        let faces = data.triangles.len();
        let layer_at =
            |face: usize| (0..faces).map(|emitter| pair(data, [emitter, face], 0, false, &nodes)[1]).sum::<f64>();
        let worst = (0..faces).into_par_iter().map(|face| (layer_at(face) + 0.5).abs()).reduce(|| 0.0, f64::max);
        assert!(worst < 1e-4, "{shape}: {worst}");
    }
}

#[test]
fn a_clear_object_is_solved_to_its_tolerance() {
    // Free paths of 1 to 1000 of the ball: even light comes back into itself but for a thousandth, and errors of the
    // product grow by that in the solution. Nothing is absorbed: what collides leaves.
    let sets = [
        "object.0.detail=2",
        "object.0.size=1",
        "object.0.material={ sigma_s_prime=[1e-3, 0.1, 1], sigma_a=0, eta=1.5 }",
    ];
    devices::on_devices(|device| {
        let mut session = Session::new(&scene("sphere", &sets), Some(device), options()).unwrap();
        session.frame(Change::EVERYTHING).unwrap();
        session.fetch(BUFFER_IDS).unwrap();
        let data = &session.state().data;
        let areas = areas(data);
        for c in 0..3 {
            let sum = |value: &dyn Fn(usize) -> f32| -> f64 {
                areas.iter().enumerate().map(|(face, area)| area * f64::from(value(face))).sum()
            };
            let (left, light) = (sum(&|face| data.solution[face][c]), sum(&|face| data.deposits[face].light[c]));
            println!("channel {c}: {:.1e}", left / light - 1.0);
            assert!((left / light - 1.0).abs() < 5e-3, "channel {c}: {left} of {light}");
        }
    });
}

/// The distance of a solution from that of the dense system, relative, in one channel.
pub(super) fn off(data: &Buffers, c: usize, wanted: &[f64]) -> f64 {
    let areas = areas(data);
    let norm = |value: &dyn Fn(usize) -> f64| {
        areas.iter().enumerate().map(|(face, area)| area * value(face).powi(2)).sum::<f64>().sqrt()
    };
    norm(&|face| f64::from(data.solution[face][c]) - wanted[face]) / norm(&|face| wanted[face])
}

/// The solution of the dense system in f64, in one channel, by elimination.
pub(super) fn dense(data: &Buffers, c: usize) -> Vec<f64> {
    let (faces, nodes) = (data.triangles.len(), legendre(12));
    let mut rows: Vec<Vec<f64>> = (0..faces)
        .into_par_iter()
        .map(|face| {
            let mut row: Vec<f64> =
                (0..faces).map(|emitter| pair(data, [emitter, face], c, false, &nodes).iter().sum()).collect();
            row[face] += 0.5;
            let light = |emitter: usize| f64::from(data.deposits[emitter].light[c]);
            let lit = (0..faces).filter(|emitter| light(*emitter) > 0.0);
            row.push(lit.map(|emitter| light(emitter) * pair(data, [emitter, face], c, true, &nodes)[0]).sum());
            row
        })
        .collect();
    for k in 0..faces {
        let pivot = (k..faces).max_by(|&a, &b| rows[a][k].abs().total_cmp(&rows[b][k].abs())).unwrap();
        rows.swap(k, pivot);
        let (done, rest) = rows.split_at_mut(k + 1);
        let first = &done[k];
        rest.par_iter_mut().for_each(|row| {
            let by = row[k] / first[k];
            row[k..].iter_mut().zip(&first[k..]).for_each(|(a, b)| *a -= by * b);
        });
    }
    let mut found = vec![0.0; faces];
    for k in (0..faces).rev() {
        let sum: f64 = (k + 1..faces).map(|j| rows[k][j] * found[j]).sum();
        found[k] = (rows[k][faces] - sum) / rows[k][k];
    }
    found
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn tolerances_are_met_against_the_dense_system() {
    let cases: [(&str, &[&str]); 4] = [
        ("sphere", &["object.0.detail=3", "object.0.size=20"]),
        ("sphere", &["object.0.shape=torus", "object.0.detail=28", "object.0.material.preset=wholemilk"]),
        ("sphere", &["object.0.shape=slab", "object.0.detail=14", "object.0.material.preset=skin1"]),
        (
            "sphere",
            &["object.0.detail=3", "object.0.size=300", "object.0.deform.0={ type='noise', amplitude=40, scale=90 }"],
        ),
    ];
    for (name, sets) in cases {
        let known: RefCell<Vec<Vec<f64>>> = RefCell::default();
        for tolerance in [1e-2, 1e-3, 1e-4] {
            let asked = format!("transport.tolerance={tolerance}");
            let scene = scene(name, &[sets, &[&asked]].concat());
            let (all, qualities) = (RefCell::new(Vec::new()), RefCell::new(Vec::new()));
            devices::on_devices(|device| {
                let estimated = Options { estimate: true, ..options() };
                let mut session = Session::new(&scene, Some(device), estimated).unwrap();
                session.frame(Change::EVERYTHING).unwrap();
                session.fetch(BUFFER_IDS).unwrap();
                let data = &session.state().data;
                let (mut known, mut worst) = (known.borrow_mut(), Vec::new());
                if known.is_empty() {
                    *known = (0..3).map(|c| dense(data, c)).collect();
                }
                worst.extend(known.iter().enumerate().map(|(c, wanted)| off(data, c, wanted)));
                println!("{sets:?} {tolerance:e}: {:?} {:?}", worst, session.solve_reports());
                let quality = |session: &Session| {
                    let data = &session.state().data;
                    let faces = 0..data.triangles.len();
                    let at = |values: &[[f32; 3]], face: usize| values[face].map(f64::from);
                    let off =
                        |face: usize| [0, 1, 2].map(|c| (at(&data.radiosity, face)[c] - known[c][face].max(0.0)).abs());
                    let errors: Vec<[f64; 3]> = faces.clone().map(off).collect();
                    let estimates: Vec<[f64; 3]> = faces.clone().map(|face| at(&data.estimate, face)).collect();
                    Quality::of(&vec![1.0; faces.len()], &estimates, &errors)
                };
                let own = quality(&session);
                session.sharpen().unwrap();
                let sharpened = quality(&session);
                println!("own {own:?}, sharpened {sharpened:?}");
                qualities.borrow_mut().push([own, sharpened]);
                all.borrow_mut().append(&mut worst);
            });
            let most = all.into_inner().into_iter().fold(0.0, f64::max);
            assert!(most < tolerance, "{sets:?}: {most:.1e} at {tolerance:e}");
            for [own, sharpened] in qualities.into_inner() {
                assert!(own.covered > 0.98 && own.ratio < 50.0, "{sets:?}: {own:?}");
                assert!(sharpened.covered > 0.95 && sharpened.ratio < 5.0, "{sets:?}: {sharpened:?}");
            }
        }
    }
}

#[test]
fn open_surfaces_are_refused() {
    let refused = |sets: &[&str]| Session::new(&scene("slab", sets), None, options()).err().unwrap().to_string();
    let mut open = scene("sphere", &["object.0.detail=1"]);
    open.objects[0].mesh.open_edges = 3;
    let told = Session::new(&open, None, options()).err().unwrap().to_string();
    assert!(told.contains("object.0: diffusion is solved inside a closed object; found 3 open edges"), "{told}");
    assert!(refused(&["object.0.material.two_sided=true"]).contains("two_sided = true"));
}
