//! Random sequences of edits of all kinds: every frame has, bit for bit, what a new session gives.

use crate::devices;
use milkglass::internals::gpu::{Buffer, Device};
use milkglass::internals::layout::BufferId;
use milkglass::internals::pipeline::plan::{Goal, Mode, Options, ShadingMethod};
use milkglass::internals::session::run::Session;
use milkglass::internals::state::Object;
use milkglass::scene::Scene;
use proptest::prelude::*;
use proptest::test_runner::{RngSeed, TestRunner};

/// The knobs: for each, the settings that it can be at.
const KNOBS: &[&[&[&str]]] = &[
    &[&["light.0.direction=[0.3, 0.4, 1]"], &["light.0.direction=[-1, 0.2, 0.4]"], &["light.0.direction=[0, 0, -1]"]],
    &[
        &["light.0.irradiance=3"],
        &["light.0.irradiance=[3, 2, 1]"],
        &["light.0.irradiance=[1.5, 1, 0.5]"],
        &["light.0.irradiance=0"],
    ],
    &[
        &[],
        &["light.1={ type='point', position=[4, 9, 25], intensity=[500, 300, 300] }"],
        &["light.1={ type='directional', direction=[1, 1, 0], irradiance=1 }"],
        &["light.1={ type='area', position=[-9, 20, 9], edge_u=[6, 0, 0], edge_v=[0, 0, 6], radiance=9, samples=2 }"],
        &["light.1={ type='environment', image='builtin:sky', occlusion=9 }"],
    ],
    &[&[], &["object.0.material.scale=2"], &["object.0.material.scale=6"]],
    &[&[], &["object.0.material.sigma_a=[0.02, 0.004, 0.04]"]],
    &[&[], &["object.0.material.eta=1.3"], &["object.0.material.eta=[1.3, 1.5, 1.4]"]],
    &[
        &[],
        &["object.0.material.reflection='ggx'", "object.0.material.roughness=0.2"],
        &["object.0.material.reflection='ggx'", "object.0.material.roughness=0.5"],
        &["object.0.material.reflection='phong'", "object.0.material.shininess=20"],
    ],
    &[&[], &["object.0.material.two_sided=true"]],
    &[&[], &["object.0.material.texture='builtin:tiles'"], &["object.0.material.texture='builtin:checker'"]],
    &[
        &["object.1.material={ preset='ketchup' }"],
        &["object.1.material={ preset='ketchup', scale=3 }"],
        &["object.1.material={ opaque=true, albedo=0.5 }"],
        &["object.1.material={ opaque=true, albedo=[0.2, 0.5, 0.7] }"],
    ],
    &[
        &["object.1.position=[0, -16, 0]"],
        &["object.1.position=[2, 12, 9]"],
        &["object.1.position=[14, 0, 3]"],
        &["object.1.position=[13, 1, 3]"],
    ],
    &[&[], &["object.1.rotation=[30, 50, 0]"], &["object.1.rotation=[31, 50, 5]"]],
    &[
        &[],
        &["object.0.deform.0={ type='twist', angle=20 }"],
        &["object.0.deform.0={ type='twist', angle=170 }"],
        &["object.0.deform.0={ type='bump', position=[0, 0, 10], radius=4, height=1 }"],
    ],
    &[&[], &["object.1.deform.0={ type='bump', position=[0, -16, 3], radius=9, height=2, direction=[0, 0, 1] }"]],
    &[&["object.0.detail=1"], &["object.0.detail=2"]],
    &[&["camera.position=[0, 0, 70]"], &["camera.position=[40, 20, 40]"]],
    &[&["camera.size=[14, 12]"], &["camera.size=[23, 9]"]],
    &[&["camera.background=0"], &["camera.background=[0.1, 0.2, 0.3]"]],
    &[&[], &["camera.exposure=2"], &["camera.tone='filmic'"]],
    // Other numbers of soft light's points, and of a reflection's rays.
    &[&[], &["camera.samples=3"], &["camera.samples=9"]],
    &[&[], &["object.0.rotation=[0, 40, 0]"], &["object.0.rotation=[15, 41, 3]"], &["object.0.position=[1, 2, 0]"]],
];

/// The knob of `two_sided`.
const TWO_SIDED: usize = 7;

/// Settings of all scenes.
const BASE: &[&str] =
    &["object.0.size=20", "object.1.shape='slab'", "object.1.detail=2", "object.1.size=18", "transport.tolerance=1e-2"];

/// The settings of a knob at a number.
fn setting(knob: usize, at: usize) -> &'static [&'static str] {
    KNOBS[knob][at % KNOBS[knob].len()]
}

