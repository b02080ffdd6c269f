//! Errors of the march through layers and of its approximations, on planes and on curved scenes.

use milkglass::measure::layers::{approximations, rules};
use milkglass::scene::Integration;

use super::scene;

#[test]
fn ours_with_ten_samples_beats_the_left_rule_with_a_hundred() {
    let flat = scene(
        "slab-layers",
        &[
            "object.0.shape=plane",
            "object.0.size=40",
            "object.0.rotation=[90, 0, 0]",
            "camera.size=[24, 20]",
            "light.0.shadows=false",
            "light.1.shadows=false",
        ],
    );
    let fish = scene("fish", &["camera.size=[48, 24]"]);
    for (scene, integration, total) in [(flat, 2e-3, 2e-2), (fish, 2e-2, f64::INFINITY)] {
        let lines = rules(&scene, None, &[10, 100], 24, 1).unwrap();
        let of = |rule, samples| lines.iter().find(|line| line.rule == rule && line.samples == samples).unwrap();
        let (ours, theirs) = (of(Integration::Exact, 10), of(Integration::Paper, 100));
        assert!(ours.integration < theirs.integration, "{lines:?}");
        assert!(ours.integration < integration, "{lines:?}");
        // On a plane the march makes no approximation.
        assert!(ours.total < total, "{lines:?}");
    }
}

#[test]
fn on_a_plane_no_approximation_costs_anything() {
    let flat = ["object.0.shape=plane", "object.0.size=40", "object.0.rotation=[90, 0, 0]", "camera.size=[24, 20]"];
    for (what, error) in approximations(&scene("slab-layers", &flat), 24).unwrap() {
        assert!(error < 2e-2, "{what}: {error}");
    }
    // On a bumpy surface every approximation costs some error.
    let gecko = approximations(&scene("gecko", &["camera.size=[48, 40]"]), 24).unwrap();
    let [.., (_, all), (_, march)] = gecko[..] else { panic!("{gecko:?}") };
    assert!((all / march - 1.0).abs() < 0.05, "{gecko:?}");
    assert!(gecko.iter().all(|(_, error)| *error > 1e-3 && *error < 1.0), "{gecko:?}");
}
