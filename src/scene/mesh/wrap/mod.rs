//! Shrink-wrapping (section 5.1.2 of Mertens et al. 2003, after Kobbelt et al. 1999): remeshes a closed mesh of genus 0
//! as a coarse base with repeated 4-to-1 splits.
//!
//! The mesh is mapped to the unit sphere and relaxed. The base uses some of the mesh's vertices; its triangles are
//! split on the sphere, and every new vertex is mapped back through the triangle of the mesh that contains it. An edge
//! is split at the point that is equally far from both ends on the mesh, so that parts are nearly even however uneven
//! the spherical map is.

mod coarsen;
mod sphere;

use super::Mesh;
use super::edges::Edges;
use super::refine::room;
use super::walk::{self, Surface};
use crate::error::Input;
use crate::scene::files::Files;
use crate::scene::range::Checked;
use glam::DVec3;
use sphere::{lay, side};

/// The origin of a vertex: three vertices of the original mesh, and the weight of each.
pub(super) type Share = ([u32; 3], [f64; 3]);

/// Minimum distance of a split from the ends of its edge, as a fraction of the edge, and the number of bisections.
const LEAST: f64 = 1e-3;
const HALVINGS: usize = 14;

/// Minimum number of triangles of a base, if the mesh has as many.
const BASE: usize = 12;

/// Remeshes `mesh` as a base split in four `levels` times, of about as many triangles as before; also returns the
/// origins of the vertices.
pub(super) fn shrink_wrap(
    mesh: &Mesh,
    levels: u32,
    files: &Files,
    report: &mut Vec<String>,
) -> Checked<(Mesh, Vec<Share>)> {
    let key = "transport.hierarchy";
    check(mesh, key)?;
    let all = mesh.triangles.len();
    let wanted = (all >> (2 * levels)).max(BASE).min(all);
    let laid = lay(&mesh.positions, &mesh.triangles, wanted).ok_or_else(|| {
        let fault = Input::new("the mesh cannot be laid over a ball: rounding turns triangles over").key(key);
        fault.expected("a mesh whose parts have no very thin necks, or another hierarchy")
    })?;
    room(files, laid.base.len(), levels)?;
    let ball = Ball { places: laid.places, triangles: &mesh.triangles, twin: Edges::of(&mesh.triangles).twin };

    // The base, with its own vertex numbers.
    let mut number = vec![u32::MAX; mesh.positions.len()];
    let mut fine = Mesh { splits: vec![0; laid.base.len()], ..Mesh::made(Vec::new(), laid.base) };
    let mut from = Vec::new();
    for corner in fine.triangles.iter_mut().flatten() {
        let old = *corner as usize;
        if number[old] == u32::MAX {
            number[old] = fine.positions.len() as u32;
            fine.positions.push(ball.places[old]);
            from.push(old as u32);
        }
        *corner = number[old];
    }
    // The triangle of the mesh that contains each vertex; for a vertex of the mesh, any of its own.
    let mut face_at = vec![0; mesh.positions.len()];
    (0..).zip(&mesh.triangles).for_each(|(face, triangle)| triangle.iter().for_each(|&v| face_at[v as usize] = face));
    let mut lies: Vec<u32> = from.iter().map(|&v| face_at[v as usize]).collect();

    for _ in 0..levels {
        let (mut finer, _) = fine.split(|_| true);
        lies.resize(finer.positions.len(), u32::MAX);
        for half in 0..3 * fine.triangles.len() {
            let middle = finer.triangles[4 * (half / 3) + 3][half % 3] as usize;
            if lies[middle] == u32::MAX {
                let ends = [half % 3, (half + 1) % 3].map(|k| fine.triangles[half / 3][k] as usize);
                let [a, b] = ends.map(|v| (fine.positions[v], lies[v]));
                (finer.positions[middle], lies[middle]) = ball.between(a, b, &mesh.positions);
            }
        }
        fine = finer;
    }
    let share = |(&face, &p): (&u32, &DVec3)| (mesh.triangles[face as usize], ball.shares(face, p));
    let mut shares: Vec<Share> = lies.iter().zip(&fine.positions).map(share).collect();
    for (share, &vertex) in shares.iter_mut().zip(&from) {
        *share = ([vertex; 3], [1.0, 0.0, 0.0]);
    }
    let middle = |[a, b, c]: [u32; 3]| {
        let p = [a, b, c].map(|v| fine.positions[v as usize]).into_iter().sum::<DVec3>().normalize();
        mesh.input_face[ball.find(p, lies[a as usize]) as usize]
    };
    fine.input_face = fine.triangles.iter().map(|&corners| middle(corners)).collect();
    fine.positions = apply(&shares, &mesh.positions);
    let (now, base) = (fine.triangles.len(), fine.triangles.len() >> (2 * levels));
    let change = 100.0 * (fine.volume() / mesh.volume() - 1.0);
    report.push(format!("shrink-wrapped: {now} triangles ({base} x 4^{levels}) for {all}, volume {change:+.2} %"));
    Ok((fine, shares))
}

