//! Subdivides triangles: those that are long against the mean free path first (see `coarse`), then, for
//! `transport.subdivide`, where a single value of irradiance is too coarse: at the borders of shadows and
//! spot cones (the first item of the paper's future work). A triangle is split in four if the mean irradiance of its
//! parts differs from its own by more than the tolerance times the object's root mean square; parts likewise, up to
//! the scene's number of levels. Where irradiance varies smoothly over a triangle no split is needed: light enters at
//! the right place on the whole.

use glam::DVec3;

use super::run::Session;
use crate::error::{Input, Result};
use crate::pipeline::frame::precedes_transport;
use crate::pipeline::plan::{Change, Goal, Options, ShadingMethod};
use crate::prepare::coarse::{Divided, Long, divide};
use crate::prepare::receivers::by_pixel;
use crate::prepare::shape::moved;
use crate::prepare::units::Units;
use crate::scene::{Mesh, Object, Scene};

/// Tolerance of the solution that estimates the remaining error.
const ROUGH: f64 = 0.1;

/// How an object's triangles were subdivided. Its parts are the triangles of the subdivided mesh.
#[derive(Clone, Debug, Default)]
pub struct Parts {
    /// The original triangles.
    pub whole: Vec<[u32; 3]>,
    /// For each part, its original triangle.
    pub of: Vec<u32>,
    /// For each original triangle, the part at its centre, or nearest to it.
    pub middle: Vec<u32>,
    /// For each original triangle, its face in the input.
    pub input_face: Vec<u32>,
    /// If triangles were divided because they are long, how many parts are too long still.
    pub long: Option<usize>,
    /// For each part, the radiosity that may be missing because irradiance still varies over parts, in the units of
    /// B, per channel; empty unless an estimate was requested.
    pub missed: Vec<[f64; 3]>,
}

/// The scene with its triangles subdivided for its materials and lights, and each object's parts; none if none needs
/// it. With `estimate`, the parts also say how much radiosity is still missing at borders of shadows.
pub fn subdivide(scene: &Scene, options: Options, estimate: bool) -> Result<Option<(Scene, Vec<Parts>)>> {
    let none = scene.objects.iter().all(|object| !divides(scene, object, options));
    if scene.transport.subdivide == 0 && none {
        return Ok(None);
    }
    let mut fine = scene.clone();
    if scene.transport.subdivide > 0 {
        deform(&mut fine);
    }
    let divided = |object: &Object| match divides(&fine, object, options) {
        true => divide(&object.mesh, &object.material, &scene.memory),
        false => Ok(None),
    };
    let divided: Vec<Option<Divided>> = fine.objects.iter().map(divided).collect::<Result<_>>()?;
    (fine.transport.subdivide, fine.transport.divided) = (0, true);
    let mut parts: Vec<Parts> = scene.objects.iter().map(|object| whole(&object.mesh)).collect();
    for ((object, parts), divided) in fine.objects.iter_mut().zip(&mut parts).zip(divided) {
        if let Some(Divided { mesh, from, left }) = divided {
            parts.divide(&object.mesh, &mesh, from);
            parts.long = Some(left);
            *object = Object { mesh, ..object.clone() };
        }
    }
    for left in (0..=scene.transport.subdivide).rev() {
        if scene.transport.subdivide == 0 || left == 0 && !estimate {
            break;
        }
        // Split all triangles, twice except at the last level, to see where that changes their irradiance: a border
        // may cross just a corner.
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
            if cut.contains(&true) && object.mesh.normals.is_none() {
                // Those of the parts would show each whole triangle as a facet.
                object.mesh.normals = Some(object.mesh.vertex_normals());
            }
            let (mesh, from) = object.mesh.split(|face| cut[face]);
            parts[number].cut(&cut, &from);
            *object = Object { mesh, ..object.clone() };
        }
        // The estimate needs a comparison with two levels of splits; after one with a single level, go on to the next
        // round.
        if !any && (!estimate || looks > 1) {
            if estimate {
                carried(&fine, &lost)?.into_iter().zip(&mut parts).for_each(|(missed, parts)| parts.missed = missed);
            }
            break;
        }
    }
    Ok(Some((fine, parts)))
}

/// Gives the meshes their deformed shapes, so that parts lie on them and stay connected.
fn deform(scene: &mut Scene) {
    let units = Units::of(&scene.objects);
    for object in &mut scene.objects {
        if let Some(places) = moved(object, units) {
            let own = units.own(object);
            object.mesh.positions = places.into_iter().map(|p| own.outside(p)).collect();
        }
        object.deforms.clear();
    }
}

/// Whether an object of a scene is one whose triangles are divided where they are long.
fn divides(scene: &Scene, object: &Object, options: Options) -> bool {
    let alone = matches!(options.transport, ShadingMethod::Walk | ShadingMethod::None);
    !alone
        && !scene.transport.divided
        && object.deforms.is_empty()
        && Long::of(&object.mesh, &object.material).is_some()
}

impl Session {
    /// The number of the original triangle, in the mesh of its object, of a triangle of the state.
    pub fn triangle(&self, face: usize) -> u32 {
        let (object, part) = self.prepared.source(face);
        self.parts.get(object).map_or(part, |parts| parts.of[part as usize])
    }

    /// The scene as it was asked for, if it was subdivided, and as it is.
    pub(super) fn scenes(&mut self) -> impl Iterator<Item = &mut Scene> {
        self.fixed.asked.iter_mut().chain([&mut self.scene])
    }

