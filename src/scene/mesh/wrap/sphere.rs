//! Maps a closed surface of genus 0 to the unit sphere, coarse to fine, without ever flipping a triangle: vertices are
//! restored one by one inside the polygon of their neighbours, and all are relaxed towards the mean of their neighbours
//! (the umbrella operator) as far as their triangles allow.

use super::coarsen::{Removal, Rounds, coarsen};
use glam::DVec3;

/// Rounds of relaxation each time the number of vertices has grown by half, and for the base and the whole at the end.
const OFTEN: usize = 3;
const LAST: usize = 10;

/// No triangle is made thinner than this, height by length, unless it was already.
const THIN: f64 = 0.03;

/// A surface mapped to the sphere, and its base.
pub(super) struct Sphere {
    /// The position of each vertex, length 1.
    pub places: Vec<DVec3>,
    /// Triangles of some of the vertices, which cover the sphere as well.
    pub base: Vec<[u32; 3]>,
}

/// Maps a surface to the sphere, with a base of about `base` triangles; `None` if rounding prevents it.
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
    /// The base, once it is known: its triangles are not flipped either.
    base: Option<Rounds>,
}

/// The positions to start from: the last four vertices as seen from the mean of the surface, or at the corners of a
/// regular tetrahedron if that would flip them or nearly so.
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

/// Positive where three points of the sphere are anticlockwise as seen from outside. Differences keep the precision of
/// near points.
pub(super) fn side(a: DVec3, b: DVec3, c: DVec3) -> f64 {
    a.dot((b - a).cross(c - a))
}

impl Laid {
    /// Relaxes, and takes the triangles that are present as the base.
    fn settle(&mut self) {
        self.relax(LAST);
        let base: Vec<[u32; 3]> = self.rounds.present().iter().map(|&t| self.rounds.triangles[t as usize]).collect();
        self.base = Some(Rounds::new(self.places.len(), &base));
    }

    /// The thinnest triangle around a vertex at `place`, those of the base included: height by length, negative if one
    /// is flipped.
    fn thinnest(&self, vertex: u32, place: DVec3) -> f64 {
        let thin = |[a, b]: [u32; 2]| {
            let (a, b) = (self.places[a as usize], self.places[b as usize]);
            let longest = place.distance_squared(a).max(place.distance_squared(b)).max(a.distance_squared(b));
            side(place, a, b) / longest
        };
        let base = self.base.iter().flat_map(|base| base.ring(vertex));
        self.rounds.ring(vertex).chain(base).map(thin).fold(f64::INFINITY, f64::min)
    }

    /// The mean of the neighbours, on the sphere.
    fn umbrella(&self, vertex: u32) -> DVec3 {
        self.rounds.ring(vertex).map(|[a, _]| self.places[a as usize]).sum::<DVec3>().normalize_or_zero()
    }

    /// Restores a vertex, at the mean of its neighbours or in the kernel of their polygon, which sees all of them;
    /// `None` if a triangle is flipped.
    fn insert(&mut self, removal: &Removal) -> Option<()> {
        self.rounds.restore(removal);
        let vertex = removal.vertex;
        let tries = [self.umbrella(vertex), self.kernel(vertex)].map(|place| (self.thinnest(vertex, place), place));
        let (thinnest, place) = if tries[0].0 > THIN || tries[0].0 >= tries[1].0 { tries[0] } else { tries[1] };
        self.places[vertex as usize] = place;
        // Relax its neighbours.
        let near: Vec<u32> = self.rounds.ring(vertex).map(|[a, _]| a).collect();
        near.into_iter().for_each(|v| self.draw(v));
        (thinnest > 0.0).then_some(())
    }

    /// The mean of the corners of the kernel: intersections of two edges' great circles on the inner side of all
    /// others.
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

    /// Relaxes every vertex that is present, so many times.
    fn relax(&mut self, times: usize) {
        for _ in 0..times {
            for vertex in 0..self.places.len() {
                if self.rounds.there[vertex] {
                    self.draw(vertex as u32);
                }
            }
        }
    }

    /// Moves a vertex towards the mean of its neighbours: all the way, a half or a quarter, the first that makes no
    /// triangle too thin.
    fn draw(&mut self, vertex: u32) {
        let (from, to) = (self.places[vertex as usize], self.umbrella(vertex));
        let least = self.thinnest(vertex, from).min(THIN);
        let mut tries = [1.0, 0.5, 0.25].map(|share| from.lerp(to, share).normalize_or_zero()).into_iter();
        let found = tries.find(|place| self.thinnest(vertex, *place) > least);
        self.places[vertex as usize] = found.unwrap_or(from);
    }
}
