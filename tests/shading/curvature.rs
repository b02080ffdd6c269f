//! Curvature at the scale of the scattering: smoothing, the default sigma_0, and what both are worth against the
//! dipole.

use crate::devices::on_devices;
use crate::shell::{bad, folder, good};
use glam::DVec3;
use milkglass::internals::layout::BufferId;
use milkglass::internals::pipeline::plan::{Change, Options, ShadingMethod};
use milkglass::internals::session::run::Session;
use milkglass::internals::shading::pack_normals::unpack;
use milkglass::internals::shading::smooth_curvature::kappa;
use milkglass::measure::validity::{lambert_share, places, share};
use milkglass::scene::Scene;

fn scene(name: &str, sets: &[&str]) -> Scene {
    let sets: Vec<String> = ["camera.size=[8, 8]"].iter().chain(sets).map(|set| (*set).to_string()).collect();
    Scene::load_with(name, &sets).unwrap()
}

fn session(scene: &Scene, device: Option<&milkglass::internals::gpu::Device>) -> Session {
    let options = Options { transport: ShadingMethod::Cdrf, ..Options::default() };
    let mut session = Session::new(scene, device, options).unwrap();
    session.frame(Change::EVERYTHING).unwrap();
    session.fetch(&[BufferId::curvature, BufferId::smooth_kappa, BufferId::packed_normals]).unwrap();
    session
}

/// Moves each vertex of a ball of radius 10 about the origin in or out by up to `amplitude`, as a scanner does.
fn scanned(mut ball: Scene, amplitude: f64) -> Scene {
    let mesh = &mut ball.objects[0].mesh;
    for (k, place) in mesh.positions.iter_mut().enumerate() {
        *place *= 1.0 + amplitude * (0.754_877 * k as f64 + 0.569_84 * (k as f64).sqrt()).fract() / 10.0;
    }
    ball
}

/// kappa times the radius, 10 mm, at every vertex: smoothed if `smooth`.
fn bends(session: &Session, smooth: bool) -> Vec<f64> {
    let (data, length) = (&session.state().data, session.units().length);
    let kappa_at = |v: usize| if smooth { kappa(data, v) } else { data.curvature[v].kappa };
    (0..data.curvature.len()).map(|v| 10.0 * length * f64::from(kappa_at(v))).collect()
}

/// The root mean square difference of two lists, relative to the second.
fn apart(found: &[f64], expected: &[f64]) -> f64 {
    let squares: f64 = found.iter().zip(expected).map(|(a, b)| (a - b).powi(2)).sum();
    (squares / expected.iter().map(|b| b * b).sum::<f64>()).sqrt()
}

const BALL: [&str; 3] = ["object.0.detail=5", "object.0.size=20", "object.0.material.sigma_0=1.4"];
const WRUNG: &str = "object.0.deform=[{ type = 'twist', angle = 90 }, { type = 'bend', angle = 60 }]";

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn noise_smaller_than_the_scattering_is_no_curvature() {
    let ones = |count: usize| vec![1.0; count];
    on_devices(|device| {
        for device in [None, Some(device)] {
            // Triangles have edges of 0.4 mm; their corners are up to 0.06 mm off.
            let noisy = session(&scanned(scene("sphere", &BALL), 0.06), device);
            let [rough, smooth] = [false, true].map(|smooth| bends(&noisy, smooth));
            let errors = [&rough, &smooth].map(|bends| apart(bends, &ones(bends.len())));
            assert!(errors[0] > 2.0 && errors[1] < 0.05, "{errors:?}");
            let worst = smooth.iter().fold(0.0, |worst: f64, bend| worst.max((bend - 1.0).abs()));
            assert!(worst < 0.25, "{worst}");

            // Deformed, noisy and even balls bend alike too, and not as the ball at rest.
            let wrung = [&BALL[..], &[WRUNG]].concat();
            let even = session(&scene("sphere", &wrung), device);
            let noisy = session(&scanned(scene("sphere", &wrung), 0.06), device);
            let expected = bends(&even, true);
            let errors = [false, true].map(|smooth| apart(&bends(&noisy, smooth), &expected));
            assert!(errors[0] > 1.0 && errors[1] < 0.1, "{errors:?}");
            assert!(apart(&expected, &ones(expected.len())) > 0.2);
        }
    });
}