/// Positions of vertices from those of the original mesh.
pub(super) fn apply(shares: &[Share], positions: &[DVec3]) -> Vec<DVec3> {
    let place =
        |(corners, parts): &Share| corners.iter().zip(parts).map(|(&v, &part)| part * positions[v as usize]).sum();
    shares.iter().map(place).collect()
}

/// Checks that a mesh is one closed surface of genus 0.
fn check(mesh: &Mesh, key: &str) -> Checked<()> {
    let fault = |found: String| {
        let fault = Input::new("the mesh cannot be shrink-wrapped").key(key).found(found);
        Err(fault.expected("one closed surface without handles; other hierarchies take any mesh"))
    };
    let open = Edges::of(&mesh.triangles).open;
    if open > 0 {
        return fault(format!("{open} open edges"));
    }
    walk::check(mesh, key)?;
    let (parts, touching) = Surface::of(mesh).parts();
    if touching > 0 {
        return fault(format!("{touching} vertices at which it touches itself"));
    }
    if parts > 1 {
        return fault(format!("{parts} parts"));
    }
    let euler = mesh.positions.len() as i64 - mesh.triangles.len() as i64 / 2;
    if euler != 2 {
        return fault(format!("a surface with {} handles", (2 - euler) / 2));
    }
    Ok(())
}

/// The mesh mapped to the unit sphere.
struct Ball<'a> {
    places: Vec<DVec3>,
    triangles: &'a [[u32; 3]],
    twin: Vec<u32>,
}

impl Ball<'_> {
    /// For each edge of a triangle how far a point is on its inner side, as a triple product.
    fn within(&self, face: u32, p: DVec3) -> [f64; 3] {
        let [a, b, c] = self.triangles[face as usize].map(|v| self.places[v as usize]);
        [side(p, a, b), side(p, b, c), side(p, c, a)]
    }

    /// The triangle that contains a point, found by walking from `face`.
    fn find(&self, p: DVec3, mut face: u32) -> u32 {
        for _ in 0..self.triangles.len() {
            let within = self.within(face, p);
            let worst = (0..3).fold(0, |worst, k| if within[k] < within[worst] { k } else { worst });
            if within[worst] >= 0.0 {
                return face;
            }
            face = self.twin[3 * face as usize + worst] / 3;
        }
        // The walk went in circles: take the triangle that the point is least outside of.
        let least = |face: &u32| self.within(*face, p).into_iter().fold(f64::INFINITY, f64::min);
        (0..self.triangles.len() as u32).max_by(|a, b| least(a).total_cmp(&least(b))).unwrap_or(face)
    }

    /// The point on the edge between two others that is equally far from both on the mesh, and the triangle that
    /// contains it.
    fn between(&self, a: (DVec3, u32), b: (DVec3, u32), positions: &[DVec3]) -> (DVec3, u32) {
        let [from, to] = [a, b].map(|(p, face)| self.on_mesh(face, p, positions));
        let (mut low, mut high, mut face) = (LEAST, 1.0 - LEAST, a.1);
        let mut place = a.0;
        for _ in 0..HALVINGS {
            let share = 0.5 * (low + high);
            place = a.0.lerp(b.0, share).normalize();
            face = self.find(place, face);
            let p = self.on_mesh(face, place, positions);
            if p.distance_squared(from) < p.distance_squared(to) { low = share } else { high = share }
        }
        (place, face)
    }

    /// The point of the mesh that a point on the sphere corresponds to.
    fn on_mesh(&self, face: u32, p: DVec3, positions: &[DVec3]) -> DVec3 {
        apply(&[(self.triangles[face as usize], self.shares(face, p))], positions)[0]
    }

    /// The barycentric weights of a triangle's corners at a point in it.
    fn shares(&self, face: u32, p: DVec3) -> [f64; 3] {
        let [c, a, b] = self.within(face, p).map(|x| x.max(0.0));
        let sum = a + b + c;
        if sum > 0.0 { [a / sum, b / sum, c / sum] } else { [1.0, 0.0, 0.0] }
    }
}

