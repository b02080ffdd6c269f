//! Determinism: the buffers of built-in scenes have the same hashes in two runs on each device, each scene in some of
//! the ways that it can run in.
//!
//! With `MILKGLASS_FINGERPRINTS=FILE`, these hashes of all scenes in all ways, those of the CPU and of all fixtures,
//! and the planned steps are compared with FILE, or written there if it does not exist. This shows whether a change
//! affects any result; without the variable nothing is computed on the CPU, whose results other tests compare with
//! devices' and with formulas.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::sync::Mutex;

use milkglass::internals::gpu::Device;
use milkglass::internals::layout::{BUFFER_IDS, BufferId};
use milkglass::internals::pipeline::plan::{Change, Goal, Mode, Options, ShadingMethod};
use milkglass::internals::session::run::Session;
use milkglass::internals::state::{State, Step};
use milkglass::scene::{BUILTIN, Scene};

/// FNV-1a over words of eight bytes, with a rotation.
fn hash(bytes: &[u8]) -> u64 {
    let word = |part: &[u8]| part.iter().rev().fold(0, |word, &byte| word << 8 | u64::from(byte));
    let mix = |sum: u64, part: &[u8]| (sum ^ word(part)).wrapping_mul(0x0100_0000_01b3).rotate_left(23);
    bytes.chunks(8).fold(0xcbf2_9ce4_8422_2325 ^ bytes.len() as u64, mix)
}

/// Buffers that devices write completely or not at all; gaps in other buffers may hold anything.
const WHOLE: [BufferId; 13] = [
    BufferId::lit,
    BufferId::pixel_lit,
    BufferId::positions,
    BufferId::bounds,
    BufferId::clusters,
    BufferId::normals,
    BufferId::curvature,
    BufferId::smooth_kappa,
    BufferId::irradiance,
    BufferId::reference_level,
    BufferId::counters,
    BufferId::hits,
    BufferId::radiance,
];

/// The hash and size of each of these buffers, by binding.
fn of_state(key: &str, state: &State, slots: &[BufferId], found: &mut BTreeMap<String, String>) {
    for &slot in slots {
        let binding = slot as usize;
        let bytes = state.data.bytes(slot);
        found.insert(format!("{key} buffer {binding:03}"), format!("{:016x} {}", hash(bytes), bytes.len()));
    }
}

fn names(steps: &[Step]) -> String {
    let mut text = String::new();
    steps.iter().for_each(|step| {
        let _ = write!(text, "{step:?} ");
    });
    text
}

/// Every change that frames are planned for.
const CHANGES: [(&str, Change); 5] = [
    ("everything", Change::EVERYTHING),
    ("light", Change::LIGHT),
    ("view", Change::VIEW),
    ("resum", Change::RESUM),
    ("relink", Change::RELINK),
];

/// A scene's buffers after a first frame and after a second for `Change::LIGHT`, and the planned steps of its frames.
fn of_scene(key: &str, scene: &Scene, options: Options, device: Option<&Device>, found: &mut BTreeMap<String, String>) {
    let mut session = Session::new(scene, device, options).unwrap();
    for (name, change) in CHANGES {
        let steps = session.plan().steps(session.state(), change);
        found.insert(format!("{key} steps {name}"), names(&steps));
    }
    let slots = if device.is_some() { &WHOLE } else { BUFFER_IDS };
    session.frame(Change::EVERYTHING).unwrap();
    session.fetch(BUFFER_IDS).unwrap();
    of_state(&format!("{key} first"), session.state(), slots, found);
    let picture = session.picture().unwrap();
    found.insert(format!("{key} picture"), format!("{:016x}", hash(bytemuck::cast_slice(&picture.pixels))));
    // The last light goes: a real change.
    let fewer = &scene.lights[..scene.lights.len().saturating_sub(1)];
    session.set_lights(fewer).unwrap();
    session.frame(Change::LIGHT).unwrap();
    session.fetch(BUFFER_IDS).unwrap();
    of_state(&format!("{key} second"), session.state(), slots, found);
}

/// Configurations in which each scene runs: name, settings, options.
fn ways() -> Vec<(String, Vec<&'static str>, Options)> {
    let mut ways = Vec::new();
    let picture = Options::default();
    for scheme in ["transport.scheme=blocks", "transport.scheme=links"] {
        for mode in [Mode::OnTheFly, Mode::Keep, Mode::Render, Mode::Incremental] {
            ways.push((format!("{scheme} {mode:?}"), vec![scheme], Options { mode, ..picture }));
        }
    }
    for transport in [ShadingMethod::None, ShadingMethod::Cdrf, ShadingMethod::Lambert, ShadingMethod::TextureBlur] {
        ways.push((format!("{transport:?}"), vec![], Options { transport, ..picture }));
    }
    for goal in [Goal::Layers, Goal::Radiosity] {
        ways.push((format!("{goal:?}"), vec![], Options { goal, estimate: true, ..picture }));
    }
    ways
}

