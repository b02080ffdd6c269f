//! Simplifies a closed surface by half-edge collapses, which are undone in reverse order. The cost of a collapse is the
//! change of shape (quadrics: Garland and Heckbert 1997) plus a weight on distance, so that tips stay, and vertices are
//! spaced evenly elsewhere.

use glam::{DMat3, DVec3};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// A half-edge collapse: a vertex moved into a neighbour, and the two triangles that vanished.
pub(super) struct Removal {
    /// The vertex that was removed.
    pub vertex: u32,
    into: u32,
    gone: [u32; 2],
}

/// Triangles around vertices. A removed vertex keeps its list, from which it is restored.
pub(super) struct Rounds {
    /// Corners of each triangle, anticlockwise from outside.
    pub triangles: Vec<[u32; 3]>,
    /// The triangles around each vertex, unordered.
    pub round: Vec<Vec<u32>>,
    /// Which vertices are present.
    pub there: Vec<bool>,
}

impl Rounds {
    /// The triangles around the vertices of a closed surface.
    pub fn new(vertices: usize, triangles: &[[u32; 3]]) -> Self {
        let mut round = vec![Vec::new(); vertices];
        for (number, triangle) in triangles.iter().enumerate() {
            triangle.iter().for_each(|&v| round[v as usize].push(number as u32));
        }
        Self { triangles: triangles.to_vec(), round, there: vec![true; vertices] }
    }

    /// The edges opposite a vertex, anticlockwise from outside; each starts at another neighbour.
    pub fn ring(&self, vertex: u32) -> impl Iterator<Item = [u32; 2]> + '_ {
        self.round[vertex as usize].iter().map(move |&t| {
            let [a, b, c] = self.triangles[t as usize];
            if a == vertex {
                [b, c]
            } else if b == vertex {
                [c, a]
            } else {
                [a, b]
            }
        })
    }

    /// The triangles that are present.
    pub fn present(&self) -> Vec<u32> {
        let starting =
            |v: usize| self.round[v].iter().copied().filter(move |&t| self.triangles[t as usize][0] as usize == v);
        (0..self.there.len()).filter(|&v| self.there[v]).flat_map(starting).collect()
    }

    fn remove(&mut self, vertex: u32, into: u32) -> Removal {
        let mut gone = [0; 2];
        let mut count = 0;
        for t in self.round[vertex as usize].clone() {
            let corners = &mut self.triangles[t as usize];
            if corners.contains(&into) {
                gone[count] = t;
                count += 1;
                let others = corners.iter().copied().filter(|&v| v != vertex);
                others.for_each(|v| self.round[v as usize].retain(|&other| other != t));
            } else {
                corners.iter_mut().filter(|v| **v == vertex).for_each(|v| *v = into);
                self.round[into as usize].push(t);
            }
        }
        self.there[vertex as usize] = false;
        Removal { vertex, into, gone }
    }

    /// Restores a vertex; those removed after it must have been restored already.
    pub fn restore(&mut self, removal: &Removal) {
        let Removal { vertex, into, gone } = *removal;
        for t in self.round[vertex as usize].clone() {
            let corners = &mut self.triangles[t as usize];
            if gone.contains(&t) {
                corners.iter().filter(|v| **v != vertex).for_each(|&v| self.round[v as usize].push(t));
            } else {
                corners.iter_mut().filter(|v| **v == into).for_each(|v| *v = vertex);
                self.round[into as usize].retain(|&other| other != t);
            }
        }
        self.there[vertex as usize] = true;
    }

    /// Whether a collapse leaves a closed surface and, unless `freely`, makes no new folds.
    fn may_go(&self, places: &[DVec3], vertex: u32, into: u32, freely: bool) -> bool {
        let common = self.ring(vertex).filter(|[a, _]| self.ring(into).any(|[b, _]| *a == b)).count();
        let stays = |&[a, b]: &[u32; 2]| {
            let [from, to, a, b] = [vertex, into, a, b].map(|v| places[v as usize]);
            let (before, after) = ((a - from).cross(b - from), (a - to).cross(b - to));
            before.dot(after) > 0.2 * before.length() * after.length()
        };
        let others = |[a, b]: &[u32; 2]| *a != into && *b != into;
        common == 2 && (freely || self.ring(vertex).filter(others).all(|edge| stays(&edge)))
    }
}

