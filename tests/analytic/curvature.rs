//! Convergence of curvature on surfaces of known curvature, and finite results on degenerate meshes.

use std::f64::consts::TAU;

use glam::DVec3;
use milkglass::internals::layout::Curvature;
use milkglass::internals::pipeline::plan::{Change, Options, ShadingMethod};
use milkglass::internals::session::run::Session;
use milkglass::internals::shading::fit;
use milkglass::scene::{Mesh, Scene};

/// A session after one frame of this mesh, shaded by curvature.
fn session(positions: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Session {
    let sets = ["object.0.detail=0", "camera.size=[16, 16]", "object.0.material.sigma_0=1"].map(String::from);
    let mut scene = Scene::load_with("sphere", &sets).unwrap();
    let input_face = (0..triangles.len() as u32).collect();
    scene.objects[0].mesh = Mesh { positions, triangles, input_face, ..Mesh::default() };
    let options = Options { transport: ShadingMethod::Cdrf, ..Options::default() };
    let mut session = Session::new(&scene, None, options).unwrap();
    session.frame(Change::EVERYTHING).unwrap();
    session
}

/// A pseudo-random number in [-1, 1] for each index.
fn noise(k: u32) -> f64 {
    let mut h = k.wrapping_mul(0x9e37_79b9) ^ 0x85eb_ca6b;
    h = (h ^ (h >> 15)).wrapping_mul(0x2c1b_3c6d);
    f64::from(h ^ (h >> 12)) / f64::from(u32::MAX) * 2.0 - 1.0
}

/// A grid of `across` x `up` cells over [0, 1]^2, mapped by `place`; its points are jittered by up to `shake` of a
/// cell. `round` says in which directions it closes.
fn grid(
    [across, up]: [u32; 2],
    round: [bool; 2],
    shake: f64,
    place: impl Fn(f64, f64) -> DVec3,
) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    let [columns, rows] = [across + u32::from(!round[0]), up + u32::from(!round[1])];
    let point = |k: u32| {
        let (i, j) = (k % columns, k / columns);
        let moved = |at: u32, count: u32, closed: bool, seed: u32| {
            let fixed = !closed && (at == 0 || at == count);
            (f64::from(at) + if fixed { 0.0 } else { shake * noise(2 * k + seed) }) / f64::from(count)
        };
        place(moved(i, across, round[0], 0), moved(j, up, round[1], 1))
    };
    let cell = |k: u32| {
        let (i, j) = (k % across, k / across);
        let at = |i: u32, j: u32| j % rows * columns + i % columns;
        let (a, b, c, d) = (at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1));
        [[a, b, c], [a, c, d]]
    };
    ((0..columns * rows).map(point).collect(), (0..across * up).flat_map(cell).collect())
}

/// Root mean square errors of H, K, kappa and the cubic fit's kappa, in units of the largest curvature (for K: of its
/// square); `truth` is k1 and k2 at a point.
fn errors(session: &Session, truth: impl Fn(DVec3) -> [f64; 2]) -> [f64; 4] {
    let (data, units) = (&session.state().data, session.units());
    let (mut sums, mut counts, mut largest) = ([0.0; 4], [0.0; 2], 0.0f64);
    for (vertex, found) in data.curvature.iter().enumerate().filter(|(_, found)| found.area > 0.0) {
        let [k1, k2] = truth(session.scene().objects[0].mesh.positions[vertex]);
        let out = |x: f32| f64::from(x) * units.length;
        let rms = |a: f64, b: f64| (0.5 * (a * a + b * b)).sqrt();
        let fitted = fit::at(data, vertex).map(|[a, b]| rms(a, b) * units.length);
        let misses = [
            out(found.mean) - 0.5 * (k1 + k2),
            out(found.gaussian) * units.length - k1 * k2,
            out(found.kappa) - rms(k1, k2),
            fitted.map_or(0.0, |fitted| fitted - rms(k1, k2)),
        ];
        sums.iter_mut().zip(misses).for_each(|(sum, miss)| *sum += miss * miss);
        largest = largest.max(k1.abs()).max(k2.abs());
        counts[0] += 1.0;
        counts[1] += f64::from(u8::from(fitted.is_some()));
    }
    let scale = [largest, largest * largest, largest, largest];
    // The fit fails at a few vertices near open edges only.
    assert!(counts[1] > 0.5 * counts[0]);
    [0, 1, 2, 3].map(|k| (sums[k] / counts[k / 3]).sqrt() / scale[k])
}