/// Settings that make large scenes coarse.
const DETAIL: &[(&str, &str)] = &[
    ("bump", "object.0.detail=2"),
    ("bust", "object.0.detail=64"),
    ("candle", "object.0.detail=16"),
    ("lotus", "object.0.detail=20"),
    ("noise", "object.0.detail=2"),
    ("slab", "object.0.detail=4"),
    ("slab-layers", "object.0.detail=4"),
    ("sphere", "object.0.detail=3"),
    ("torus", "object.0.detail=16"),
    ("twist", "object.0.detail=2"),
    ("veins", "object.0.detail=64"),
];

/// Every built-in scene in every way that it can run in.
fn cases() -> Vec<(String, Scene, Options)> {
    let mut cases = Vec::new();
    for (way, sets, options) in ways() {
        for &(name, _, _) in BUILTIN {
            let detail = DETAIL.iter().find(|(scene, _)| *scene == name).map_or("", |(_, set)| set);
            let size = ["camera.size=[24, 20]", "camera.samples=1", detail];
            let sets = sets.iter().copied().chain(size.into_iter().filter(|set| !set.is_empty()));
            let scene = Scene::load_with(name, &sets.map(String::from).collect::<Vec<_>>()).unwrap();
            let triangles: usize = scene.objects.iter().map(|object| object.mesh.triangles.len()).sum();
            let light = ["transport.scheme=blocks Render", "transport.scheme=links Keep", "Cdrf"];
            if triangles > 5000 && !light.contains(&way.as_str())
                || options.transport == ShadingMethod::TextureBlur
                    && scene.objects.iter().any(|object| object.mesh.uvs.is_none())
            {
                continue;
            }
            cases.push((format!("{name} {way}"), scene, options));
        }
    }
    cases
}

/// Usually one case in this many runs: another scene and another way each time, but not every scene in every way.
const SOME: usize = 15;

/// Fingerprints of these cases on a device, or on the CPU.
fn all<'a>(
    device: Option<&Device>,
    cases: impl Iterator<Item = &'a (String, Scene, Options)>,
) -> BTreeMap<String, String> {
    let mut found = BTreeMap::new();
    let on = device.map_or("cpu", Device::name).to_string();
    cases.for_each(|(key, scene, options)| of_scene(&format!("{on} {key}"), scene, *options, device, &mut found));
    found
}

/// Fingerprints of all fixtures, before and after their CPU references.
fn of_fixtures() -> BTreeMap<String, String> {
    let mut found = BTreeMap::new();
    for fixture in super::stages::all() {
        let mut state = fixture.state.clone();
        of_state(&format!("fixture {} before", fixture.name), &state, BUFFER_IDS, &mut found);
        fixture.steps.iter().for_each(|step| step.reference(&mut state));
        of_state(&format!("fixture {} after", fixture.name), &state, BUFFER_IDS, &mut found);
        found.insert(format!("fixture {} steps", fixture.name), names(&fixture.steps));
    }
    found
}

/// Runs one case in `step` twice on every device; both must have the same fingerprints.
fn same_twice(cases: &[(String, Scene, Options)], step: usize) -> BTreeMap<String, String> {
    let found = Mutex::new(BTreeMap::new());
    crate::devices::on_devices(|device| {
        let [once, again] = [0; 2].map(|_| all(Some(device), cases.iter().step_by(step)));
        let differ: Vec<_> = once.iter().filter(|(key, value)| again.get(*key) != Some(value)).collect();
        assert!(differ.is_empty() && !once.is_empty(), "two runs differ: {differ:.4000?}");
        found.lock().unwrap().extend(once);
    });
    found.into_inner().unwrap()
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn every_run_has_the_same_bits() {
    let file = std::env::var_os("MILKGLASS_FINGERPRINTS");
    let mut found = BTreeMap::new();
    let cases = cases();
    if file.is_some() {
        found.extend(of_fixtures());
        found.extend(all(None, cases.iter()));
    }
    found.extend(same_twice(&cases, if file.is_some() { 1 } else { SOME }));
    let Some(file) = file else { return };
    let text: String = found.iter().map(|(key, value)| format!("{key}: {value}\n")).collect();
    match std::fs::read_to_string(&file) {
        Err(_) => std::fs::write(&file, text).unwrap(),
        Ok(before) => {
            let before: std::collections::BTreeSet<&str> = before.lines().collect();
            let other: Vec<&str> = text.lines().filter(|line| !before.contains(line)).collect();
            assert!(other.is_empty(), "{} of {} differ:\n{}", other.len(), found.len(), other.join("\n"));
        }
    }
}

mod rare {
    #[test]
    #[ignore = "rare: part of .ci/full, `cargo test --release -- --include-ignored`"]
    fn so_it_has_in_every_way() {
        super::same_twice(&super::cases(), 1);
    }
}
