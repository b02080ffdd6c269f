//! Skins of a scene's objects: conversion to internal units.

use glam::{DMat4, DVec3};

use super::units::Units;
use crate::geometry::skin::skin;
use crate::layout::{Buffers, ObjectParams, SkinJoint, SkinMatrix, SkinVertex};
use crate::scene::{Deform, Object, Pose, Rig};
use crate::state::{State, narrow};

/// Writes the joints and morph targets that the objects' vertices follow; empty if they follow none.
pub(super) fn write(state: &mut State, objects: &[Object], units: Units) {
    let data = &mut state.data;
    for part in &mut state.objects {
        part.skinned = false;
    }
    let skin_of = |object: &Object| {
        object.deforms.iter().find_map(|deform| match deform {
            Deform::Skin { rig, pose } => Some((rig.clone(), pose.clone())),
            _ => None,
        })
    };
    let all: Vec<_> = objects.iter().map(skin_of).collect();
    (data.skin_joints, data.skin_targets, data.skin_weights, data.skin_matrices) = Default::default();
    let vertices = if all.iter().any(Option::is_some) { data.positions.len() } else { 0 };
    data.skin_vertices.resize(vertices, SkinVertex::default());
    data.skinned.resize(vertices, [0.0; 3]);
    let mut params = std::mem::take(&mut data.object_params);
    for (((object, part), params), skin) in objects.iter().zip(&mut state.objects).zip(&mut params).zip(&all) {
        params.skin_joints = 0;
        if let Some((rig, pose)) = skin {
            part.skinned = true;
            append(data, params, rig, pose, units.own(object), part.first.vertices);
        }
    }
    data.object_params = params;
}

/// Appends a skin whose vertices begin at `first`.
fn append(data: &mut Buffers, params: &mut ObjectParams, rig: &Rig, pose: &Pose, units: Units, first: usize) {
    params.skin_joints = rig.joints as u32;
    params.first_joint = data.skin_joints.len() as u32;
    params.first_matrix = data.skin_matrices.len() as u32;
    params.skin_targets = rig.targets as u32;
    params.first_target = data.skin_targets.len() as u32;
    params.first_weight = data.skin_weights.len() as u32;
    // Relative to the middle of the vertices, so that their places keep most of their digits.
    let start = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    let (low, high) = rig.base.iter().fold(start, |(low, high), p| (low.min(*p), high.max(*p)));
    let middle = 0.5 * (low + high);
    let (to, from) = (DMat4::from_translation(-units.center), DMat4::from_translation(middle));
    let inside = DMat4::from_scale(DVec3::splat(units.length)) * to;
    for (k, (base, row)) in rig.base.iter().zip(&rig.rows).enumerate() {
        data.skin_vertices[first + k] = SkinVertex { base: narrow(*base - middle), row: row * rig.targets as u32 };
    }
    let joint = |&(matrix, weight): &(u32, f64)| SkinJoint { matrix, weight: weight as f32 };
    data.skin_joints.extend(rig.influences.iter().map(joint));
    data.skin_targets.extend(rig.ways.iter().map(|way| narrow(*way)));
    data.skin_weights.extend(pose.weights.iter().map(|weight| *weight as f32));
    data.skin_matrices.extend(pose.matrices.iter().map(|matrix| {
        let rows = (inside * *matrix * from).transpose();
        let row = |row: glam::DVec4| row.to_array().map(|x| x as f32);
        SkinMatrix { x: row(rows.x_axis), y: row(rows.y_axis), z: row(rows.z_axis) }
    }));
}

/// Where a pose places the vertices, in internal units of the object's own frame: as stage `skin` does.
pub(super) fn placed(rig: &Rig, pose: &Pose, units: Units) -> Vec<[f32; 3]> {
    let vertices = rig.base.len();
    let mut data = Buffers {
        skin_vertices: vec![SkinVertex::default(); vertices],
        skinned: vec![[0.0; 3]; vertices],
        ..Buffers::default()
    };
    let mut params = ObjectParams { vertices: vertices as u32, ..ObjectParams::default() };
    append(&mut data, &mut params, rig, pose, units, 0);
    data.object_params.push(params);
    skin(&mut data, 0);
    data.skinned
}
