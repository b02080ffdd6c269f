//! Several objects in one scene: no light is transported between them, but they cast shadows on each other.

use milkglass::internals::layout::BufferId;
use milkglass::internals::pipeline::plan::{Change, Goal, Mode, Options, ShadingMethod};
use milkglass::internals::session::run::Session;
use milkglass::measure::reference::verify;
use milkglass::scene::Scene;

fn scene(sets: &[&str]) -> Scene {
    let mut all = vec!["object.0.detail=3".to_string(), "camera.size=[40, 30]".to_string()];
    all.extend(sets.iter().map(|set| set.to_string()));
    Scene::load_with("sphere", &all).unwrap()
}

fn run(scene: &Scene, transport: ShadingMethod, mode: Mode) -> Session {
    let options = Options { transport, mode, goal: Goal::Radiosity, estimate: false };
    let mut session = Session::new(scene, None, options).unwrap();
    session.frame(Change::EVERYTHING).unwrap();
    session
}

/// Irradiance or radiosity of each face of an object, in scene units and in the order of its mesh.
fn of(session: &Session, object: usize, slot: BufferId) -> Vec<[f64; 3]> {
    let data = &session.state().data;
    let values = if slot == BufferId::irradiance { &data.irradiance } else { &data.radiosity };
    let light = session.units().light;
    session.prepared().places(object).into_iter().map(|face| values[face].map(|x| f64::from(x) * light)).collect()
}

/// L2 norm of the difference, relative to that of `b`.
fn apart(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    let square = |x: f64| x * x;
    let error: f64 = a.iter().flatten().zip(b.iter().flatten()).map(|(a, b)| square(a - b)).sum();
    (error / b.iter().flatten().copied().map(square).sum::<f64>()).sqrt()
}

const SECOND: &str =
    "object.1={ shape = 'sphere', detail = 2, size = 5, position = [30, 0, 0], material = { preset = 'ketchup' } }";
const GROUND: &str = "object.2={ shape = 'slab', detail = 8, size = 90, position = [0, -15, 0], rotation = [-90, 0, 0], \
                      material = { opaque = true, albedo = [0.5, 0.25, 0] } }";

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn each_object_is_lit_as_if_it_were_alone() {
    let three = scene(&[SECOND, GROUND]);
    for (transport, scheme) in [
        (ShadingMethod::Hierarchy, "transport.scheme=blocks"),
        (ShadingMethod::Hierarchy, "transport.scheme=links"),
        (ShadingMethod::Brute, "transport.scheme=blocks"),
        (ShadingMethod::Octree, "transport.scheme=blocks"),
    ] {
        let mut three = scene(&[SECOND, GROUND, scheme]);
        // Without shadows, so that none falls on another object.
        three.lights[0].shadows = false;
        let together = run(&three, transport, Mode::OnTheFly);
        for object in [0, 1] {
            let mut alone = three.clone();
            alone.objects = vec![three.objects[object].clone()];
            let alone = run(&alone, transport, Mode::OnTheFly);
            let [a, b] = [of(&together, object, BufferId::radiosity), of(&alone, 0, BufferId::radiosity)];
            let far = apart(&a, &b);
            assert!(far < 2e-3, "{transport:?}, {scheme}, object {object}: {far}");
        }
    }
    let mut session = run(&three, ShadingMethod::Hierarchy, Mode::OnTheFly);
    let worst = verify(&mut session, 300, 1).unwrap().iter().map(|n| n.l2).fold(0.0, f64::max);
    assert!(worst > 0.0 && worst < 1e-3, "{worst}");
}

#[test]
fn each_object_is_seen_as_if_it_were_alone() {
    // Receivers at faces, interpolated from vertices: the picture of each object shows that it uses its own vertices.
    let mut three = scene(&[SECOND, GROUND, "transport.receivers=faces", "camera.size=[160, 120]"]);
    three.lights[0].shadows = false;
    let shown = |scene: &Scene| {
        let mut session = Session::new(scene, None, Options::default()).unwrap();
        session.frame(Change::EVERYTHING).unwrap();
        let (data, light) = (&session.state().data, session.units().light);
        let objects: Vec<_> = data.hits.iter().map(|hit| session.state().object_of(hit.face as usize)).collect();
        let seen = data.radiance.iter().map(|color| color.map(|x| f64::from(x) * light));
        let hits: Vec<bool> = data.hits.iter().map(|hit| hit.face != u32::MAX).collect();
        (objects, hits, seen.collect::<Vec<_>>())
    };
    let (objects, hits, together) = shown(&three);
    for object in 0..3 {
        let mut alone = three.clone();
        alone.objects = vec![three.objects[object].clone()];
        let (_, _, alone) = shown(&alone);
        let own: Vec<usize> = (0..hits.len()).filter(|&pixel| hits[pixel] && objects[pixel] == object).collect();
        let pick = |all: &[[f64; 3]]| own.iter().map(|&pixel| all[pixel]).collect::<Vec<_>>();
        let far = apart(&pick(&together), &pick(&alone));
        assert!(own.len() > 20 && far < 2e-3, "object {object}, {} pixels: {far}", own.len());
    }
}

