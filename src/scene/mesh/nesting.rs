//! How deep each closed part of a mesh lies inside the others.

use super::Mesh;
use crate::error::Input;
use crate::scene::range::Checked;
use glam::DVec3;
use rayon::prelude::*;
use std::sync::atomic::{AtomicU64, Ordering};

/// Most faces that points are compared with, all together: a minute or two.
const MOST: u64 = 4_000_000_000;

/// For each closed part, given by its faces, the number of other ones that contain it. A part
/// contains another when the centres of that one's outermost faces are all inside. An error where parts are so many, and
/// so deep in one another, that it would take too long to tell.
pub(super) fn depths(mesh: &Mesh, parts: &[&[u32]]) -> Checked<Vec<usize>> {
    let compared = AtomicU64::new(0);
    let boxes: Vec<(DVec3, DVec3)> = parts.par_iter().map(|faces| bounds(mesh, faces)).collect();
    let depth = |(inner, faces): (usize, &&[u32])| {
        let (low, high) = boxes[inner];
        let around = |outer: &usize| {
            let (outer_low, outer_high) = boxes[*outer];
            *outer != inner && outer_low.cmple(low).all() && outer_high.cmpge(high).all()
        };
        let mut outside = (0..parts.len()).filter(around).peekable();
        if outside.peek().is_none() {
            return Some(0);
        }
        let outside: Vec<usize> = outside.collect();
        let faces_of = outside.iter().map(|&outer| parts[outer].len() as u64).sum::<u64>();
        let more = 6 * faces_of + parts.len() as u64 / 16;
        if compared.fetch_add(more, Ordering::Relaxed) > MOST {
            return None;
        }
        let samples = outermost(mesh, faces);
        let contains = |outer: &usize| samples.iter().all(|&sample| winding(mesh, parts[*outer], sample).abs() > 0.5);
        Some(outside.iter().filter(|&outer| contains(outer)).count())
    };
    let depths: Option<Vec<usize>> = parts.par_iter().enumerate().map(depth).collect();
    depths.ok_or_else(|| {
        let fault = Input::new("too many parts of the mesh lie in one another to tell walls from cavities");
        fault.found(format!("{} closed parts", parts.len())).expected("parts side by side, or in objects of their own")
    })
}

/// The bounding box of some faces.
fn bounds(mesh: &Mesh, faces: &[u32]) -> (DVec3, DVec3) {
    let corners = faces.iter().filter_map(|&face| mesh.corners(face as usize)).flatten();
    let empty = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    corners.fold(empty, |(low, high), corner| (low.min(corner), high.max(corner)))
}

/// The centres of the faces that lie furthest along each axis, both ways. Centres, and not
/// corners, because a corner may also be one of another part.
fn outermost(mesh: &Mesh, faces: &[u32]) -> [DVec3; 6] {
    let mut best = [(f64::NEG_INFINITY, DVec3::ZERO); 6];
    for [a, b, c] in faces.iter().filter_map(|&face| mesh.corners(face as usize)) {
        let centre = (a + b + c) / 3.0;
        let along = [centre.x, centre.y, centre.z, -centre.x, -centre.y, -centre.z];
        for (best, along) in best.iter_mut().zip(along) {
            if along > best.0 {
                *best = (along, centre);
            }
        }
    }
    best.map(|(_, centre)| centre)
}

/// The generalised winding number of a closed part about a point: the solid angles of its faces
/// (van Oosterom and Strackee 1983) over 4 pi; about 1 or -1 inside and 0 outside.
pub(super) fn winding(mesh: &Mesh, faces: &[u32], point: DVec3) -> f64 {
    let half_angle = |[a, b, c]: [DVec3; 3]| {
        let (a, b, c) = (a - point, b - point, c - point);
        let (la, lb, lc) = (a.length(), b.length(), c.length());
        let below = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
        a.dot(b.cross(c)).atan2(below)
    };
    let corners = faces.iter().filter_map(|&face| mesh.corners(face as usize));
    corners.map(half_angle).sum::<f64>() / std::f64::consts::TAU
}

#[cfg(test)]
mod tests {
    use super::super::Shape;
    use super::*;

    #[test]
    fn winding_is_one_inside_and_zero_outside() {
        let mesh = Shape::Lotus.build(32);
        let faces: Vec<u32> = (0..mesh.triangles.len() as u32).collect();
        let (low, high) = mesh.bounds();
        assert!(winding(&mesh, &faces, (low + high) / 2.0).abs() < 1e-9);
        assert!(winding(&mesh, &faces, high * 3.0).abs() < 1e-9);
        let ball = Shape::Sphere.build(2);
        let faces: Vec<u32> = (0..ball.triangles.len() as u32).collect();
        assert!((winding(&ball, &faces, DVec3::splat(0.4)) - 1.0).abs() < 1e-9);
    }
}
