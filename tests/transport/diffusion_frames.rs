//! Diffusion frame after frame: what a start from the last frame's solution saves, and what it must not change.

use milkglass::internals::pipeline::plan::{Change, Goal, Mode, Options, ShadingMethod};
use milkglass::internals::session::run::Session;
use milkglass::scene::{Light, Scene};

use crate::devices;

fn scene(sets: &[&str]) -> Scene {
    let common = ["object.0.detail=3", "transport.tolerance=1e-3"];
    Scene::load_with("sphere", &common.iter().chain(sets).map(ToString::to_string).collect::<Vec<_>>()).unwrap()
}

/// The lights of the scene, the first one from this angle, degrees.
fn lights(angle: f64, irradiance: &str) -> Vec<Light> {
    let (sin, cos) = angle.to_radians().sin_cos();
    let direction = format!("light.0.direction=[{sin}, 0.3, {cos}]");
    scene(&[&direction, &format!("light.0.irradiance={irradiance}")]).lights
}

fn session(mode: Mode, device: Option<&milkglass::Device>) -> Session {
    let options = Options { transport: ShadingMethod::Diffusion, goal: Goal::Radiosity, mode, ..Options::default() };
    Session::new(&scene(&[]), device, options).unwrap()
}

/// A frame with these lights: steps, and the radiosity of every triangle.
fn frame(session: &mut Session, lights: &[Light]) -> (usize, Vec<[f64; 3]>) {
    session.set_lights(lights).unwrap();
    session.frame(Change::default()).unwrap();
    let reports = session.solve_reports();
    assert!(reports.iter().all(|report| report.converged), "{reports:?}");
    let steps = reports.iter().map(|report| report.steps).sum();
    (steps, session.faces().unwrap().into_iter().map(|face| face.radiosity).collect())
}

/// The relative L2 of the worst channel; triangles of a ball are about equal.
fn apart(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    let relative = |c: usize| {
        let off: f64 = a.iter().zip(b).map(|(a, b)| (a[c] - b[c]).powi(2)).sum();
        (off / b.iter().map(|b| b[c] * b[c]).sum::<f64>()).sqrt()
    };
    (0..3).map(relative).fold(0.0, f64::max)
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_solution_to_start_from_saves_steps_and_keeps_the_tolerance() {
    let turns = |device: Option<&milkglass::Device>| {
        for mode in [Mode::Render, Mode::Incremental] {
            let (mut warm, mut cold) = (session(mode, device), session(Mode::OnTheFly, device));
            let first = [frame(&mut warm, &lights(0.0, "1")), frame(&mut cold, &lights(0.0, "1"))];
            assert_eq!(first[0], first[1], "the first frame has nothing to start from");
            let (mut saved, mut most) = (0, 0.0);
            for angle in 1..6 {
                let next = lights(f64::from(angle), "1");
                let [(few, start), (many, none)] = [frame(&mut warm, &next), frame(&mut cold, &next)];
                (saved, most) = (saved + many - few, f64::max(most, apart(&start, &none)));
            }
            assert!(saved >= 5, "{mode:?}: {saved} steps saved in 5 frames");
            assert!(most > 0.0 && most < 1e-3, "{mode:?}: {most:e}");
        }
    };
    turns(None);
    devices::on_devices(|device| turns(Some(device)));
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_start_that_does_not_fit_is_passed_over() {
    let turns = |device: Option<&milkglass::Device>| {
        let mut session = session(Mode::Render, device);
        let (cold, bright) = frame(&mut session, &lights(0.0, "[1, 1, 1]"));
        let (_, dim) = frame(&mut session, &lights(0.0, "[1e-4, 0, 1]"));
        for (dim, bright) in dim.iter().zip(&bright) {
            assert!(dim[1] == 0.0, "no light entered in green: {}", dim[1]);
            assert!((dim[0] - 1e-4 * bright[0]).abs() < 1e-5 * bright[0], "{dim:?} {bright:?}");
        }
        let (again, back) = frame(&mut session, &lights(0.0, "[1, 1, 1]"));
        assert!(again <= cold + 2 && apart(&back, &bright) < 1e-3, "{again} {}", apart(&back, &bright));
        let (_, dark) = frame(&mut session, &[]);
        assert!(dark.iter().all(|dark| *dark == [0.0; 3]));
        let (steps, lit) = frame(&mut session, &lights(0.0, "[1, 1, 1]"));
        assert!(apart(&lit, &bright) < 1e-3, "{} after {steps} steps of {cold}", apart(&lit, &bright));
    };
    turns(None);
    devices::on_devices(|device| turns(Some(device)));
}
