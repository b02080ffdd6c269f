//! Creases: edges at which a surface ends or turns sharply, by its triangles or by the normals in its file.

use super::Mesh;
use super::clean::weld;
use super::edges::{Edges, NONE, start};
use super::walk::after;
use glam::DVec3;

/// The cosine of the angle between the normals of two triangles from which on their edge is a crease: 45 degrees.
const SHARP: f64 = std::f64::consts::FRAC_1_SQRT_2;
/// The cosine from which on a normal in a file agrees with the triangles around its vertex: 78 degrees.
const AGREES: f64 = 0.2;

impl Mesh {
    /// The ends of each edge that has one triangle only, or three and more, or two whose normals are more than 45
    /// degrees apart.
    #[must_use]
    pub fn creases(&self) -> Vec<[DVec3; 2]> {
        let edges = Edges::of(&self.triangles);
        let place = |half: u32| self.positions[start(&self.triangles, half) as usize];
        let once = |&(half, &twin): &(u32, &u32)| twin == NONE || half < twin;
        let sharp = (0..).zip(&edges.twin).filter(once).filter(|&(half, &twin)| self.is_crease(half, twin));
        sharp.map(|(half, _)| [place(half), place(after(half))]).collect()
    }

    /// The same triangles, whose corners on two sides of a crease are two vertices, so that nothing is interpolated
    /// across it. Vertices keep their numbers; new ones follow them.
    #[must_use]
    pub fn parted(&self) -> Self {
        self.parted_at(|half, twin| self.is_crease(half, twin))
    }

    /// The mesh with vertex normals from those that its file gives the corners of triangles, if any: the mean at each
    /// vertex, but not across edges where normals are more than 45 degrees apart; there a vertex becomes several. One
    /// that points to the other side is turned over; in place of one that does not agree with the triangles around the
    /// vertex, or none, theirs counts.
    pub(super) fn with_normals_of_corners(mut self, report: &mut Vec<String>) -> Self {
        let Some(mut corners) = self.corner_normals.take() else { return self };
        corners.iter_mut().flatten().for_each(|normal| *normal = normal.normalize_or_zero());
        let at = |corner: u32| corners[corner as usize / 3][corner as usize % 3];
        let apart = |[a, b]: [u32; 2]| at(a) != DVec3::ZERO && at(b) != DVec3::ZERO && at(a).dot(at(b)) < SHARP;
        let mut mesh = self.parted_at(|half, twin| self.across(half, twin).into_iter().any(apart));
        let mut normals = vec![DVec3::ZERO; mesh.positions.len()];
        for (triangle, corners) in mesh.triangles.iter().zip(&corners) {
            triangle.iter().zip(corners).for_each(|(vertex, normal)| normals[*vertex as usize] += *normal);
        }
        let mut off = 0;
        for (normal, own) in normals.iter_mut().zip(mesh.vertex_normals()) {
            let unit = normal.normalize_or_zero();
            let agrees = unit.dot(own).abs() >= AGREES;
            off += usize::from(!agrees);
            *normal = if agrees { unit * unit.dot(own).signum() } else { own };
        }
        if off > 0 {
            let all = normals.len();
            report.push(format!("normals: those of {off} of {all} vertices are missing or do not fit, and made anew"));
        }
        mesh.normals = Some(normals);
        mesh
    }

    /// The same triangles, with one vertex where several are in one place; without normals.
    #[must_use]
    pub fn joined(&self) -> Self {
        let (first, _) = weld(&self.positions);
        let triangles = self.triangles.iter().map(|corners| corners.map(|vertex| first[vertex as usize])).collect();
        Self { triangles, normals: None, ..self.clone() }
    }

    /// The corners of the triangles of these two half-edges that meet at the first end of the first one, and at its
    /// second.
    fn across(&self, half: u32, twin: u32) -> [[u32; 2]; 2] {
        let start_of = |half: u32| start(&self.triangles, half);
        [half, after(half)].map(|corner| [corner, if start_of(twin) == start_of(corner) { twin } else { after(twin) }])
    }

    /// The same triangles with vertices parted at edges with these properties, which are given by their half-edges.
    fn parted_at(&self, is_crease: impl Fn(u32, u32) -> bool) -> Self {
        let edges = Edges::of(&self.triangles);
        // Corners of one vertex, joined across the edges that are no creases.
        let mut joined: Vec<u32> = (0..edges.twin.len() as u32).collect();
        let start_of = |half: u32| start(&self.triangles, half);
        for (half, &twin) in (0..).zip(&edges.twin).filter(|&(half, &twin)| twin != NONE && half < twin) {
            if is_crease(half, twin) {
                continue;
            }
            for [corner, other] in self.across(half, twin) {
                let [first, second] = [corner, other].map(|corner| root(&mut joined, corner));
                joined[first.max(second) as usize] = first.min(second);
            }
        }
        let mut fine = self.clone();
        let mut first = vec![NONE; self.positions.len()];
        let mut vertex = vec![NONE; joined.len()];
        for corner in 0..joined.len() as u32 {
            let (old, root) = (start_of(corner) as usize, root(&mut joined, corner) as usize);
            if vertex[root] == NONE && first[old] == NONE {
                (first[old], vertex[root]) = (corner, old as u32);
            } else if vertex[root] == NONE {
                vertex[root] = fine.positions.len() as u32;
                fine.positions.push(self.positions[old]);
            }
            fine.triangles[corner as usize / 3][corner as usize % 3] = vertex[root];
        }
        fine
    }

