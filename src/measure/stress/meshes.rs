//! Meshes of the extreme cases.

use std::f64::consts::TAU;

use glam::{DQuat, DVec3};

use crate::scene::Mesh;

/// A mesh of these vertices and triangles.
pub(super) fn mesh(positions: Vec<DVec3>, triangles: Vec<[u32; 3]>) -> Mesh {
    let input_face = (0..triangles.len() as u32).collect();
    Mesh { positions, triangles, input_face, open_edges: 1, ..Mesh::default() }
}

/// Rotates a mesh about the origin so that no coordinate is a round number.
pub(super) fn turned(mut mesh: Mesh) -> Mesh {
    mesh.positions.iter_mut().for_each(|p| *p = turn(*p));
    mesh
}

/// The same rotation of one vector.
pub(super) fn turn(v: DVec3) -> DVec3 {
    DQuat::from_axis_angle(DVec3::new(0.48, -0.6, 0.64), 0.7391) * v
}

/// A sheet over [0,1]^2 that faces +z, with grid lines at these coordinates.
pub(super) fn sheet(xs: &[f64], ys: &[f64]) -> Mesh {
    let positions = ys.iter().flat_map(|&y| xs.iter().map(move |&x| DVec3::new(x, y, 0.0))).collect();
    let (across, up) = (xs.len() as u32, ys.len() as u32);
    let cell = |j: u32, i: u32| {
        let a = j * across + i;
        [[a, a + 1, a + across + 1], [a, a + across + 1, a + across]]
    };
    let triangles = (0..up - 1).flat_map(|j| (0..across - 1).flat_map(move |i| cell(j, i))).collect();
    mesh(positions, triangles)
}

/// Coordinates of grid lines from 0 to 1, with a second line after each inner one, this share of a cell away, unless 0.
pub(super) fn lines(cells: u32, width: f64) -> Vec<f64> {
    if width == 0.0 {
        return (0..=cells).map(|k| f64::from(k) / f64::from(cells)).collect();
    }
    let step = 1.0 / f64::from(cells);
    let pair = |k: u32| [f64::from(k) * step, (f64::from(k) + width) * step];
    [0.0].into_iter().chain((1..cells).flat_map(pair)).chain([1.0]).collect()
}

/// A closed triangle fan: a cone on a flat disc.
pub(super) fn cone(count: u32, radius: f64, height: f64) -> Mesh {
    let angle = |k: u32| TAU * f64::from(k) / f64::from(count);
    let rim = (0..count).map(|k| DVec3::new(radius * angle(k).cos(), radius * angle(k).sin(), 0.0));
    let positions = [DVec3::new(0.0, 0.0, height), DVec3::ZERO].into_iter().chain(rim).collect();
    let next = |k: u32| 2 + (k + 1) % count;
    turned(mesh(positions, (0..count).flat_map(|k| [[0, 2 + k, next(k)], [1, next(k), 2 + k]]).collect()))
}

/// Joins two meshes.
pub(super) fn both(mut one: Mesh, other: Mesh) -> Mesh {
    let first = one.positions.len() as u32;
    one.positions.extend(other.positions);
    one.triangles.extend(other.triangles.into_iter().map(|t| t.map(|v| v + first)));
    mesh(one.positions, one.triangles)
}

/// The mesh with its orientation reversed.
pub(super) fn reversed(mut mesh: Mesh) -> Mesh {
    mesh.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    mesh
}
