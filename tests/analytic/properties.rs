//! Properties for any mesh and light, on small seeded meshes, on the CPU: radiosity is finite and at least 0, linear in
//! light, independent of the scene's position and of the order of its file, and on a half-space at most R_full times
//! what enters.

use glam::{DQuat, DVec3};
use milkglass::internals::dipole::profile::Dipole;
use milkglass::internals::lighting::fresnel;
use milkglass::internals::pipeline::plan::{Change, Goal, Options};
use milkglass::internals::session::run::Session;
use milkglass::scene::{Files, Memory, Scene};
use proptest::prelude::*;
use proptest::test_runner::RngSeed;
use std::fmt::Write as _;

/// A fixed seed: every run tries the same meshes.
fn cases(cases: u32) -> ProptestConfig {
    ProptestConfig { cases, rng_seed: RngSeed::Fixed(2003), failure_persistence: None, ..ProptestConfig::default() }
}

const MARBLE: &str = "material = { preset = 'marble' }\n";
/// A tight tolerance, so that wrong values do not pass as tolerated ones. Results may differ by ten times as much,
/// relative to their rms.
const TIGHT: &str = "[transport]\ntolerance = 1e-4\n";
const APART: f64 = 1e-3;

/// Vertices, and vertex indices from 0.
#[derive(Clone, Debug)]
struct Mesh {
    positions: Vec<DVec3>,
    faces: Vec<[usize; 3]>,
}

impl Mesh {
    fn obj(&self) -> String {
        let mut text = String::new();
        for p in &self.positions {
            let _ = writeln!(text, "v {:e} {:e} {:e}", p.x, p.y, p.z);
        }
        for [a, b, c] in &self.faces {
            let _ = writeln!(text, "f {} {} {}", a + 1, b + 1, c + 1);
        }
        text
    }

    fn moved(&self, place: impl Fn(DVec3) -> DVec3) -> Self {
        Self { positions: self.positions.iter().map(|&p| place(p)).collect(), ..self.clone() }
    }
}

/// A session after its first frame; `None` where the scene is refused.
fn frame(mesh: &Mesh, lights: &[String], rest: &str) -> Option<Session> {
    let text = format!("{}[[object]]\nmesh = 'm.obj'\n{rest}", lights.concat());
    let files = Files::held([("m.obj".into(), mesh.obj().into_bytes())], Memory::USUAL);
    let mut scene = Scene::parse_from("property.toml", &text, &[], &files).ok()?;
    // Dented balls keep their triangles, which are compared.
    scene.transport.divided = mesh.faces.len() == FACES;
    let options = Options { goal: Goal::Radiosity, ..Options::default() };
    let mut session = Session::new(&scene, None, options).ok()?;
    session.frame(Change::EVERYTHING).unwrap();
    Some(session)
}

/// Irradiance and radiosity of each face in the file's order, in scene units; `None` where the scene is refused.
fn solve(mesh: &Mesh, lights: &[String], rest: &str) -> Option<[Vec<[f64; 3]>; 2]> {
    let session = frame(mesh, lights, rest)?;
    let (data, unit) = (&session.state().data, session.units().light);
    let places = session.prepared().places(0);
    let in_order = |light: &[[f32; 3]]| places.iter().map(|&face| light[face].map(|x| f64::from(x) * unit)).collect();
    Some([in_order(&data.irradiance), in_order(&data.radiosity)])
}

fn sun(direction: DVec3, strength: f64, shadows: bool) -> String {
    let DVec3 { x, y, z } = direction;
    let [r, g, b] = [1.0, 0.8, 0.5].map(|x| x * strength);
    format!(
        "[[light]]\ntype = 'directional'\ndirection = [{x:e}, {y:e}, {z:e}]\nirradiance = [{r:e}, {g:e}, {b:e}]\n\
         shadows = {shadows}\n"
    )
}

fn rms(values: &[[f64; 3]]) -> f64 {
    let count = 3.0 * values.len() as f64;
    (values.iter().flatten().map(|x| x * x).sum::<f64>() / count).sqrt()
}

/// The largest difference, relative to the rms of `a`.
fn apart(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    let pairs = a.iter().flatten().zip(b.iter().flatten());
    pairs.map(|(x, y)| (x - y).abs()).fold(0.0, f64::max) / rms(a).max(1e-300)
}

/// Number of faces and vertices of a dented ball.
const FACES: usize = 320;
const VERTICES: usize = 162;

/// A dented ball of size 2 to 60. For marble, this ranges from all faces near each other to each face on its own.
fn dented() -> impl Strategy<Value = Mesh> {
    let size = (2f64.ln()..60f64.ln()).prop_map(f64::exp);
    (proptest::collection::vec(0.8..1.1f64, VERTICES), size).prop_map(|(radii, size)| {
        let scene = Scene::load_with("sphere", &["object.0.detail=2".into(), format!("object.0.size={size}")]).unwrap();
        let mesh = &scene.objects[0].mesh;
        let positions = mesh.positions.iter().zip(radii).map(|(p, radius)| radius * *p).collect();
        Mesh { positions, faces: mesh.triangles.iter().map(|t| t.map(|v| v as usize)).collect() }
    })
}

