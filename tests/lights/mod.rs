//! Arriving light: shadows, spots, area lights and environments against known results.

mod environment;
mod kinds;
mod paint;
mod shadow;
mod soft;

use glam::DVec3;
use milkglass::internals::pipeline::plan::{Goal, Options};
use milkglass::internals::session::run::Session;
use milkglass::scene::{Light, Mesh, Scene};

/// A built-in scene with these settings.
pub fn scene(name: &str, sets: &[&str]) -> Scene {
    Scene::load_with(name, &sets.iter().map(ToString::to_string).collect::<Vec<_>>()).unwrap()
}

/// Settings that remove the Fresnel boundary: all light passes.
pub const CLEAR: &str = "object.0.material.eta=1";

/// Irradiance of each face of the mesh as it is, in its order and in the scene's units, by the CPU reference.
pub fn irradiance(scene: &Scene) -> Vec<DVec3> {
    let options = Options { goal: Goal::Radiosity, ..Options::default() };
    let mut scene = scene.clone();
    scene.transport.divided = true;
    let mut session = Session::new(&scene, None, options).unwrap();
    session.prepare_light();
    let (irradiance, light) = (&session.state().data.irradiance, session.units().light);
    let value = |face: usize| DVec3::from_array(irradiance[face].map(f64::from)) * light;
    session.prepared().all_places().map(value).collect()
}

/// The same without shadows.
pub fn unshadowed(scene: &Scene) -> Vec<DVec3> {
    let lights = scene.lights.iter().map(|light| Light { shadows: false, ..light.clone() }).collect();
    irradiance(&Scene { lights, ..scene.clone() })
}

/// A mesh of these positions and triangles.
pub fn mesh(positions: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Mesh {
    let input_face = (0..triangles.len() as u32).collect();
    Mesh { positions, triangles, input_face, ..Mesh::default() }
}

/// Rectangles of `n` x `n` cells, each given by a corner and two edge vectors.
pub fn sheets(n: u32, rectangles: &[[DVec3; 3]]) -> Mesh {
    let (mut positions, mut triangles) = (Vec::new(), Vec::new());
    for &[corner, u, v] in rectangles {
        let first = positions.len() as u32;
        let part = |i: u32| f64::from(i) / f64::from(n);
        positions.extend((0..=n).flat_map(|j| (0..=n).map(move |i| corner + u * part(i) + v * part(j))));
        for (i, j) in (0..n).flat_map(|j| (0..n).map(move |i| (i, j))) {
            let a = first + j * (n + 1) + i;
            let (b, c, d) = (a + 1, a + n + 2, a + n + 1);
            triangles.extend([[a, b, c], [a, c, d]]);
        }
    }
    mesh(positions, triangles)
}

/// Centroid and unit normal of each face.
pub fn places(mesh: &Mesh) -> Vec<(DVec3, DVec3)> {
    let corners = (0..mesh.triangles.len()).filter_map(|face| mesh.corners(face));
    corners.map(|[a, b, c]| ((a + b + c) / 3.0, (b - a).cross(c - a).normalize())).collect()
}
