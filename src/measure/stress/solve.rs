//! Extreme scenes: the usual method, brute force and the octree, against a sum over all faces in `f64`.

use super::{Found, Plant};
use crate::error::Result;
use crate::gpu::Device;
use crate::layout::BufferId;
use crate::measure::norms::{norms, worst};
use crate::measure::reference::radiosity;
use crate::measure::sample::Sample;
use crate::pipeline::plan::{Change, Goal, Options, ShadingMethod};
use crate::prepare::receivers::by_pixel;
use crate::scene::{Mesh, Receivers, Scene};
use crate::session::run::Session;

/// A scene and its expected radiosity.
pub(super) struct Setup {
    /// The scene.
    pub scene: Scene,
    /// The expected radiosity.
    pub against: Against,
}

/// The radiosity that a scene must have.
pub(super) enum Against {
    /// That of the same scene in `f64`.
    Itself,
    /// That of another scene in `f64`, with the same faces in the same order, times a factor per channel.
    Another(Box<Scene>, [f64; 3]),
    /// Exactly zero.
    Darkness,
}

/// Number of receivers compared; all, if the mesh has fewer faces.
const RECEIVERS: usize = 48;
/// Share of the largest expected radiosity above which a radiosity must not be zero.
const SEEN: f64 = 1e-6;

/// The base scene: a marble ball, 1 mm across, in the sun.
const BASE: &str = r#"
unit = "mm"
[camera]
size = [24, 24]
[[light]]
type = "directional"
direction = [0.35, 0.6, 0.75]
irradiance = [1.0, 0.8, 0.6]
[[object]]
shape = "sphere"
detail = 2
size = 1
material = { sigma_s_prime = [22, 26, 30], sigma_a = [0.02, 0.04, 0.07], eta = 1.5 }
"#;

/// The base scene with these settings.
pub(super) fn scene(sets: &[&str]) -> Result<Scene> {
    let sets: Vec<String> = sets.iter().map(|set| set.to_string()).collect();
    Scene::parse("stress", BASE, &sets)
}

impl Setup {
    /// The base scene with these settings, compared with itself in `f64`.
    pub fn new(sets: &[&str]) -> Result<Self> {
        Ok(Self { scene: scene(sets)?, against: Against::Itself })
    }

    /// Replaces the mesh.
    pub fn mesh(mut self, mesh: Mesh) -> Self {
        self.scene.objects[0].mesh = mesh;
        self
    }

    /// Compares with the radiosity of another scene, times a factor per channel.
    pub fn against(mut self, other: Scene, factor: [f64; 3]) -> Self {
        self.against = Against::Another(Box::new(other), factor);
        self
    }

    /// Compares with exactly zero.
    pub fn dark(mut self) -> Self {
        self.against = Against::Darkness;
        self
    }
}

/// The radiosity of a scene at these faces of its mesh, in scene units: irradiance by the CPU reference, then a sum
/// over all faces with near-exact form factors.
fn reference(scene: &Scene, faces: &[usize]) -> Result<Vec<[f64; 3]>> {
    let options = Options { transport: ShadingMethod::Brute, goal: Goal::Radiosity, ..Options::default() };
    let mut session = Session::new(scene, None, options)?;
    session.prepare_light();
    let place = session.prepared().places(0);
    let places: Vec<usize> = faces.iter().map(|&face| place[face]).collect();
    let values = radiosity(session.state(), &places);
    Ok(values.into_iter().map(|value| value.map(|x| x * session.units().light)).collect())
}

