//! Reference integrals that share only the integrand and the Gauss-Legendre nodes with the code under test.

use glam::DVec3;
use milkglass::internals::dipole::form_factor::gauss::{Node, legendre};
use milkglass::internals::dipole::profile::kernel;

/// `int_low^high f` with 16 nodes per panel; panels double in length, starting with `finest`.
pub fn on_line(low: f64, high: f64, finest: f64, f: impl Fn(f64) -> f64) -> f64 {
    let rule = legendre(16);
    let (mut start, mut step, mut sum) = (low, finest, 0.0);
    while start < high {
        let end = (start + step).min(high);
        let half = 0.5 * (end - start);
        sum += rule.iter().map(|n| half * n.weight * f(start + half * (1.0 + n.x))).sum::<f64>();
        (start, step) = (end, step * 2.0);
    }
    sum
}

/// The integral of `p(s)` over a triangle: bisects longest edges until the kernel is smooth on each piece, then applies
/// a product rule of 8 x 8 nodes.
pub struct Area {
    rule: Vec<Node>,
}

impl Area {
    pub fn new() -> Self {
        Self { rule: legendre(8) }
    }

    /// `s^2 = |x - foot|^2 + h^2`, with the foot in the triangle's plane.
    pub fn integral(&self, triangle: [DVec3; 3], foot: DVec3, h: f64, sigma: f64) -> f64 {
        let mut sum = 0.0;
        let mut open = vec![triangle.map(|corner| corner - foot)];
        while let Some([a, b, c]) = open.pop() {
            let centroid = (a + b + c) / 3.0;
            let radius = [a, b, c].map(|v| v.distance(centroid)).into_iter().fold(0.0, f64::max);
            let s = centroid.length().hypot(h);
            // e^(-sigma s) is negligible here against its value at the nearest point of the plane.
            let faint = sigma * (s - radius - h) > 45.0;
            if radius <= 0.35 * s && (faint || sigma * radius <= 1.5) {
                sum += self.piece([a, b, c], h, sigma);
                continue;
            }
            let sides = [a.distance(b), b.distance(c), c.distance(a)];
            let (p, q, r) = if sides[0] >= sides[1] && sides[0] >= sides[2] {
                (a, b, c)
            } else if sides[1] >= sides[2] {
                (b, c, a)
            } else {
                (c, a, b)
            };
            let middle = 0.5 * (p + q);
            open.extend([[p, middle, r], [middle, q, r]]);
        }
        sum
    }

    fn piece(&self, [a, b, c]: [DVec3; 3], h: f64, sigma: f64) -> f64 {
        let area2 = (b - a).cross(c - a).length();
        let mut sum = 0.0;
        for u in &self.rule {
            let across = 0.5 * (1.0 + u.x);
            let (p, q) = (a.lerp(b, across), a.lerp(c, across));
            for v in &self.rule {
                let x = p.lerp(q, 0.5 * (1.0 + v.x));
                let s = (x.length_squared() + h * h).sqrt();
                sum += 0.25 * u.weight * v.weight * across * kernel(sigma, s);
            }
        }
        area2 * sum
    }
}
