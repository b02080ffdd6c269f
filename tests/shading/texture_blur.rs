//! Irradiance blurred in texture space: the stages it runs, its results, and its requirements on a mesh.

use crate::shell::{bad, folder, good};
use milkglass::internals::layout::{BUFFER_IDS, BufferId};
use milkglass::internals::lighting::fresnel::transmittance;
use milkglass::internals::pipeline::plan::{Change, Options, ShadingMethod};
use milkglass::internals::prepare::material::dipoles;
use milkglass::internals::session::run::Session;
use milkglass::internals::state::Scope;
use milkglass::scene::Scene;

const BLUR: ShadingMethod = ShadingMethod::TextureBlur;
const STAGES: [&str; 3] = ["bake_irradiance", "blur", "texture_blur"];

fn scene(name: &str, sets: &[&str]) -> Scene {
    let usual = ["camera.size=[40, 30]", "transport.unwrap=true", "transport.blur_texture=64"];
    Scene::load_with(name, &usual.iter().chain(sets).map(|set| set.to_string()).collect::<Vec<_>>()).unwrap()
}

fn run(scene: &Scene, transport: ShadingMethod) -> Session {
    let options = Options { transport, ..Options::default() };
    let mut session = Session::new(scene, None, options).unwrap();
    session.frame(Change::EVERYTHING).unwrap();
    session
}

fn names(session: &Session) -> Vec<&'static str> {
    session.plan().stages.iter().map(|stage| stage.name).collect()
}

/// A plane seen from above, evenly lit.
const PLANE: [&str; 8] = [
    "object.0.shape=plane",
    "object.0.detail=6",
    "object.0.size=40",
    "object.0.material={ preset = 'marble' }",
    "light.0={ type = 'directional', direction = [0.4, 1, 0.2], irradiance = [3, 2, 1] }",
    "camera.position=[0, 60, 1]",
    "camera.target=[0, 0, 0]",
    "camera.background=0",
];

#[test]
fn an_evenly_lit_plane_gives_back_the_profiles_total() {
    let plane = scene("sphere", &PLANE);
    let mut session = run(&plane, BLUR);
    let picture = session.picture().unwrap();
    let dipoles = dipoles(&plane.objects[0].material, 1.0);
    let cosine = 1.0 / (0.16f64 + 1.0 + 0.04).sqrt();
    let eye = plane.camera.position;
    let mut seen = 0;
    for (pixel, hit) in picture.pixels.iter().zip(&session.state().data.hits) {
        let Some(corners) = session.state().data.triangles.get(hit.face as usize) else { continue };
        seen += 1;
        let weight = [1.0 - hit.u - hit.v, hit.u, hit.v].map(f64::from);
        let point = (0..3).map(|k| {
            weight[k] * milkglass::internals::state::wide(session.state().data.positions[corners[k] as usize])
        });
        let way = eye - point.sum::<glam::DVec3>() / session.units().length;
        for c in 0..3 {
            let eta = plane.objects[0].material.eta[c];
            let enters = [3.0, 2.0, 1.0][c] * cosine * transmittance(eta, cosine);
            let leaves = transmittance(eta, way.y / way.length()) / std::f64::consts::PI;
            let (found, expected) = (f64::from(pixel[c]), leaves * dipoles[c].total() * enters);
            assert!((found / expected - 1.0).abs() < 1e-4, "{c}: {found} {expected}");
        }
    }
    assert!(seen > 300);
}

#[test]
fn pixels_show_maps_bilinearly() {
    let sets = [&PLANE[..], &["object.0.material={ preset = 'marble', eta = 1 }"]].concat();
    let session = run(&scene("sphere", &sets), BLUR);
    let mut state = session.state().clone();
    // Every map rises linearly along both axes, which bilinear look-ups keep.
    let side = state.data.unwrappings[0].side as usize;
    let ramp = |x: f64, y: f64| 2.0 + 0.3 * x + 0.05 * x * y + 0.2 * y;
    for (k, texel) in state.data.irradiance_maps.iter_mut().enumerate() {
        let value = ramp((k % side) as f64, (k / side % side) as f64) as f32;
        *texel = [value, value, value, 1.0];
    }
    (milkglass::internals::shading::texture_blur::STAGE.cpu)(&mut state, Scope::default());
    let data = &state.data;
    let mut shares = Vec::new();
    for (hit, pixel) in data.hits.iter().zip(&data.radiance).filter(|(hit, _)| hit.face != u32::MAX) {
        let uvs = &data.corner_uvs[hit.face as usize];
        let weight = [1.0 - hit.u - hit.v, hit.u, hit.v];
        let at = |k: usize| f64::from(weight[0] * uvs.a[k] + weight[1] * uvs.b[k] + weight[2] * uvs.c[k]);
        let [x, y] = [at(0), at(1)].map(|place| place * side as f64 - 0.5);
        if x.min(y) > 0.0 && x.max(y) < side as f64 - 1.0 {
            shares.push(f64::from(pixel[0]) / ramp(x, y));
        }
    }
    assert!(shares.len() > 300 && shares[0] > 0.0);
    assert!(shares.iter().all(|share| (share / shares[0] - 1.0).abs() < 1e-4), "{shares:?}");
}

