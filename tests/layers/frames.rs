//! Plans with and without layers, and what reruns after a change.

use milkglass::internals::layout::BufferId;
use milkglass::internals::pipeline::plan::{Change, Options, ShadingMethod};
use milkglass::internals::session::run::Session;
use milkglass::scene::Scene;

use super::{scene, session};

const LAYERS: &str = "object.0.material.layers={ samples = 5, layer = [\
    { sigma_s = [2, 1, 1], sigma_t = [2.6, 1.6, 1.6], g = 0.25, thickness = 0.5 }, \
    { sigma_s = 1, sigma_t = 1.5, g = 0.5, thickness = 2 }] }";
const SMALL: [&str; 2] = ["object.0.detail=3", "camera.size=[40, 40]"];
const OWN: [BufferId; 6] = [
    BufferId::layerings,
    BufferId::layer_media,
    BufferId::depths,
    BufferId::layer_lights,
    BufferId::vertex_moments,
    BufferId::planes,
];

fn picture(session: &mut Session) -> Vec<[f32; 3]> {
    session.picture().unwrap().pixels
}

#[test]
fn a_scene_without_layers_has_no_trace_of_them() {
    let bare = session(&scene("sphere", &SMALL), Options::default());
    for name in ["plane_fit", "relief"] {
        assert!(!bare.plan().stages.iter().any(|stage| stage.name == name));
        assert!(bare.plan().left_out.contains(&(name, "no material has layers".to_string())));
    }
    assert!(OWN.iter().all(|&slot| bare.state().data.bytes(slot).is_empty()));

    let layered = session(&scene("sphere", &[&SMALL[..], &[LAYERS]].concat()), Options::default());
    assert!(OWN.iter().all(|&slot| !layered.state().data.bytes(slot).is_empty()));
    // With only radiosity requested, layers take nothing either.
    let options = Options { goal: milkglass::internals::pipeline::plan::Goal::Radiosity, ..Options::default() };
    let solved = session(&scene("sphere", &[&SMALL[..], &[LAYERS]].concat()), options);
    assert!(OWN.iter().all(|&slot| solved.state().data.bytes(slot).is_empty()));
}

#[test]
fn light_beneath_the_surface_is_added_to_what_any_transport_gives() {
    let layered = scene("sphere", &[&SMALL[..], &[LAYERS]].concat());
    let with = |transport| Options { transport, ..Options::default() };
    let alone = picture(&mut session(&layered, with(ShadingMethod::None)));
    assert!(alone.iter().flatten().any(|&x| x > 0.01));
    for transport in [ShadingMethod::Hierarchy, ShadingMethod::Octree, ShadingMethod::Brute] {
        let both = picture(&mut session(&layered, with(transport)));
        let without = picture(&mut session(&scene("sphere", &SMALL), with(transport)));
        for ((both, without), alone) in both.iter().zip(&without).zip(&alone) {
            // Pixels without an object show the background in both.
            let shown = layered.camera.background.map(|x| x as f32) != *both;
            let fits = (0..3).all(|c| (both[c] - without[c] - alone[c]).abs() <= 1e-6 * (1.0 + both[c]));
            assert!(!shown || fits, "{transport:?}: {both:?} {without:?} {alone:?}");
        }
    }
    let none = session(&scene("sphere", &SMALL), with(ShadingMethod::None));
    let why = none.plan().left_out.iter().find(|(name, _)| *name == "gather");
    assert!(why.is_some_and(|(_, why)| why == "no light is carried; part of scheme blocks"), "{why:?}");
}

#[test]
fn planes_are_fitted_again_only_where_the_shape_changes() {
    let sets = [&SMALL[..], &[LAYERS, "object.0.deform=[{ type = 'twist', angle = 40 }]"]].concat();
    let first = scene("sphere", &sets);
    let mut kept = session(&first, Options::default());
    let ran = |session: &mut Session, change: Change| -> Vec<String> {
        session.frame(change).unwrap().into_iter().map(|step| step.name).collect()
    };
    for change in [Change::LIGHT, Change::VIEW, Change::RESUM] {
        let names = ran(&mut kept, change);
        assert!(names.contains(&"relief".to_string()) && !names.contains(&"plane_fit".to_string()), "{names:?}");
    }
    // New shape, lights and view: the frame equals that of a new session.
    let more = ["object.0.deform.0.angle=140", "light.0.direction=[1, 0.2, 0.6]", "camera.position=[9, 4, 44]"];
    let second = scene("sphere", &[&sets[..], &more].concat());
    kept.show(&second).unwrap();
    assert!(ran(&mut kept, Change::default()).contains(&"plane_fit".to_string()));
    assert_eq!(picture(&mut kept), picture(&mut session(&second, Options::default())));
    let more = ["object.0.material.layers.layer.0.thickness=0.1"];
    let third = scene("sphere", &[&sets[..], &more].concat());
    kept.show(&third).unwrap();
    kept.frame(Change::default()).unwrap();
    assert_eq!(picture(&mut kept), picture(&mut session(&third, Options::default())));
}

