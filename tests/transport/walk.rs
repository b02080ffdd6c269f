//! The random walk against known answers, and its tallies bit for bit.

use super::walk_light::on_devices_and_cpu;
use crate::devices::on_devices;
use milkglass::internals::gpu::Device;
use milkglass::internals::layout::{BUFFER_IDS, BufferId, ExitSum};
use milkglass::internals::lighting::fresnel;
use milkglass::internals::session::walk::WalkReport;
use milkglass::internals::state::{DeviceState, State, Step};
use milkglass::internals::transport::walk::{random_walk, sum64, total};
use milkglass::scene::Mesh;
use milkglass::{Options, Scene, Session, ShadingMethod};

pub(super) fn scene(sets: &[&str]) -> Scene {
    let all: Vec<String> = sets.iter().map(ToString::to_string).collect();
    Scene::load_with("sphere", &all).unwrap()
}

pub(super) fn options() -> Options {
    let goal = milkglass::Goal::Radiosity;
    Options { transport: ShadingMethod::Walk, goal, ..Options::default() }
}

/// A walk on the CPU, and its session.
fn walked(sets: &[&str]) -> (Session, WalkReport) {
    let mut session = Session::new(&scene(sets), None, options()).unwrap();
    session.faces_after_a_frame();
    let report = session.walk_reports()[0].clone();
    (session, report)
}

pub(super) trait Frame {
    fn faces_after_a_frame(&mut self) -> Vec<milkglass::FaceLight>;
}

impl Frame for Session {
    fn faces_after_a_frame(&mut self) -> Vec<milkglass::FaceLight> {
        self.frame(milkglass::internals::pipeline::plan::Change::EVERYTHING).unwrap();
        self.faces().unwrap()
    }
}

pub(super) const SUN: &str = "light=[{ type = 'directional', direction = [0, 0, 1], irradiance = 1, shadows = false }]";
pub(super) const SKY: &str = "light=[{ type = 'environment', radiance = 1 }]";

/// In each channel as much light goes as came, counted in integers.
pub(super) fn balances(state: &State) {
    for channel in 0..3 {
        let own = || state.data.balances.iter().skip(channel).step_by(3);
        let sum =
            |of: fn(&milkglass::internals::layout::WalkBalance) -> [u32; 2]| own().map(|b| sum64(of(b))).sum::<u64>();
        let left: u64 = state.data.exits.iter().map(|exit| exit.once(channel) + exit.more(channel)).sum();
        let out = left + sum(|b| b.straight) + sum(|b| b.absorbed) + sum(|b| b.lost) + sum(|b| b.killed);
        assert_eq!(sum(|b| b.entered) + sum(|b| b.gained), out, "channel {channel}");
        assert!(sum(|b| b.entered) > 0);
    }
}

#[test]
fn without_absorption_everything_leaves() {
    for eta in ["1", "1.5"] {
        let eta = format!("object.0.material={{ sigma_s_prime = [0.05, 0.5, 5], sigma_a = 0, eta = {eta} }}");
        let (session, report) = walked(&["object.0.detail=3", SUN, &eta, "transport.walks=4000"]);
        balances(session.state());
        for c in 0..3 {
            assert_eq!((report.absorbed[c], report.lost[c]), (0.0, 0.0));
            assert!((report.left[c] + report.straight[c] - 1.0).abs() < 1e-15, "{report:?}");
        }
    }
}

#[test]
fn straight_light_fades_by_the_free_path() {
    // Parallel light through a ball: the mean of e^-x over its chords, x the diameter in free paths.
    let media = "object.0.material={ sigma_s_prime = [0.02, 0.1, 0.3], sigma_a = 0, eta = 1 }";
    let (session, report) = walked(&["object.0.detail=5", "object.0.size=20", SUN, media, "transport.walks=100000"]);
    balances(session.state());
    for (c, sigma) in [0.02, 0.1, 0.3].into_iter().enumerate() {
        let x: f64 = 20.0 * sigma;
        let expected = 2.0 * (1.0 - (1.0 + x) * (-x).exp()) / (x * x);
        let error = (expected * (1.0 - expected) / 1e5).sqrt();
        assert!((report.straight[c] - expected).abs() < 3.5 * error + 1e-3, "{} {expected}", report.straight[c]);
    }
}

/// A cube with sharp edges.
pub(super) fn cube_of(side: f64) -> Mesh {
    let corner = |k: usize| side * (glam::DVec3::new((k & 1) as f64, ((k >> 1) & 1) as f64, (k >> 2) as f64) - 0.5);
    let squares = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    Mesh {
        positions: (0..8).map(corner).collect(),
        triangles: squares.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
        input_face: (0..12).collect(),
        ..Mesh::default()
    }
}

