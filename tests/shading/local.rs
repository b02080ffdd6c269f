//! Local shading: which stages run for it, and what its pictures show.

use crate::devices::on_devices;
use crate::shell::{bad, folder, good};
use milkglass::internals::layout::{BUFFER_IDS, BufferId};
use milkglass::internals::pipeline::plan::{Change, Options, ShadingMethod};
use milkglass::internals::session::run::Session;
use milkglass::internals::shading::reflectance::zonal;
use milkglass::scene::Scene;

const CDRF: Options = options(ShadingMethod::Cdrf);
const LAMBERT: Options = options(ShadingMethod::Lambert);

const fn options(transport: ShadingMethod) -> Options {
    use milkglass::internals::pipeline::plan::{Goal, Mode};
    Options { transport, mode: Mode::OnTheFly, goal: Goal::Picture, estimate: false }
}

fn scene(name: &str, sets: &[&str], frame: f64) -> Scene {
    let sets: Vec<String> = ["camera.size=[40, 30]"].iter().chain(sets).map(|set| set.to_string()).collect();
    Scene::load_at(name, &sets, frame).unwrap()
}

fn run(scene: &Scene, options: Options) -> Session {
    let mut session = Session::new(scene, None, options).unwrap();
    session.frame(Change::EVERYTHING).unwrap();
    session
}

fn names(session: &Session) -> Vec<&'static str> {
    session.plan().stages.iter().map(|stage| stage.name).collect()
}

/// The buffers of a frame of the CDRF in closed form.
const USED: [&str; 26] = [
    "object_params",
    "lights",
    "camera",
    "positions",
    "triangles",
    "corner_starts",
    "corners",
    "vertex_order",
    "topology",
    "leaves",
    "arrivals",
    "order",
    "bounds",
    "wide_links",
    "wide_boxes",
    "clusters",
    "normals",
    "curvature",
    "curvature_sums",
    "smooth_kappa",
    "packed_normals",
    "counters",
    "hits",
    "radiance",
    "tones",
    "shown",
];

#[test]
fn nothing_of_transport_has_a_stage_or_a_buffer() {
    let ball = scene("sphere", &["object.0.detail=2"], 0.0);
    let session = run(&ball, CDRF);
    let shape = "refit curvature curvature_sums smooth_curvature pack_normals widen visibility";
    assert_eq!(names(&session).join(" "), format!("{shape} cdrf tone"));
    let used: Vec<&str> = BUFFER_IDS
        .iter()
        .filter(|slot| !session.state().data.bytes(**slot).is_empty())
        .map(|slot| slot.spec().name)
        .collect();
    assert_eq!(used, USED);
    for (stage, word) in
        [("gather", "no light is carried"), ("shadow", "does not shadow itself"), ("cdrf_table", "closed")]
    {
        assert!(session.plan().left_out.iter().any(|(name, why)| *name == stage && why.contains(word)), "{stage}");
    }

    assert_eq!(names(&run(&ball, LAMBERT)), ["refit", "pack_normals", "widen", "visibility", "lambert", "tone"]);
    let table = scene("sphere", &["object.0.detail=2", "transport.cdrf=table", "transport.cdrf_table=9"], 0.0);
    let session = run(&table, CDRF);
    assert_eq!(names(&session).join(" "), format!("{shape} cdrf_table cdrf_cells cdrf tone"));
    assert_eq!(session.state().data.cdrf_cells.len(), 64);
    let dark = scene("sphere", &["object.0.detail=2", "light.0.irradiance=0"], 0.0);
    let mut session = run(&dark, CDRF);
    assert_eq!(names(&session), ["refit", "widen", "visibility", "shade", "tone"]);
    assert!(session.picture().unwrap().pixels.contains(&[0.0; 3]));

    // With light transport, none of these stages run.
    let session = run(&ball, Options::default());
    for stage in [
        "curvature",
        "pack_normals",
        "cdrf_table",
        "cdrf_cells",
        "cdrf",
        "lambert",
        "bake_irradiance",
        "blur",
        "texture_blur",
    ] {
        assert!(
            session
                .plan()
                .left_out
                .iter()
                .any(|(name, why)| *name == stage
                    && why.starts_with("scheme blocks carries the light; part of --transport")),
            "{stage}"
        );
    }
    assert!(session.state().data.curvature.is_empty());
}

