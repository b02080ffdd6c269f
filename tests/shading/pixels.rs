//! Receivers at pixels: within the tolerance of brute force, chosen by count, and absent where unused.

use milkglass::internals::layout::BufferId;
use milkglass::internals::pipeline::plan::{Change, Goal, Options, ShadingMethod};
use milkglass::internals::prepare::receivers::by_pixel;
use milkglass::internals::session::run::Session;
use milkglass::internals::state::wide;
use milkglass::measure::reference::at;
use milkglass::scene::Scene;

fn scene(name: &str, sets: &[&str]) -> Scene {
    let sets: Vec<String> = sets.iter().map(|set| set.to_string()).collect();
    Scene::load_with(name, &sets).unwrap()
}

fn drawn(scene: &Scene, options: Options) -> Session {
    let mut session = Session::new(scene, None, options).unwrap();
    session.frame(Change::EVERYTHING).unwrap();
    session
}

const SMALL: [&str; 3] = ["camera.size=[60, 50]", "object.0.detail=40", "transport.receivers=pixels"];

#[test]
fn radiosity_is_that_of_the_place_itself() {
    for tolerance in [1e-2, 1e-3] {
        let mut scene = scene("lotus", &SMALL);
        scene.transport.tolerance = tolerance;
        let session = drawn(&scene, Options::default());
        let data = &session.state().data;
        let shown: Vec<usize> = (0..data.hits.len()).filter(|&pixel| data.hits[pixel].face != u32::MAX).collect();
        assert!(shown.len() > 500);
        let receivers: Vec<usize> = shown.iter().step_by(5).map(|&pixel| data.seen[pixel] as usize).collect();
        let places: Vec<_> = receivers.iter().map(|&receiver| wide(data.receiver_positions[receiver])).collect();
        let exact = at(session.state(), &places);
        for c in 0..3 {
            let (mut error, mut power) = (0.0, 0.0);
            for (&receiver, exact) in receivers.iter().zip(&exact) {
                error += (f64::from(data.radiosity[receiver][c]) - exact[c]).powi(2);
                power += exact[c].powi(2);
            }
            assert!((error / power).sqrt() < tolerance, "{tolerance}, channel {c}: {}", (error / power).sqrt());
        }
    }
}

#[test]
fn the_picture_is_nearly_that_of_fine_triangles() {
    let mut pixels =
        drawn(&scene("sphere", &["camera.size=[60, 50]", "transport.receivers=pixels"]), Options::default());
    let mut faces = drawn(&scene("sphere", &["camera.size=[60, 50]", "transport.receivers=faces"]), Options::default());
    let [a, b] = [&mut pixels, &mut faces].map(|session| session.picture().unwrap().pixels);
    let brightest = b.iter().flatten().copied().fold(0.0, f32::max);
    let far = a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
    assert!(far > 0.0 && far < 0.02 * brightest, "{far} of {brightest}");
}

#[test]
fn a_new_view_sums_anew_and_another_size_begins_anew() {
    let first = scene("sphere", &[SMALL[0], "object.0.detail=2", SMALL[2]]);
    let mut session = drawn(&first, Options::default());
    let mut camera = session.scene().camera.clone();
    camera.position *= 0.8;
    session.set_camera(&camera).unwrap();
    session.frame(Change::default()).unwrap();
    let fresh = |camera| {
        let mut other = first.clone();
        other.camera = camera;
        drawn(&other, Options::default()).picture().unwrap().pixels
    };
    assert_eq!(session.picture().unwrap().pixels, fresh(camera.clone()));
    camera.size = [33, 70];
    session.set_camera(&camera).unwrap();
    session.frame(Change::default()).unwrap();
    assert_eq!(session.picture().unwrap().pixels, fresh(camera));
}

#[test]
fn whichever_are_fewer() {
    let fine = scene("sphere", &["object.0.detail=5", "camera.size=[100, 100]"]);
    let coarse = scene("sphere", &["object.0.detail=3", "camera.size=[100, 100]"]);
    assert!(by_pixel(&fine, Options::default()).0 && !by_pixel(&coarse, Options::default()).0);
    let many = scene("sphere", &["object.0.detail=5", "camera.size=[100, 100]", "camera.samples=3"]);
    assert!(!by_pixel(&many, Options::default()).0);
    let solve = Options { goal: Goal::Radiosity, ..Options::default() };
    let octree = Options { transport: ShadingMethod::Octree, ..Options::default() };
    assert!(!by_pixel(&fine, solve).0 && !by_pixel(&fine, octree).0);
    assert!(!by_pixel(&scene("sphere", &["transport.scheme=links", "camera.size=[9, 9]"]), Options::default()).0);
}

#[test]
fn what_is_not_wanted_is_not_there() {
    let at = |receivers: &str| drawn(&scene("sphere", &[SMALL[0], "object.0.detail=2", receivers]), Options::default());
    let (pixels, faces) = (at("transport.receivers=pixels"), at("transport.receivers=faces"));
    let has = |session: &Session, name: &str| session.plan().stages.iter().any(|stage| stage.name == name);
    assert!(has(&pixels, "pixel_receivers") && !has(&pixels, "average"));
    assert!(!has(&faces, "pixel_receivers") && has(&faces, "average"));
    assert!(faces.state().data.bytes(BufferId::seen).is_empty());
    let why = |session: &Session, what: &str| {
        session.plan().left_out.iter().find(|(name, _)| *name == what).map(|(_, why)| why.clone()).unwrap_or_default()
    };
    assert_eq!(why(&faces, "receivers at pixels"), "transport.receivers is faces");
    assert_eq!(why(&pixels, "receivers at triangles"), "transport.receivers is pixels");
    assert_eq!(why(&faces, "pixel_receivers"), "the receivers are triangles");

    let sets = ["transport.receivers=pixels", "transport.scheme=links"].map(String::from);
    let error = Scene::load_with("sphere", &sets).unwrap_err().to_string();
    assert!(error.contains("transport.receivers: scheme links has no receivers at pixels"), "{error}");
}

#[test]
fn every_transport_gives_nearly_the_same_picture() {
    let scene = scene("sphere", &["camera.size=[24, 20]", "object.0.detail=2"]);
    let mean = |transport: ShadingMethod| {
        let mut session = drawn(&scene, Options { transport, ..Options::default() });
        let pixels = session.picture().unwrap().pixels;
        pixels.iter().flatten().map(|&x| f64::from(x)).sum::<f64>() / pixels.len() as f64
    };
    let hierarchy = mean(ShadingMethod::Hierarchy);
    assert!(hierarchy > 0.01);
    // The octree treats triangles of this size as points.
    for (transport, most) in [(ShadingMethod::Brute, 0.05), (ShadingMethod::Octree, 0.5)] {
        let other = mean(transport);
        assert!((other / hierarchy - 1.0).abs() < most, "{transport:?}: {other} instead of {hierarchy}");
    }
}