/// Arbitrary triangles: a few vertices, close together or far apart, connected at random.
fn soup() -> impl Strategy<Value = Mesh> {
    let number = prop_oneof![4 => -1.0..1.0f64, 1 => Just(0.0), 1 => -1e6..1e6f64, 1 => -1e-6..1e-6f64];
    let place = [number.clone(), number.clone(), number].prop_map(DVec3::from_array);
    let mesh = (proptest::collection::vec(place, 3..9), proptest::collection::vec([0..9usize, 0..9, 0..9], 1..13));
    mesh.prop_map(|(positions, faces)| {
        let count = positions.len();
        Mesh { positions, faces: faces.into_iter().map(|face| face.map(|v| v % count)).collect() }
    })
}

fn direction() -> impl Strategy<Value = DVec3> {
    (-1.0..1.0f64, 0.0..std::f64::consts::TAU).prop_map(|(z, turn)| {
        let wide = (1.0 - z * z).sqrt();
        DVec3::new(wide * turn.cos(), wide * turn.sin(), z)
    })
}

proptest! {
    #![proptest_config(cases(64))]

    #[test]
    fn whatever_loads_gives_finite_light_of_at_least_0(
        mesh in prop_oneof![3 => soup(), 1 => dented()], way in direction(), size in -6.0..6.0f64,
        tolerance in -4.0..-1.0f64,
    ) {
        let (size, tolerance) = (10f64.powf(size), 10f64.powf(tolerance));
        let rest = format!("{MARBLE}size = {size:e}\n[transport]\ntolerance = {tolerance:e}\n");
        if let Some([e, b]) = solve(&mesh, &[sun(way, 1.0, true)], &rest) {
            prop_assert!(e.iter().chain(&b).flatten().all(|x| x.is_finite() && *x >= 0.0), "{:?} {:?}", e, b);
        }
    }
}

