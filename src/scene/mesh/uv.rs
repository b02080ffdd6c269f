//! Texture coordinates of the built-in shapes.

use super::{Mesh, Shape};
use glam::DVec3;
use std::f64::consts::{PI, TAU};

/// Texture coordinates of each corner of a shape as it is built.
///
/// Sphere: longitude to the right, latitude upwards; the middle of the texture is at +z, its left and right edges meet
/// at -z. Lotus, candle and bust: the angle around the axis in the same way, and the height. Slab and cube: each side
/// has its own copy, with the longest side across the whole texture, upright as seen from outside where that has a
/// meaning. Plane and bump: seen from above, +x to the right, -z upwards; the gecko likewise, repeated four times over
/// its length. Torus: seen from +z. Fish: seen from its side, +x to the right.
pub(super) fn of_shape(shape: Shape, mesh: &Mesh) -> Vec<[[f64; 2]; 3]> {
    let (low, high) = mesh.bounds();
    let corners = (0..mesh.triangles.len()).filter_map(|face| mesh.corners(face));
    let place = |corners: [DVec3; 3]| match shape {
        Shape::Sphere => around(corners, |p| 0.5 + p.y.clamp(-1.0, 1.0).asin() / PI),
        Shape::Lotus | Shape::Candle | Shape::Bust => around(corners, |p| (p.y - low.y) / (high.y - low.y)),
        Shape::Plane | Shape::Bump => corners.map(|p| [p.x + 0.5, 0.5 - p.z]),
        Shape::Slab | Shape::Cube => planar(corners),
        Shape::Torus => corners.map(|p| [0.5 + p.x / 2.8, 0.5 + p.y / 2.8]),
        Shape::Fish => corners.map(|p| [p.x + 0.5, p.y + 0.5]),
        Shape::Gecko => corners.map(|p| [4.0 * p.x + 2.0, 2.0 - 4.0 * p.z]),
    };
    corners.map(place).collect()
}

/// Cylindrical, about the y axis. A triangle across the seam continues beyond 1; a corner on the axis gets the mean of
/// the others.
fn around(corners: [DVec3; 3], height: impl Fn(DVec3) -> f64) -> [[f64; 2]; 3] {
    let on_axis = |p: DVec3| p.x.hypot(p.z) < 1e-9;
    let turns = corners.map(|p| if on_axis(p) { f64::NAN } else { 0.5 + p.x.atan2(p.z) / TAU });
    let most = turns.into_iter().fold(0.0, f64::max);
    let turns = turns.map(|turn| if most - turn > 0.5 { turn + 1.0 } else { turn });
    let known = turns.into_iter().filter(|turn| !turn.is_nan());
    let (sum, count) = known.fold((0.0, 0.0), |(sum, count), turn| (sum + turn, count + 1.0));
    let turns = turns.map(|turn| if turn.is_nan() { sum / f64::max(count, 1.0) } else { turn });
    std::array::from_fn(|k| [turns[k], height(corners[k])])
}

/// Planar, on the side of a box that contains the triangle.
fn planar(corners: [DVec3; 3]) -> [[f64; 2]; 3] {
    let [a, b, c] = corners;
    let normal = (b - a).cross(c - a);
    let size = normal.abs();
    corners.map(|p| {
        let [u, v] = match size.max_element() {
            x if x == size.x => [-p.z * normal.x.signum(), p.y],
            y if y == size.y => [p.x, -p.z * normal.y.signum()],
            _ => [p.x * normal.z.signum(), p.y],
        };
        [u + 0.5, v + 0.5]
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_triangle_of_a_ball_spans_the_texture() {
        let ball = Shape::Sphere.build_textured(3);
        let uvs = ball.uvs.as_ref().expect("places");
        assert_eq!(uvs.len(), ball.triangles.len());
        let mut crossing = 0;
        for (face, places) in uvs.iter().enumerate() {
            let corners = ball.corners(face).expect("a triangle");
            for ([u, v], p) in places.iter().zip(corners) {
                assert!((p.y - (PI * (v - 0.5)).sin()).abs() < 1e-12);
                let round = (TAU * (u - 0.5)).sin_cos();
                let across = p.x.hypot(p.z);
                assert!(
                    across < 1e-9 || ((p.x - across * round.0).abs() < 1e-9 && (p.z - across * round.1).abs() < 1e-9)
                );
            }
            let us = places.map(|[u, _]| u);
            let span = us.into_iter().fold(0.0, f64::max) - us.into_iter().fold(2.0, f64::min);
            // A triangle at a pole spans much of the circle; elsewhere a few degrees.
            let steep = corners.iter().any(|p| p.x.hypot(p.z) < 0.3);
            assert!(span < if steep { 0.5 } else { 0.12 }, "{span} {corners:?}");
            crossing += usize::from(us.iter().any(|u| *u > 1.0));
        }
        assert!(crossing > 8, "{crossing}");
    }

    #[test]
    fn the_sides_of_a_slab_are_flat_and_not_mirrored() {
        let slab = Shape::Slab.build_textured(5);
        for (face, [a, b, c]) in slab.uvs.as_ref().expect("places").iter().enumerate() {
            let turned = (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]);
            let [p, q, r] = slab.corners(face).expect("a triangle");
            assert!((turned - (q - p).cross(r - p).length()).abs() < 1e-12, "{face}");
            assert!([a, b, c].into_iter().flatten().all(|x| (-1e-12..=1.0 + 1e-12).contains(x)));
        }
    }
}
