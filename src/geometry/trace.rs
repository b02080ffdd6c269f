//! The nearest triangle along a ray, by the tree: a decision, so it is `f32` additions, multiplications and
//! comparisons only, in the same order as `glsl/geometry/trace.glsl`, and the two agree bit for bit.

use crate::layout::Buffers;

/// In place of a triangle where a driver has cut the walk short: lavapipe ends an invocation's loops, silently, after
/// 65,535 iterations all together.
pub const UNFINISHED: u32 = 0xffff_fffe;

/// What a ray met first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Nearest {
    /// The triangle, or all ones.
    pub face: u32,
    /// Signed volumes of the ray with the triangle's edges; barycentric once divided by their sum.
    pub weights: [f32; 3],
    /// Distance along the ray is `numerator / denominator`, in multiples of its direction.
    pub numerator: f32,
    /// Always positive.
    pub denominator: f32,
}

pub(super) fn dot(a: [f32; 3], b: [f32; 3]) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub(super) fn cross(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub(super) fn minus(a: [f32; 3], b: [f32; 3]) -> [f32; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// Whether the half line may meet the box before the nearest hit: separating axes, with a margin above rounding.
pub(super) fn meets(
    low: [f32; 3],
    high: [f32; 3],
    origin: [f32; 3],
    direction: [f32; 3],
    dd: f32,
    nearest: &Nearest,
) -> bool {
    let each = |f: &dyn Fn(usize) -> f32| [f(0), f(1), f(2)];
    let c = each(&|k| 0.5 * (low[k] + high[k]) - origin[k]);
    let margin = 1e-6 * (1.0 + c[0].abs() + c[1].abs() + c[2].abs());
    let h = each(&|k| 0.5 * (high[k] - low[k]) * 1.00001 + margin);
    let d = direction.map(f32::abs);
    let side = cross(c, direction).map(f32::abs);
    let reach = [h[1] * d[2] + h[2] * d[1], h[2] * d[0] + h[0] * d[2], h[0] * d[1] + h[1] * d[0]];
    let line = side[0] <= reach[0] && side[1] <= reach[1] && side[2] <= reach[2];
    let (along, half) = (dot(c, direction), dot(h, d));
    let first = (along - half) * nearest.denominator;
    let limit = nearest.numerator * dd;
    line && along + half >= 0.0 && (nearest.face == u32::MAX || first <= limit)
}

/// Follows a ray from `origin` along `direction` (any length) through the trees of all objects.
pub fn trace(data: &Buffers, origin: [f32; 3], direction: [f32; 3]) -> Nearest {
    let mut nearest = Nearest { face: u32::MAX, weights: [0.0; 3], numerator: 0.0, denominator: 1.0 };
    let dd = dot(direction, direction);
    let mut node = 0;
    while let Some(bounds) = data.bounds.get(node) {
        if !meets(bounds.low, bounds.high, origin, direction, dd, &nearest) {
            node = bounds.next as usize;
            continue;
        }
        let Some(corner) = data.triangles.get(bounds.face as usize) else {
            node += 1;
            continue;
        };
        node = bounds.next as usize;

        // The ray's side of each edge, and the plane's distance as a fraction.
        let [a, b, c] = corner.map(|v| minus(data.positions[v as usize], origin));
        let w = [dot(direction, cross(b, c)), dot(direction, cross(c, a)), dot(direction, cross(a, b))];
        let normal = cross(minus(b, a), minus(c, a));
        let (mut numerator, mut denominator) = (dot(a, normal), dot(direction, normal));
        if denominator < 0.0 {
            (numerator, denominator) = (-numerator, -denominator);
        }
        let inside = w.iter().all(|&x| x >= 0.0) || w.iter().all(|&x| x <= 0.0);
        let (mine, its) = (numerator * nearest.denominator, nearest.numerator * denominator);
        let nearer = nearest.face == u32::MAX || mine < its || (mine == its && bounds.face < nearest.face);
        if inside && w[0] + w[1] + w[2] != 0.0 && denominator > 0.0 && numerator > 0.0 && nearer {
            nearest = Nearest { face: bounds.face, weights: w, numerator, denominator };
        }
    }
    nearest
}
