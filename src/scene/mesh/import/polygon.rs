//! Cuts polygons into triangles: convex ones into the fan about their first corner, all others by ear clipping.

use crate::scene::mesh::clean::is_sliver;
use earcut::Earcut;
use glam::DVec3;

/// A corner turns the wrong way if the sine of its angle is below this, negated.
const STRAIGHT: f64 = 1e-7;
/// A polygon with more corners becomes a fan: the crate's lists hold no more.
const MOST: usize = 1 << 24;

/// Cuts one polygon after another.
#[derive(Default)]
pub(super) struct Cutter {
    ears: Earcut<f64>,
    /// The polygon in its plane, beginning with the corner of the least coordinates.
    flat: Vec<[f64; 2]>,
    numbers: Vec<u32>,
    /// The corners' places.
    places: Vec<DVec3>,
    triangles: Vec<[u32; 3]>,
}

impl Cutter {
    /// The triangles of a polygon with corners at these places, as numbers of its corners; none below three corners.
    /// They turn as the polygon does.
    pub fn cut(&mut self, places: impl Iterator<Item = DVec3>) -> &[[u32; 3]] {
        self.places.clear();
        self.places.extend(places);
        self.triangles.clear();
        if self.places.len() > 3 && self.places.len() <= MOST {
            let normal = normal(&self.places);
            if normal != DVec3::ZERO && !has_fan(&self.places, normal) {
                self.clip(normal);
            }
        }
        // Ear clipping finds no triangle in a polygon without an inside.
        if self.triangles.is_empty() {
            self.triangles.extend((2..self.places.len() as u32).map(|corner| [0, corner - 1, corner]));
        }
        &self.triangles
    }

    /// Ear clipping in the plane of the two axes across which the polygon is largest.
    fn clip(&mut self, normal: DVec3) {
        let (places, count) = (&self.places, self.places.len());
        let size = normal.abs();
        let axis = (0..3).fold(0, |most, axis| if size[axis] > size[most] { axis } else { most });
        let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];

        // The corner of the least coordinates is first, so that the file's first corner does not matter.
        let key = |corner: usize| [corner, corner + 1].map(|corner| places[corner % count].to_array());
        let order = |a: &usize, b: &usize| key(*a).partial_cmp(&key(*b)).unwrap_or(std::cmp::Ordering::Equal);
        let first = (0..count).min_by(order).unwrap_or(0);
        self.flat.clear();
        self.flat.extend((first..first + count).map(|corner| [places[corner % count][u], places[corner % count][v]]));
        self.ears.earcut_slice(&self.flat, &[], &mut self.numbers);

        for ear in self.numbers.as_chunks().0 {
            let [a, b, c] = ear.map(|corner: u32| (corner + first as u32) % count as u32);
            let [p, q, r] = [a, b, c].map(|corner| places[corner as usize]);
            let turned = (q - p).cross(r - p).dot(normal) < 0.0;
            self.triangles.push(if turned { [a, c, b] } else { [a, b, c] });
        }
    }
}

/// The unit normal of a polygon by its projected areas (Newell); 0 if it has none.
fn normal(places: &[DVec3]) -> DVec3 {
    let pairs = places.windows(2).map(|pair| (pair[0] - places[0]).cross(pair[1] - places[0]));
    pairs.sum::<DVec3>().normalize_or_zero()
}

