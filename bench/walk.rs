//! `cargo bench --bench walk`: photons a second of the random walk, on the default device and by the CPU reference,
//! beside a plain native program of the same walk: `f64`, the standard library's functions, one photon after another
//! on every core, a search of the triangles near a flight by a tree, and none where a distance to the surface is known.
//!
//! `cargo bench --bench walk -- bunny.obj` measures other scenes than the ball, in marble under one directional light.
//! Medians of turns in which all three alternate.

use std::f64::consts::TAU;
use std::time::Instant;

use glam::DVec3;
use milkglass::error::Result;
use milkglass::internals::lighting::fresnel;
use milkglass::internals::pipeline::plan::Change;
use milkglass::{Device, Goal, Options, Scene, Session, ShadingMethod};
use rayon::prelude::*;

/// Photons of each channel, and turns.
const PHOTONS: u64 = 16_000;
const TURNS: usize = 5;
/// Cells of the grid of distances along an axis.
const SIDE: usize = 48;

/// splitmix64, uniform in (0, 1].
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (((z ^ (z >> 31)) >> 11) as f64 + 1.0) / (1u64 << 53) as f64
    }
}

/// A node of the tree over triangles: its box, the node after its subtree, and its triangle if it is a leaf.
struct Node {
    low: DVec3,
    high: DVec3,
    next: usize,
    face: Option<usize>,
}

