//! Finds the triangle at a point beyond an island's border: triangles are unfolded into the plane, one after another,
//! along the straight line to the point.

use glam::DVec2;

use super::NONE;
use crate::scene::Mesh;

/// Most triangles that a line is followed through.
const FARTHEST: u32 = 10_000;

/// A mesh with its corners' positions in the maps, in texels; texel centres are at whole numbers.
pub struct Faces<'a> {
    pub mesh: &'a Mesh,
    /// For each half-edge, the half-edge of the only other triangle at that edge.
    pub twins: Vec<u32>,
    pub places: Vec<[DVec2; 3]>,
}

/// The surface at a point beyond a border.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Across {
    /// This triangle, with the weights of its corners.
    Face(u32, [f64; 3]),
    /// Nothing: the edge itself is open.
    Open,
    /// Undetermined: for example, the triangle at the border has no area in the maps.
    Unknown,
}

/// Barycentric weights of a point; none for a triangle without area.
pub fn weights([a, b, c]: [DVec2; 3], p: DVec2) -> Option<[f64; 3]> {
    let area = (b - a).perp_dot(c - a);
    let tells = area.abs() > 1e-12 * (b - a).length_squared().max((c - a).length_squared());
    tells.then(|| [(b - p).perp_dot(c - p), (c - p).perp_dot(a - p), (a - p).perp_dot(b - p)].map(|span| span / area))
}

impl Faces<'_> {
    /// The vertices of a half-edge, from its start to its end.
    fn vertices(&self, half: u32) -> [u32; 2] {
        let (face, k) = (self.mesh.triangles[half as usize / 3], half as usize % 3);
        [face[k], face[(k + 1) % 3]]
    }

    /// The positions of a half-edge's ends in the maps.
    pub fn ends(&self, half: u32) -> [DVec2; 2] {
        let (face, k) = (self.places[half as usize / 3], half as usize % 3);
        [face[k], face[(k + 1) % 3]]
    }

    /// Offsets of a half-edge's ends from those of its twin; none at an open edge.
    pub fn apart(&self, half: u32) -> Option<[DVec2; 2]> {
        let twin = self.twins[half as usize];
        if twin == NONE {
            return None;
        }
        let ([p, q], mut other) = (self.ends(half), self.ends(twin));
        if self.vertices(half)[0] != self.vertices(twin)[0] {
            other.reverse();
        }
        Some([p - other[0], q - other[1]])
    }

    /// A triangle's corners unfolded into the plane, to the left of the edge from vertex `from` at `p` to vertex `to`
    /// at `q`.
    fn laid(&self, face: u32, [from, to]: [u32; 2], [p, q]: [DVec2; 2]) -> [DVec2; 3] {
        let at = |vertex: u32| self.mesh.positions[vertex as usize];
        let (edge, axis) = (at(to) - at(from), (q - p).normalize_or_zero());
        self.mesh.triangles[face as usize].map(|vertex| match vertex {
            v if v == from => p,
            v if v == to => q,
            v => {
                let way = at(v) - at(from);
                let along = way.dot(edge) / edge.length();
                p + along * axis + (way.length_squared() - along * along).max(0.0).sqrt() * axis.perp()
            }
        })
    }

    /// The surface at a point of the maps that lies beyond this edge of its island.
    pub fn across(&self, half: u32, place: DVec2) -> Across {
        if self.twins[half as usize] == NONE {
            return Across::Open;
        }
        // Put the edge on the x axis, its own triangle below it, the point above.
        let (face, mut ends) = (half / 3, self.vertices(half));
        let length = self.mesh.positions[ends[0] as usize].distance(self.mesh.positions[ends[1] as usize]);
        let mut axis = [DVec2::ZERO, DVec2::new(length, 0.0)];
        let Some(w) = weights(self.places[face as usize], place) else { return Across::Unknown };
        let above = self.laid(face, ends, axis);
        let goal: DVec2 = (0..3).map(|k| w[k] * DVec2::new(above[k].x, -above[k].y)).sum();
        let goal = DVec2::new(goal.x, goal.y.max(1e-9 * length));
        let from = DVec2::new(goal.x.clamp(1e-3 * length, 0.999 * length), 0.0);

        // Walk from edge to edge; the next triangle lies to the left of each.
        let mut half = half;
        for _ in 0..FARTHEST {
            let face = self.twins[half as usize] / 3;
            let laid = self.laid(face, ends, axis);
            let Some(found) = weights(laid, goal) else { return Across::Unknown };
            if found.iter().all(|&w| w >= -1e-9) {
                return Across::Face(face, found);
            }
            let corners = self.mesh.triangles[face as usize];
            let Some(k) = (0..3).find(|&k| !ends.contains(&corners[k])) else { return Across::Unknown };
            // The line passes the third corner on one side or the other.
            let side = usize::from((goal - from).perp_dot(laid[k] - from) <= 0.0);
            (ends[side], axis[side]) = (corners[k], laid[k]);
            let Some(next) = (3 * face..3 * face + 3).find(|&h| self.vertices(h).iter().all(|v| ends.contains(v)))
            else {
                return Across::Unknown;
            };
            if self.twins[next as usize] == NONE {
                // The surface ends here.
                let (way, edge) = (goal - from, axis[1] - axis[0]);
                let share = ((axis[0] - from).perp_dot(edge) / way.perp_dot(edge)).clamp(0.0, 1.0);
                return weights(laid, from + share * way).map_or(Across::Unknown, |w| Across::Face(face, w));
            }
            half = next;
        }
        Across::Unknown
    }
}
