//! A closed surface with vertices taken away one by one, each drawn along the shortest edge into a neighbour, and given
//! back in the opposite order.

use glam::DVec3;
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

    /// Whether drawing a vertex into a neighbour leaves a closed surface; unless `freely`, one without new folds as well.
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

    /// How readily a vertex is drawn into a neighbour: the nearer, the sooner, unless too many triangles meet there then.
    fn cost(&self, places: &[DVec3], vertex: u32, into: u32) -> u64 {
        let meet = (self.round[vertex as usize].len() + self.round[into as usize].len()).saturating_sub(4);
        let crowd = 1u64 << (2 * meet.saturating_sub(8)).min(60);
        (places[vertex as usize].distance_squared(places[into as usize]) * crowd as f64).to_bits()
    }
}

/// Takes vertices away until four are left; none if that cannot be done.
pub(super) fn coarsen(rounds: &mut Rounds, places: &[DVec3]) -> Option<Vec<Removal>> {
    let mut removals = Vec::new();
    let last = places.len().checked_sub(4)?;
    let mut freely = false;
    while removals.len() < last {
        let before = removals.len();
        let mut queue = BinaryHeap::new();
        let entry = |rounds: &Rounds, vertex, into| Reverse((rounds.cost(places, vertex, into), vertex, into));
        for vertex in (0..places.len() as u32).filter(|&v| rounds.there[v as usize]) {
            queue.extend(rounds.ring(vertex).map(|[into, _]| entry(rounds, vertex, into)));
        }
        while let Some(Reverse((cost, vertex, into))) = queue.pop() {
            if removals.len() == last {
                break;
            }
            let linked = rounds.there[vertex as usize] && rounds.ring(vertex).any(|[a, _]| a == into);
            let now = if linked { rounds.cost(places, vertex, into) } else { cost };
            if now > cost {
                queue.push(Reverse((now, vertex, into)));
            } else if linked && rounds.may_go(places, vertex, into, freely) {
                removals.push(rounds.remove(vertex, into));
                queue.extend(rounds.ring(into).flat_map(|[a, _]| [entry(rounds, a, into), entry(rounds, into, a)]));
            }
        }
        // What was not possible may be now, or with folds.
        if removals.len() - before < last / 64 {
            if freely && removals.len() == before {
                return None;
            }
            freely = true;
        }
    }
    Some(removals)
}