#[test]
fn what_is_opaque_gives_back_its_albedo() {
    let session = run(&scene(&[SECOND, GROUND]), ShadingMethod::Hierarchy, Mode::OnTheFly);
    let [light, given] = [BufferId::irradiance, BufferId::radiosity].map(|slot| of(&session, 2, slot));
    assert!(light.iter().any(|e| e[0] > 1.0));
    for (e, b) in light.iter().zip(&given) {
        for (c, albedo) in [0.5, 0.25, 0.0].into_iter().enumerate() {
            assert!((b[c] - albedo * e[c]).abs() <= 1e-6 * e[c]);
        }
    }
}

#[test]
fn an_object_shades_another() {
    // A plate between the sun and the ball, and the same plate elsewhere.
    let plate = |place: &str| {
        format!(
            "object.1={{ shape = 'slab', detail = 2, size = 30, position = {place}, rotation = [-45, 40, 0], \
             material = {{ opaque = true }} }}"
        )
    };
    let lit = |sets: &[&str]| of(&run(&scene(sets), ShadingMethod::Hierarchy, Mode::OnTheFly), 0, BufferId::irradiance);
    let (before, beside) = (plate("[12, 14, 8]"), plate("[-60, 0, 0]"));
    let (alone, shaded, free) = (lit(&[]), lit(&[&before]), lit(&[&beside]));
    assert!(apart(&free, &alone) < 1e-5);
    let sum = |values: &[[f64; 3]]| values.iter().flatten().sum::<f64>();
    assert!(sum(&shaded) < 0.1 * sum(&alone), "{} of {}", sum(&shaded), sum(&alone));
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn light_that_moves_and_lists_that_are_kept() {
    let sets = [SECOND, GROUND];
    for scheme in ["transport.scheme=blocks", "transport.scheme=links"] {
        let first = scene(&[sets[0], sets[1], scheme]);
        let second = scene(&[sets[0], sets[1], scheme, "light.0.direction=[-1, 0.4, 0.1]"]);
        let mut session = run(&first, ShadingMethod::Hierarchy, Mode::Render);
        session.set_lights(&second.lights).unwrap();
        session.frame(Change::default()).unwrap();
        let fresh = run(&second, ShadingMethod::Hierarchy, Mode::Render);
        for object in 0..3 {
            assert_eq!(of(&session, object, BufferId::radiosity), of(&fresh, object, BufferId::radiosity), "{scheme}");
        }
    }
}

#[test]
fn without_opaque_objects_nothing_is_there_for_them() {
    let left = |sets: &[&str]| {
        let session = run(&scene(sets), ShadingMethod::Hierarchy, Mode::OnTheFly);
        session.plan().left_out.iter().map(|(name, why)| format!("{name}: {why}")).collect::<Vec<_>>().join("\n")
    };
    assert!(left(&[SECOND]).contains("opaque_faces: no opaque object is lit by triangle"));
    assert!(!left(&[SECOND, GROUND]).contains("opaque_faces: "));
    let all = left(&["object.0.material={ opaque = true }"]);
    assert!(all.contains("gather: every object is opaque") && all.contains("pull: every object is opaque"), "{all}");
}

#[test]
fn faults_name_the_object() {
    let fault = |sets: &[&str]| {
        let sets: Vec<String> = sets.iter().map(|set| set.to_string()).collect();
        Scene::load_with("sphere", &sets).unwrap_err().to_string()
    };
    let cases = [
        (vec!["object.1={ shape = 'slap' }"], "did you mean `slab`"),
        (
            vec!["object.1={ shape = 'slab', material = { opaque = true, preset = 'marble' } }"],
            "an opaque material has no such key",
        ),
        (vec!["object.0.material.albedo=0.5"], "only an opaque material has an albedo"),
        (
            vec!["object.1={ shape = 'slab', material = { opaque = true, albedo = 2 } }"],
            "object.1.material.albedo: out of range",
        ),
        (vec!["object.0.position=[0, 1e12, 0]"], "object.0.position: out of range"),
        (vec!["light.0={ type = 'point', position = [30, 0, 0], intensity = 1 }", SECOND], "stands in the medium"),
    ];
    for (sets, expected) in cases {
        let found = fault(&sets);
        assert!(found.contains(expected), "{found}");
    }
    // A lamp inside an opaque object is allowed; it lights nothing.
    let lamp = "light.0={ type = 'point', position = [0, -15, 0], intensity = 1 }";
    assert!(Scene::load_with("sphere", &[SECOND, GROUND, lamp].map(String::from)).is_ok());
}
