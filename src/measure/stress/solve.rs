//! Extreme scenes: the usual method, brute force and the octree, against a sum over all faces in `f64`.

use super::setup::{Expected, Setup};
use super::{Found, Plant};
use crate::error::Result;
use crate::gpu::Device;
use crate::layout::BufferId;
use crate::measure::norms::{norms, worst};
use crate::measure::reference::radiosity;
use crate::measure::sample::Sample;
use crate::pipeline::plan::{Change, Goal, Options, ShadingMethod};
use crate::prepare::receivers::by_pixel;
use crate::scene::{Receivers, Scene};
use crate::session::run::Session;

/// Number of receivers compared; all, if the mesh has fewer faces.
const RECEIVERS: usize = 48;
/// Share of the largest expected radiosity above which a radiosity must not be zero.
const SEEN: f64 = 1e-6;

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
    let scene = setup.scene(&[])?;
    let mesh = &scene.objects[0].mesh;
    let area = |face: usize| mesh.corners(face).map_or(0.0, |[a, b, c]| 0.5 * (b - a).cross(c - a).length());
    let areas: Vec<f64> = (0..mesh.triangles.len()).map(area).collect();
    let sample = Sample::seeded(&areas, &[], RECEIVERS, 1);
    let faces = &sample.faces;
    let expected = match &setup.expect {
        Expected::Itself => reference(&scene, faces)?,
        Expected::Darkness => vec![[0.0; 3]; faces.len()],
        Expected::Another { scene: other, factor } => {
            let entering = setup.entering(other, scene.objects[0].material.eta);
            let times = |value: [f64; 3]| [0, 1, 2].map(|c| value[c] * (factor * entering[c]));
            reference(&other.scene(&[])?, faces)?.into_iter().map(times).collect()
        }
    };
    let picture = Options { goal: Goal::Picture, ..Options::default() };
    let brute = Options { transport: ShadingMethod::Brute, goal: Goal::Radiosity, ..Options::default() };
    let octree = Options { transport: ShadingMethod::Octree, ..brute };
    Ok([
        method(&scene, device, picture, plant, &sample, &expected)?,
        method(&scene, device, brute, None, &sample, &expected)?,
        method(&scene, device, octree, None, &sample, &expected)?,
    ])
}

fn method(
    shown: &Scene,
    device: Option<&Device>,
    options: Options,
    plant: Option<Plant>,
    sample: &Sample,
    expected: &[[f64; 3]],
) -> Result<Found> {
    // The receivers are the faces here, since their values are compared; receivers at pixels come below.
    let mut scene = shown.clone();
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
    if by_pixel(shown, options).0 {
        let mut session = Session::new(shown, device, options)?;
        session.frame(Change::EVERYTHING)?;
        session.fetch(&[BufferId::hits, BufferId::seen, BufferId::radiosity, BufferId::radiance])?;
        // Radiosity of receivers that no pixel shows is never written.
        let data = &session.state().data;
        let shown = data.hits.iter().zip(&data.seen).filter(|(hit, _)| hit.face != u32::MAX);
        let values: Vec<_> = shown.map(|(_, &receiver)| data.radiosity[receiver as usize]).collect();
        found.look("radiosity at pixels", &values);
        found.look("radiance of pixels", &data.radiance);
    }
    let dark = expected.iter().flatten().all(|&x| x == 0.0);
    if dark && radiosity.iter().flatten().any(|&x| x != 0.0) {
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