/// The scene with each knob at one of its settings.
fn scene(scheme: &str, extra: &[&str], at: &[usize]) -> Scene {
    let scheme = format!("transport.scheme='{scheme}'");
    let knobs = at.iter().enumerate().flat_map(|(knob, &at)| setting(knob, at));
    let sets: Vec<&str> = BASE.iter().chain(extra).chain(knobs).copied().chain([&scheme[..]]).collect();
    let sets: Vec<String> = sets.into_iter().map(String::from).collect();
    Scene::load_with("sphere", &sets).unwrap()
}

/// The results of a frame.
struct Outcome {
    pixels: Vec<[f32; 3]>,
    shown: Vec<u8>,
    irradiance: Vec<[f32; 3]>,
    radiosity: Vec<[f32; 3]>,
}

impl Outcome {
    fn of(session: &mut Session) -> Self {
        let picture = session.render().unwrap();
        let shown = session.shown().unwrap();
        assert!(shown == picture.bytes(), "the host's curve and the stage `tone` differ");
        session.fetch(&[BufferId::irradiance, BufferId::radiosity]).unwrap();
        let state = session.state();
        // By face: values between the objects' parts do not count.
        let by_face = |values: &[[f32; 3]]| {
            let lit = |object: &&Object| !object.by_pixel && object.lit_by_face();
            let faces_of = |object: &Object| {
                let first = object.first.faces;
                values.get(first..first + object.count.faces).unwrap_or_default().to_vec()
            };
            state.objects.iter().filter(lit).flat_map(faces_of).collect()
        };
        let (irradiance, radiosity) = (by_face(&state.data.irradiance), by_face(&state.data.radiosity));
        Self { pixels: picture.pixels, shown, irradiance, radiosity }
    }

    /// The names of the results that differ.
    fn apart(&self, other: &Self) -> Vec<&'static str> {
        let same = [
            ("picture", self.pixels == other.pixels),
            ("bytes", self.shown == other.shown),
            ("irradiance", self.irradiance == other.irradiance),
            ("radiosity", self.radiosity == other.radiosity),
        ];
        same.into_iter().filter(|(_, same)| !same).map(|(name, _)| name).collect()
    }
}

/// Edits a session and compares it with a new one after each edit.
fn follow(
    device: Option<&Device>,
    scheme: &str,
    extra: &[&str],
    options: Options,
    edits: &[Vec<(usize, usize)>],
) -> Result<(), TestCaseError> {
    let mut at = vec![0; KNOBS.len()];
    let mut session = Session::new(&scene(scheme, extra, &at), device, options).unwrap();
    for (step, edit) in edits.iter().enumerate() {
        // Diffusion refuses light from both sides.
        let allowed = |knob: usize| options.transport != ShadingMethod::Diffusion || knob != TWO_SIDED;
        edit.iter().filter(|(knob, _)| allowed(*knob)).for_each(|&(knob, value)| at[knob] = value);
        let scene = scene(scheme, extra, &at);
        session.show(&scene).unwrap();
        let mut fresh = Session::new(&scene, device, options).unwrap();
        let apart = Outcome::of(&mut session).apart(&Outcome::of(&mut fresh));
        let told: Vec<_> = edit.iter().map(|&(knob, value)| setting(knob, value)).collect();
        let Options { mode, transport, .. } = options;
        prop_assert!(apart.is_empty(), "{scheme} {mode:?} {transport:?}: {apart:?} after edit {step}: {told:?}");
    }
    Ok(())
}

/// The ways of making frames: scheme, settings, transport, mode.
const WAYS: &[(&str, &[&str], ShadingMethod, Mode)] = &[
    ("blocks", &["transport.receivers='faces'"], ShadingMethod::Hierarchy, Mode::OnTheFly),
    ("blocks", &["transport.receivers='faces'"], ShadingMethod::Hierarchy, Mode::Render),
    ("blocks", &["transport.receivers='pixels'"], ShadingMethod::Hierarchy, Mode::Render),
    ("blocks", &["transport.receivers='pixels'"], ShadingMethod::Hierarchy, Mode::OnTheFly),
    ("blocks", &[], ShadingMethod::Hierarchy, Mode::Keep),
    ("links", &[], ShadingMethod::Hierarchy, Mode::OnTheFly),
    ("links", &[], ShadingMethod::Hierarchy, Mode::Render),
    ("links", &[], ShadingMethod::Hierarchy, Mode::Incremental),
    ("blocks", &[], ShadingMethod::Brute, Mode::OnTheFly),
    ("blocks", &[], ShadingMethod::Octree, Mode::OnTheFly),
    ("blocks", &[], ShadingMethod::Cdrf, Mode::OnTheFly),
    ("blocks", &["transport.cdrf='table'"], ShadingMethod::Cdrf, Mode::OnTheFly),
    ("blocks", &[], ShadingMethod::Lambert, Mode::OnTheFly),
    ("blocks", &["transport.subdivide=1"], ShadingMethod::Hierarchy, Mode::OnTheFly),
    ("blocks", &[], ShadingMethod::Diffusion, Mode::OnTheFly),
    ("blocks", &[], ShadingMethod::Auto, Mode::OnTheFly),
];