/// Whether the fan about the first corner is as good as any: the polygon is convex, and the fan leaves no corner aside.
fn has_fan(places: &[DVec3], normal: DVec3) -> bool {
    let at = |corner: usize| places[corner % places.len()];
    let turns = (0..places.len()).all(|corner| {
        let (before, after) = (at(corner + 1) - at(corner), at(corner + 2) - at(corner + 1));
        before.cross(after).dot(normal) >= -STRAIGHT * before.length() * after.length()
    });
    turns
        && (2..places.len()).all(|corner| {
            let [a, b, c] = [places[0], places[corner - 1], places[corner]];
            // A corner that the file repeats leaves out a triangle without leaving out a corner.
            a == b || b == c || c == a || !is_sliver([a, b, c]) && (b - a).cross(c - a).dot(normal) > 0.0
        })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn cut(places: &[DVec3]) -> Vec<[u32; 3]> {
        Cutter::default().cut(places.iter().copied()).to_vec()
    }

    /// The sum of the triangles' areas, each counted along the polygon's normal.
    fn area(places: &[DVec3], triangles: &[[u32; 3]]) -> f64 {
        let of = |corners: &[u32; 3]| {
            let [a, b, c] = corners.map(|corner| places[corner as usize]);
            (b - a).cross(c - a).dot(normal(places)) / 2.0
        };
        triangles.iter().map(of).sum()
    }

    /// A polygon in the xy-plane, turned out of it.
    fn tilted(places: &[[f64; 2]]) -> Vec<DVec3> {
        let turn = glam::DQuat::from_euler(glam::EulerRot::XYZ, 0.7, -0.4, 0.3);
        places.iter().map(|&[x, y]| turn * DVec3::new(x, y, 0.0) + DVec3::splat(3.0)).collect()
    }

    const L: [[f64; 2]; 6] = [[2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0], [0.0, 0.0], [2.0, 0.0]];

    #[test]
    fn convex_polygons_stay_fans() {
        let circle = |count: u32| -> Vec<[f64; 2]> {
            (0..count).map(|k| (f64::from(k) / f64::from(count) * std::f64::consts::TAU).sin_cos().into()).collect()
        };
        for count in [3, 4, 5, 17, 1000] {
            let fan: Vec<[u32; 3]> = (2..count).map(|corner| [0, corner - 1, corner]).collect();
            assert_eq!(cut(&tilted(&circle(count))), fan);
        }
        let bent = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.4], [1.0, 1.0, 0.0], [0.0, 1.0, 0.4]].map(DVec3::from_array);
        assert_eq!(cut(&bent), [[0, 1, 2], [0, 2, 3]]);
        // A corner twice.
        let twice = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [0.0, 1.0]];
        assert_eq!(cut(&tilted(&twice)), [[0, 1, 2], [0, 2, 3]]);
    }

    #[test]
    fn concave_polygons_have_their_area_whatever_their_first_corner() {
        let star: Vec<[f64; 2]> = (0..10)
            .map(|k| (std::f64::consts::PI / 5.0 * f64::from(k)).sin_cos())
            .zip([2.0, 0.5].into_iter().cycle())
            .map(|((y, x), radius)| [radius * x, radius * y])
            .collect();
        let of_star = 10.0 * 0.5 * 2.0 * 0.5 * (std::f64::consts::PI / 5.0).sin();
        for (shape, expected) in [(&L[..], 3.0), (&star[..], of_star)] {
            let mut found = Vec::new();
            for first in 0..shape.len() {
                for reversed in [false, true] {
                    let mut turned = shape.to_vec();
                    turned.rotate_left(first);
                    if reversed {
                        turned.reverse();
                    }
                    let places = tilted(&turned);
                    let triangles = cut(&places);
                    assert_eq!(triangles.len(), shape.len() - 2);
                    assert!((area(&places, &triangles) - expected).abs() < 1e-12, "{first}: {triangles:?}");
                    let whole = triangles.iter().map(|corners| {
                        let [a, b, c] = corners.map(|corner| places[corner as usize]);
                        (b - a).cross(c - a).length() / 2.0
                    });
                    assert!((whole.sum::<f64>() - expected).abs() < 1e-12, "they do not overlap");
                    let mut same: Vec<_> = triangles
                        .iter()
                        .map(|corners| corners.map(|corner| places[corner as usize].to_array().map(f64::to_bits)))
                        .collect();
                    same.iter_mut().for_each(|corners| corners.sort_unstable());
                    same.sort_unstable();
                    if !reversed {
                        found.push(same);
                    }
                }
            }
            assert!(found.windows(2).all(|pair| pair[0] == pair[1]), "the same triangles");
        }
    }

    #[test]
    fn a_corner_on_an_edge_is_not_left_aside() {
        // Fans about the first corner of these have a triangle without area.
        let square = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [2.0, 2.0], [0.0, 2.0]];
        let places = square.map(|[x, y]| DVec3::new(x, y, 0.0));
        let triangles = cut(&places);
        assert_eq!(triangles.len(), 3);
        assert!((area(&places, &triangles) - 4.0).abs() < 1e-12);
        assert!(triangles.iter().all(|corners| !is_sliver(corners.map(|corner| places[corner as usize]))));
    }

    #[test]
    fn what_is_no_polygon_still_has_triangles() {
        let crossed = [[0.0, 0.0], [1.0, 1.0], [1.0, 0.0], [0.0, 1.0]];
        let line = [[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [3.0, 0.0]];
        let pentagram: Vec<[f64; 2]> =
            (0..5).map(|k| (f64::from(k) * 0.8 * std::f64::consts::PI).sin_cos().into()).collect();
        let point = [[1.0, 1.0]; 5];
        for shape in [&crossed[..], &line, &pentagram, &point] {
            assert!(!cut(&tilted(shape)).is_empty(), "{shape:?}");
        }
        for few in 0..3 {
            assert!(cut(&tilted(&L[..few])).is_empty());
        }
        let folded = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1e-9, 0.0], [1.0, 0.0, 5.0]].map(DVec3::from_array);
        assert!(!cut(&folded).is_empty());
    }

    #[test]
    fn a_polygon_of_many_corners_takes_no_time() {
        let gear: Vec<[f64; 2]> = (0..60_000)
            .map(|k| {
                let (sine, cosine) = (f64::from(k) / 60_000.0 * std::f64::consts::TAU).sin_cos();
                let radius = if k % 2 == 0 { 1.0 } else { 0.99 };
                [radius * sine, radius * cosine]
            })
            .collect();
        assert_eq!(cut(&tilted(&gear)).len(), 59_998);
    }

    proptest! {
        #[test]
        fn any_corners_are_cut_without_a_panic(
            raw in prop::collection::vec([-3i8..4, -3i8..4, -1i8..2], 0..40),
            scale in prop::sample::select(vec![1e-320, 1e-160, 1e-30, 1.0, 1e30]),
        ) {
            let places: Vec<DVec3> =
                raw.iter().map(|p| DVec3::from_array(p.map(|x| f64::from(x) * 0.1 * scale))).collect();
            let triangles = cut(&places);
            prop_assert!(triangles.iter().flatten().all(|&corner| (corner as usize) < places.len()));
            prop_assert_eq!(triangles.is_empty(), places.len() < 3);
            prop_assert!(triangles.len() <= places.len().saturating_sub(2));
        }
    }
}
