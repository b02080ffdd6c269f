//! A seeded population of triangles and receivers, with an individual medium in every channel.

pub mod seeded;

use glam::{DQuat, DVec3};
use milkglass::internals::dipole::profile::Dipole;
use milkglass::measure::stress::factor::Pair;
use milkglass::scene::PRESETS;

use seeded::Seeded;

/// A medium whose sigma_tr times `length` is log-uniform from 1e-4 to 1e4: a channel of a measured material, or any
/// albedo and index.
pub fn medium(random: &mut Seeded, length: f64) -> [f64; 3] {
    let channel = (random.bits() % 3) as usize;
    let [s, a, eta] = if random.bits().is_multiple_of(2) {
        let preset = &PRESETS[(random.bits() % PRESETS.len() as u64) as usize];
        [preset.sigma_s_prime[channel], preset.sigma_a[channel], preset.eta]
    } else {
        let absorbed = random.log_between(1e-5, 1.0);
        [1.0 - absorbed, absorbed, random.between(0.5, 3.0)]
    };
    // Without absorption, the mean free path is scaled instead.
    let sigma = Dipole::new(s, a, 1.0).sigma;
    let scale = random.log_between(1e-4, 1e4) / (length * if sigma > 0.0 { sigma } else { s });
    [s * scale, a * scale, eta]
}

/// A triangle whose longest edge is about 1, from well shaped to a width of 1e-4.
fn triangle(random: &mut Seeded) -> [DVec3; 3] {
    let width = if random.bits().is_multiple_of(2) { random.between(0.3, 1.0) } else { random.log_between(1e-4, 1.0) };
    let turn = DQuat::from_axis_angle(random.direction(), random.between(0.0, 6.0));
    let offset = 3.0 * random.direction();
    [[0.0, 0.0], [1.0, 0.0], [random.between(0.0, 1.0), width]].map(|[x, y]| turn * DVec3::new(x, y, 0.0) + offset)
}

/// A receiver above, below or in the plane, at a point inside, on an edge, at a vertex or beside the triangle; or
/// anywhere up to ten thousand edge lengths away.
fn receiver(random: &mut Seeded, [a, b, c]: [DVec3; 3], length: f64) -> DVec3 {
    let normal = (b - a).cross(c - a).normalize();
    let (u, v) = (random.between(0.0, 1.0), random.between(0.0, 1.0));
    let base = match random.bits() % 5 {
        0 => a + (b - a) * u.min(1.0 - v) + (c - a) * v.min(1.0 - u).min(1.0 - u.min(1.0 - v)),
        1 => a + (c - a) * u,
        2 => b,
        3 => a + (b - a) * (4.0 * u - 1.5) + (b - a).cross(normal) * (4.0 * v - 2.0),
        _ => return a + length * random.log_between(0.1, 1e4) * random.direction(),
    };
    let height = if random.bits().is_multiple_of(3) { 0.0 } else { length * random.log_between(1e-6, 1e2) };
    base + if random.bits().is_multiple_of(2) { height } else { -height } * normal
}

/// Length of the longest edge.
pub fn longest([a, b, c]: [DVec3; 3]) -> f64 {
    a.distance(b).max(b.distance(c)).max(c.distance(a))
}

/// `count` triangles, each with a receiver and three media.
pub fn population(seed: u64, count: usize) -> Vec<Pair> {
    let mut random = Seeded(seed);
    let pair = |_| {
        let triangle = triangle(&mut random);
        let length = longest(triangle);
        let point = receiver(&mut random, triangle, length);
        Pair { triangle, point, media: [0; 3].map(|_| medium(&mut random, length)) }
    };
    (0..count).map(pair).collect()
}

/// Per channel, the distance from the nearer source to the triangle's plane, in longest edges; radial distances.
pub fn heights(pair: &Pair) -> [f64; 3] {
    let [a, b, c] = pair.triangle;
    let delta = (b - a).cross(c - a).normalize().dot(pair.point - a);
    pair.dipoles().map(|dipole| delta.hypot(dipole.z_real) / longest(pair.triangle))
}
