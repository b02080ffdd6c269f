//! The cosine towards the eye at which light leaves, in step with `glsl/lighting/leaving.glsl`.
//!
//! On a coarse mesh, interpolated normals turn edge-on before the silhouette is reached. No light leaves edge-on, so
//! the silhouette would have a dark seam. The cosine is therefore at least that of the triangle's own normal, or
//! [`LEAST_SEEN`] if that is less. On a fine mesh the two normals are nearly the same.

use glam::DVec3;

use crate::geometry::trace::{cross, minus};
use crate::layout::LEAST_SEEN;
use crate::state::wide;

/// The cosine at a point of a triangle with these corners; `normal` is the interpolated one, `eye` the vector to the
/// eye, both of any length. 0 where the normal is 0.
#[must_use]
pub fn seen_cosine(normal: DVec3, eye: DVec3, [a, b, c]: [[f32; 3]; 3]) -> f64 {
    let eye = eye.normalize_or_zero();
    let plain = wide(cross(minus(b, a), minus(c, a))).normalize_or_zero();
    let smooth = normal.normalize_or_zero().dot(eye).abs();
    if normal == DVec3::ZERO { 0.0 } else { smooth.max(plain.dot(eye).abs().min(LEAST_SEEN.into())) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_coarse_silhouette_is_not_dark() {
        // Seen from +z; turned by 60 degrees about x, a triangle has the cosine 0.5.
        let turned = |degrees: f64| {
            let (sine, cosine) = degrees.to_radians().sin_cos();
            let row = |y: f64| [0.0, (y * cosine) as f32, (y * sine) as f32];
            [[0.0; 3], [1.0, 0.0, 0.0], row(1.0)]
        };
        let normal = |degrees: f64| DVec3::new(0.0, -degrees.to_radians().sin(), degrees.to_radians().cos());
        let cosine = |own: f64, shape: f64| seen_cosine(2.0 * normal(own), 3.0 * DVec3::Z, turned(shape));
        let near = |found: f64, expected: f64| assert!((found - expected).abs() < 1e-6, "{found}, {expected}");
        near(cosine(60.0, 60.0), 0.5);
        near(cosine(90.0, 60.0), LEAST_SEEN.into());
        near(cosine(95.0, 89.0), 5f64.to_radians().sin());
        near(cosine(90.0, 89.0), 1f64.to_radians().sin());
        near(seen_cosine(DVec3::Z, DVec3::Z, [[0.0; 3]; 3]), 1.0);
        near(seen_cosine(DVec3::ZERO, DVec3::Z, turned(60.0)), 0.0);
    }
}