#[test]
fn a_device_follows_shape_light_and_layers() {
    let sets = [&SMALL[..], &[LAYERS, "object.0.deform=[{ type = 'twist', angle = 40 }]"]].concat();
    let shape = ["object.0.deform.0.angle=140"];
    let light = ["light.1={ type = 'point', position = [9, 30, 9], intensity = [900, 800, 700] }"];
    let layers = ["object.0.material.layers.layer.0.thickness=0.1"];
    crate::devices::on_devices(|device| {
        let new = |scene: &Scene| Session::new(scene, Some(device), Options::default()).unwrap();
        let mut kept = new(&scene("sphere", &sets));
        kept.frame(Change::EVERYTHING).unwrap();
        let mut all = sets.clone();
        for more in [&shape[..], &light, &layers] {
            all.extend(more);
            let next = scene("sphere", &all);
            kept.show(&next).unwrap();
            kept.frame(Change::default()).unwrap();
            let mut fresh = new(&next);
            fresh.frame(Change::EVERYTHING).unwrap();
            assert!(picture(&mut kept) == picture(&mut fresh), "{more:?}");
        }
    });
}

#[test]
fn light_from_behind_does_not_come_in() {
    // A layer thinner than the sag of the fitted planes, lit from behind without shadows: samples of both rules that
    // lie at the surface have no depth to attenuate the light.
    for rule in ["exact", "paper"] {
        let layers = format!(
            "object.0.material.layers={{ integration = '{rule}', layer = [{{ sigma_s = 1, sigma_t = 1, thickness = 0.2 }}] }}"
        );
        let sum = |direction: &str| {
            let light =
                format!("light.0={{ type = 'directional', direction = {direction}, irradiance = 3, shadows = false }}");
            let sets = [&SMALL[..], &[&layers, &light, "camera.background=0"]].concat();
            let mut session =
                session(&scene("sphere", &sets), Options { transport: ShadingMethod::None, ..Options::default() });
            picture(&mut session).iter().map(|pixel| f64::from(pixel[0])).sum::<f64>()
        };
        let camera = scene("sphere", &SMALL).camera;
        let toward = (camera.position - camera.target).normalize();
        let [front, behind] = [toward, -toward].map(|d| sum(&format!("[{}, {}, {}]", d.x, d.y, d.z)));
        assert!(front > 1.0 && behind < 0.02 * front, "{rule}: {front} {behind}");
    }
}

#[test]
fn of_several_objects_each_has_its_own_layers() {
    let both = [
        "camera={ position = [0.0, 0.0, 90.0], size = [60, 30], fov = 36 }",
        "object.0.detail=3",
        "object.0.position=[-14, 0, 0]",
        LAYERS,
        "object.1={ shape = 'sphere', detail = 3, size = 20, position = [14, 0, 0] }",
        "object.1.material={ layers = { layer = [{ sigma_s = 1, sigma_t = 1, thickness = 3 }] } }",
        "light.0.shadows=false",
    ];
    let all = picture(&mut session(&scene("sphere", &both), Options::default()));
    let mut first = scene("sphere", &both);
    let mut second = first.clone();
    first.objects[1].material.layers = None;
    second.objects[0].material.layers = None;
    let [a, b] = [first, second].map(|scene| picture(&mut session(&scene, Options::default())));
    let (mut left, mut right) = (0, 0);
    for (pixel, (all, (a, b))) in all.iter().zip(a.iter().zip(&b)).enumerate() {
        let half = pixel % 60 < 30;
        assert_eq!(all, if half { a } else { b });
        left += usize::from(half && a != b);
        right += usize::from(!half && a != b);
    }
    assert!(left > 10 && right > 10, "{left} {right}");
}