    /// Whether the edge of these two half-edges, or of the first alone, is a crease.
    fn is_crease(&self, half: u32, twin: u32) -> bool {
        let normal = |half: u32| {
            self.corners(half as usize / 3).map_or(DVec3::ZERO, |[a, b, c]| (b - a).cross(c - a).normalize_or_zero())
        };
        twin == NONE || normal(half).dot(normal(twin)) < SHARP
    }
}

/// The first corner that this one is joined with.
fn root(joined: &mut [u32], mut corner: u32) -> u32 {
    while joined[corner as usize] != corner {
        joined[corner as usize] = joined[joined[corner as usize] as usize];
        corner = joined[corner as usize];
    }
    corner
}

#[cfg(test)]
mod tests {
    use super::super::Shape;
    use super::*;

    #[test]
    fn a_box_has_twelve_and_a_ball_none() {
        let cube = Shape::Slab.build(1);
        let (low, high) = cube.bounds();
        let size = high - low;
        let all: f64 = cube.creases().iter().map(|[a, b]| a.distance(*b)).sum();
        assert!((all - 4.0 * (size.x + size.y + size.z)).abs() < 1e-9, "{all} of {size}");
        assert!(Shape::Sphere.build(0).creases().is_empty());
        assert_eq!(Shape::Plane.build(1).creases().len(), 4);
    }

    #[test]
    fn vertices_are_parted_at_creases_only() {
        let cube = Mesh::made(
            (0..8).map(|k| DVec3::new(f64::from(k & 1), f64::from(k >> 1 & 1), f64::from(k >> 2))).collect(),
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]]
                .into_iter()
                .flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]])
                .collect(),
        );
        assert_eq!(cube.creases().len(), 12);
        let parted = cube.parted();
        assert_eq!(parted.positions.len(), 24);
        assert!((0..12).all(|face| parted.corners(face) == cube.corners(face)));
        // Both triangles of a side still share two vertices.
        let shared = |a: [u32; 3], b: [u32; 3]| a.iter().filter(|v| b.contains(v)).count();
        assert!(parted.triangles.chunks(2).all(|side| shared(side[0], side[1]) == 2));
        let ball = Shape::Sphere.build(1);
        assert_eq!(ball.parted(), ball);
    }

    /// The normals of a mesh with these at the corners of its triangles, and what is said of them.
    fn with_normals(mesh: &Mesh, of: impl Fn(usize, DVec3) -> DVec3) -> (Mesh, Vec<String>) {
        let all = |face: usize| mesh.corners(face).unwrap().map(|place| of(face, place));
        let corner_normals = Some((0..mesh.triangles.len()).map(all).collect());
        let mut report = Vec::new();
        (Mesh { corner_normals, ..mesh.clone() }.with_normals_of_corners(&mut report), report)
    }

    #[test]
    fn smooth_normals_stay_and_sharp_ones_part_vertices() {
        let ball = Shape::Sphere.build(1);
        let (round, report) = with_normals(&ball, |_, place| -3.0 * place);
        assert_eq!((&round.triangles, report.len()), (&ball.triangles, 0), "turned over, and no vertex more");
        let off = |mesh: &Mesh, of: &dyn Fn(usize) -> DVec3| {
            let normals = mesh.normals.as_ref().unwrap();
            (0..normals.len()).map(|v| normals[v].distance(of(v))).fold(0.0, f64::max)
        };
        assert!(off(&round, &|v| ball.positions[v].normalize()) < 1e-12);
        // Each face its own, as of a program that shades flat: what is less than 45 degrees apart is one.
        let own =
            |mesh: &Mesh, face: usize| mesh.corners(face).map(|[a, b, c]| (b - a).cross(c - a).normalize()).unwrap();
        let (flat, _) = with_normals(&ball, |face, _| own(&ball, face));
        assert_eq!(flat.triangles, ball.triangles);
        let cube = Shape::Slab.build(1);
        let (sharp, _) = with_normals(&cube, |face, _| own(&cube, face));
        assert!(sharp.positions.len() > cube.positions.len() && sharp.open_edges == 0);
        assert!(off(&sharp, &|v| sharp.normals.as_ref().unwrap()[v].round()) < 1e-12, "those of the sides");
        assert_eq!(sharp.joined().triangles, cube.triangles);
    }

    #[test]
    fn normals_that_do_not_fit_are_made_anew() {
        let ball = Shape::Sphere.build(1);
        let across = |place: DVec3| place.cross(DVec3::new(0.3, 0.5, 0.7)).normalize();
        for bad in [&|_: DVec3| DVec3::ZERO as DVec3, &|_| DVec3::NAN, &across] as [&dyn Fn(DVec3) -> DVec3; 3] {
            let (mesh, report) = with_normals(&ball, |_, place| if place.z > 0.0 { bad(place) } else { place });
            let (own, normals) = (ball.vertex_normals(), mesh.normals.as_ref().unwrap());
            let above = (0..own.len()).filter(|&v| ball.positions[v].z > 0.0);
            assert!(above.clone().all(|v| normals[v] == own[v]));
            let said = format!("normals: those of {} of {} vertices are missing", above.count(), own.len());
            assert!(report.len() == 1 && report[0].starts_with(&said), "{report:?}, not {said}");
        }
    }
}