/// The results of the usual method, including a picture, of brute force, and of the irradiance octree.
pub(super) fn run(setup: &Setup, device: Option<&Device>, plant: Option<Plant>) -> Result<[Found; 3]> {
    let mesh = &setup.scene.objects[0].mesh;
    let area = |face: usize| mesh.corners(face).map_or(0.0, |[a, b, c]| 0.5 * (b - a).cross(c - a).length());
    let areas: Vec<f64> = (0..mesh.triangles.len()).map(area).collect();
    let sample = Sample::seeded(&areas, &[], RECEIVERS, 1);
    let faces = &sample.faces;
    let expected = match &setup.against {
        Against::Itself => reference(&setup.scene, faces)?,
        Against::Darkness => vec![[0.0; 3]; faces.len()],
        Against::Another(scene, factor) => {
            let times = |value: [f64; 3]| [0, 1, 2].map(|c| value[c] * factor[c]);
            reference(scene, faces)?.into_iter().map(times).collect()
        }
    };
    let picture = Options { goal: Goal::Picture, ..Options::default() };
    let brute = Options { transport: ShadingMethod::Brute, goal: Goal::Radiosity, ..Options::default() };
    let octree = Options { transport: ShadingMethod::Octree, ..brute };
    Ok([
        method(setup, device, picture, plant, &sample, &expected)?,
        method(setup, device, brute, None, &sample, &expected)?,
        method(setup, device, octree, None, &sample, &expected)?,
    ])
}

fn method(
    setup: &Setup,
    device: Option<&Device>,
    options: Options,
    plant: Option<Plant>,
    sample: &Sample,
    expected: &[[f64; 3]],
) -> Result<Found> {
    // The receivers are the faces here, for their values are compared; receivers at pixels come below.
    let mut scene = setup.scene.clone();
    scene.transport.receivers = Receivers::Faces;
    let mut session = Session::new(&scene, device, options)?;
    session.frame(Change::EVERYTHING)?;
    session.fetch(&[BufferId::irradiance, BufferId::radiosity, BufferId::vertex_radiosity, BufferId::radiance])?;
    let mut radiosity = session.state().data.radiosity.clone();
    if let Some(plant) = plant {
        plant.apply(&mut radiosity);
    }

    // Check every value of every face, vertex and pixel.
    let mut found = Found::default();
    let data = &session.state().data;
    found.look("irradiance", &data.irradiance);
    found.look("radiosity", &radiosity);
    found.look("vertex radiosity", &data.vertex_radiosity);
    found.look("radiance", &data.radiance);
    if by_pixel(&setup.scene, options).0 {
        let mut session = Session::new(&setup.scene, device, options)?;
        session.frame(Change::EVERYTHING)?;
        session.fetch(&[BufferId::hits, BufferId::seen, BufferId::radiosity, BufferId::radiance])?;
        // Radiosity of receivers that no pixel shows is never written.
        let data = &session.state().data;
        let shown = data.hits.iter().zip(&data.seen).filter(|(hit, _)| hit.face != u32::MAX);
        let values: Vec<_> = shown.map(|(_, &receiver)| data.radiosity[receiver as usize]).collect();
        found.look("radiosity at pixels", &values);
        found.look("radiance of pixels", &data.radiance);
    }
    if matches!(setup.against, Against::Darkness) && radiosity.iter().flatten().any(|&x| x != 0.0) {
        found.faults.push("there is light where there can be none".into());
    }

    // Compare the sample with the reference, in scene units.
    let (places, light) = (session.prepared().places(0), session.units().light);
    let value = |&face: &usize| radiosity[places[face]].map(|x| f64::from(x) * light);
    let values: Vec<[f64; 3]> = sample.faces.iter().map(value).collect();
    found.error = worst(&norms(sample, &values, expected)).into();

    let largest = |channel: usize| expected.iter().map(|value| value[channel]).fold(0.0, f64::max);
    let zeros: usize = [0, 1, 2]
        .map(|c| {
            let seen = SEEN * largest(c);
            values.iter().zip(expected).filter(|(v, e)| v[c] == 0.0 && e[c] > seen).count()
        })
        .iter()
        .sum();
    if zeros > 0 {
        found.faults.push(format!("{zeros} radiosities are 0 and should not be"));
    }
    Ok(found)
}