/// Chandrasekhar's H of isotropic scattering.
fn chandrasekhar(albedo: f64, at: f64) -> f64 {
    let count = 400;
    let mu = |k: usize| (k as f64 + 0.5) / count as f64;
    let mut h = vec![1.0; count];
    let next = |h: &[f64], x: f64| {
        let integral: f64 = (0..count).map(|k| mu(k) * h[k] / (x + mu(k))).sum::<f64>() / count as f64;
        1.0 / ((1.0 - albedo).sqrt() + 0.5 * albedo * integral)
    };
    for _ in 0..200 {
        h = (0..count).map(|k| next(&h, mu(k))).collect();
    }
    next(&h, at)
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn a_half_space_reflects_by_chandrasekhars_h() {
    assert!((chandrasekhar(0.9, 1.0) - 1.849).abs() < 0.02);
    // A cube of a thousand free paths, lit from one side, or aslant and then on two sides.
    let media = "object.0.material={ sigma_s_prime = [45, 35, 15], sigma_a = [5, 15, 35], eta = 1 }";
    for (direction, cosine) in [("[0, 0, 1]", 1.0), ("[1, 0, 1]", 0.5f64.sqrt())] {
        let sun = SUN.replace("[0, 0, 1]", direction);
        let mut cube = scene(&[&sun, media, "transport.walks=60000"]);
        cube.objects[0].mesh = cube_of(20.0);
        let mut session = Session::new(&cube, None, options()).unwrap();
        session.faces_after_a_frame();
        let report = session.walk_reports()[0].clone();
        balances(session.state());
        let once: [f64; 3] = [0, 1, 2].map(|c| {
            session.state().data.exits.iter().map(|exit| exit.once(c) as f64).sum::<f64>() / 60_000.0 / f64::exp2(30.0)
        });
        for (c, albedo) in [0.9, 0.7, 0.3f64].into_iter().enumerate() {
            let expected = 1.0 - chandrasekhar(albedo, cosine) * (1.0 - albedo).sqrt();
            let error = 0.5 / 60_000f64.sqrt();
            assert!(
                (report.left[c] - expected).abs() < 3.5 * error + 2e-3,
                "{direction} {albedo}: {report:?} {expected}"
            );
            let first = 0.5 * albedo * (1.0 - cosine * (1.0 + 1.0 / cosine).ln());
            assert!((once[c] - first).abs() < 3.5 * error + 1e-3, "{direction} {albedo}: {} {first}", once[c]);
        }
    }
}

/// The mean path of light from all around is 4 V / S over the share that passes outward, in any medium that absorbs
/// little: however it scatters, whatever the shape.
#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn light_from_all_around_stays_as_long_as_it_must() {
    let sigma = 1e-4;
    for (eta, g) in [(1.0, 0.0), (1.3, 0.0), (1.5, 0.7), (2.0, -0.4)] {
        let media = format!(
            "object.0.material={{ sigma_s_prime = [0.01, 0.1, 0.4], sigma_a = {sigma}, eta = {eta}, g = {g} }}"
        );
        let (mut session, report) =
            walked(&["object.0.detail=3", "object.0.size=10", SKY, &media, "transport.walks=30000"]);
        let points = session.vertices();
        let faces = session.faces().unwrap();
        let corners = |face: &milkglass::FaceLight| face.triangle.map(|v| points[v as usize]);
        let volume: f64 = faces.iter().map(corners).map(|[a, b, c]| a.dot(b.cross(c)) / 6.0).sum();
        let surface: f64 = faces.iter().map(|face| face.area).sum();
        let path = 4.0 * volume / surface / (1.0 - fresnel::diffuse_internal_exact(eta));
        balances(session.state());
        for c in 0..3 {
            let found = report.absorbed[c] / sigma;
            assert!((found / path - 1.0).abs() < 0.02, "{eta} {g} {c}: {found} {path}");
        }
        // Without absorption as much would leave each face as enters it.
        let scattered: f64 = faces.iter().map(|face| face.area * face.radiosity[2]).sum();
        let entered: f64 = faces.iter().map(|face| face.area * face.irradiance[2]).sum();
        assert!((scattered / entered + report.straight[2] + report.absorbed[2] - 1.0).abs() < 1e-4);
    }
}

