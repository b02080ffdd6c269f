//! What pictures look like: light that leaves.

use std::f64::consts::PI;

use milkglass::light::fresnel::transmittance;
use milkglass::render::plan::{Change, Options};
use milkglass::render::run::{Room, Session};
use milkglass::scene::Scene;

/// A small ball with these settings, drawn by the reference.
fn session(sets: &[&str]) -> Session {
    let small = ["object.0.detail=2", "camera.size=[48, 40]"];
    let sets: Vec<_> = small.iter().chain(sets).map(ToString::to_string).collect();
    let mut session = Session::new(&Scene::load("sphere", &sets).unwrap(), None, Options::default(), Room::default());
    session.as_mut().unwrap().frame(Change::EVERYTHING).unwrap();
    session.unwrap()
}

#[test]
fn all_light_leaves_where_the_exit_is_normalised() {
    const ETA: &str = "object.0.material.eta=[0.8, 1.3, 2.0]";
    let (mut paper, mut whole) = (session(&[ETA]), session(&[ETA, "object.0.material.normalize_exit=true"]));
    let exit = whole.state().data.frame[0].exit.map(f64::from);
    for (eta, exit) in [0.8, 1.3, 2.0].into_iter().zip(exit) {
        // L cos over the hemisphere, for B = 1.
        let steps = 20_000;
        let at = |i: u32| (f64::from(i) + 0.5) / f64::from(steps);
        let sum: f64 = (0..steps).map(|i| 2.0 * PI * at(i) * transmittance(eta, at(i)) * exit / PI).sum();
        assert!((sum / f64::from(steps) - 1.0).abs() < 1e-5, "{eta}: {sum}");
    }
    let shown: Vec<bool> = whole.state().data.hits.iter().map(|hit| hit.face != u32::MAX).collect();
    let (paper, whole) = (paper.picture().unwrap().pixels, whole.picture().unwrap().pixels);
    for ((a, b), _) in paper.iter().zip(&whole).zip(shown).filter(|(_, shown)| *shown) {
        assert!((0..3).all(|c| (f64::from(a[c]) * exit[c] - f64::from(b[c])).abs() <= 1e-6 * f64::from(b[c])));
    }
}