#[test]
fn curvature_follows_the_shape_and_nothing_else() {
    let deformed = |frame: f64| scene("twist", &["object.0.detail=8", "object.0.material.sigma_0=3"], frame);
    on_devices(|device| {
        for backend in [None, Some(device)] {
            let mut moving = Session::new(&deformed(0.0), backend, CDRF).unwrap();
            moving.frame(Change::EVERYTHING).unwrap();
            let ran = |times: &[milkglass::internals::gpu::Timing]| {
                times.iter().any(|time| time.name == "curvature" || time.name == "pack_normals")
            };
            assert!(!ran(&moving.frame(Change::LIGHT).unwrap()) && !ran(&moving.frame(Change::VIEW).unwrap()));
            for frame in [4.0, 30.0, 2.0] {
                moving.show(&deformed(frame)).unwrap();
                assert!(ran(&moving.frame(Change::default()).unwrap()));
                let mut fresh = Session::new(&deformed(frame), backend, CDRF).unwrap();
                fresh.frame(Change::EVERYTHING).unwrap();
                for slot in [BufferId::curvature, BufferId::packed_normals, BufferId::radiance] {
                    let [a, b] = [&mut moving, &mut fresh].map(|session| {
                        session.fetch(&[slot]).unwrap();
                        session.state().data.bytes(slot).to_vec()
                    });
                    assert!(!a.is_empty() && a == b, "{slot:?} at {frame}");
                }
            }
        }
    });
}

#[test]
fn only_other_objects_cast_shadows() {
    // A ball lit from behind, with a plate between it and the light, or behind the camera.
    let ball = ["object.0.detail=3", "object.0.material.sigma_0=9", "light.0.direction=[0, 0, -1]"];
    let plate =
        "object.1={ shape = 'slab', detail = 2, size = 60, position = [0, 0, -40], material = { opaque = true } }";
    let aside =
        "object.1={ shape = 'slab', detail = 2, size = 60, position = [0, 0, 90], material = { opaque = true } }";
    let view = ["camera.position=[0, 0, 60]", "camera.target=[0, 0, 0]", "camera.background=0"];
    let sum = |more: &[&str]| {
        let mut session = run(&scene("sphere", &[&ball[..], &view, more].concat(), 0.0), CDRF);
        session.picture().unwrap().pixels.iter().map(|pixel| f64::from(pixel[0])).sum::<f64>()
    };
    let alone = sum(&[]);
    assert!(alone > 0.0);
    assert_eq!(sum(&[plate, "light.0.shadows=true"]), 0.0);
    assert!(sum(&[plate, "light.0.shadows=false"]) >= alone);
    assert!((sum(&[aside]) / alone - 1.0).abs() < 1e-3, "behind the eye it hides nothing");
}

#[test]
fn opaque_objects_are_shaded_as_ever() {
    // One opaque object, with its own shadow, and a texture set for light that enters.
    let sets = [
        "object.0.detail=64",
        "object.0.material={ opaque = true, texture = 'builtin:tiles', texture_on = 'entry' }",
        "light.0={ type = 'directional', direction = [1, 0.3, 0.4], irradiance = 3 }",
        "camera.background=0",
    ];
    let bust = scene("bust", &sets, 0.0);
    let picture = |transport: ShadingMethod| run(&bust, options(transport)).picture().unwrap().pixels;
    let [carried, local, lambert] =
        [ShadingMethod::Hierarchy, ShadingMethod::Cdrf, ShadingMethod::Lambert].map(picture);
    assert!(carried == local && carried == lambert);
    let session = run(&bust, CDRF);
    assert!(
        names(&session).contains(&"pixel_shadow")
            && !names(&session).iter().any(|name| ["cdrf", "curvature", "pack_normals"].contains(name))
    );
}

#[test]
fn the_command_line_says_what_local_shading_does_not_tell() {
    let here = folder(&[]);
    let cdrf = "render sphere --transport cdrf -o a.png --size 24x20 --device cpu --set object.0.detail=1";
    assert!(!good(&here, cdrf).1.contains("note:"));
    let far = good(&here, &format!("{cdrf} --set object.0.material.sigma_0=900")).1;
    assert!(far.contains("note: sigma_0 kappa is above 1 on 100 % of the vertices"), "{far}");
    good(&here, "render sphere --transport lambert -o b.png --size 24x20 --device cpu --set object.0.detail=1");
    bad(
        &here,
        "solve sphere --transport cdrf -o a.csv",
        2,
        &["--transport", "cdrf, lambert or texture-blur", "hierarchy"],
    );
    let dark = "render sphere --view curvature -o k.png --size 9x9 --device cpu --set light.0.irradiance=0";
    bad(&here, dark, 2, &["--view curvature", "no light shines"]);
    bad(&here, "render sphere --transport lambert --aov -o a.exr", 2, &["--aov", "hierarchy"]);
    let cases = [
        ("object.0.material.sigma_0=-1", "object.0.material.sigma_0"),
        ("object.0.material.sigma_0=[1,nan,1]", "object.0.material.sigma_0"),
        (
            "object.0.material.sigma_0_texture=builtin:tile",
            "object.0.material.sigma_0_texture: no texture of this name",
        ),
        ("object.0.material.sigma_0_texture=none.png", "none.png"),
        (
            "object.0.material={opaque=true,sigma_0_texture='builtin:tiles'}",
            "sigma_0_texture: an opaque material has no",
        ),
        ("transport.blur_texture=8", "transport.blur_texture: out of range; found 8; expected 16 to 2048"),
        ("transport.cdrf=tabel", "cdrf"),
        ("transport.cdrf_table=7", "transport.cdrf_table: out of range; found 7; expected 8 to 1024"),
        ("transport.curvature=max", "curvature"),
    ];
    for (set, words) in cases {
        bad(&here, &format!("render sphere --transport cdrf -o c.png --set {set}"), 2, &[words]);
    }
}