#[test]
fn an_environment_shines_as_so_many_suns() {
    // Uniform light from all directions: the 32 beams together carry 4 pi times the radiance.
    let sky = "light.0={ type = 'environment', radiance = [0.5, 1.0, 2.0] }";
    let session = session(&scene("sphere", &[&SMALL[..], &[LAYERS, sky]].concat()), Options::default());
    let (beams, unit) = (&session.state().data.layer_lights, session.units().light);
    assert_eq!(beams.len(), 32);
    let sum: f64 = beams.iter().map(|beam| f64::from(beam.color[2]) * unit).sum();
    assert!((sum / (8.0 * std::f64::consts::PI) - 1.0).abs() < 1e-4, "{sum}");
    let most = beams.iter().map(|beam| f64::from(beam.color[2]) * unit).fold(0.0, f64::max);
    assert!(most < 2.0 * sum / 32.0, "{most}");
}

#[test]
fn an_environment_shines_from_where_it_is_bright() {
    // The image's middle is at -z, with +x to its right; one of eight columns is bright at a time.
    for (column, toward) in [(1, [-1.0, 0.4]), (6, [1.0, 0.4]), (3, [-0.4, -1.0]), (0, [-0.4, 1.0])] {
        let here = crate::shell::folder(&[]);
        let path = here.path().join("sky.exr");
        let pixel = |x, _| if x == column { (1.0f32, 1.0f32, 1.0f32) } else { (0.0, 0.0, 0.0) };
        exr::prelude::write_rgb_file(&path, 8, 4, pixel).unwrap();
        let sky = format!("light.0={{ type = 'environment', image = '{}' }}", path.display());
        let lit = session(&scene("sphere", &[&SMALL[..], &[LAYERS, &sky]].concat()), Options::default());
        let beams = &lit.state().data.layer_lights;
        assert!(!beams.is_empty() && beams.len() < 32, "{}: black suns do not march", beams.len());
        let along = |k: usize| beams.iter().map(|beam| f64::from(beam.place[k] * beam.color[0])).sum::<f64>();
        let (x, z) = (along(0), along(2));
        let length = x.hypot(z) * f64::hypot(toward[0], toward[1]);
        assert!((x * toward[0] + z * toward[1]) / length > 0.95, "{column}: {x} {z}");
    }
}

#[test]
fn a_black_light_does_not_march() {
    let black = "light.1={ type = 'point', position = [0, 30, 0], intensity = 0 }";
    let opened = |more: &[&str]| session(&scene("sphere", &[&SMALL[..], &[LAYERS], more].concat()), Options::default());
    let (mut one, mut two) = (opened(&[]), opened(&[black]));
    assert_eq!((one.state().data.layer_lights.len(), two.state().data.layer_lights.len()), (1, 1));
    assert!(picture(&mut one) == picture(&mut two));
}

#[test]
fn fish_and_gecko_are_closed_and_as_fine_as_the_papers() {
    for (name, vertices, triangles) in [("fish", Some(1396), 2788), ("gecko", None, 10_944)] {
        let mesh = &scene(name, &[]).objects[0].mesh;
        assert_eq!(mesh.triangles.len(), triangles);
        assert!(vertices.is_none_or(|vertices| mesh.positions.len() == vertices));
        assert!(mesh.volume() > 0.0);
        // Each edge occurs once in each direction.
        let mut edges = std::collections::BTreeMap::new();
        for &[a, b, c] in &mesh.triangles {
            for (from, to) in [(a, b), (b, c), (c, a)] {
                *edges.entry((from.min(to), from.max(to))).or_insert(0) += if from < to { 1 } else { -1 };
            }
        }
        assert!(edges.values().all(|&sum| sum == 0) && edges.len() * 2 == triangles * 3, "{name}");
    }
}

/// A picture that needs more steps than one dispatch allows is summed once: its two dispatches meet in row 130, where
/// the slab is visible.
#[test]
fn no_pixel_is_lit_twice_where_dispatches_meet() {
    let sets = ["camera.size=[130, 138]", "camera.target=[0, 20, 0]", "object.0.material.layers.samples=990"];
    let scene = scene("slab-layers", &sets);
    let options = || Options { transport: ShadingMethod::None, ..Options::default() };
    let expected = picture(&mut session(&scene, options()));
    let (sky, row) = (scene.camera.background.map(|x| x as f32), 130 * 130..131 * 130);
    assert!(expected[row].iter().filter(|&&seen| seen != sky).count() > 60, "a poor test");
    crate::devices::on_devices(|device| {
        let mut session = Session::new(&scene, Some(device), options()).unwrap();
        session.frame(Change::EVERYTHING).unwrap();
        for (at, (found, expected)) in picture(&mut session).iter().zip(&expected).enumerate() {
            let near = (0..3).all(|c| (found[c] - expected[c]).abs() <= 2e-3 * expected[c] + 1e-4);
            assert!(near, "{}: pixel {at}: {found:?} for {expected:?}", device.name());
        }
    });
}