fn sequences(device: Option<&Device>, way: usize, length: usize) {
    let (scheme, extra, transport, mode) = WAYS[way];
    let options = Options { transport, mode, goal: Goal::Picture, estimate: false };
    let edit = prop::collection::vec((0..KNOBS.len(), 0..60usize), 1..4);
    let config = ProptestConfig {
        cases: 1,
        rng_seed: RngSeed::Fixed(way as u64),
        max_shrink_iters: 200,
        failure_persistence: None,
        ..ProptestConfig::default()
    };
    let done = TestRunner::new(config)
        .run(&prop::collection::vec(edit, length), |edits| follow(device, scheme, extra, options, &edits));
    if let Err(fault) = done {
        panic!("{fault}");
    }
}

/// How many edits a sequence has: `MILKGLASS_EDITS`, or this many.
fn length(usual: usize) -> usize {
    std::env::var("MILKGLASS_EDITS").ok().and_then(|text| text.parse().ok()).unwrap_or(usual)
}

/// The ways tried: the one that `MILKGLASS_WAY` numbers, or all.
fn ways() -> Vec<usize> {
    let one = std::env::var("MILKGLASS_WAY").ok().map(|text| text.parse().expect("MILKGLASS_WAY is a number"));
    (0..WAYS.len()).filter(|way| one.is_none_or(|one: usize| one == *way)).collect()
}

#[test]
fn any_edits_give_what_a_new_session_gives() {
    ways().into_iter().for_each(|way| sequences(None, way, length(2)));
    devices::on_devices_each(&ways(), |device, &way| sequences(Some(device), way, length(2)));
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn many_edits_do_too() {
    devices::on_devices_each(&ways(), |device, &way| sequences(Some(device), way, length(20)));
}

mod rare {
    use super::*;

    #[test]
    #[ignore = "rare: part of .ci/full, `cargo test --release -- --include-ignored`"]
    fn so_do_twice_as_many() {
        ways().into_iter().for_each(|way| sequences(None, way, length(40)));
        devices::on_devices_each(&ways(), |device, &way| sequences(Some(device), way, length(40)));
    }
}

#[test]
fn a_refused_edit_changes_nothing() {
    let options = Options { goal: Goal::Picture, ..Options::default() };
    let at = vec![0; KNOBS.len()];
    let before = scene("blocks", &[], &at);
    let mut session = Session::new(&before, None, options).unwrap();
    let wanted = Outcome::of(&mut session);
    let bump = "object.0.deform.0={ type='bump', position=[0, 0, 10], radius=4, height=1000 }";
    let refused = scene("blocks", &[bump, "object.0.material.scale=3", "camera.size=[3, 3]"], &at[..14]);
    let told = session.show(&refused).unwrap_err().to_string();
    assert!(told.contains("move the object too far"), "{told}");
    assert!(session.scene().objects[0].deforms.is_empty());
    session.show(&before).unwrap();
    assert!(Outcome::of(&mut session).apart(&wanted).is_empty());
}

/// Where no stage says which receiver a pixel shows, memory must not: some drivers fault beyond a buffer's end.
#[test]
fn without_light_every_pixel_shows_the_first_receiver() {
    devices::on_devices(|device| {
        let sets = ["transport.receivers=pixels", "camera.size=[24, 20]"].map(String::from);
        let scene = Scene::load_with("sphere", &sets).unwrap();
        let mut session = Session::new(&scene, Some(device), Options::default()).unwrap();
        session.render().unwrap();
        session.fetch(&[BufferId::seen]).unwrap();
        assert!(session.state().data.seen.iter().any(|&seen| seen > 0));
        session.set_lights(&[]).unwrap();
        session.render().unwrap();
        session.fetch(&[BufferId::seen]).unwrap();
        assert!(session.state().data.seen.iter().all(|&seen| seen == 0));
    });
}

/// A buffer that a change of the scene brings into a session does not show what was in its memory before.
#[test]
fn memory_that_is_used_again_does_not_show() {
    devices::on_devices(|device| {
        let with = |shadows: &str| {
            let sets = ["object.0.detail=2", "camera.size=[8, 8]", &format!("light.0.shadows={shadows}")];
            Scene::load_with("sphere", &sets.map(str::to_string)).unwrap()
        };
        let mut session = Session::new(&with("false"), Some(device), Options::default()).unwrap();
        session.render().unwrap();
        let used: Vec<_> = (0..64).map(|_| Buffer::new(device, "used", 4).unwrap()).collect();
        used.iter().for_each(|buffer| buffer.upload(&[0xff; 4]).unwrap());
        drop(used);
        session.show(&with("true")).unwrap();
        let shown = session.render().unwrap();
        let wanted = Session::new(&with("true"), Some(device), Options::default()).unwrap().render().unwrap();
        assert!(shown.pixels == wanted.pixels);
    });
}
