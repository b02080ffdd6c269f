//! `--transport auto`: diffusion in each object where it holds, the dipole in the others.

use milkglass::internals::pipeline::plan::{Change, Goal, Mode, Options, ShadingMethod};
use milkglass::internals::session::run::Session;
use milkglass::scene::Scene;

use crate::devices;

/// A marble ball, a nearly black one, a marble one lit from both sides, and an opaque one.
const OBJECTS: &[&str] = &[
    "object.0.detail=2",
    "object.1={ shape = 'sphere', detail = 2, size = 14, position = [20, 0, 0], material = { sigma_s_prime = 0.05, sigma_a = 1, eta = 1.3 } }",
    "object.2={ shape = 'torus', detail = 14, size = 14, position = [0, 20, 0], material = { preset = 'marble', two_sided = true } }",
    "object.3={ shape = 'sphere', detail = 2, size = 14, position = [20, 20, 0], material = { opaque = true, albedo = 0.5 } }",
];

fn scene(sets: &[&str]) -> Scene {
    Scene::load_with("sphere", &OBJECTS.iter().chain(sets).map(ToString::to_string).collect::<Vec<_>>()).unwrap()
}

fn session(scene: &Scene, transport: ShadingMethod, mode: Mode, device: Option<&milkglass::Device>) -> Session {
    let options = Options { transport, mode, goal: Goal::Radiosity, ..Options::default() };
    Session::new(scene, device, options).unwrap()
}

/// The radiosity of each object's triangles.
fn radiosity(session: &mut Session) -> Vec<Vec<[f64; 3]>> {
    session.frame(Change::default()).unwrap();
    let faces = session.faces().unwrap();
    let mut rest = faces.as_slice();
    let counts = session.scene().objects.iter().map(|object| object.mesh.triangles.len());
    counts
        .map(|count| {
            let (own, after) = rest.split_at(count);
            rest = after;
            own.iter().map(|face| face.radiosity).collect()
        })
        .collect()
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn each_object_has_the_transport_that_suits_it() {
    let compare = |device: Option<&milkglass::Device>| {
        for mode in [Mode::OnTheFly, Mode::Render] {
            let all = scene(&[]);
            let auto = radiosity(&mut session(&all, ShadingMethod::Auto, mode, device));
            let dipole = radiosity(&mut session(&all, ShadingMethod::Hierarchy, mode, device));
            let closed = scene(&["object.2.material.two_sided=false"]);
            let diffusion = radiosity(&mut session(&closed, ShadingMethod::Diffusion, mode, device));
            assert!(auto[0] == diffusion[0], "{mode:?}: the marble ball is solved");
            assert!(auto[0] != dipole[0]);
            for object in 1..4 {
                assert!(auto[object] == dipole[object], "{mode:?}: object {object} has the dipole's");
            }
        }
    };
    compare(None);
    devices::on_devices(|device| compare(Some(device)));
}

#[test]
fn the_plan_says_why() {
    let session = session(&scene(&[]), ShadingMethod::Auto, Mode::OnTheFly, None);
    let left: Vec<_> = session.plan().left_out.iter().filter(|(what, _)| *what == "diffusion").collect();
    assert!(left.len() == 2 && left[0].1.starts_with("of object 1, the dipole serves instead: the reduced albedo"));
    assert!(left[1].1.contains("object 2") && left[1].1.contains("both sides"), "{left:?}");
    let stages: Vec<_> = session.plan().stages.iter().map(|stage| stage.name).collect();
    for stage in ["gather", "push", "deposit", "krylov_step"] {
        assert!(stages.contains(&stage), "{stage} of {stages:?}");
    }
    // No object has diffusion.
    let dark = scene(&["object.0.material={ sigma_s_prime = 0.01, sigma_a = 1 }"]);
    let session = self::session(&dark, ShadingMethod::Auto, Mode::OnTheFly, None);
    assert!(!session.plan().stages.iter().any(|stage| stage.name == "krylov_step"));
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn another_material_makes_another_choice() {
    let follow = |device: Option<&milkglass::Device>| {
        for mode in [Mode::OnTheFly, Mode::Render] {
            let mut kept = session(&scene(&[]), ShadingMethod::Auto, mode, device);
            radiosity(&mut kept);
            let materials = [
                "object.0.material={ sigma_s_prime = 0.01, sigma_a = 1 }",
                "object.2.material.two_sided=false",
                "object.0.material.preset='skin1'",
            ];
            for material in materials {
                let next = scene(&[material]);
                kept.show(&next).unwrap();
                let found = radiosity(&mut kept);
                let fresh = radiosity(&mut session(&next, ShadingMethod::Auto, mode, device));
                let apart = (0..4).find(|&object| found[object] != fresh[object]);
                // A solution that starts from the last one differs within the tolerance.
                let close = |object: usize| {
                    let pairs = found[object].iter().flatten().zip(fresh[object].iter().flatten());
                    mode == Mode::Render && pairs.into_iter().all(|(a, b)| (a - b).abs() < 2e-2 * b.abs().max(1e-3))
                };
                assert!(apart.is_none_or(close), "{mode:?}: {material}: object {apart:?}");
            }
        }
    };
    follow(None);
    devices::on_devices(|device| follow(Some(device)));
}

#[test]
fn receivers_at_pixels_are_refused() {
    let scene = scene(&["transport.receivers='pixels'"]);
    for transport in [ShadingMethod::Auto, ShadingMethod::Diffusion] {
        let options = Options { transport, ..Options::default() };
        let error = Session::new(&scene, None, options).err().map(|error| error.to_string()).unwrap_or_default();
        assert!(error.contains("transport.receivers") && error.contains("at triangles"), "{error}");
    }
}

#[test]
fn keys_of_scheme_links_are_refused() {
    let scene = scene(&["transport.scheme='links'"]);
    let options = Options { transport: ShadingMethod::Auto, goal: Goal::Radiosity, ..Options::default() };
    let error = Session::new(&scene, None, options).err().map(|error| error.to_string()).unwrap_or_default();
    assert!(error.contains("transport.scheme") && error.contains("auto takes scheme blocks"), "{error}");
}
