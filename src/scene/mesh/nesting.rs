//! The nesting depth of each closed part of a mesh within the others.

use super::Mesh;
use crate::error::Input;
use crate::scene::range::Checked;
use glam::DVec3;
use rayon::prelude::*;

/// Maximum tests of a point against a face, all together: a minute or two.
const MOST: u64 = 4_000_000_000;

/// Comparisons of boxes that take as long as one such test.
const BOXES: u64 = 16;

/// For each closed part, given by its faces, the number of other parts that contain it. A part contains another if the
/// centroids of the other's outermost faces are all inside. Returns an error if the parts are so many and so deeply
/// nested that this would take too long.
pub(super) fn depths(mesh: &Mesh, parts: &[&[u32]]) -> Checked<Vec<usize>> {
    depths_within(MOST, mesh, parts).ok_or_else(|| {
        let fault = Input::new("too many parts of the mesh lie in one another to tell walls from cavities");
        fault.found(format!("{} closed parts", parts.len())).expected("parts side by side, or in objects of their own")
    })
}

/// The same; `None`, before the first test, if there would be more than `most`.
fn depths_within(most: u64, mesh: &Mesh, parts: &[&[u32]]) -> Option<Vec<usize>> {
    let most = most.checked_sub((parts.len() as u64).pow(2) / BOXES)?;
    let boxes: Vec<(DVec3, DVec3)> = parts.par_iter().map(|faces| bounds(mesh, faces)).collect();
    // The parts whose boxes contain a part's box.
    let around = |inner: usize| {
        let ((low, high), boxes) = (boxes[inner], &boxes);
        let holds = move |&outer: &usize| {
            let (outer_low, outer_high) = boxes[outer];
            outer != inner && outer_low.cmple(low).all() && outer_high.cmpge(high).all()
        };
        (0..parts.len()).filter(holds)
    };
    let faces_around = |inner| around(inner).map(|outer| parts[outer].len() as u64).sum();
    let faces_around: Vec<u64> = (0..parts.len()).into_par_iter().map(faces_around).collect();
    if faces_around.iter().sum::<u64>() > most / SAMPLES as u64 {
        return None;
    }
    let depth = |(inner, &faces_around): (usize, &u64)| {
        if faces_around == 0 {
            return 0;
        }
        let samples = outermost(mesh, parts[inner]);
        let contains = |outer: &usize| samples.iter().all(|&sample| winding(mesh, parts[*outer], sample).abs() > 0.5);
        around(inner).filter(contains).count()
    };
    Some(faces_around.par_iter().enumerate().map(depth).collect())
}

/// The bounding box of some faces.
fn bounds(mesh: &Mesh, faces: &[u32]) -> (DVec3, DVec3) {
    let corners = faces.iter().filter_map(|&face| mesh.corners(face as usize)).flatten();
    let empty = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    corners.fold(empty, |(low, high), corner| (low.min(corner), high.max(corner)))
}

/// Points at which a part is tested.
const SAMPLES: usize = 6;

/// The centroids of the faces that lie furthest along each axis, both ways. Not corners, because a corner may be shared
/// with another part.
fn outermost(mesh: &Mesh, faces: &[u32]) -> [DVec3; SAMPLES] {
    let mut best = [(f64::NEG_INFINITY, DVec3::ZERO); SAMPLES];
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

    #[test]
    fn no_more_faces_are_compared_than_are_allowed() {
        // Nested balls of 80 faces: each except the outermost is tested at 6 points, against all balls around it.
        let balls = |count: usize| {
            let ball = Shape::Sphere.build(1);
            let (vertices, faces) = (ball.positions.len() as u32, ball.triangles.len() as u32);
            let mut mesh = Mesh::default();
            for k in 0..count as u32 {
                mesh.positions.extend(ball.positions.iter().map(|p| f64::from(k + 1) * *p));
                mesh.triangles.extend(ball.triangles.iter().map(|t| t.map(|v| v + k * vertices)));
            }
            let parts: Vec<Vec<u32>> = (0..count as u32).map(|k| (k * faces..(k + 1) * faces).collect()).collect();
            (mesh, parts)
        };
        for count in [1, 2, 7, 32] {
            let (mesh, parts) = balls(count);
            let parts: Vec<&[u32]> = parts.iter().map(Vec::as_slice).collect();
            let steps = (6 * 80 * count * (count - 1) / 2 + count * count / 16) as u64;
            let depths = depths_within(steps, &mesh, &parts).unwrap();
            assert!((0..count).all(|k| depths[k] == count - 1 - k), "{count}: {depths:?}");
            assert!(steps == 0 || depths_within(steps - 1, &mesh, &parts).is_none(), "{count}");
        }
    }
}
