//! Single form factors: the stage `evaluate` and brute force, against graded quadrature in `f64`.

use std::collections::BTreeMap;

use glam::DVec3;
use rayon::prelude::*;
use serde::Deserialize;

use super::meshes::turn;
use super::setup::Setup;
use super::{Found, Plant, Worst};
use crate::dipole::form_factor::exact::edge_form_exact;
use crate::dipole::form_factor::{Distance, vector_area};
use crate::dipole::profile::Dipole;
use crate::error::{Input, Result};
use crate::gpu::Device;
use crate::layout::{BUFFER_IDS, BufferId, Query};
use crate::lighting::fresnel::{boundary, diffuse_internal_exact};
use crate::pipeline::plan::{Change, Goal, Options, ShadingMethod};
use crate::scene::{Fresnel, Light, Material, Mesh, Scene, Surface};
use crate::session::run::Session;
use crate::state::{DeviceState, Scope, State, Step};
use crate::transport::evaluate;

/// Three media, one per channel: reduced scattering and absorption, 1/length, and the index of refraction.
pub type Media = [[f64; 3]; 3];

/// A triangle, a receiving point and three media.
pub struct Pair {
    /// Corners, counter-clockwise, in the media's unit of length.
    pub triangle: [DVec3; 3],
    /// The receiving point.
    pub point: DVec3,
    /// The media.
    pub media: Media,
}

/// Triangles, points and media by name.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Lists {
    /// Corners.
    triangles: BTreeMap<String, Vec<[[f64; 3]; 3]>>,
    points: BTreeMap<String, Vec<Place>>,
    media: BTreeMap<String, Vec<Media>>,
}

/// A place relative to a triangle.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Place {
    /// Barycentric weights.
    at: [f64; 3],
    /// Offset from there in the triangle's frame, z along its normal.
    #[serde(default)]
    off: [f64; 3],
}

/// All combinations of triangles, points and media: names of lists.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Combinations {
    triangles: Vec<String>,
    points: Vec<String>,
    media: Vec<String>,
    /// Whether triangles stay where they are; others are rotated and moved so that no coordinate is a round number.
    #[serde(default)]
    as_is: bool,
}

impl Combinations {
    /// The combinations.
    pub(super) fn pairs(&self, lists: &Lists) -> Result<Vec<Pair>> {
        fn listed<'a, T>(lists: &'a BTreeMap<String, Vec<T>>, names: &[String]) -> Result<Vec<&'a T>> {
            let list = |name| lists.get(name).ok_or_else(|| Input::new("no such list").found(name));
            Ok(names.iter().map(list).collect::<std::result::Result<Vec<_>, _>>()?.into_iter().flatten().collect())
        }
        let (turned, offset) = match self.as_is {
            true => (DVec3::from_array as fn([f64; 3]) -> DVec3, DVec3::ZERO),
            false => ((|v| turn(DVec3::from_array(v))) as fn([f64; 3]) -> DVec3, DVec3::new(0.313, -0.771, 0.119)),
        };
        let (points, media) = (listed(&lists.points, &self.points)?, listed(&lists.media, &self.media)?);
        let mut pairs = Vec::new();
        for corners in listed(&lists.triangles, &self.triangles)? {
            let triangle = corners.map(|corner| turned(corner) + offset);
            for Place { at: [a, b, c], off } in &points {
                let point = *a * triangle[0] + *b * triangle[1] + *c * triangle[2] + turned(*off);
                pairs.extend(media.iter().map(|media| Pair { triangle, point, media: **media }));
            }
        }
        Ok(pairs)
    }
}

/// Share of R_full above which a form factor must not be zero; below it the edges of a thin triangle cancel.
const SEEN: f64 = 1e-6;
/// If any form factor of a case exceeds this, they must not all be zero. Far above the smallest `f32`.
const ANY: f64 = 1e-30;

impl Pair {
    /// The dipoles of the media, in their unit of length, with the exact diffuse Fresnel reflectance.
    pub fn dipoles(&self) -> [Dipole; 3] {
        self.media.map(|[s, a, eta]| Dipole::new(s, a, boundary(diffuse_internal_exact(eta))))
    }

    /// Near-exact form factors, one per medium, for radial distances.
    pub fn exact(&self) -> [f64; 3] {
        let form = |dipole: &Dipole| {
            let corners = self.triangle.map(|corner| corner - self.point);
            edge_form_exact(&corners, [0, 1, 2], DVec3::ZERO, dipole, Distance::Radial)
        };
        self.dipoles().each_ref().map(form)
    }

    /// The queries of `milkglass eval`, one per channel: relative to the point, in mean free paths.
    pub fn queries(&self) -> [Query; 3] {
        std::array::from_fn(|channel| {
            let [s, a, eta] = self.media[channel];
            let unit = 1.0 / (s + a);
            let corner = |k: usize| ((self.triangle[k] - self.point) / unit).to_array().map(|x| x as f32);
            let dipole = Dipole::new(s * unit, a * unit, boundary(diffuse_internal_exact(eta)));
            Query {
                a: corner(0),
                b: corner(1),
                c: corner(2),
                strength: dipole.strength as f32,
                sigma: dipole.sigma as f32,
                z_real: dipole.z_real as f32,
                z_virtual: dipole.z_virtual as f32,
            }
        })
    }