#[cfg(test)]
mod tests {
    use super::super::Shape;
    use super::*;

    fn wrapped(shape: Shape, detail: u32, levels: u32) -> (Mesh, Mesh) {
        let mesh = shape.build(detail);
        let mut report = Vec::new();
        let (fine, shares) = shrink_wrap(&mesh, levels, &Files::default(), &mut report).expect("a closed surface");
        assert!(report.len() == 1 && report[0].starts_with("shrink-wrapped: "), "{report:?}");
        assert_eq!(fine.positions, apply(&shares, &mesh.positions));
        (mesh, fine)
    }

    /// Closed, in one part, without handles, every triangle with an area.
    fn check_surface(fine: &Mesh) {
        assert!(check(fine, "k").is_ok());
        let area = |face| fine.corners(face).map_or(0.0, |[a, b, c]| (b - a).cross(c - a).length());
        assert!((0..fine.triangles.len()).all(|face| area(face) > 0.0));
    }

    #[test]
    fn a_ball_stays_one() {
        let (ball, fine) = wrapped(Shape::Sphere, 4, 3);
        check_surface(&fine);
        assert_eq!(fine.splits, vec![3; fine.triangles.len()]);
        let count = fine.triangles.len() as f64 / ball.triangles.len() as f64;
        assert!((0.9..1.1).contains(&count), "{count}");
        // The vertices lie on the triangles of the ball, so hardly inside the sphere; areas are as even as can be
        // expected.
        assert!(fine.positions.iter().all(|p| (0.99..=1.0 + 1e-12).contains(&p.length())));
        assert!((fine.volume() / ball.volume() - 1.0).abs() < 0.03, "{}", fine.volume() / ball.volume());
        let mut areas: Vec<f64> = (0..fine.triangles.len())
            .filter_map(|face| fine.corners(face))
            .map(|[a, b, c]| 0.5 * (b - a).cross(c - a).length())
            .collect();
        areas.sort_by(f64::total_cmp);
        assert!(areas[areas.len() * 9 / 10] < 6.0 * areas[areas.len() / 10], "{areas:?}");
    }

    #[test]
    fn folded_things_are_wrapped_too() {
        // The bowl is far from star-shaped: seen from the middle it hides itself many times over.
        for (shape, detail, levels, most) in
            [(Shape::Lotus, 64, 2, 0.1), (Shape::Candle, 48, 3, 0.03), (Shape::Cube, 16, 3, 0.03)]
        {
            let (mesh, fine) = wrapped(shape, detail, levels);
            check_surface(&fine);
            let change = fine.volume() / mesh.volume() - 1.0;
            assert!(change.abs() < most, "{shape:?}: {change}");
            let ((low, high), (a, b)) = (mesh.bounds(), fine.bounds());
            let slack = 1e-9 * (high - low).length();
            assert!(a.cmpge(low - slack).all() && b.cmple(high + slack).all());
        }
    }

    #[test]
    fn what_is_no_ball_is_refused() {
        let refused = |mesh: &Mesh| {
            shrink_wrap(mesh, 2, &Files::default(), &mut Vec::new()).err().map(|e| e.to_string()).unwrap_or_default()
        };
        let open = refused(&Shape::Plane.build(3));
        assert!(
            open.starts_with(
                "transport.hierarchy: the mesh cannot be shrink-wrapped; found 12 open edges; expected one closed"
            ),
            "{open}"
        );
        let mut two = Shape::Sphere.build(0);
        let second: Vec<_> = two.positions.iter().map(|p| *p + 9.0).collect();
        two.positions.extend(second);
        two.triangles.extend_from_within(..);
        two.triangles[20..].iter_mut().flatten().for_each(|v| *v += 12);
        assert!(refused(&two).contains("found 2 parts"));
        assert!(refused(&Shape::Torus.build(8)).contains("found a surface with 1 handles"));
    }
}