#[test]
fn a_smooth_ball_is_near_the_dipole() {
    let ball = scene(
        "sphere",
        &["object.0.detail=4", "object.0.size=20", "transport.blur_texture=128", "camera.background=0"],
    );
    let [blurred, carried, lambert] = [BLUR, ShadingMethod::Hierarchy, ShadingMethod::Lambert]
        .map(|transport| run(&ball, transport).picture().unwrap().pixels);
    let apart = |a: &[[f32; 3]]| {
        let sum_of = |f: &dyn Fn(f64, f64) -> f64| {
            a.iter().flatten().zip(carried.iter().flatten()).map(|(a, b)| f(f64::from(*a), f64::from(*b))).sum::<f64>()
        };
        (sum_of(&|a, b| (a - b).powi(2)) / sum_of(&|_, b| b * b)).sqrt()
    };
    let (blurred, lambert) = (apart(&blurred), apart(&lambert));
    println!("{blurred} {lambert}");
    assert!(blurred < 0.04 && blurred < 0.75 * lambert, "{blurred} {lambert}");
}

#[test]
fn what_it_needs_is_there_and_elsewhere_nothing_of_it() {
    let ball = scene("sphere", &["object.0.detail=2", "light.0.shadows=false"]);
    let mut session = run(&ball, BLUR);
    assert_eq!(names(&session), ["refit", "widen", "visibility", "bake_irradiance", "blur", "texture_blur", "tone"]);
    let ran =
        |times: Vec<milkglass::internals::gpu::Timing>| times.into_iter().map(|time| time.name).collect::<Vec<_>>();
    assert_eq!(ran(session.frame(Change::VIEW).unwrap()), ["visibility", "texture_blur"]);
    assert_eq!(ran(session.frame(Change::LIGHT).unwrap()), STAGES);
    for transport in [ShadingMethod::Hierarchy, ShadingMethod::Cdrf, ShadingMethod::Lambert, ShadingMethod::None] {
        let session = run(&ball, transport);
        assert!(STAGES.iter().all(|stage| !names(&session).contains(stage)));
        let own = [
            BufferId::unwrappings,
            BufferId::texel_hits,
            BufferId::stretch,
            BufferId::gaussians,
            BufferId::irradiance_maps,
            BufferId::blurred_rows,
        ];
        let held: Vec<_> = BUFFER_IDS.iter().filter(|slot| own.contains(slot)).collect();
        assert!(held.len() == 6 && held.iter().all(|slot| session.state().data.bytes(**slot).is_empty()));
        for stage in STAGES {
            assert!(session.plan().left_out.iter().any(|(name, why)| *name == stage && !why.is_empty()), "{stage}");
        }
    }
}

#[test]
fn an_objects_own_shadow_counts() {
    // A ball lit from behind is dark in front.
    let behind = ["object.0.detail=3", "object.0.size=400", "light.0.direction=[0, 0, -1]", "camera.background=0"];
    let view = ["camera.position=[0, 0, 1500]", "camera.target=[0, 0, 0]"];
    let ball = scene("sphere", &[&behind[..], &view].concat());
    assert!(names(&run(&ball, BLUR)).contains(&"shadow"));
    let middle = run(&ball, BLUR).picture().unwrap().pixels[15 * 40 + 20];
    assert!(middle.iter().all(|&x| x < 1e-6), "{middle:?}");
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn it_asks_for_texture_coordinates_that_are_one_to_one() {
    let here = folder(&[
        ("bare.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"),
        ("flat.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n"),
        ("over.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\nf 1/1 3/2 4/3\n"),
        ("often.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 9 0\nvt 0 9\nf 1/1 2/2 3/3\n"),
    ]);
    let line = |name: &str| format!("render {name} --transport texture-blur -o a.png --size 20x16 --device cpu");
    good(&here, &line("flat.obj"));
    bad(&here, &line("bare.obj"), 2, &["bare.obj:4", "no texture coordinates"]);
    bad(&here, &line("over.obj"), 2, &["object.0", "lie over each other", "one to one"]);
    bad(&here, &line("often.obj"), 2, &["object.0", "too often"]);
    bad(&here, &line("slab"), 2, &["lie over each other"]);
    let plain = Scene::load_with("sphere", &["object.0.detail=1".into()]).unwrap();
    let options = Options { transport: BLUR, ..Options::default() };
    let error = Session::new(&plain, None, options).err().unwrap().to_string();
    assert!(error.contains("the mesh has none") && error.contains("transport.unwrap"), "{error}");
}

#[test]
fn a_map_gives_sigma_0_by_the_square_of_what_it_holds() {
    // The checker's texels are 1 and 1/4, so sigma_0 is multiplied by 1 and by 1/16.
    let shade = |sigma: &str, more: &[&str]| {
        let sigma = format!("object.0.material.sigma_0={sigma}");
        let sets = [&["object.0.detail=3", "camera.size=[80, 60]", sigma.as_str()], more].concat();
        run(&scene("sphere", &sets), ShadingMethod::Cdrf).picture().unwrap().pixels
    };
    let mapped = shade("4", &["object.0.material.sigma_0_texture=builtin:checker"]);
    let (whole, part) = (shade("4", &[]), shade("0.25", &[]));
    let near = |a: &[f32; 3], b: &[f32; 3]| (0..3).all(|c| (a[c] - b[c]).abs() <= 1e-6 * (1.0 + b[c].abs()));
    let mut counts = [0; 4];
    for ((mapped, whole), part) in mapped.iter().zip(&whole).zip(&part).filter(|((_, whole), part)| !near(whole, part))
    {
        let between =
            (0..3).all(|c| mapped[c] >= whole[c].min(part[c]) - 1e-6 && mapped[c] <= whole[c].max(part[c]) + 1e-6);
        let which = if near(mapped, whole) {
            0
        } else if near(mapped, part) {
            1
        } else if between {
            2
        } else {
            3
        };
        counts[which] += 1;
    }
    assert!(counts[0] > 200 && counts[1] > 200 && counts[2] < 600, "{counts:?}");
}
