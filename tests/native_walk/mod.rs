//! The random walk once more, as a plain native program: `f64`, the standard library's functions, one photon after
//! another on every core, a search of the triangles near a flight by a tree, and none where a distance to the surface
//! is known.

use std::f64::consts::TAU;

use glam::DVec3;
use milkglass::Scene;
use milkglass::internals::lighting::fresnel;
use milkglass::measure::statistics::Random;
use rayon::prelude::*;

/// Cells of the grid of distances along an axis.
const SIDE: usize = 48;

/// A node of the tree over triangles: its box, the node after its subtree, and its triangle if it is a leaf.
struct Node {
    low: DVec3,
    high: DVec3,
    next: usize,
    face: Option<usize>,
}

/// A body to walk through.
pub struct Body {
    faces: Vec<[DVec3; 3]>,
    normals: Vec<DVec3>,
    nodes: Vec<Node>,
    /// Sums of the light on the triangles.
    sums: Vec<f64>,
    low: DVec3,
    cell: DVec3,
    clearance: Vec<f64>,
    toward: DVec3,
}

impl Body {
    /// The first object of a scene, with this light on its triangles, which comes from this direction.
    pub fn new(scene: &Scene, light: Vec<f64>, toward: DVec3) -> Self {
        let mesh = &scene.objects[0].mesh;
        let faces: Vec<[DVec3; 3]> = (0..mesh.triangles.len()).filter_map(|face| mesh.corners(face)).collect();
        let normals = faces.iter().map(|[a, b, c]| (*b - *a).cross(*c - *a).normalize()).collect();
        let mut sum = 0.0;
        let sums = light.into_iter().map(|light| (sum += light, sum).1).collect();
        let mut order: Vec<usize> = (0..faces.len()).collect();
        let mut body = Self {
            nodes: Vec::new(),
            sums,
            low: DVec3::ZERO,
            cell: DVec3::ONE,
            clearance: Vec::new(),
            toward,
            normals,
            faces,
        };
        body.split(&mut order);
        (body.low, body.cell) = (body.nodes[0].low, (body.nodes[0].high - body.nodes[0].low) / SIDE as f64);
        let center = |k: usize| {
            let at = DVec3::new((k % SIDE) as f64, (k / SIDE % SIDE) as f64, (k / SIDE / SIDE) as f64);
            body.low + (at + 0.5) * body.cell
        };
        let cells = (0..SIDE * SIDE * SIDE).into_par_iter();
        let half = 0.5 * body.cell.length();
        body.clearance = cells.map(|k| (body.distance(center(k)) - half).max(0.0)).collect();
        body
    }

    /// Appends the tree of these triangles.
    fn split(&mut self, faces: &mut [usize]) {
        let corners = || faces.iter().flat_map(|&face| self.faces[face]);
        let (low, high) = (corners().fold(DVec3::MAX, DVec3::min), corners().fold(DVec3::MIN, DVec3::max));
        let place = self.nodes.len();
        self.nodes.push(Node { low, high, next: 0, face: (faces.len() == 1).then(|| faces[0]) });
        if faces.len() > 1 {
            let size = high - low;
            let axis = (0..3).fold(0, |best, k| if size[k] > size[best] { k } else { best });
            let middle = |face: usize| self.faces[face].iter().map(|corner| corner[axis]).sum::<f64>();
            faces.sort_by(|&a, &b| middle(a).total_cmp(&middle(b)));
            let (one, other) = faces.split_at_mut(faces.len() / 2);
            self.split(one);
            self.split(other);
        }
        self.nodes[place].next = self.nodes.len();
    }

    /// Distance to the nearest box of a triangle.
    fn distance(&self, place: DVec3) -> f64 {
        let (mut best, mut at) = (f64::INFINITY, 0);
        while let Some(node) = self.nodes.get(at) {
            let apart = (node.low - place).max(place - node.high).max(DVec3::ZERO).length();
            let enter = apart < best && node.face.is_none();
            if apart < best && !enter {
                best = apart;
            }
            at = if enter { at + 1 } else { node.next };
        }
        best
    }

    fn around(&self, place: DVec3) -> f64 {
        let at = ((place - self.low) / self.cell).max(DVec3::ZERO).min(DVec3::splat(SIDE as f64 - 1.0));
        self.clearance[at.x as usize + SIDE * (at.y as usize + SIDE * at.z as usize)]
    }