    /// A scene of two triangles: the lit one, and a small one around the point that faces away from the light.
    fn scene(&self) -> Result<Scene> {
        let mut scene = Setup::default().scene(&[])?;
        let normal = vector_area(&self.triangle).try_normalize().unwrap_or(DVec3::Z);
        let spread = self.triangle.iter().map(|corner| corner.distance(self.point)).fold(0.0, f64::max);
        let (u, v) = normal.any_orthonormal_pair();
        let small = [-u - v, 2.0 * v - u, 2.0 * u - v].map(|d| self.point + 1e-4 * spread * d);
        scene.objects[0].mesh = Mesh {
            positions: self.triangle.into_iter().chain(small).collect(),
            triangles: vec![[0, 1, 2], [3, 4, 5]],
            input_face: vec![0, 1],
            open_edges: 6,
            ..Mesh::default()
        };
        scene.objects[0].material = Material {
            opaque: None,
            name: "extreme".into(),
            sigma_s_prime: self.media.map(|[s, ..]| s),
            sigma_a: self.media.map(|[_, a, _]| a),
            eta: self.media.map(|[.., eta]| eta),
            g: [0.0; 3],
            fresnel: Fresnel::Exact,
            two_sided: false,
            single_scattering: false,
            surface: Surface::default(),
            sigma_0: None,
            curvature_radius: None,
            sigma_0_texture: None,
            texture: None,
            layers: None,
        };
        // No shadows: the receiver may block the light.
        scene.lights = vec![Light { shadows: false, ..Light::directional(normal, [1.0; 3]) }];
        Ok(scene)
    }
}

/// The form factors of these pairs by `evaluate` and by brute force.
pub(super) fn run(pairs: &[Pair], device: Option<&Device>, plant: Option<Plant>) -> Result<[Found; 2]> {
    // One device state for all pairs, so that pipelines are created once.
    let mut device_state = device.map(|device| DeviceState::new(device, false)).transpose()?;
    let mut evaluated = evaluate(pairs, device_state.as_mut())?;
    if let Some(plant) = plant {
        plant.apply(&mut evaluated);
    }
    let brute = pairs.iter().map(|pair| brute(pair, device_state.as_mut())).collect::<Result<Vec<_>>>()?;
    let exact: Vec<_> = pairs.par_iter().map(Pair::exact).collect();
    Ok([judge(pairs, &exact, &evaluated), judge(pairs, &exact, &brute)])
}

fn judge(pairs: &[Pair], exact: &[[f64; 3]], values: &[[f32; 3]]) -> Found {
    let mut found = Found::default();
    found.look("form factors", values);
    let (mut sum, mut max, mut zeros, mut any) = (0.0, 0.0, 0, false);
    for ((pair, exact), values) in pairs.iter().zip(exact).zip(values) {
        for ((dipole, &exact), value) in pair.dipoles().iter().zip(exact).zip(values.map(f64::from)) {
            // Without scattering R_full is 0, and F must be 0 too.
            let full = if dipole.total() > 0.0 { dipole.total() } else { f64::MIN_POSITIVE };
            let error = (value - exact).abs() / full;
            sum += error * error;
            max = if error.is_nan() || error > max { error } else { max };
            zeros += usize::from(value == 0.0 && exact > SEEN * full);
            any |= exact > ANY;
        }
    }
    if any && values.iter().flatten().all(|&value| value == 0.0) {
        found.faults.push("all form factors are 0 and should not be".into());
    }
    if zeros > 0 {
        found.faults.push(format!("{zeros} form factors are 0 and should not be"));
    }
    found.error = Worst { l2: (sum / (3 * pairs.len()) as f64).sqrt(), max };
    found
}

/// Form factors by the stage `evaluate`, on a device or by the CPU reference; radial distances.
pub fn evaluated(pairs: &[Pair], device: Option<&Device>) -> Result<Vec<[f32; 3]>> {
    evaluate(pairs, device.map(|device| DeviceState::new(device, false)).transpose()?.as_mut())
}

fn evaluate(pairs: &[Pair], device_state: Option<&mut DeviceState>) -> Result<Vec<[f32; 3]>> {
    let mut state = State::default();
    state.data.queries = pairs.iter().flat_map(Pair::queries).collect();
    state.data.answers = vec![[0.0; 3]; state.data.queries.len()];
    let steps = [Step { stage: &evaluate::STAGE, at: Scope::SCENE }];
    steps_on(&mut state, &steps, device_state, &[BufferId::answers])?;
    let radial = |answers: &[[f32; 3]]| [answers[0][0], answers[1][0], answers[2][0]];
    Ok(state.data.answers.chunks_exact(3).map(radial).collect())
}

/// Runs these steps on the device or the CPU; afterwards the state holds these buffers.
fn steps_on(
    state: &mut State,
    steps: &[Step],
    device_state: Option<&mut DeviceState>,
    slots: &[BufferId],
) -> Result<()> {
    let Some(device_state) = device_state else {
        steps.iter().for_each(|step| step.reference(state));
        return Ok(());
    };
    device_state.upload(state, BUFFER_IDS)?;
    device_state.run(state, steps)?;
    device_state.download(state, slots)
}

/// Brute force over the two triangles: the point's radiosity per unit irradiance of the lit triangle.
fn brute(pair: &Pair, device_state: Option<&mut DeviceState>) -> Result<[f32; 3]> {
    let options = Options { transport: ShadingMethod::Brute, goal: Goal::Radiosity, ..Options::default() };
    let session = Session::new(&pair.scene()?, None, options)?;
    let steps = session.plan().steps(session.state(), Change::EVERYTHING);
    let mut state = session.state().clone();
    steps_on(&mut state, &steps, device_state, &[BufferId::irradiance, BufferId::radiosity])?;
    let places = session.prepared().places(0);
    let data = &state.data;
    let (light, received) = (data.irradiance[places[0]], data.radiosity[places[1]]);
    // A degenerate triangle gets no light; then the point must get none.
    Ok(std::array::from_fn(|c| if light[c] == 0.0 { received[c] } else { received[c] / light[c] }))
}
