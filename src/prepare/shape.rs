//! Deformations of a scene's objects: conversion to internal units, and checks of the deformed triangles.

use std::f64::consts::TAU;

use glam::DVec3;
use rayon::prelude::*;

use super::skins;
use super::units::Units;
use crate::geometry::deform::{deform, displace, way};
use crate::geometry::skin::skin;
use crate::layout::Deform as Record;
use crate::layout::{
    DEFORM_BEND, DEFORM_BUMP_AXIS, DEFORM_BUMP_NORMAL, DEFORM_MORPH, DEFORM_NOISE, DEFORM_SKIN, DEFORM_TWIST,
};
use crate::scene::{Deform, Object};
use crate::state::{State, narrow, wide};

/// Writes the objects' deformations, and the vertices and normals at rest that they apply to; all empty if nothing is
/// deformed. The positions are written by [`deform_all`].
pub fn shape(state: &mut State, objects: &[Object], units: Units) {
    let data = &mut state.data;
    data.deforms.clear();
    data.morphs.clear();
    for ((object, part), params) in objects.iter().zip(&mut state.objects).zip(&mut data.object_params) {
        params.first_deform = data.deforms.len() as u32;
        let deforms = records(object, units.own(object));
        let first = data.morphs.len() as u32;
        data.deforms.extend(deforms.records.into_iter().map(|record| Record { first: record.first + first, ..record }));
        data.morphs.extend(deforms.morphs);
        params.deforms = data.deforms.len() as u32 - params.first_deform;
        part.deforms = params.deforms as usize;
    }
    skins::write(state, objects, units);
    let data = &mut state.data;
    if data.deforms.is_empty() {
        if !data.rest.is_empty() {
            data.positions = std::mem::take(&mut data.rest);
        }
        data.rest_normals = Vec::new();
        return;
    }
    // The shape at rest stays, as long as something is deformed.
    if data.rest.is_empty() {
        data.rest = vec![[0.0; 3]; data.positions.len()];
        data.rest_normals = data.rest.clone();
        for (object, part) in objects.iter().zip(&state.objects) {
            let vertices = part.first.vertices..part.first.vertices + part.count.vertices;
            let (places, normals) = rest(object, units.own(object));
            data.rest.splice(vertices.clone(), places);
            data.rest_normals.splice(vertices, normals);
        }
    }
}

/// Writes the vertex normals of triangles that were divided; none if none were.
pub fn whole_normals(state: &mut State, objects: &[Object]) {
    for (object, part) in objects.iter().zip(&mut state.objects) {
        let Some(normals) = &object.mesh.normals else { continue };
        part.whole_normals = true;
        state.data.whole_normals.resize(state.data.positions.len(), [0.0; 3]);
        let vertices = part.first.vertices..part.first.vertices + part.count.vertices;
        state.data.whole_normals.splice(vertices, normals.iter().copied().map(narrow));
    }
}

/// Deforms all objects on the host; the result is bit-identical to any device's.
pub fn deform_all(state: &mut State) {
    if state.data.deforms.is_empty() {
        return;
    }
    state.data.positions.clone_from(&state.data.rest);
    for object in 0..state.objects.len() {
        skin(&mut state.data, object);
        deform(&mut state.data, object);
    }
}

/// Vertices and their normals at rest; `units` are those of the object's own frame, as in [`records`].
pub(super) fn rest(object: &Object, units: Units) -> (Vec<[f32; 3]>, Vec<[f32; 3]>) {
    let places = object.mesh.positions.iter().map(|&p| narrow(units.inside(p))).collect();
    (places, object.mesh.vertex_normals().into_iter().map(narrow).collect())
}

/// An object's deformed vertices, in internal units of its own frame; none where nothing deforms it.
pub fn moved(object: &Object, units: Units) -> Option<Vec<DVec3>> {
    let units = units.own(object);
    let deforms = records(object, units);
    if deforms.records.is_empty() {
        return None;
    }
    let (places, normals) = rest(object, units);
    let place = |v: usize| deforms.moved(v, places[v], normals[v]);
    Some((0..places.len()).into_par_iter().map(|v| wide(place(v))).collect())
}

/// An object's deformations in internal units.
pub(super) struct Records {
    /// Those that have an effect; morphs begin with the object's own.
    records: Vec<Record>,
    /// Displacements of the vertices by morphs.
    morphs: Vec<[f32; 3]>,
    /// Where joints place the vertices; empty if they follow none.
    skinned: Vec<[f32; 3]>,
}

impl Records {
    /// Where a vertex with this place and normal at rest moves.
    pub fn moved(&self, vertex: usize, place: [f32; 3], normal: [f32; 3]) -> [f32; 3] {
        let way = |deform| way(&self.morphs, &self.skinned, deform, vertex);
        self.records.iter().fold(place, |p, deform| displace(deform, p, normal, way(deform)))
    }
}

/// An object's deformations, without those that have no effect.
pub(super) fn records(object: &Object, units: Units) -> Records {
    let mut all = Records { records: Vec::new(), morphs: Vec::new(), skinned: Vec::new() };
    for deform in &object.deforms {
        let Some(mut record) = record(deform, units) else { continue };
        match deform {
            Deform::Morph { ways, .. } => {
                record.first = all.morphs.len() as u32;
                all.morphs.extend(ways.iter().map(|&way| narrow(way * units.length)));
            }
            Deform::Skin { rig, pose } => all.skinned = skins::placed(rig, pose, units),
            _ => {}
        }
        all.records.push(record);
    }
    all
}

