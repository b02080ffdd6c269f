//! Triangles cut finer for lighting where one value of irradiance will not do: at the borders of shadows and cones (the
//! first item of the paper's future work). A triangle is cut in four where the mean over its parts differs from what it
//! has as a whole by more than the tolerance, of the root mean square over the object; parts likewise, up to as many
//! times as the scene says. What varies evenly over a triangle needs no cut: light goes in at the right place on the
//! whole.

use super::run::{CapacityHints, Session};
use crate::error::{Input, Result};
use crate::pipeline::frame::precedes_transport;
use crate::pipeline::plan::{Change, Goal, Options};
use crate::prepare::shape::moved;
use crate::prepare::units::Units;
use crate::scene::{Mesh, Object, Scene};

/// Tolerance of an estimate of errors.
const ROUGH: f64 = 0.1;

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
    /// Of each part, the radiosity that may be missing because irradiance still varies over parts, in the units of B,
    /// per channel; empty where nobody asked.
    pub missed: Vec<[f64; 3]>,
}

/// The scene with its triangles cut as its lights want it, and of each object what became of them; with what borders
/// still miss where an `estimate` is wanted.
pub fn subdivide(scene: &Scene, estimate: bool) -> Result<(Scene, Vec<Parts>)> {
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
    for left in (0..=scene.transport.subdivide).rev() {
        if left == 0 && !estimate {
            break;
        }
        // All triangles cut, twice where they may be, to see which should have been: a border may cross a corner alone.
        let mut finer = fine.clone();
        let looks = 1 + u32::from(left != 1);
        for _ in 0..looks {
            let four = |object: &Object| 4 * Mesh::BYTES * object.mesh.triangles.len() as u64;
            let bytes = finer.objects.iter().map(four).sum();
            scene.memory.need(bytes).map_err(|error| {
                Input::new("the triangles cut in four do not fit the memory").key("transport.subdivide").found(error)
            })?;
            finer.objects.iter_mut().for_each(|object| object.mesh = object.mesh.split(|_| true).0);
        }
        let (coarse_light, fine_light) = (irradiance(&fine)?, irradiance(&finer)?);
        let lost: Vec<Vec<[f64; 3]>> =
            coarse_light.iter().zip(&fine_light).map(|(coarse, fine)| lost(coarse, fine)).collect();
        let mut any = false;
        for (number, object) in fine.objects.iter_mut().enumerate().filter(|_| left > 0) {
            let limit = scene.transport.tolerance;
            let cut = wanted(&object.mesh, &coarse_light[number], &lost[number], limit);
            any |= cut.contains(&true);
            let (mesh, from) = object.mesh.split(|face| cut[face]);
            parts[number].cut(&cut, &from);
            *object = Object { mesh, ..object.clone() };
        }
        // What is left has to have been looked at twice.
        if !any && (!estimate || looks > 1) {
            if estimate {
                carried(&fine, &lost)?.into_iter().zip(&mut parts).for_each(|(missed, parts)| parts.missed = missed);
            }
            break;
        }
    }
    Ok((fine, parts))
}

impl Session {
    /// The number of a triangle of the state in the mesh of its object, as the scene has it.
    pub fn triangle(&self, face: usize) -> u32 {
        let (object, part) = self.prepared.source(face);
        self.parts.get(object).map_or(part, |parts| parts.of[part as usize])
    }

    /// What borders of shadows may still miss of the radiosity of a triangle of the state, in the units of B.
    pub fn missed(&self, face: usize) -> [f64; 3] {
        let (object, part) = self.prepared.source(face);
        self.parts.get(object).and_then(|parts| parts.missed.get(part as usize)).copied().unwrap_or_default()
    }
}

/// Nothing cut yet.
fn whole(mesh: &Mesh) -> Parts {
    let all: Vec<u32> = (0..).take(mesh.triangles.len()).collect();
    Parts {
        whole: mesh.triangles.clone(),
        of: all.clone(),
        middle: all,
        input_face: mesh.input_face.clone(),
        missed: Vec::new(),
    }
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
    let mut session = Session::new(scene, None, options, CapacityHints::default())?;
    session.prepare_light();
    Ok(by_object(&session, &session.state().data.irradiance, 1.0))
}

/// Values of the triangles in the order of the objects' meshes.
fn by_object(session: &Session, values: &[[f32; 3]], scale: f64) -> Vec<Vec<[f64; 3]>> {
    let value = |face: usize| values[face].map(|x| scale * f64::from(x));
    let of_object = |object: usize| session.prepared.places(object).into_iter().map(value).collect();
    (0..session.scene().objects.len()).map(of_object).collect()
}

/// How far the mean over the parts of each triangle is from what it has as a whole.
fn lost(coarse: &[[f64; 3]], fine: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let parts = fine.len() / coarse.len().max(1);
    let of = |(whole, parts): (&[f64; 3], &[[f64; 3]])| {
        [0, 1, 2].map(|c| (parts.iter().map(|e| e[c]).sum::<f64>() / parts.len() as f64 - whole[c]).abs())
    };
    coarse.iter().zip(fine.chunks(parts.max(1))).map(of).collect()
}

/// Whether each triangle has to be cut.
fn wanted(mesh: &Mesh, light: &[[f64; 3]], lost: &[[f64; 3]], limit: f64) -> Vec<bool> {
    let area = |face: usize| mesh.corners(face).map_or(0.0, |[a, b, c]| 0.5 * (b - a).cross(c - a).length());
    let areas: Vec<f64> = (0..light.len()).map(area).collect();
    let all: f64 = areas.iter().sum();
    let power = |c: usize| light.iter().zip(&areas).map(|(e, area)| area * e[c] * e[c]).sum::<f64>();
    let level = [0, 1, 2].map(|c| (power(c) / all.max(f64::MIN_POSITIVE)).sqrt());
    lost.iter().map(|lost| (0..3).any(|c| lost[c] > limit * level[c])).collect()
}

/// The radiosity that this light would give: what the parts lose or gain has either sign along a border, so its sizes
/// make a bound.
fn carried(scene: &Scene, lost: &[Vec<[f64; 3]>]) -> Result<Vec<Vec<[f64; 3]>>> {
    let mut rough = scene.clone();
    rough.transport.tolerance = ROUGH;
    let options = Options { goal: Goal::Radiosity, ..Options::default() };
    let mut session = Session::new(&rough, None, options, CapacityHints::default())?;
    let steps = session.plan.steps(session.state(), Change::EVERYTHING);
    let after: Vec<_> = steps.iter().filter(|step| !precedes_transport(step.stage)).collect();
    loop {
        session.prepare_light();
        for (object, lost) in lost.iter().enumerate() {
            for (place, lost) in session.prepared.places(object).into_iter().zip(lost) {
                session.prepared.state.data.irradiance[place] = lost.map(|x| x as f32);
            }
        }
        after.iter().for_each(|step| step.reference(&mut session.prepared.state));
        if session.state().data.counters.iter().all(|counters| counters.overflow == 0) {
            return Ok(by_object(&session, &session.state().data.radiosity, session.units().light));
        }
        session.lists.grow(&mut session.prepared)?;
        session.resize()?;
    }
}
