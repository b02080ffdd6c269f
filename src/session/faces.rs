//! The light of every face, in the scene's units and in the order of the meshes.

use glam::DVec3;

use super::run::Session;
use super::subdivide::Parts;
use crate::error::Result;
use crate::layout::BufferId;
use crate::prepare::shape::moved;
use crate::scene::Object;

/// The light of one triangle of a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct FaceLight {
    /// The object, in the order of the scene.
    pub object: usize,
    /// The face of the mesh's file that the triangle was cut from, counted from 0.
    pub input_face: u32,
    /// Centroid, scene units.
    pub center: DVec3,
    /// Area, square scene units.
    pub area: f64,
    /// Irradiance E that enters, after Fresnel, r g b.
    pub irradiance: [f64; 3],
    /// Radiosity B that leaves, before Fresnel, r g b: at the centroid, or the mean over a triangle that was
    /// subdivided.
    pub radiosity: [f64; 3],
    /// Estimated error of the radiosity, r g b, if [`crate::Options::estimate`] asks for it.
    pub estimate: Option<[f64; 3]>,
    /// Standard error of the radiosity, r g b, of a random walk.
    pub noise: Option<[f64; 3]>,
    /// Indices of the corners among the vertices of all objects.
    pub triangle: [u32; 3],
}

impl Session {
    /// The light of every triangle after a frame: object after object, in the order of the scene's meshes.
    pub fn faces(&mut self) -> Result<Vec<FaceLight>> {
        self.sharpen()?;
        self.fetch(&[
            BufferId::clusters,
            BufferId::irradiance,
            BufferId::radiosity,
            BufferId::estimate,
            BufferId::walk_noise,
        ])?;
        Ok(rows(self))
    }

    /// The vertices of all objects in scene units, deformed where the object is.
    pub fn vertices(&self) -> Vec<DVec3> {
        (0..self.scene().objects.len()).flat_map(|object| self.own_vertices(object)).collect()
    }

    /// An object's vertices in scene units, deformed if the object is.
    pub(crate) fn own_vertices(&self, object: usize) -> Vec<DVec3> {
        let object = &self.scene().objects[object];
        let units = self.units().own(object);
        match moved(object, *self.units()) {
            None => object.mesh.positions.iter().map(|&p| object.placed(p)).collect(),
            Some(moved) => moved.into_iter().map(|p| object.placed(units.outside(p))).collect(),
        }
    }
}

fn rows(session: &Session) -> Vec<FaceLight> {
    let (data, units) = (&session.state().data, session.units());
    let light = |value: [f32; 3]| value.map(|x| f64::from(x) * units.light);
    let mut first = 0;
    let of_object = |(object, Object { mesh, .. }): (usize, &Object)| {
        let (before, vertices) = (first, session.own_vertices(object));
        first += vertices.len() as u32;
        let row = move |(of_mesh, face): (usize, usize)| {
            let triangle = mesh.triangles[of_mesh];
            let [a, b, c] = triangle.map(|v| vertices[v as usize]);
            FaceLight {
                object,
                input_face: mesh.input_face[of_mesh],
                center: (a + b + c) / 3.0,
                area: 0.5 * (b - a).cross(c - a).length(),
                irradiance: light(data.irradiance[face]),
                radiosity: light(data.radiosity[face]),
                estimate: data.estimate.get(face).copied().map(light),
                noise: data.walk_noise.get(face).copied().map(light),
                triangle: triangle.map(|v| v + before),
            }
        };
        let rows = session.prepared().places(object).into_iter().enumerate().map(row).collect::<Vec<_>>();
        match session.parts().get(object) {
            Some(parts) => put_together(rows, parts, before),
            None => rows,
        }
    };
    session.scene().objects.iter().enumerate().flat_map(of_object).collect()
}

/// Combines the rows of a subdivided object's parts into rows of its original triangles: means over their area. A mean
/// of estimates is an estimate of the mean's error.
fn put_together(parts: Vec<FaceLight>, made: &Parts, before: u32) -> Vec<FaceLight> {
    let mut areas = vec![0.0; made.whole.len()];
    parts.iter().zip(&made.of).for_each(|(row, &whole)| areas[whole as usize] += row.area);
    let mut rows: Vec<FaceLight> = (made.middle.iter().zip(&made.whole).zip(&made.input_face))
        .map(|((&middle, triangle), &input_face)| {
            let (row, none) = (&parts[middle as usize], [0.0; 3]);
            FaceLight {
                area: 0.0,
                center: DVec3::ZERO,
                irradiance: none,
                radiosity: none,
                estimate: row.estimate.map(|_| none),
                noise: row.noise,
                triangle: triangle.map(|v| v + before),
                input_face,
                object: row.object,
            }
        })
        .collect();
    for (part, (row, &original)) in parts.iter().zip(&made.of).enumerate() {
        let whole = &mut rows[original as usize];
        // Triangles without an area have the values of one of their parts.
        let share = if areas[original as usize] > 0.0 {
            row.area / areas[original as usize]
        } else {
            f64::from(made.middle[original as usize] as usize == part)
        };
        let add = |sum: &mut [f64; 3], more: [f64; 3]| (0..3).for_each(|c| sum[c] += share * more[c]);
        whole.area += row.area;
        whole.center += share * row.center;
        add(&mut whole.irradiance, row.irradiance);
        add(&mut whole.radiosity, row.radiosity);
        if let (Some(sum), Some(estimate)) = (&mut whole.estimate, row.estimate) {
            let missed = made.missed.get(part).copied().unwrap_or_default();
            add(sum, [0, 1, 2].map(|c| estimate[c].hypot(missed[c])));
        }
    }
    rows
}