    /// Whether materials of a scene with the same objects need other triangles or receivers.
    pub(super) fn cuts_anew(&self, new: &Scene) -> bool {
        let options = self.fixed.options;
        let scatters = |object: &Object| (object.material.sigma_a, object.material.sigma_s_prime);
        let other = |(old, new): (&Object, &Object)| scatters(old) != scatters(new);
        let asked = self.fixed.asked.as_ref().unwrap_or(&self.scene);
        self.cut_for_light()
            || asked.objects.iter().zip(&new.objects).any(other)
                && (self.fixed.asked.is_some()
                    || new.objects.iter().any(|object| divides(new, object, options))
                    || by_pixel(new, options).0 != by_pixel(asked, options).0)
    }

    /// Whether triangles are subdivided where their lights need it.
    pub(super) fn cut_for_light(&self) -> bool {
        self.fixed.asked.as_ref().is_some_and(|asked| asked.transport.subdivide > 0)
    }

    /// The radiosity that may be missing at a triangle of the state because of shadow borders, in the units of B.
    pub fn missed(&self, face: usize) -> [f64; 3] {
        let (object, part) = self.prepared.source(face);
        self.parts.get(object).and_then(|parts| parts.missed.get(part as usize)).copied().unwrap_or_default()
    }
}

/// The parts of an object that is not split.
fn whole(mesh: &Mesh) -> Parts {
    let all: Vec<u32> = (0..).take(mesh.triangles.len()).collect();
    Parts {
        whole: mesh.triangles.clone(),
        of: all.clone(),
        middle: all,
        long: None,
        input_face: mesh.input_face.clone(),
        missed: Vec::new(),
    }
}

impl Parts {
    /// The parts of a mesh that was divided, each of which comes from one of its triangles.
    fn divide(&mut self, whole: &Mesh, mesh: &Mesh, from: Vec<u32>) {
        let center = |mesh: &Mesh, face: usize| mesh.corners(face).map_or(DVec3::ZERO, |[a, b, c]| (a + b + c) / 3.0);
        let mut nearest = vec![f64::INFINITY; self.middle.len()];
        for (part, &original) in (0..).zip(&from) {
            let distance = center(mesh, part as usize).distance_squared(center(whole, original as usize));
            if distance < nearest[original as usize] {
                (nearest[original as usize], self.middle[original as usize]) = (distance, part);
            }
        }
        self.of = from;
    }

    /// Updates the parts after some were split; `from` is, for each new part, the part that it comes from.
    fn cut(&mut self, cut: &[bool], from: &[u32]) {
        // The first new part of each old one. An unsplit part stays the middle; of four parts the last is in the
        // middle.
        let mut first = vec![0; cut.len()];
        from.iter().enumerate().rev().for_each(|(part, &before)| first[before as usize] = part as u32);
        for middle in &mut self.middle {
            let before = *middle as usize;
            *middle = first[before] + if cut[before] { 3 } else { 0 };
        }
        self.of = from.iter().map(|&before| self.of[before as usize]).collect();
    }
}

/// Irradiance of each triangle, by the CPU reference; object by object, in mesh order.
fn irradiance(scene: &Scene) -> Result<Vec<Vec<[f64; 3]>>> {
    let options = Options { goal: Goal::Radiosity, ..Options::default() };
    let mut session = Session::new(scene, None, options)?;
    session.prepare_light();
    Ok(by_object(&session, &session.state().data.irradiance, 1.0))
}

/// Values of the triangles times `scale`, object by object, in mesh order.
fn by_object(session: &Session, values: &[[f32; 3]], scale: f64) -> Vec<Vec<[f64; 3]>> {
    let value = |face: usize| values[face].map(|x| scale * f64::from(x));
    let of_object = |object: usize| session.prepared.places(object).into_iter().map(value).collect();
    (0..session.scene().objects.len()).map(of_object).collect()
}

/// Difference between the mean irradiance of each triangle's parts and its own.
fn lost(coarse: &[[f64; 3]], fine: &[[f64; 3]]) -> Vec<[f64; 3]> {
    let parts = fine.len() / coarse.len().max(1);
    let change = |(whole, parts): (&[f64; 3], &[[f64; 3]])| {
        [0, 1, 2].map(|c| (parts.iter().map(|e| e[c]).sum::<f64>() / parts.len() as f64 - whole[c]).abs())
    };
    coarse.iter().zip(fine.chunks(parts.max(1))).map(change).collect()
}

/// Whether each triangle has to be split.
fn wanted(mesh: &Mesh, light: &[[f64; 3]], lost: &[[f64; 3]], limit: f64) -> Vec<bool> {
    let area = |face: usize| mesh.corners(face).map_or(0.0, |[a, b, c]| 0.5 * (b - a).cross(c - a).length());
    let areas: Vec<f64> = (0..light.len()).map(area).collect();
    let all: f64 = areas.iter().sum();
    let power = |c: usize| light.iter().zip(&areas).map(|(e, area)| area * e[c] * e[c]).sum::<f64>();
    let level = [0, 1, 2].map(|c| (power(c) / all.max(f64::MIN_POSITIVE)).sqrt());
    lost.iter().map(|lost| (0..3).any(|c| lost[c] > limit * level[c])).collect()
}

/// Transports the absolute irradiance errors: along a border they have either sign, so the radiosity of their
/// absolute values is a bound.
fn carried(scene: &Scene, lost: &[Vec<[f64; 3]>]) -> Result<Vec<Vec<[f64; 3]>>> {
    let mut rough = scene.clone();
    rough.transport.tolerance = ROUGH;
    let options = Options { goal: Goal::Radiosity, ..Options::default() };
    let mut session = Session::new(&rough, None, options)?;
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
