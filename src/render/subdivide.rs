//! Triangles cut finer for lighting where one value of irradiance will not do: at the borders of shadows and cones (the
//! first item of the paper's future work). A triangle is cut in four where the mean over its parts differs from what it
//! has as a whole by more than the tolerance, of the root mean square over the object; parts likewise, up to as many times
//! as the scene says. What varies evenly over a triangle needs no cut: light goes in at the right place on the whole.

use super::plan::{Goal, Options};
use super::run::{Room, Session};
use super::shape::moved;
use super::units::Units;
use crate::error::Result;
use crate::scene::{Mesh, Object, Scene};

/// What became of an object's triangles.
#[derive(Clone, Debug, Default)]
pub struct Parts {
    /// The triangles as they were.
    pub whole: Vec<[u32; 3]>,
    /// Of each part, the triangle that it is a part of.
    pub of: Vec<u32>,
    /// Of each triangle, the part that has its centre.
    pub middle: Vec<u32>,
    /// Of each triangle, the face of the input it came from.
    pub input_face: Vec<u32>,
}

/// The scene with its triangles cut as its lights want it, and of each object what became of them.
pub fn subdivide(scene: &Scene) -> Result<(Scene, Vec<Parts>)> {
    let mut fine = scene.clone();
    fine.transport.subdivide = 0;
    // The shape as deformed is cut, so that parts lie on it and next to each other.
    let units = Units::of(scene.objects.iter().map(|object| &object.mesh));
    for object in &mut fine.objects {
        if let Some(places) = moved(object, units) {
            object.mesh.positions = places.into_iter().map(|p| units.outside(p)).collect();
        }
        object.deforms.clear();
    }
    let mut parts: Vec<Parts> = scene.objects.iter().map(|object| whole(&object.mesh)).collect();
    for left in (0..scene.transport.subdivide).rev() {
        // All triangles cut, twice where they may be, to see which should have been: a border may cross a corner alone.
        let mut finer = fine.clone();
        let looks = 1 + left.min(1);
        for _ in 0..looks {
            finer.objects.iter_mut().for_each(|object| object.mesh = object.mesh.split(|_| true).0);
        }
        let (coarse_light, fine_light) = (irradiance(&fine)?, irradiance(&finer)?);
        let mut any = false;
        for (number, object) in fine.objects.iter_mut().enumerate() {
            let limit = scene.transport.tolerance;
            let cut = wanted(&object.mesh, &coarse_light[number], &fine_light[number], limit);
            any |= cut.contains(&true);
            let (mesh, from) = object.mesh.split(|face| cut[face]);
            parts[number].cut(&cut, &from);
            *object = Object { mesh, ..object.clone() };
        }
        if !any {
            break;
        }
    }
    Ok((fine, parts))
}

/// Nothing cut yet.
fn whole(mesh: &Mesh) -> Parts {
    let all: Vec<u32> = (0..).take(mesh.triangles.len()).collect();
    Parts { whole: mesh.triangles.clone(), of: all.clone(), middle: all, input_face: mesh.input_face.clone() }
}

impl Parts {
    /// After a cut of some parts, each part now `from` one of those before.
    fn cut(&mut self, cut: &[bool], from: &[u32]) {
        // The first new part of each: where it was not cut itself, else the fourth is in the middle.
        let mut first = vec![0; cut.len()];
        from.iter().enumerate().rev().for_each(|(part, &before)| first[before as usize] = part as u32);
        for middle in &mut self.middle {
            let before = *middle as usize;
            *middle = first[before] + if cut[before] { 3 } else { 0 };
        }
        self.of = from.iter().map(|&before| self.of[before as usize]).collect();
    }
}

/// What enters each triangle, by the reference; object by object, in the order of their meshes.
fn irradiance(scene: &Scene) -> Result<Vec<Vec<[f64; 3]>>> {
    let options = Options { goal: Goal::Radiosity, ..Options::default() };
    let mut session = Session::new(scene, None, options, Room::default())?;
    session.prepare_light();
    let values = &session.state().data.irradiance;
    let of_object =
        |object: usize| session.prepared.places(object).into_iter().map(|face| values[face].map(f64::from)).collect();
    Ok((0..scene.objects.len()).map(of_object).collect())
}

/// Whether each triangle has to be cut.
fn wanted(mesh: &Mesh, coarse: &[[f64; 3]], fine: &[[f64; 3]], limit: f64) -> Vec<bool> {
    let parts = fine.len() / coarse.len().max(1);
    let area = |face: usize| mesh.corners(face).map_or(0.0, |[a, b, c]| 0.5 * (b - a).cross(c - a).length());
    let areas: Vec<f64> = (0..coarse.len()).map(area).collect();
    let all: f64 = areas.iter().sum();
    let power = |c: usize| coarse.iter().zip(&areas).map(|(e, area)| area * e[c] * e[c]).sum::<f64>();
    let level = [0, 1, 2].map(|c| (power(c) / all.max(f64::MIN_POSITIVE)).sqrt());
    let differs = |face: usize| {
        let mean = |c: usize| fine[parts * face..parts * (face + 1)].iter().map(|e| e[c]).sum::<f64>() / parts as f64;
        (0..3).any(|c| (mean(c) - coarse[face][c]).abs() > limit * level[c])
    };
    (0..coarse.len()).map(differs).collect()
}