#[test]
fn smoothing_keeps_what_is_even() {
    // A ball has one curvature, at any radius and however coarse it is.
    for (detail, radius) in [(2, 1.0), (2, 6.0), (4, 0.5), (4, 3.0), (4, 8.0), (4, 1e6)] {
        let sets = [format!("object.0.detail={detail}"), format!("object.0.material.curvature_radius={radius}")];
        let sets: Vec<&str> = sets.iter().map(String::as_str).chain(["object.0.size=20"]).collect();
        let ball = session(&scene("sphere", &sets), None);
        let [rough, smooth] = [false, true].map(|smooth| bends(&ball, smooth));
        assert!(apart(&smooth, &rough) < 0.01, "{detail} {radius}: {}", apart(&smooth, &rough));
    }
    // The far side of a thin bowl does not count: its two sheets bend to opposite sides.
    let mut bowl = scene("sphere", &["object.0.detail=4", "object.0.size=20", "object.0.material.curvature_radius=2"]);
    let mesh = &mut bowl.objects[0].mesh;
    let (count, outer) = (mesh.positions.len() as u32, mesh.triangles.len() as u32);
    mesh.positions.extend(mesh.positions.clone().into_iter().map(|p: DVec3| 0.97 * p));
    mesh.triangles.extend(mesh.triangles.clone().into_iter().map(|[a, b, c]| [a + count, c + count, b + count]));
    mesh.input_face = (0..2 * outer).collect();
    let bowl = session(&bowl, None);
    let [rough, smooth] = [false, true].map(|smooth| bends(&bowl, smooth));
    assert!(apart(&smooth, &rough) < 0.01, "{}", apart(&smooth, &rough));
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn radius_zero_is_the_estimate_of_the_triangles() {
    on_devices(|device| {
        for device in [None, Some(device)] {
            let sets = ["object.0.detail=64", "object.0.material.curvature_radius=0"];
            let rough = session(&scene("bust", &sets), device);
            let plan = rough.plan();
            let why = |stage: &str| plan.left_out.iter().find(|(name, _)| *name == stage).map(|(_, why)| why.clone());
            for stage in ["curvature_sums", "smooth_curvature"] {
                assert!(why(stage).unwrap().contains("every curvature_radius is 0"), "{stage}: {:?}", why(stage));
            }
            let data = &rough.state().data;
            assert!(data.smooth_kappa.is_empty() && data.curvature_sums.is_empty());
            for (bend, &packed) in data.curvature.iter().zip(&data.packed_normals) {
                let (stored, own) = (unpack(packed).1, f64::from(bend.kappa));
                assert!((stored - own).abs() <= 2.5e-4 * own + 1e-8, "{stored} {own}");
            }
            // Beside an object with a radius, too.
            let other = "object.1={ shape = 'sphere', detail = 2, size = 9, position = [60, 0, 0], material = { preset = 'skin1' } }";
            let both = session(&scene("bust", &[&sets[..], &[other]].concat()), device);
            let data = &both.state().data;
            let own = rough.state().data.curvature.len();
            assert!((0..own).all(|v| data.smooth_kappa[v] == data.curvature[v].kappa));
            assert!((own..data.curvature.len()).any(|v| data.smooth_kappa[v] != data.curvature[v].kappa));
        }
    });
}

#[test]
fn the_radius_follows_from_sigma_0_unless_given() {
    let radius = |sets: &[&str]| {
        let sets = [&["object.0.detail=2"], sets].concat();
        let session = session(&scene("sphere", &sets), None);
        f64::from(session.state().data.object_params[0].curvature_radius) / session.units().length
    };
    let near = |found: f64, expected: f64| assert!((found / expected - 1.0).abs() < 1e-4, "{found} {expected}");
    near(radius(&["object.0.material.sigma_0=[3, 2, 1]"]), 4.0);
    near(radius(&["object.0.material.preset=marble"]), 2.0 * (1.6785 + 1.3410 + 1.1755) / 3.0);
    near(radius(&["object.0.material.curvature_radius=0.7"]), 0.7);
    near(radius(&["object.0.material.curvature_radius=0.7", "object.0.material.scale=2"]), 0.35);
    assert_eq!(radius(&["object.0.material.sigma_0=0"]), 0.0);
    let here = folder(&[]);
    for (set, words) in [
        ("object.0.material.curvature_radius=-1", "object.0.material.curvature_radius: out of range; found -1"),
        ("object.0.material.curvature_radius=nan", "object.0.material.curvature_radius: not a finite number"),
        ("object.0.material={opaque=true,curvature_radius=1}", "curvature_radius: an opaque material has no such key"),
    ] {
        bad(&here, &format!("render sphere --transport cdrf -o c.png --set {set}"), 2, &[words]);
    }
    let (plan, _) = good(&here, "plan sphere --transport cdrf --device cpu");
    assert!(plan.contains("smooth_curvature"), "{plan}");
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn by_default_the_cdrf_is_nearer_to_the_dipole_than_lambert() {
    // sigma_0 of the profile's own spread was farther than Lambert on each of these.
    for (name, sets) in [("bust", &["object.0.detail=64"][..]), ("bump", &[]), ("twist", &["object.0.detail=16"])] {
        let all = places(&scene(name, sets), None).unwrap();
        let [cdrf, lambert] = [share(&all, |_| true), lambert_share(&all, |_| true)].map(|part| part.error);
        assert!(cdrf < 0.95 * lambert, "{name}: {cdrf} {lambert}");
    }
    // A scan, on which the curvature of the triangles is noise.
    let all = places(&scanned(scene("sphere", &["object.0.detail=5", "object.0.size=20"]), 0.03), None).unwrap();
    let [cdrf, lambert] = [share(&all, |_| true), lambert_share(&all, |_| true)].map(|part| part.error);
    assert!(cdrf < 0.8 * lambert, "{cdrf} {lambert}");
}
