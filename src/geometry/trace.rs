//! Finds the nearest triangle along a ray by the tree: a decision, so it is `f32` additions, multiplications and
//! comparisons only, in the same order as `glsl/geometry/trace.glsl`, and the two agree bit for bit. Which of two hits
//! is nearer is decided exactly.

use crate::layout::{Buffers, NONE};

pub use crate::layout::UNFINISHED;

/// The first hit of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    /// The triangle, or [`NONE`].
    pub face: u32,
    /// Edge functions of the triangle at the ray; barycentric coordinates once divided by their sum.
    pub weights: [f32; 3],
    /// Distance along the ray is `numerator / denominator`, in multiples of its direction.
    pub numerator: f32,
    /// Always positive.
    pub denominator: f32,
}

pub(crate) fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(crate) fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(crate) fn minus(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// A ray's direction, and two axes across it.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Sight {
    pub along: [f32; 3],
    right: [f32; 3],
    up: [f32; 3],
    /// The power of two that scales the direction to `along`, whose largest component is 1 to 2.
    pub scale: f32,
    /// Square of the length of `along`.
    pub square: f32,
}

impl Sight {
    /// The sight of a ray along `direction`, of any length.
    pub fn new(direction: [f32; 3]) -> Self {
        let m = direction.map(f32::abs);
        let largest = m[0].max(m[1].max(m[2]));
        let scale = f32::from_bits(0x7f00_0000 - (largest.to_bits() & 0x7f80_0000));
        let along = direction.map(|x| scale * x);
        let [x, y, z] = along;
        let (right, up) = if m[2] >= m[0].max(m[1]) {
            ([z, 0.0, -x], [0.0, z, -y])
        } else {
            ([-y, x, 0.0], if m[0] >= m[1] { [-z, 0.0, x] } else { [0.0, -z, y] })
        };
        Self { along, right, up, scale, square: dot(along, along) }
    }

    /// Where the ray hits a triangle, whose corners are relative to the ray's origin: the distance is
    /// `numerator / (denominator * square)`, in multiples of `along`.
    ///
    /// Each corner's coordinates across the ray are rounded once, the same for all triangles around it, and the sign
    /// of a difference of two products of such coordinates is never wrong, at worst 0: no ray slips between
    /// triangles, nor past a corner that many share.
    pub fn pierce(&self, corners: [[f32; 3]; 3]) -> Option<Nearest> {
        let coordinates = |axis| [dot(axis, corners[0]), dot(axis, corners[1]), dot(axis, corners[2])];
        let (x, y, z) = (coordinates(self.right), coordinates(self.up), coordinates(self.along));
        let w = [x[1] * y[2] - y[1] * x[2], x[2] * y[0] - y[2] * x[0], x[0] * y[1] - y[0] * x[1]];
        let inside = w.iter().all(|&x| x >= 0.0) || w.iter().all(|&x| x <= 0.0);
        let (sum, away) = (w[0] + w[1] + w[2], dot(w, z));
        let numerator = if sum < 0.0 { -away } else { away };
        (inside && sum != 0.0).then_some(Nearest { face: 0, weights: w, numerator, denominator: sum.abs() })
    }
}

/// Whether the half line may meet the box before the nearest hit: separating axes, with a margin larger than
/// rounding.
pub(crate) fn meets(low: [f32; 3], high: [f32; 3], origin: [f32; 3], ray: &Sight, nearest: &Nearest) -> bool {
    let each = |f: &dyn Fn(usize) -> f32| [f(0), f(1), f(2)];
    let abs = |[x, y, z]: [f32; 3]| [x.abs(), y.abs(), z.abs()];
    let c = each(&|k| 0.5 * (low[k] + high[k]) - origin[k]);
    let margin = 1e-6 * (1.0 + c[0].abs() + c[1].abs() + c[2].abs());
    let h = each(&|k| 0.5 * (high[k] - low[k]) * 1.00001 + margin);
    let d = abs(ray.along);
    let side = abs(cross(c, ray.along));
    let reach = [h[1] * d[2] + h[2] * d[1], h[2] * d[0] + h[0] * d[2], h[0] * d[1] + h[1] * d[0]];
    let line = side[0] <= reach[0] && side[1] <= reach[1] && side[2] <= reach[2];
    let (along, half) = (dot(c, ray.along), dot(h, d));
    let first = (along - half) * nearest.denominator;
    line && along + half >= 0.0 && (nearest.face == NONE || first <= nearest.numerator)
}

