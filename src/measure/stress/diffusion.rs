//! Diffusion in extreme media and shapes: the device's radiosity against the CPU's, and what is left of the equation by
//! sums over all pairs of triangles in `f64`.

use glam::DVec3;

use super::meshes::{both, reversed};
use super::shade::cone;
use super::solve::scene;
use super::{Bound, Case, Found, Kind, Plant, Worst, within};
use crate::error::Result;
use crate::gpu::Device;
use crate::layout::BufferId;
use crate::measure::norms::worst;
use crate::measure::reference::verify;
use crate::pipeline::plan::{Change, Goal, Options, ShadingMethod};
use crate::scene::{Mesh, Scene};
use crate::session::run::Session;

/// The bounds on the difference of two solutions, and on what is left of the equation.
const SAME: Bound = within(5e-4, 4e-3);
const LEFT: Bound = within(1e-3, 1e-2);
const REASON: &str = "each solution is within the tolerance of 1e-3 of the dense one, mostly a tenth of it. In the place of brute \
                      force: what is left of the equation, whose solver ends at a tenth of the tolerance; clusters add to it";

const fn case(name: &'static str, fallback: &'static str, make: fn() -> Result<Scene>) -> Case {
    Case { name, fallback, bound: SAME, brute: LEFT, reason: REASON, kind: Kind::Diffusion(make) }
}

/// The base scene with another closed mesh.
fn shaped(mesh: Mesh, sets: &[&str]) -> Result<Scene> {
    let mut scene = scene(sets)?;
    scene.objects[0].mesh = Mesh { open_edges: 0, ..mesh };
    Ok(scene)
}

/// The base scene's ball, scaled and moved.
fn ball(scale: f64, to: f64) -> Result<Mesh> {
    let mut mesh = scene(&["object.0.detail=2"])?.objects.swap_remove(0).mesh;
    mesh.positions.iter_mut().for_each(|place| *place = *place * scale + DVec3::X * to);
    Ok(mesh)
}

/// The cases; sizes are in units of the object's.
pub(super) const CASES: &[Case] = &[
    case("diffusion: no absorption", "k is 0: the kernels' limits", || scene(&["object.0.material.sigma_a=0"])),
    case("diffusion: eta 0.8, 1 and 2.5", "at 1 nothing is reflected within; below 1 light is lost at the rim", || {
        scene(&["object.0.material.eta=[0.8, 1, 2.5]"])
    }),
    case("diffusion: mean free path 1e-4", "B is nearly local", || {
        scene(&["object.0.material.sigma_s_prime=[1e4, 5e3, 9e3]", "object.0.material.sigma_a=[10, 1e-2, 0]"])
    }),
    case(
        "diffusion: mean free path 1 to 100",
        "most light passes straight through; what collides does so in the middle",
        || scene(&["object.0.material.sigma_s_prime=[0.01, 0.1, 1]", "object.0.material.sigma_a=[0, 1e-5, 5e-5]"]),
    ),
    case("diffusion: k size 1e-4, 1 and 1e4", "kernels from 1 / s to none", || {
        scene(&["object.0.material.sigma_s_prime=[22, 22, 5e3]", "object.0.material.sigma_a=[1.5e-10, 0.015, 4.2e3]"])
    }),
    case("diffusion: alpha' 0.01", "light that enters is lost; the CPU and the device agree", || {
        scene(&["object.0.material.sigma_s_prime=[0.2, 0.3, 0.4]", "object.0.material.sigma_a=[22, 30, 40]"])
    }),
    case("diffusion: needle", "thinner than a mean free path, and triangles of a thousand to one", || {
        shaped(cone(6, 1e-2, 0.49), &["object.0.material.sigma_s_prime=[22, 2, 900]"])
    }),
    case("diffusion: touching balls", "one object; triangles of one see those of the other across a point", || {
        shaped(both(ball(0.5, -0.249)?, ball(0.5, 0.249)?), &[])
    }),
    case("diffusion: shell round a cavity", "a wall of a twentieth; light that leaves into it is gone", || {
        shaped(both(ball(1.0, 0.0)?, reversed(ball(0.9, 0.0)?)), &[])
    }),
    case("diffusion: grazing light", "as any: the refracted ray is at its steepest", || {
        scene(&["object.0.shape=slab", "object.0.detail=10", "light.0.direction=[1, 0, 1e-4]"])
    }),
];

/// A solved session.
fn solved(scene: &Scene, device: Option<&Device>) -> Result<Session> {
    let options = Options { transport: ShadingMethod::Diffusion, goal: Goal::Radiosity, ..Options::default() };
    let mut session = Session::new(scene, device, options)?;
    session.frame(Change::EVERYTHING)?;
    session.fetch(&[BufferId::radiosity, BufferId::solution])?;
    Ok(session)
}

/// The solution against the CPU's, and what is left of its equation.
pub(super) fn run(scene: &Scene, device: Option<&Device>, plant: Option<Plant>) -> Result<[Found; 2]> {
    let (expected, mut found) = (solved(scene, None)?, solved(scene, device)?);
    let mut radiosity = found.state().data.radiosity.clone();
    if let Some(plant) = plant {
        plant.apply(&mut radiosity);
    }
    let (mut usual, mut left) = (Found::default(), Found::default());
    usual.look("radiosity", &radiosity);
    for channel in 0..3 {
        let pairs = || expected.state().data.radiosity.iter().zip(&radiosity);
        let sum = |of: &dyn Fn(f64, f64) -> f64| -> f64 {
            pairs().map(|(a, b)| of(f64::from(a[channel]), f64::from(b[channel]))).sum()
        };
        let (whole, apart) = (sum(&|a, _| a * a), sum(&|a, b| (a - b).powi(2)));
        let most = pairs().map(|(a, b)| f64::from(a[channel] - b[channel]).abs()).fold(0.0, f64::max);
        let mean = (whole / pairs().count().max(1) as f64).sqrt();
        if whole == 0.0 {
            usual.faults.push(format!("no light leaves in channel {channel}"));
        }
        let own = Worst { l2: (apart / whole).sqrt(), max: most / mean };
        // NaN counts as more than any number.
        let worse = |a: f64, b: f64| if a > b || a.is_nan() { a } else { b };
        usual.error = Worst { l2: worse(own.l2, usual.error.l2), max: worse(own.max, usual.error.max) };
    }
    for report in found.solve_reports().iter().filter(|report| !report.converged) {
        left.faults.push(format!("not solved after {} steps: {:?} is left", report.steps, report.residual));
    }
    left.error = worst(&verify(&mut found, 60, 1)?).into();
    Ok([usual, left])
}