#[test]
fn an_environment_counts_by_its_own_factors() {
    // Uniform light from all directions gives A_0(sigma) at every normal; sigma is constant on a ball.
    let sky = "light.0={ type = 'environment', radiance = 2 }";
    let ball =
        ["object.0.detail=5", "object.0.size=20", "object.0.material.eta=1", "object.0.material.sigma_0=[9, 2, 0]"];
    let mut session = run(&scene("sphere", &[&ball[..], &[sky, "camera.background=0"]].concat(), 0.0), CDRF);
    let picture = session.picture().unwrap();
    let frame = session.state().data.object_params[0];
    let seen: Vec<_> = picture.pixels.iter().filter(|pixel| **pixel != [0.0; 3]).collect();
    assert!(seen.len() > 100);
    for (c, sigma) in [(0, 0.9), (1, 0.2), (2, 0.0)] {
        let expected = f64::from(frame.diffuse[c]) / std::f64::consts::PI * zonal(sigma)[0] * 2.0;
        for pixel in &seen {
            assert!((f64::from(pixel[c]) / expected - 1.0).abs() < 5e-3, "{c}: {pixel:?} {expected}");
        }
    }
}

#[test]
fn between_its_points_the_table_is_near_and_the_closed_form_everywhere() {
    use milkglass::internals::layout::CDRF_WIDEST;
    use milkglass::internals::layout::Query;
    use milkglass::internals::pipeline::frame::stage;
    use milkglass::internals::shading::cdrf_cells::lookup;
    use milkglass::internals::shading::reflectance::cdrf;
    use milkglass::internals::state::{DeviceState, Scope, State, Step};
    let table = scene("sphere", &["object.0.detail=1", "transport.cdrf=table"], 0.0);
    let cells = run(&table, CDRF).state().data.cdrf_cells.clone();
    // Additive recurrences, so that no point is on the grid; then the terminator as sigma tends to 0, the table's worst
    // case.
    let share = |k: u32, rate: f64| (f64::from(k) * rate).fract();
    let all = (1..60_000).map(|k| (2.0 * share(k, 0.754_877_666) - 1.0, CDRF_WIDEST * share(k, 0.569_840_291)));
    let terminator = (1..20_000).map(|k| (0.03 * share(k, 0.754_877_666) - 0.015, 0.03 * share(k, 0.569_840_291)));
    let places: Vec<(f64, f64)> = all.chain(terminator).collect();
    let worst = places.iter().map(|&(c, s)| (lookup(&cells, 256, c, s) - cdrf(c, s)).abs()).fold(0.0, f64::max);
    assert!(worst < 2e-3 && worst > 1e-4, "{worst}");

    on_devices(|device| {
        let mut state = State::default();
        let query = |&(c, s): &(f64, f64)| Query { a: [c as f32, s as f32, 0.0], ..Query::default() };
        state.data.queries = places.iter().map(query).collect();
        state.data.answers = vec![[0.0; 3]; places.len()];
        let mut device_state = DeviceState::new(device, false).unwrap();
        device_state.upload(&state, BUFFER_IDS).unwrap();
        device_state.run(&state, &[Step { stage: stage("cdrf_values").unwrap(), at: Scope::SCENE }]).unwrap();
        device_state.download(&mut state, &[BufferId::answers]).unwrap();
        let apart = |(query, answer): (&Query, &[f32; 3])| {
            (f64::from(answer[0]) - cdrf(query.a[0].into(), query.a[1].into())).abs()
        };
        let worst = state.data.queries.iter().zip(&state.data.answers).map(apart).fold(0.0, f64::max);
        assert!(worst < 2e-5, "{worst}");
        println!("closed form {worst:e}");
    });
}