/// Whether the half line from `origin` along `direction` may meet a box.
#[must_use]
pub fn may_meet(low: [f32; 3], high: [f32; 3], origin: [f32; 3], direction: [f32; 3]) -> bool {
    let nothing = Nearest { face: NONE, weights: [0.0; 3], numerator: 0.0, denominator: 1.0 };
    meets(low, high, origin, &Sight::new(direction), &nothing)
}

/// Follows a ray from `origin` along `direction` (any length) through the trees of all objects.
pub fn trace(data: &Buffers, origin: [f32; 3], direction: [f32; 3]) -> Nearest {
    let mut nearest = Nearest { face: NONE, weights: [0.0; 3], numerator: 0.0, denominator: 1.0 };
    let ray = Sight::new(direction);
    let mut node = 0;
    let (boxes, positions) = (data.bounds_in_scene(), data.in_scene());
    while let Some(bounds) = boxes.get(node) {
        if !meets(bounds.low, bounds.high, origin, &ray, &nearest) {
            node = bounds.next as usize;
            continue;
        }
        let Some(corner) = data.triangles.get(bounds.face as usize) else {
            node += 1;
            continue;
        };
        node = bounds.next as usize;
        let Some(found) = ray.pierce(corner.map(|v| minus(positions[v as usize], origin))) else { continue };
        // Products of two singles are exact in `f64`, so the order in which triangles come does not matter.
        let product = |a: f32, b: f32| f64::from(a) * f64::from(b);
        let (mine, its) =
            (product(found.numerator, nearest.denominator), product(nearest.numerator, found.denominator));
        let nearer = nearest.face == NONE || mine < its || (mine == its && bounds.face < nearest.face);
        if found.numerator > 0.0 && nearer {
            nearest = Nearest { face: bounds.face, ..found };
        }
    }
    nearest.numerator *= ray.scale;
    nearest.denominator *= ray.square;
    nearest
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::layout::Bounds;

    /// Triangles in this order, each in a box of its own.
    fn listed(positions: &[[f32; 3]], triangles: &[[u32; 3]], order: &[u32]) -> Buffers {
        let all = |f: fn(f32, f32) -> f32, [a, b]: [[f32; 3]; 2]| std::array::from_fn(|k| f(a[k], b[k]));
        let leaf = |(place, &face): (usize, &u32)| {
            let corners = triangles[face as usize].map(|v| positions[v as usize]);
            let merge = |f| corners.into_iter().reduce(|a, b| all(f, [a, b])).unwrap();
            Bounds { low: merge(f32::min), next: place as u32 + 1, high: merge(f32::max), face }
        };
        Buffers {
            positions: positions.to_vec(),
            triangles: triangles.to_vec(),
            bounds: order.iter().enumerate().map(leaf).collect(),
            ..Buffers::default()
        }
    }

    #[test]
    fn the_order_of_triangles_does_not_matter() {
        // Three sheets through a point, so steep that the distances at which rays near it hit them round alike.
        let (mut random, mut close) = (1u32, 0);
        let mut next = || {
            random = random.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            (random >> 8) as f32 / (1 << 24) as f32 - 0.5
        };
        for _ in 0..3_000 {
            let center = [next(), next(), next()];
            let mut positions = vec![center];
            positions.extend((0..6).map(|_| [center[0] + 1e-6 * next(), center[1] + next(), center[2] + next()]));
            let triangles = [[0, 1, 2], [0, 3, 4], [0, 5, 6]];
            let eye = [-2.0, next(), next()];
            let direction = minus(center, eye);
            let orders = [[0, 1, 2], [0, 2, 1], [1, 0, 2], [1, 2, 0], [2, 0, 1], [2, 1, 0]];
            let found = orders.map(|order| trace(&listed(&positions, &triangles, &order), eye, direction));
            close += usize::from(found[0].face != NONE);
            assert!(found.iter().all(|one| *one == found[0]), "{positions:?} {eye:?}: {found:?}");
        }
        assert!(close > 500, "{close} rays hit");
    }
}