/// The sum over planes of area times squared distance from the plane: p.A p + 2 b.p + c.
#[derive(Clone, Copy, Default)]
struct Quadric {
    a: DMat3,
    b: DVec3,
    c: f64,
}

impl Quadric {
    /// The quadric of a triangle's plane.
    fn of([p, q, r]: [DVec3; 3]) -> Self {
        let normal = (q - p).cross(r - p);
        let (area, unit) = (0.5 * normal.length(), normal.normalize_or_zero());
        let height = -unit.dot(p);
        let a = DMat3::from_cols(unit.x * unit, unit.y * unit, unit.z * unit) * area;
        Self { a, b: area * height * unit, c: area * height * height }
    }

    fn add(&mut self, other: Self) {
        (self.a, self.b, self.c) = (self.a + other.a, self.b + other.b, self.c + other.c);
    }

    fn at(&self, p: DVec3) -> f64 {
        (p.dot(self.a * p) + 2.0 * self.b.dot(p) + self.c).max(0.0)
    }
}

/// Weight of distance relative to the change of shape.
const EVEN: f64 = 0.03;

/// Cost of a collapse, as the bits of a non-negative `f64`; higher where too many triangles would meet.
fn cost(rounds: &Rounds, places: &[DVec3], quadrics: &[Quadric], vertex: u32, into: u32) -> u64 {
    let [from, to] = [vertex, into].map(|v| places[v as usize]);
    let area = |[a, b]: [u32; 2]| 0.5 * (places[a as usize] - from).cross(places[b as usize] - from).length();
    let around: f64 = rounds.ring(vertex).map(area).sum();
    let meet = (rounds.round[vertex as usize].len() + rounds.round[into as usize].len()).saturating_sub(4);
    let crowd = 1u64 << (2 * meet.saturating_sub(8)).min(60);
    ((quadrics[vertex as usize].at(to) + EVEN * around * from.distance_squared(to)) * crowd as f64).to_bits()
}

/// Removes vertices until four are left; `None` if that is impossible.
pub(super) fn coarsen(rounds: &mut Rounds, places: &[DVec3]) -> Option<Vec<Removal>> {
    let mut removals = Vec::new();
    let last = places.len().checked_sub(4)?;
    // Relative to the mean position, for precision.
    let middle = places.iter().sum::<DVec3>() / places.len().max(1) as f64;
    let places: &[DVec3] = &places.iter().map(|p| *p - middle).collect::<Vec<_>>();
    let mut quadrics = vec![Quadric::default(); places.len()];
    for triangle in &rounds.triangles {
        let quadric = Quadric::of(triangle.map(|v| places[v as usize]));
        triangle.iter().for_each(|&v| quadrics[v as usize].add(quadric));
    }
    let mut freely = false;
    while removals.len() < last {
        let before = removals.len();
        let mut queue = BinaryHeap::new();
        for vertex in (0..places.len() as u32).filter(|&v| rounds.there[v as usize]) {
            let entry = |[into, _]: [u32; 2]| Reverse((cost(rounds, places, &quadrics, vertex, into), vertex, into));
            queue.extend(rounds.ring(vertex).map(entry));
        }
        while let Some(Reverse((asked, vertex, into))) = queue.pop() {
            if removals.len() == last {
                break;
            }
            let linked = rounds.there[vertex as usize] && rounds.ring(vertex).any(|[a, _]| a == into);
            let now = if linked { cost(rounds, places, &quadrics, vertex, into) } else { asked };
            if now > asked {
                queue.push(Reverse((now, vertex, into)));
            } else if linked && rounds.may_go(places, vertex, into, freely) {
                removals.push(rounds.remove(vertex, into));
                let quadric = quadrics[vertex as usize];
                quadrics[into as usize].add(quadric);
                let entry = |(a, b)| Reverse((cost(rounds, places, &quadrics, a, b), a, b));
                queue.extend(rounds.ring(into).flat_map(|[a, _]| [(a, into), (into, a)]).map(entry));
            }
        }
        // Retry: collapses that were rejected may be possible now, or with folds.
        if removals.len() - before <= last / 64 {
            if freely && removals.len() == before {
                return None;
            }
            freely = true;
        }
    }
    Some(removals)
}