proptest! {
    #![proptest_config(cases(6))]

    #[test]
    #[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
    fn radiosity_is_linear_in_light_and_more_light_never_darkens(
        mesh in dented(), one in direction(), other in direction(), strength in 0.1..10.0f64, doublings in -20..20i32,
    ) {
        let rest = format!("{MARBLE}{TIGHT}");
        let (first, second) = (sun(one, 1.0, true), sun(other, strength, true));
        let [_, a] = solve(&mesh, std::slice::from_ref(&first), &rest).unwrap();
        let [_, b] = solve(&mesh, std::slice::from_ref(&second), &rest).unwrap();
        let [_, both] = solve(&mesh, &[first, second], &rest).unwrap();
        let sum: Vec<[f64; 3]> = a.iter().zip(&b).map(|(a, b)| std::array::from_fn(|c| a[c] + b[c])).collect();
        prop_assert!(apart(&sum, &both) < APART, "{}", apart(&sum, &both));
        let (least, unit) = (APART * rms(&both), f64::from(doublings).exp2());
        prop_assert!(a.iter().flatten().zip(both.iter().flatten()).all(|(a, both)| *both >= a - least));
        // Scaling by a power of two is exact.
        let [_, scaled] = solve(&mesh, &[sun(one, unit, true)], &rest).unwrap();
        prop_assert!(a.iter().flatten().zip(scaled.iter().flatten()).all(|(a, scaled)| a * unit == *scaled));
    }

    #[test]
    #[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
    fn a_scene_turned_or_moved_is_the_same(
        mesh in dented(), way in direction(), axis in direction(), angle in 0.0..6.0f64, far in direction(),
    ) {
        let rest = format!("{MARBLE}{TIGHT}");
        let turn = DQuat::from_axis_angle(axis.normalize(), angle);
        let [_, b] = solve(&mesh, &[sun(way, 1.0, false)], &rest).unwrap();
        let [_, turned] = solve(&mesh.moved(|p| turn * p), &[sun(turn * way, 1.0, false)], &rest).unwrap();
        prop_assert!(apart(&b, &turned) < APART, "turned: {}", apart(&b, &turned));
        let [_, moved] = solve(&mesh.moved(|p| p + 1e6 * far), &[sun(way, 1.0, false)], &rest).unwrap();
        prop_assert!(apart(&b, &moved) < APART, "moved: {}", apart(&b, &moved));
    }

    #[test]
    fn the_order_of_a_file_does_not_matter(
        mesh in dented(), way in direction(), order in Just((0..FACES).collect::<Vec<usize>>()).prop_shuffle(),
        numbers in Just((0..VERTICES).collect::<Vec<usize>>()).prop_shuffle(),
        turns in proptest::collection::vec(0..3usize, FACES),
    ) {
        let (rest, light) = (format!("{MARBLE}{TIGHT}"), [sun(way, 1.0, true)]);
        let [e, b] = solve(&mesh, &light, &rest).unwrap();
        // Renumbering the vertices is exact.
        let mut renumbered = mesh.clone();
        numbers.iter().enumerate().for_each(|(old, &new)| renumbered.positions[new] = mesh.positions[old]);
        renumbered.faces.iter_mut().flatten().for_each(|v| *v = numbers[*v]);
        prop_assert_eq!(solve(&renumbered, &light, &rest).unwrap(), [e.clone(), b.clone()]);
        // Shuffling the faces, and rotating the corners within each.
        let face = |&old: &usize| { let mut face = mesh.faces[old]; face.rotate_left(turns[old]); face };
        let shuffled = Mesh { faces: order.iter().map(face).collect(), ..mesh.clone() };
        let [_, other] = solve(&shuffled, &light, &rest).unwrap();
        let at = |face| order.iter().position(|&old| old == face).unwrap();
        let back: Vec<[f64; 3]> = (0..FACES).map(|face| other[at(face)]).collect();
        prop_assert!(apart(&b, &back) < APART, "{}", apart(&b, &back));
    }

    #[test]
    fn scene_and_material_scaled_together_are_the_same(mesh in dented(), way in direction(), factor in -9.0..9.0f64) {
        let material = |scale: f64| {
            let [s, a] = [2.19 / scale, 0.0021 / scale];
            format!("material = {{ sigma_s_prime = {s:e}, sigma_a = {a:e}, eta = 1.5 }}\n{TIGHT}")
        };
        let [e, b] = solve(&mesh, &[sun(way, 1.0, true)], &material(1.0)).unwrap();
        // Scaling by a power of two is exact.
        let two = factor.round().exp2();
        let double = solve(&mesh.moved(|p| two * p), &[sun(way, 1.0, true)], &material(two)).unwrap();
        prop_assert_eq!(double, [e, b.clone()]);
        let larger = mesh.moved(|p| factor.exp2() * p);
        let [_, scaled] = solve(&larger, &[sun(way, 1.0, true)], &material(factor.exp2())).unwrap();
        prop_assert!(apart(&b, &scaled) < APART, "{}", apart(&b, &scaled));
    }

    #[test]
    fn a_half_space_gives_back_no_more_than_r_full(
        way in direction(), scattering in 0.1..10.0f64, albedo in -6.0..-0.5f64, eta in 1.0..2.5f64,
        size in 1.0..1e4f64,
    ) {
        // A plane of 8 x 8 squares; the free path is from 1e-5 to 10 times its width.
        let side = |k: usize| size * (k as f64 / 8.0 - 0.5);
        let positions = (0..81).map(|k| DVec3::new(side(k % 9), side(k / 9), 0.0)).collect();
        let square = |k: usize| { let a = k % 8 + 9 * (k / 8); [[a, a + 1, a + 10], [a, a + 10, a + 9]] };
        let mesh = Mesh { positions, faces: (0..64).flat_map(square).collect() };
        let absorption = scattering * 10f64.powf(albedo);
        let rest = format!(
            "material = {{ sigma_s_prime = {scattering:e}, sigma_a = {absorption:e}, eta = {eta:e}, \
             fresnel = 'exact' }}\n{TIGHT}"
        );
        let up = DVec3::new(way.x, way.y, way.z.abs().max(0.01));
        let [e, b] = solve(&mesh, &[sun(up, 1.0, false)], &rest).unwrap();
        let inner = fresnel::diffuse_internal_exact(eta);
        let full = Dipole::new(scattering, absorption, fresnel::boundary(inner)).total();
        prop_assert!(full <= 1.0);
        for (e, b) in e.iter().zip(&b) {
            prop_assert!((0..3).all(|c| b[c] <= full * e[c] * (1.0 + APART)), "{:?} of {:?}, R_full {}", b, e, full);
        }
    }
}

#[test]
#[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
fn dented_balls_have_emitters_of_every_kind() {
    // Otherwise the properties above would not cover every kind of emitter.
    use proptest::strategy::ValueTree;
    let mut runner = proptest::test_runner::TestRunner::new(cases(6));
    let mut kinds = [0; 5];
    for _ in 0..6 {
        let mesh = dented().new_tree(&mut runner).unwrap().current();
        let session = frame(&mesh, &[sun(DVec3::new(1.0, 2.0, 3.0), 1.0, false)], &format!("{MARBLE}{TIGHT}")).unwrap();
        for run in &session.state().data.runs {
            let counts = [run.dropped, run.expanded, run.direct, run.area, run.edge];
            (0..5).for_each(|kind| kinds[kind] += counts[kind]);
        }
    }
    assert!(kinds.iter().all(|&count| count > 0), "dropped, expanded, direct, area, edge: {kinds:?}");
}