    /// The first triangle that is passed outward within a distance, and where.
    fn exit(&self, place: DVec3, way: DVec3, path: f64) -> Option<(usize, f64)> {
        let (inverse, mut found, mut at) = (way.recip(), None, 0);
        let mut end = path;
        while let Some(node) = self.nodes.get(at) {
            let (one, other) = ((node.low - place) * inverse, (node.high - place) * inverse);
            let (near, far) = (one.min(other).max_element(), one.max(other).min_element());
            let met = near <= far.min(end) + 1e-9 && far >= -1e-9;
            at = if met && node.face.is_none() { at + 1 } else { node.next };
            let Some(face) = node.face.filter(|_| met) else { continue };
            let [a, b, c] = self.faces[face];
            let (right, up, from) = (b - a, c - a, place - a);
            let across = way.cross(up);
            let sum = right.dot(across);
            if way.dot(self.normals[face]) <= 0.0 || sum == 0.0 {
                continue;
            }
            let u = from.dot(across) / sum;
            let turned = from.cross(right);
            let (v, distance) = (way.dot(turned) / sum, up.dot(turned) / sum);
            if u >= -1e-9 && v >= -1e-9 && u + v <= 1.0 + 1e-9 && distance > -1e-6 && distance < end {
                (found, end) = (Some(face), distance);
            }
        }
        found.map(|face| (face, end.max(0.0)))
    }

    /// Walks a photon; the weight with which it left, if it was scattered, and its flights.
    fn photon(&self, (scattering, absorption, eta): (f64, f64, f64), random: &mut Random) -> (f64, u64) {
        let extinction = scattering + absorption;
        let albedo = scattering / extinction;
        let light = random.uniform() * self.sums[self.sums.len() - 1];
        let face = self.sums.partition_point(|&sum| sum < light).min(self.faces.len() - 1);
        let ([a, b, c], normal) = (self.faces[face], self.normals[face]);
        let (root, v) = (random.uniform().sqrt(), random.uniform());
        let mut place = a + root * (1.0 - v) * (b - a) + root * v * (c - a);
        let cosine = self.toward.dot(normal);
        let inner = (1.0 - (1.0 - cosine * cosine) / (eta * eta)).max(0.0).sqrt();
        let mut way = (-self.toward / eta + (cosine / eta - inner) * normal).normalize();
        let (mut weight, mut scattered, mut flights) = (1.0, false, 0);
        while flights < 1_000_000 {
            flights += 1;
            let path = -random.uniform().ln() / extinction;
            if path < self.around(place) {
            } else if let Some((face, edge)) = self.exit(place, way, path) {
                place += edge * way;
                let normal = self.normals[face];
                let cosine = way.dot(normal);
                let out = (1.0 - (1.0 - cosine * cosine) * eta * eta).max(0.0).sqrt();
                if random.uniform() < fresnel::transmittance(eta, out) {
                    return (if scattered { weight } else { 0.0 }, flights);
                }
                way -= 2.0 * cosine * normal;
                continue;
            }
            place += path * way;
            weight *= albedo;
            scattered = true;
            if weight < 0.125 {
                if random.uniform() > 0.5 {
                    return (0.0, flights);
                }
                weight *= 2.0;
            }
            let (z, turn) = (2.0 * random.uniform() - 1.0, TAU * random.uniform());
            let across = (1.0 - z * z).sqrt();
            way = DVec3::new(across * turn.cos(), across * turn.sin(), z);
        }
        (0.0, flights)
    }

    /// Walks this many photons of each of these media, a multiple of 100, on all cores; the mean weight with which they
    /// left, and the mean of their flights.
    pub fn walk(&self, media: [(f64, f64, f64); 3], photons: u64, seed: u64) -> (f64, f64) {
        let parts = (0..3 * photons / 100).into_par_iter().map(|part| {
            let mut random = Random::of(3 * photons * seed + part);
            let walk = |_| self.photon(media[part as usize % 3], &mut random);
            (0..100).map(walk).fold((0.0, 0), |sum, one| (sum.0 + one.0, sum.1 + one.1))
        });
        let (left, flights) = parts.reduce(|| (0.0, 0), |a, b| (a.0 + b.0, a.1 + b.1));
        (left / (3 * photons) as f64, flights as f64 / (3 * photons) as f64)
    }
}
