//! Walks over a surface from triangle to triangle.

use super::Mesh;
use super::edges::{Edges, NONE, start};
use crate::error::Input;
use crate::scene::range::Checked;
use glam::DVec3;

/// Half-edges and vertex positions of a mesh. Half-edge `3 t + k` runs from corner `k` of triangle `t` to the next.
pub(super) struct Surface<'a> {
    positions: &'a [DVec3],
    triangles: &'a [[u32; 3]],
    /// For each half-edge its twin, that of the other triangle at the same edge, or [`NONE`].
    pub twin: Vec<u32>,
}

impl<'a> Surface<'a> {
    /// The half-edges of a mesh.
    pub fn of(mesh: &'a Mesh) -> Self {
        Self { positions: &mesh.positions, triangles: &mesh.triangles, twin: Edges::of(&mesh.triangles).twin }
    }

    /// Where a half-edge starts.
    pub fn place(&self, half: u32) -> DVec3 {
        self.positions[start(self.triangles, half) as usize]
    }

    /// The twin of a half-edge, or [`NONE`].
    pub fn across(&self, half: u32) -> u32 {
        self.twin[half as usize]
    }

    /// Half-edges out of this one's start, in order around it from this one, and whether they go all the way around.
    pub fn fan(&self, half: u32) -> (Vec<u32>, bool) {
        let mut fan = vec![half];
        loop {
            // The edge that leads to this vertex; its twin leads away.
            let next = self.across(before(fan[fan.len() - 1]));
            if next == NONE || next == half {
                return (fan, next == half);
            }
            fan.push(next);
        }
    }

    /// The number of connected parts of a closed surface, and of vertices at which it touches itself; a vertex counts
    /// once per extra fan.
    pub fn parts(&self) -> (usize, usize) {
        let (mut seen, mut parts) = (vec![false; self.triangles.len()], 0);
        for first in 0..self.triangles.len() as u32 {
            let mut open = vec![first];
            parts += usize::from(!seen[first as usize]);
            while let Some(face) = open.pop() {
                if !std::mem::replace(&mut seen[face as usize], true) {
                    open.extend((3 * face..3 * face + 3).map(|half| self.across(half) / 3));
                }
            }
        }
        let (mut met, mut fans) = (vec![false; self.twin.len()], 0);
        for half in 0..self.twin.len() {
            if !met[half] {
                fans += 1;
                self.fan(half as u32).0.into_iter().for_each(|half| met[half as usize] = true);
            }
        }
        (parts, fans - self.positions.len())
    }
}

/// Checks that a mesh is a surface with consistent orientation and no edge of three triangles or more.
pub(super) fn check(mesh: &Mesh, key: &str) -> Checked<()> {
    let edges = Edges::of(&mesh.triangles);
    let fault = |found: String| {
        let fault = Input::new("the mesh cannot be subdivided").key(key).found(found);
        Err(fault.expected("a surface: one or two triangles at every edge, which agree on its outside"))
    };
    if edges.crowded > 0 {
        return fault(format!("{} edges that three triangles or more share", edges.crowded));
    }
    let from = |half: u32| start(&mesh.triangles, half);
    let same = |&(half, &twin): &(u32, &u32)| twin != NONE && from(half) == from(twin);
    match (0..).zip(&edges.twin).filter(same).count() / 2 {
        0 => Ok(()),
        count => fault(format!("{count} edges whose triangles disagree on a side")),
    }
}

/// The next half-edge of a triangle.
pub(super) fn after(half: u32) -> u32 {
    if half % 3 == 2 { half - 2 } else { half + 1 }
}

/// The half-edge of a triangle before this one.
pub(super) fn before(half: u32) -> u32 {
    if half.is_multiple_of(3) { half + 2 } else { half - 1 }
}

#[cfg(test)]
mod tests {
    use super::super::Shape;
    use super::*;

    #[test]
    fn fans_go_round_and_end_at_borders() {
        let ball = Shape::Sphere.build(1);
        let surface = Surface::of(&ball);
        let (fan, whole) = surface.fan(0);
        assert!(whole && fan.iter().all(|&half| surface.place(half) == surface.place(0)));
        let plane = Shape::Plane.build(2);
        let middle = (0..24).find(|&half| Surface::of(&plane).place(half) == DVec3::ZERO).unwrap();
        assert_eq!((Surface::of(&plane).fan(middle).0.len(), Surface::of(&plane).fan(middle).1), (6, true));
        assert!((0..24).any(|half| !Surface::of(&plane).fan(half).1));
    }

    #[test]
    fn parts_are_counted_and_where_they_touch() {
        let tetrahedron = [[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        let two = |last: u32| {
            let second = tetrahedron.map(|t| t.map(|v| if v == 3 { last } else { v + 4 }));
            let vertices = if last == 3 { 7 } else { 8 };
            Mesh::made(vec![DVec3::ZERO; vertices], [tetrahedron, second].concat())
        };
        assert_eq!(Surface::of(&two(7)).parts(), (2, 0));
        assert_eq!(Surface::of(&two(3)).parts(), (2, 1));
        assert_eq!(Surface::of(&Shape::Sphere.build(2)).parts(), (1, 0));
    }

    #[test]
    fn what_is_no_surface_is_refused() {
        assert!(check(&Shape::Sphere.build(1), "k").is_ok() && check(&Shape::Plane.build(2), "k").is_ok());
        let mut fan = Shape::Plane.build(1);
        fan.positions.push(DVec3::Z);
        fan.triangles.push([0, 3, 4]);
        let message = check(&fan, "k").unwrap_err().to_string();
        assert!(message.contains("1 edges that three triangles or more share"), "{message}");
        let strip = Mesh::made(vec![DVec3::ZERO, DVec3::X, DVec3::Y, DVec3::Z], vec![[0, 1, 2], [0, 1, 3]]);
        assert!(check(&strip, "k").unwrap_err().to_string().contains("1 edges whose triangles disagree"));
    }
}