/// A deformation in internal units; none where it has no effect.
fn record(deform: &Deform, units: Units) -> Option<Record> {
    let long = |x: f64| (x * units.length) as f32;
    let place = |p: DVec3| narrow(units.inside(p));
    match *deform {
        Deform::Twist { span, angle } => (angle != 0.0).then(|| Record {
            kind: DEFORM_TWIST,
            origin: place(span.center),
            axis: narrow(span.axis),
            low: long(span.low),
            extent: long(span.length),
            rate: (angle / TAU / (span.length * units.length)) as f32,
            ..Record::default()
        }),
        Deform::Bend { span, toward, angle } => (angle != 0.0).then(|| Record {
            kind: DEFORM_BEND,
            origin: place(span.center),
            axis: narrow(span.axis),
            toward: narrow(toward),
            low: long(span.low),
            extent: long(span.length),
            rate: (angle / TAU / (span.length * units.length)) as f32,
            amount: long(span.length / angle),
            ..Record::default()
        }),
        Deform::Bump { position, radius, height, direction } => (height != 0.0).then(|| Record {
            kind: if direction.is_some() { DEFORM_BUMP_AXIS } else { DEFORM_BUMP_NORMAL },
            origin: place(position),
            axis: narrow(direction.unwrap_or_default()),
            rate: (1.0 / (radius * units.length).powi(2)) as f32,
            amount: long(height),
            ..Record::default()
        }),
        Deform::Noise { amplitude, scale, offset } => (amplitude != 0.0).then(|| Record {
            kind: DEFORM_NOISE,
            origin: place(offset),
            rate: (1.0 / (scale * units.length)) as f32,
            amount: long(amplitude),
            ..Record::default()
        }),
        Deform::Morph { weight, .. } => {
            (weight != 0.0).then(|| Record { kind: DEFORM_MORPH, amount: weight as f32, ..Record::default() })
        }
        Deform::Skin { .. } => Some(Record { kind: DEFORM_SKIN, ..Record::default() }),
    }
}

/// For each object, how many triangles its deformations turn inside out or leave without an area: their rest shape's
/// front side is at the back, or nowhere. Morphs and skins do not define what happens in front of a triangle; with
/// one, triangles count that fold against their neighbours, or all of a closed surface that is turned inside out.
pub fn turned(state: &State) -> Vec<usize> {
    let data = &state.data;
    let count = |(part, params): (&crate::state::Object, &crate::layout::ObjectParams)| {
        let deforms = &data.deforms[params.first_deform as usize..][..params.deforms as usize];
        let triangles = &data.triangles[part.first.faces..][..part.count.faces];
        if deforms.is_empty() {
            return 0;
        }
        if deforms.iter().any(|deform| [DEFORM_MORPH, DEFORM_SKIN].contains(&deform.kind)) {
            return folded(state, part.first.vertices, part.count.vertices, triangles);
        }
        let moved = |p: DVec3, n: DVec3| {
            wide(deforms.iter().fold(narrow(p), |p, deform| displace(deform, p, narrow(n), [0.0; 3])))
        };
        let turned = |triangle: &&[u32; 3]| {
            let rest = triangle.map(|v| wide(data.rest[v as usize]));
            let normals = triangle.map(|v| wide(data.rest_normals[v as usize]));
            let [a, b, c] = [0, 1, 2].map(|k| moved(rest[k], normals[k]));
            let before = (rest[1] - rest[0]).cross(rest[2] - rest[0]);
            let after = (b - a).cross(c - a);
            let (middle, normal) = (rest.iter().sum::<DVec3>() / 3.0, normals.iter().sum::<DVec3>() / 3.0);
            let step = 0.1 * before.length().sqrt() * before.normalize_or_zero();
            let up = moved(middle + step, normal) - moved(middle, normal);
            after.length() <= 1e-6 * before.length() || (before.length() > 0.0 && after.dot(up) <= 0.0)
        };
        triangles.par_iter().filter(turned).count()
    };
    state.objects.iter().zip(&data.object_params).map(count).collect()
}

/// How many triangles fold against the triangles around their corners or have lost their area; all if the enclosed
/// volume has changed sign.
fn folded(state: &State, first: usize, vertices: usize, triangles: &[[u32; 3]]) -> usize {
    let [rest, now] = [&state.data.rest, &state.data.positions].map(|places| {
        let area = |triangle: &[u32; 3]| {
            let [a, b, c] = triangle.map(|v| wide(places[v as usize]));
            (a.dot(b.cross(c)), (b - a).cross(c - a))
        };
        let (mut round, mut volume) = (vec![DVec3::ZERO; vertices], 0.0);
        let areas: Vec<DVec3> = triangles
            .iter()
            .map(|triangle| {
                let (part, vector) = area(triangle);
                volume += part;
                triangle.iter().for_each(|&v| round[v as usize - first] += vector);
                vector
            })
            .collect();
        // Cosine between each triangle and those around it.
        let lies = |(triangle, vector): (&[u32; 3], &DVec3)| {
            let others = triangle.iter().map(|&v| round[v as usize - first]).sum::<DVec3>() - 3.0 * *vector;
            vector.normalize_or_zero().dot(others.normalize_or_zero())
        };
        let cosines: Vec<f64> = triangles.iter().zip(&areas).map(lies).collect();
        (areas, cosines, volume)
    });
    // The vector areas cancel for a closed surface only.
    let (sum, all) = now.0.iter().fold((DVec3::ZERO, 0.0), |(sum, all), area| (sum + *area, all + area.length()));
    if rest.2 * now.2 < 0.0 && sum.length() < 1e-4 * all {
        return triangles.len();
    }
    let folded =
        |&k: &usize| now.0[k].length() <= 1e-6 * rest.0[k].length() || (now.1[k] < -0.5 && now.1[k] < rest.1[k] - 0.5);
    (0..triangles.len()).filter(folded).count()
}