/// A surface: name, grid cells, closed or not in each direction, its map, and its principal curvatures.
type Surface = (&'static str, [u32; 2], [bool; 2], fn(f64, f64) -> DVec3, fn(DVec3) -> [f64; 2]);

/// Major and minor radius of the torus.
const TORUS: [f64; 2] = [3.0, 1.0];

const SURFACES: [Surface; 4] = [
    // A cap of a ball of radius 2, by stereographic projection, so that triangles are as even as on a plane.
    (
        "sphere",
        [12, 12],
        [false, false],
        |u, v| {
            let (x, y) = (1.6 * u - 0.8, 1.6 * v - 0.8);
            let square = x * x + y * y;
            2.0 * DVec3::new(2.0 * x, 2.0 * y, 1.0 - square) / (1.0 + square)
        },
        |_| [0.5, 0.5],
    ),
    ("cylinder", [16, 8], [true, false], |u, v| DVec3::new((TAU * u).cos(), (TAU * u).sin(), 3.0 * v), |_| [1.0, 0.0]),
    (
        "torus",
        [36, 12],
        [true, true],
        |u, v| {
            let across = TORUS[0] + TORUS[1] * (TAU * v).cos();
            DVec3::new(across * (TAU * u).cos(), across * (TAU * u).sin(), TORUS[1] * (TAU * v).sin())
        },
        |p| {
            let cosine = (p.x.hypot(p.y) - TORUS[0]) / TORUS[1];
            [1.0 / TORUS[1], cosine / (TORUS[0] + TORUS[1] * cosine)]
        },
    ),
    (
        "saddle",
        [12, 12],
        [false, false],
        |u, v| DVec3::new(2.0 * u - 1.0, 2.0 * v - 1.0, 0.5 * ((2.0 * u - 1.0).powi(2) - (2.0 * v - 1.0).powi(2))),
        |p| {
            // z = (x^2 - y^2) / 2 with +z outward, convex positive: H = (x^2 - y^2) / (2 w^3), K = -1 / w^4, w^2 = 1 +
            // x^2 + y^2.
            let w2 = 1.0 + p.x * p.x + p.y * p.y;
            let (mean, gaussian) = ((p.x * p.x - p.y * p.y) / (2.0 * w2.powf(1.5)), -1.0 / (w2 * w2));
            let half = (mean * mean - gaussian).sqrt();
            [mean + half, mean - half]
        },
    ),
];

#[test]
fn curvature_converges_on_known_surfaces() {
    println!("surface, shake, triangles: error of H, K, kappa, kappa of the cubic fit; orders");
    for (name, cells, round, place, truth) in SURFACES {
        for shake in [0.0, 0.2] {
            let levels: Vec<[f64; 4]> = [1, 2, 4]
                .map(|fine| {
                    let (positions, triangles) = grid(cells.map(|n| n * fine), round, shake, place);
                    let count = triangles.len();
                    let found = errors(&session(positions, triangles), truth);
                    println!("{name} {shake} {count}: {}", found.map(|x| format!("{x:.1e}")).join(", "));
                    found
                })
                .to_vec();
            let order = |k: usize| (levels[0][k] / levels[2][k]).log2() / 2.0;
            println!("{name} {shake}: orders {:.1?}", [0, 1, 2, 3].map(order));
            let [mean, gaussian, kappa, fitted] = levels[2];
            if shake > 0.0 {
                // Uneven triangles: neither method converges, so only the error is bounded.
                assert!(mean < 0.15 && gaussian < 0.3 && kappa < 0.2 && fitted < 0.3, "{name}, shaken: {levels:?}");
                continue;
            }
            assert!(mean < 3e-3 && gaussian < 8e-3 && kappa < 4e-3 && fitted < 8e-3, "{name}: {levels:?}");
            let converges = |k: usize| levels[2][k] < 1e-5 || order(k) > 1.6;
            assert!((0..4).all(converges), "{name}: {levels:?}");
        }
    }
}

#[test]
fn hardly_surfaces_have_numbers() {
    let fan = |count: u32, height: f64| {
        let rim = (0..count).map(|k| {
            let angle = TAU * f64::from(k) / f64::from(count);
            DVec3::new(angle.cos(), angle.sin(), 0.0)
        });
        let positions: Vec<_> =
            [DVec3::new(0.0, 0.0, height), DVec3::new(9.0, 9.0, 9.0)].into_iter().chain(rim).collect();
        let triangles: Vec<_> = (0..count).map(|k| [0, 2 + k, 2 + (k + 1) % count]).collect();
        session(positions, triangles)
    };
    let sound = |found: &Curvature| {
        [found.kappa, found.mean, found.gaussian].iter().all(|x| x.is_finite()) && found.kappa >= 0.0
    };
    for (count, height) in [(3, 1.0), (5, 1e6), (900, 0.0), (900, 1e-7), (1000, 3.0), (3, -1e9), (400, 1e12)] {
        let made = fan(count, height);
        let curvature = &made.state().data.curvature;
        assert!(curvature.iter().all(sound), "{count} {height}: {curvature:?}");
        // A vertex without triangles is flat; the rim takes the curvature of the tip.
        assert_eq!(curvature[1], Curvature::default());
        assert_eq!(curvature[2].kappa, curvature[0].kappa);
        assert!(curvature[0].area > 0.0 && curvature[2].area == 0.0);
        assert!(made.state().data.radiance.iter().flatten().all(|x| x.is_finite()), "{count} {height}");
    }
    // A cone of 1000 triangles: the angle deficit at the tip is 2 pi (1 - 1 / slant).
    let made = fan(1000, 1.0);
    let (tip, units) = (made.state().data.curvature[0], made.units());
    let slant = 2f64.sqrt();
    // The part nearer to the tip than to the rim: a quarter of the cone's lateral area.
    let area = 0.25 * 0.5 * TAU * slant;
    let expected = TAU * (1.0 - 1.0 / slant) / area;
    assert!((f64::from(tip.gaussian) * units.length.powi(2) / expected - 1.0).abs() < 0.02, "{tip:?} {expected}");
    // A flat fan has next to no curvature; a hollow has a negative mean.
    assert!(fan(900, 0.0).state().data.curvature[0].kappa < 1e-2);
    assert!(fan(9, -1.0).state().data.curvature[0].mean < 0.0 && fan(9, 1.0).state().data.curvature[0].mean > 0.0);
}
