//! A closed surface without handles laid over the ball, coarse first, so that no triangle is ever turned over: vertices
//! come back one by one inside of what their neighbours enclose, and all are drawn towards the middle of their
//! neighbours (the umbrella operator) as far as their triangles allow.

use super::coarsen::{Removal, Rounds, coarsen};
use glam::DVec3;

/// Rounds of relaxation whenever there are half as many vertices again, and of base and whole in the end.
const OFTEN: usize = 3;
const LAST: usize = 10;

/// No triangle is made thinner than this that was not so before, height by length.
const THIN: f64 = 0.03;

/// A surface on the ball, and its base.
pub(super) struct Sphere {
    /// Of length 1, one a vertex.
    pub places: Vec<DVec3>,
    /// Triangles of some of the vertices, which cover the ball as well.
    pub base: Vec<[u32; 3]>,
}

/// Lays a surface over the ball, with a base of about as many triangles; none if rounding does not let it.
pub(super) fn lay(positions: &[DVec3], triangles: &[[u32; 3]], base: usize) -> Option<Sphere> {
    let mut rounds = Rounds::new(positions.len(), triangles);
    let mut removals = coarsen(&mut rounds, positions)?;
    let mut laid = Laid { places: first(&rounds, positions)?, rounds, base: None };
    let (mut left, mut relaxed) = (4, 4);
    while let Some(removal) = removals.pop() {
        if left == base / 2 + 2 {
            laid.settle();
        }
        laid.insert(&removal)?;
        left += 1;
        if 2 * left > 3 * relaxed {
            laid.relax(OFTEN);
            relaxed = left;
        }
    }
    if laid.base.is_none() {
        laid.settle();
    }
    laid.relax(LAST);
    Some(Sphere { places: laid.places, base: laid.base?.triangles })
}

struct Laid {
    rounds: Rounds,
    places: Vec<DVec3>,
    /// The base, once it is known: its triangles are not turned over either.
    base: Option<Rounds>,
}

/// The last four vertices as seen from the middle of the surface, or as even as can be where that would turn them over.
fn first(rounds: &Rounds, positions: &[DVec3]) -> Option<Vec<DVec3>> {
    let middle = positions.iter().sum::<DVec3>() / positions.len() as f64;
    let mut places: Vec<DVec3> = positions.iter().map(|p| (*p - middle).normalize_or(DVec3::Z)).collect();
    let four = rounds.present();
    let steep = |places: &[DVec3]| {
        let turn = |&t: &u32| {
            let [a, b, c] = rounds.triangles[t as usize].map(|v| places[v as usize]);
            side(a, b, c)
        };
        four.iter().map(turn).fold(f64::INFINITY, f64::min)
    };
    if steep(&places) < 0.1 {
        let corners = rounds.triangles[*four.first()? as usize];
        let top = (0..places.len()).find(|&v| rounds.there[v] && !corners.contains(&(v as u32)))?;
        let even = [DVec3::new(1.0, 1.0, 1.0), DVec3::new(1.0, -1.0, -1.0), DVec3::new(-1.0, 1.0, -1.0)];
        corners.iter().zip(even).for_each(|(&v, place)| places[v as usize] = place.normalize());
        places[top] = DVec3::new(-1.0, -1.0, 1.0).normalize();
    }
    (steep(&places) > 0.0).then_some(places)
}

/// Above 0 where three points of the ball run anticlockwise, as seen from outside. Differences keep the digits of near
/// ones.
pub(super) fn side(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    a.dot((b - a).cross(c - a))
}

impl Laid {
    /// The triangles that are there are the base.
    fn settle(&mut self) {
        self.relax(LAST);
        let base: Vec<[u32; 3]> = self.rounds.present().iter().map(|&t| self.rounds.triangles[t as usize]).collect();
        self.base = Some(Rounds::new(self.places.len(), &base));
    }

    /// The thinnest of a vertex's triangles, the base's too, if it were here: height by length, below 0 where one is
    /// turned over.
    fn thinnest(&self, vertex: u32, place: DVec3) -> f64 {
        let thin = |[a, b]: [u32; 2]| {
            let (a, b) = (self.places[a as usize], self.places[b as usize]);
            let longest = place.distance_squared(a).max(place.distance_squared(b)).max(a.distance_squared(b));
            side(place, a, b) / longest
        };
        let base = self.base.iter().flat_map(|base| base.ring(vertex));
        self.rounds.ring(vertex).chain(base).map(thin).fold(f64::INFINITY, f64::min)
    }

    /// The middle of the neighbours.
    fn umbrella(&self, vertex: u32) -> DVec3 {
        self.rounds.ring(vertex).map(|[a, _]| self.places[a as usize]).sum::<DVec3>().normalize_or_zero()
    }

    /// Brings a vertex back, into the middle of its neighbours, or of the part that sees all of them.
    fn insert(&mut self, removal: &Removal) -> Option<()> {
        self.rounds.restore(removal);
        let vertex = removal.vertex;
        let tries = [self.umbrella(vertex), self.kernel(vertex)].map(|place| (self.thinnest(vertex, place), place));
        let (thinnest, place) = if tries[0].0 > THIN || tries[0].0 >= tries[1].0 { tries[0] } else { tries[1] };
        self.places[vertex as usize] = place;
        // Its neighbours make room.
        let near: Vec<u32> = self.rounds.ring(vertex).map(|[a, _]| a).collect();
        near.into_iter().for_each(|v| self.draw(v));
        (thinnest > 0.0).then_some(())
    }

    /// The middle of the corners of that part: where two of the great circles meet and all others agree.
    fn kernel(&self, vertex: u32) -> DVec3 {
        let circle = |[a, b]: [u32; 2]| {
            let (a, b) = (self.places[a as usize], self.places[b as usize]);
            a.cross(b - a).normalize_or_zero()
        };
        let circles: Vec<DVec3> = self.rounds.ring(vertex).map(circle).collect();
        let agree = |p: &DVec3| circles.iter().all(|n| n.dot(*p) >= -1e-13);
        let pairs = circles.iter().enumerate().flat_map(|(k, a)| circles[k + 1..].iter().map(|b| a.cross(*b)));
        let corners = pairs.filter_map(DVec3::try_normalize).flat_map(|p| [p, -p]).filter(agree);
        corners.sum::<DVec3>().normalize_or_zero()
    }

    /// Draws every vertex towards the middle of its neighbours, so many times.
    fn relax(&mut self, times: usize) {
        for _ in 0..times {
            for vertex in 0..self.places.len() {
                if self.rounds.there[vertex] {
                    self.draw(vertex as u32);
                }
            }
        }
    }

    /// Draws a vertex towards the middle of its neighbours, the whole way or a half or a quarter.
    fn draw(&mut self, vertex: u32) {
        let (from, to) = (self.places[vertex as usize], self.umbrella(vertex));
        let least = self.thinnest(vertex, from).min(THIN);
        let mut tries = [1.0, 0.5, 0.25].map(|share| from.lerp(to, share).normalize_or_zero()).into_iter();
        let found = tries.find(|place| self.thinnest(vertex, *place) > least);
        self.places[vertex as usize] = found.unwrap_or(from);
    }
}
