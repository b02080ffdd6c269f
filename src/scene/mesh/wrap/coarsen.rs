//! A closed surface with vertices taken away one by one, each drawn into a neighbour, and given back in the opposite
//! order. First go those that change the shape least (quadrics: Garland and Heckbert 1997) and whose neighbours are
//! near, so that tips stay, and what is left is even elsewhere.

use glam::{DMat3, DVec3};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// A vertex drawn into a neighbour, and the two triangles that went with it.
pub(super) struct Removal {
    /// The vertex.
    pub vertex: u32,
    into: u32,
    gone: [u32; 2],
}

/// Triangles round vertices. Those of a vertex that is away are still its own.
pub(super) struct Rounds {
    /// Corners of each triangle, anticlockwise from outside.
    pub triangles: Vec<[u32; 3]>,
    /// The triangles round each vertex, in no order.
    pub round: Vec<Vec<u32>>,
    /// Which vertices are there.
    pub there: Vec<bool>,
}

impl Rounds {
    /// Of a closed surface.
    pub fn new(vertices: usize, triangles: &[[u32; 3]]) -> Self {
        let mut round = vec![Vec::new(); vertices];
        for (number, triangle) in triangles.iter().enumerate() {
            triangle.iter().for_each(|&v| round[v as usize].push(number as u32));
        }
        Self { triangles: triangles.to_vec(), round, there: vec![true; vertices] }
    }

    /// The edges across from a vertex, anticlockwise from outside: every neighbour begins one.
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

    /// The triangles that are there.
    pub fn present(&self) -> Vec<u32> {
        let own =
            |v: usize| self.round[v].iter().copied().filter(move |&t| self.triangles[t as usize][0] as usize == v);
        (0..self.there.len()).filter(|&v| self.there[v]).flat_map(own).collect()
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

    /// Gives a vertex back; those taken away after it have to be there again.
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

    /// Whether drawing a vertex into a neighbour leaves a closed surface; unless `freely`, one without new folds as
    /// well.
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

/// Area times squared distance from planes, summed over them: p.A p + 2 b.p + c.
#[derive(Clone, Copy, Default)]
struct Quadric {
    a: DMat3,
    b: DVec3,
    c: f64,
}

impl Quadric {
    /// Of the plane of a triangle.
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

/// How much distance counts beside the change of shape.
const EVEN: f64 = 0.03;

/// What it costs to draw a vertex into a neighbour; more where too many triangles would meet.
fn cost(rounds: &Rounds, places: &[DVec3], quadrics: &[Quadric], vertex: u32, into: u32) -> u64 {
    let [from, to] = [vertex, into].map(|v| places[v as usize]);
    let area = |[a, b]: [u32; 2]| 0.5 * (places[a as usize] - from).cross(places[b as usize] - from).length();
    let around: f64 = rounds.ring(vertex).map(area).sum();
    let meet = (rounds.round[vertex as usize].len() + rounds.round[into as usize].len()).saturating_sub(4);
    let crowd = 1u64 << (2 * meet.saturating_sub(8)).min(60);
    ((quadrics[vertex as usize].at(to) + EVEN * around * from.distance_squared(to)) * crowd as f64).to_bits()
}

/// Takes vertices away until four are left; none if that cannot be done.
pub(super) fn coarsen(rounds: &mut Rounds, places: &[DVec3]) -> Option<Vec<Removal>> {
    let mut removals = Vec::new();
    let last = places.len().checked_sub(4)?;
    // About the middle, so that digits are not lost.
    let middle = places.iter().sum::<DVec3>() / places.len().max(1) as f64;
    let places: &[DVec3] = &places.iter().map(|p| *p - middle).collect::<Vec<_>>();
    let mut quadrics = vec![Quadric::default(); places.len()];
    for triangle in &rounds.triangles {
        let own = Quadric::of(triangle.map(|v| places[v as usize]));
        triangle.iter().for_each(|&v| quadrics[v as usize].add(own));
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
                let own = quadrics[vertex as usize];
                quadrics[into as usize].add(own);
                let entry = |(a, b)| Reverse((cost(rounds, places, &quadrics, a, b), a, b));
                queue.extend(rounds.ring(into).flat_map(|[a, _]| [(a, into), (into, a)]).map(entry));
            }
        }
        // What was not possible may be now, or with folds.
        if removals.len() - before <= last / 64 {
            if freely && removals.len() == before {
                return None;
            }
            freely = true;
        }
    }
    Some(removals)
}
