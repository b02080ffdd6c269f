//! Shading by curvature on extreme curvatures: a device's picture against the reference's.

use std::f64::consts::TAU;

use glam::DVec3;

use super::meshes::{doubled, even, mesh, reversed, sheet, turned};
use super::solve::scene;
use super::{Bound, Case, Found, Kind, Plant, Worst, within};
use crate::error::{Error, Result};
use crate::gpu::Device;
use crate::layout::BufferId;
use crate::pipeline::plan::{Change, Options, ShadingMethod};
use crate::scene::{Cdrf, Mesh, Scene};
use crate::session::run::Session;
use crate::shading::smooth_curvature::kappa;

/// The bound for these pictures, and its reason.
const SHADED: Bound = within(3e-6, 1e-5);
const SHADED_REASON: &str = "some ten roundings; curvature of slivers is off by 1e-4, and f changes by at most sigma / sqrt(2 pi); the \
                             closed form is within 6e-6 of the convolution";

/// The bound for normals in general directions: some lie halfway between two codes of stage `pack_normals`, so that
/// rounding decides between the codes.
const STEPPED: Bound = within(1.5e-5, 1e-4);
const STEPPED_REASON: &str = "a vertex's normal and kappa may be coded a step apart, 3e-5 and 5e-4 of kappa; that happens at few vertices, and \
                              two drivers stay within half of the bounds or a little more; errors are shares of what is seen";

/// A case: the closed form under `bound`, the table under `brute`.
const fn case(name: &'static str, fallback: &'static str, make: fn() -> Result<Scene>) -> Case {
    Case { name, fallback, bound: SHADED, brute: SHADED, reason: SHADED_REASON, kind: Kind::Shade(make) }
}

/// The same for normals whose codes may differ by one step.
const fn stepped(name: &'static str, fallback: &'static str, make: fn() -> Result<Scene>) -> Case {
    Case { bound: STEPPED, brute: STEPPED, reason: STEPPED_REASON, ..case(name, fallback, make) }
}

/// The base scene with this mesh, which lies within the ball's bounding box, and with its curvature as it is.
fn with(mesh: Mesh, sigma_0: &str) -> Result<Scene> {
    let mut scene = smoothed(mesh, sigma_0)?;
    scene.objects[0].material.curvature_radius = Some(0.0);
    Ok(scene)
}

/// The same with smoothed curvature.
fn smoothed(mesh: Mesh, sigma_0: &str) -> Result<Scene> {
    let mut scene = scene(&["object.0.detail=0", &format!("object.0.material.sigma_0={sigma_0}")])?;
    scene.objects[0].mesh = mesh;
    Ok(scene)
}

/// A closed triangle fan: a cone on a flat disc.
pub(super) fn cone(count: u32, radius: f64, height: f64) -> Mesh {
    let angle = |k: u32| TAU * f64::from(k) / f64::from(count);
    let rim = (0..count).map(|k| DVec3::new(radius * angle(k).cos(), radius * angle(k).sin(), 0.0));
    let positions = [DVec3::new(0.0, 0.0, height), DVec3::ZERO].into_iter().chain(rim).collect();
    let next = |k: u32| 2 + (k + 1) % count;
    turned(mesh(positions, (0..count).flat_map(|k| [[0, 2 + k, next(k)], [1, next(k), 2 + k]]).collect()))
}

/// The cases.
pub(super) const CASES: &[Case] = &[
    case("shading: kappa 0", "a flat sheet: Lambert's cosine", || {
        with(turned(sheet(&even(8), &even(8))), "[1, 1e9, 0]")
    }),
    stepped("shading: sigma_0 0", "Lambert's cosine", || scene(&["object.0.material.sigma_0=0"])),
    stepped("shading: sigma_0 1e9 mm", "light from all around alike: 1 / pi", || {
        scene(&["object.0.material.sigma_0=1e9"])
    }),
    stepped("shading: hollow", "kappa has no sign: as a hill", || {
        with(reversed(scene(&["object.0.detail=2"])?.objects[0].mesh.clone()), "[0.1, 0.3, 1]")
    }),
    stepped("shading: fan of 1000", "a vertex of many triangles, as any", || {
        with(cone(1000, 0.45, 0.01), "[0.01, 0.1, 1]")
    }),
    case("shading: cone", "the tip's angles lack a part of a turn", || with(cone(40, 0.3, 0.45), "[0.01, 0.1, 1]")),
    case("shading: needle", "cotangents end at 100, curvature at 1e4 of the extent", || {
        with(cone(6, 1e-3, 0.49), "[1e-6, 1e-3, 1]")
    }),
    case("shading: needle, smoothed", "mean curvature over a ball, whatever the tip", || {
        smoothed(cone(6, 1e-3, 0.49), "[1e-6, 1e-3, 1]")
    }),
    case("shading: slivers", "cotangents end at 100", || {
        with(turned(sheet(&doubled(6, 1e-4), &doubled(6, 1e-4))), "[0.01, 0.1, 1]")
    }),
];

/// Pictures in closed form and from the table, against the reference's.
pub(super) fn run(scene: &Scene, device: Option<&Device>, plant: Option<Plant>) -> Result<[Found; 2]> {
    let mut tabled = scene.clone();
    tabled.transport.cdrf = Cdrf::Table;
    Ok([method(scene, device, plant)?, method(&tabled, device, None)?])
}

fn method(scene: &Scene, device: Option<&Device>, plant: Option<Plant>) -> Result<Found> {
    let options = Options { transport: ShadingMethod::Cdrf, ..Options::default() };
    let picture = |device: Option<&Device>| {
        let mut session = Session::new(scene, device, options)?;
        session.frame(Change::EVERYTHING)?;
        session.fetch(&[BufferId::curvature, BufferId::smooth_kappa, BufferId::radiance])?;
        let data = &session.state().data;
        let kappa: Vec<_> = (0..data.curvature.len()).map(|v| [kappa(data, v); 3]).collect();
        Ok::<_, Error>((data.curvature.clone(), kappa, data.radiance.clone()))
    };
    let (.., expected) = picture(None)?;
    let (curvature, kappa, mut radiance) = picture(device)?;
    if let Some(plant) = plant {
        plant.apply(&mut radiance);
    }
    let mut found = Found::default();
    found.look("kappa", &kappa);
    found.look("radiance", &radiance);
    let sound = |bend: &crate::layout::Curvature| bend.mean.is_finite() && bend.gaussian.is_finite();
    if !curvature.iter().all(sound) {
        found.faults.push("a curvature is no number".into());
    }
    let square = |values: &mut dyn Iterator<Item = f64>| values.map(|x| x * x).sum::<f64>();
    let numbers = || expected.iter().flatten().map(|&x| f64::from(x));
    let misses = || numbers().zip(radiance.iter().flatten()).map(|(a, &b)| (a - f64::from(b)).abs());
    let whole = square(&mut numbers());
    let shown = numbers().filter(|x| *x > 0.0).count().max(1) as f64;
    found.error = Worst {
        l2: (square(&mut misses()) / whole).sqrt(),
        max: misses().fold(0.0, f64::max) / (whole / shown).sqrt(),
    };
    Ok(found)
}