/// Light from all around, and no absorption: as much leaves each triangle as enters it, as in any equilibrium.
#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn each_triangle_returns_what_it_takes() {
    let media = "object.0.material={ sigma_s_prime = [1, 3, 9], sigma_a = 0, eta = [1.5, 1, 1.3], g = 0.3 }";
    let mut cube = scene(&[SKY, media, "transport.walks=20000"]);
    cube.objects[0].mesh = cube_of(20.0);
    // Triangles of other sizes, at the corners too.
    cube.objects[0].mesh.positions[0] *= 0.7;
    on_devices_and_cpu(|device| {
        let mut session = Session::new(&cube, device, options()).unwrap();
        for face in session.faces_after_a_frame() {
            let noise = face.noise.unwrap();
            for (c, noise) in noise.into_iter().enumerate() {
                let (enters, leaves) = (face.irradiance[c], face.radiosity[c]);
                assert!((leaves - enters).abs() < 4.0 * noise && noise < 0.05 * enters, "{c}: {leaves} {enters}");
            }
        }
    });
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn noise_is_that_of_other_photons() {
    // Standard errors against the spread of two independent halves: objects of other numbers walk otherwise.
    let ball = "{ shape = 'sphere', detail = 2, size = 10, position = [0, 0, 40], material = { preset = 'marble' } }";
    let sets =
        ["object.0.detail=2", "object.0.size=10", "object.0.material.preset=marble", SKY, "transport.walks=20000"];
    let mut session =
        Session::new(&scene(&[&sets[..], &[&format!("object.1={ball}")]].concat()), None, options()).unwrap();
    let faces = session.faces_after_a_frame();
    let (one, two) = faces.split_at(faces.len() / 2);
    let score = |(a, b): (&milkglass::FaceLight, &milkglass::FaceLight), c: usize| {
        let (m, n) = (a.noise.unwrap()[c], b.noise.unwrap()[c]);
        (a.radiosity[c] - b.radiosity[c]).powi(2) / (m * m + n * n)
    };
    for c in 0..3 {
        let mean = one.iter().zip(two).map(|pair| score(pair, c)).sum::<f64>() / one.len() as f64;
        assert!((mean - 1.0).abs() < 0.2, "{mean}");
    }
}

/// Runs an object's walk to its end, with so many photons under way at once.
fn walk(session: &Session, slots: u32, device: Option<&Device>) -> Vec<ExitSum> {
    let mut state = session.state().clone();
    state.data.walk_params[0].slots = slots;
    state.data.balances.fill(Default::default());
    let steps = session.plan().steps(&state, milkglass::internals::pipeline::plan::Change::EVERYTHING);
    let at = steps.iter().position(|step| step.stage.is(&random_walk::STAGE)).unwrap();
    let over = |state: &State| {
        let slots = state.data.photons[..slots as usize].iter().enumerate();
        let number = |slot: usize, started: u32| slot as u32 / 3 + started * (slots_of(state) / 3);
        slots.clone().all(|(k, p)| p.weight == 0 && number(k, p.started) >= state.data.walk_params[0].photons)
    };
    let mut gpu = device.map(|device| DeviceState::new(device, false).unwrap());
    let mut run = |state: &mut State, step: Step| match &mut gpu {
        None => step.reference(state),
        Some(gpu) => {
            gpu.upload(state, BUFFER_IDS).unwrap();
            gpu.run(state, &[step]).unwrap();
            gpu.download(state, &[BufferId::photons, BufferId::balances, BufferId::exits]).unwrap();
        }
    };
    let own = |step: &&Step| step.stage.module == random_walk::STAGE.module;
    steps[..at].iter().filter(own).for_each(|step| run(&mut state, *step));
    while !over(&state) {
        run(&mut state, steps[at]);
    }
    balances(&state);
    state.data.exits
}

fn slots_of(state: &State) -> u32 {
    state.data.walk_params[0].slots
}

#[test]
fn any_number_at_once_counts_the_same() {
    let sets = ["object.0.detail=2", "object.0.size=10", "object.0.material.preset=skin1", "transport.walks=600"];
    let mut session = Session::new(&scene(&sets), None, options()).unwrap();
    session.faces_after_a_frame();
    let expected = session.state().data.exits.clone();
    assert!(total(&session.state().data).light(0) > 0.0);
    for slots in [3, 96, 1800] {
        assert!(walk(&session, slots, None) == expected, "{slots} on the CPU");
    }
    on_devices(|device| {
        for slots in [99, 1800] {
            assert!(walk(&session, slots, Some(device)) == expected, "{slots} on {}", device.name());
        }
    });
}

#[test]
fn surfaces_without_an_inside_are_refused() {
    let mut open = scene(&["object.0.detail=2"]);
    open.objects[0].mesh.triangles.truncate(300);
    open.objects[0].mesh.open_edges = 12;
    let error = Session::new(&open, None, options()).err().unwrap().to_string();
    assert!(error.contains("12 open edges") && error.contains("closed"), "{error}");
    // Holes that nobody counted: photons fall through.
    open.objects[0].mesh.open_edges = 0;
    let error = Session::new(&open, None, options()).unwrap().frame(Default::default()).err().unwrap().to_string();
    assert!(error.contains("found no way out") && error.contains("object.0"), "{error}");
}