/// A body to walk through.
struct Body {
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
    fn new(scene: &Scene, light: Vec<f64>, toward: DVec3) -> Self {
        let mesh = &scene.objects[0].mesh;
        let faces: Vec<[DVec3; 3]> = (0..mesh.triangles.len()).filter_map(|face| mesh.corners(face)).collect();
        let normals = faces.iter().map(|[a, b, c]| (*b - *a).cross(*c - *a).normalize()).collect();
        let mut sum = 0.0;
        let sums = light.into_iter().map(|light| (sum += light, sum).1).collect();
        let mut own: Vec<usize> = (0..faces.len()).collect();
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
        body.split(&mut own);
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
    fn split(&mut self, own: &mut [usize]) {
        let corners = || own.iter().flat_map(|&face| self.faces[face]);
        let (low, high) = (corners().fold(DVec3::MAX, DVec3::min), corners().fold(DVec3::MIN, DVec3::max));
        let place = self.nodes.len();
        self.nodes.push(Node { low, high, next: 0, face: (own.len() == 1).then(|| own[0]) });
        if own.len() > 1 {
            let size = high - low;
            let axis = (0..3).fold(0, |best, k| if size[k] > size[best] { k } else { best });
            let middle = |face: usize| self.faces[face].iter().map(|corner| corner[axis]).sum::<f64>();
            own.sort_by(|&a, &b| middle(a).total_cmp(&middle(b)));
            let (one, other) = own.split_at_mut(own.len() / 2);
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
        let light = random.next() * self.sums[self.sums.len() - 1];
        let face = self.sums.partition_point(|&sum| sum < light).min(self.faces.len() - 1);
        let ([a, b, c], normal) = (self.faces[face], self.normals[face]);
        let (root, v) = (random.next().sqrt(), random.next());
        let mut place = a + root * (1.0 - v) * (b - a) + root * v * (c - a);
        let cosine = self.toward.dot(normal);
        let inner = (1.0 - (1.0 - cosine * cosine) / (eta * eta)).max(0.0).sqrt();
        let mut way = (-self.toward / eta + (cosine / eta - inner) * normal).normalize();
        let (mut weight, mut scattered, mut flights) = (1.0, false, 0);
        while flights < 1_000_000 {
            flights += 1;
            let path = -random.next().ln() / extinction;
            if path < self.around(place) {
            } else if let Some((face, edge)) = self.exit(place, way, path) {
                place += edge * way;
                let normal = self.normals[face];
                let cosine = way.dot(normal);
                let out = (1.0 - (1.0 - cosine * cosine) * eta * eta).max(0.0).sqrt();
                if random.next() < fresnel::transmittance(eta, out) {
                    return (if scattered { weight } else { 0.0 }, flights);
                }
                way -= 2.0 * cosine * normal;
                continue;
            }
            place += path * way;
            weight *= albedo;
            scattered = true;
            if weight < 0.125 {
                if random.next() > 0.5 {
                    return (0.0, flights);
                }
                weight *= 2.0;
            }
            let (z, turn) = (2.0 * random.next() - 1.0, TAU * random.next());
            let across = (1.0 - z * z).sqrt();
            way = DVec3::new(across * turn.cos(), across * turn.sin(), z);
        }
        (0.0, flights)
    }
}

/// The median.
fn middle(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    values[values.len() / 2]
}

fn run() -> Result<()> {
    let device = Device::best()?;
    println!(
        "{}",
        device.as_ref().map_or("no usable Vulkan device".into(), |d| format!("{}, {}", d.name(), d.driver()))
    );
    let named: Vec<String> = std::env::args().skip(1).filter(|argument| !argument.starts_with("--")).collect();
    let names = if named.is_empty() { vec!["sphere".to_string()] } else { named };
    println!(
        "{:<20} {:<10} {:>14} {:>10} {:>9} {:>9}",
        "scene", "walk", "photons / s", "/ native", "left %", "flights"
    );
    for name in &names {
        let sun = "light=[{ type = 'directional', direction = [0, 0, 1], irradiance = 1, shadows = false }]";
        let mut sets = vec![sun.to_string(), "object.0.material.preset=marble".into(), "object.0.size=20".into()];
        sets.extend((name == "sphere").then(|| "object.0.detail=3".to_string()));
        sets.push(format!("transport.walks={PHOTONS}"));
        let scene = Scene::load_with(name, &sets)?;
        let material = &scene.objects[0].material;
        let options = Options { transport: ShadingMethod::Walk, goal: Goal::Radiosity, ..Options::default() };
        let mut sessions = Vec::new();
        for own in device.iter().map(Some).chain([None]) {
            let mut session = Session::new(&scene, own, options)?;
            session.frame(Change::EVERYTHING)?;
            sessions.push((if own.is_some() { "device" } else { "CPU" }, session, Vec::new()));
        }
        let light = sessions[0].1.faces()?.iter().map(|face| face.area * face.irradiance[1]).collect();
        let body = Body::new(&scene, light, DVec3::Z);
        let media = [0, 1, 2].map(|c| (material.sigma_s_prime[c], material.sigma_a[c], material.eta[c]));
        let (mut native, mut left, mut flights) = (Vec::new(), 0.0, 0);
        for turn in 0..TURNS {
            let begin = Instant::now();
            let parts: Vec<(f64, u64)> = (0..3 * PHOTONS / 100)
                .into_par_iter()
                .map(|part| {
                    let mut random = Random(part.wrapping_mul(0xd134_2543_de82_ef95) ^ turn as u64);
                    let walk = |_| body.photon(media[part as usize % 3], &mut random);
                    (0..100).map(walk).fold((0.0, 0), |sum, one| (sum.0 + one.0, sum.1 + one.1))
                })
                .collect();
            native.push(3.0 * PHOTONS as f64 / begin.elapsed().as_secs_f64());
            left += parts.iter().map(|part| part.0).sum::<f64>() / (3 * PHOTONS * TURNS as u64) as f64;
            flights += parts.iter().map(|part| part.1).sum::<u64>();
            for (_, session, rates) in &mut sessions {
                session.frame(Change::LIGHT)?;
                rates.push(3.0 * PHOTONS as f64 / session.walk_reports()[0].seconds);
            }
        }
        let native = middle(native);
        let flights = flights as f64 / (3 * PHOTONS * TURNS as u64) as f64;
        println!("{name:<20} {:<10} {native:>14.3e} {:>10.2} {:>9.2} {flights:>9.1}", "native", 1.0, 100.0 * left);
        for (about, session, rates) in sessions {
            let rate = middle(rates);
            let left = session.walk_reports()[0].left.iter().sum::<f64>() / 3.0;
            println!("{name:<20} {about:<10} {rate:>14.3e} {:>10.2} {:>9.2}", rate / native, 100.0 * left);
        }
    }
    Ok(())
}

fn main() {
    if let Err(error) = run() {
        eprintln!("{error}");
        std::process::exit(error.exit_code().into());
    }
}
