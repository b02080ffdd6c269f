//! Where a straight line crosses the real surfaces of the scene, in `f64`: the reference of the march follows light
//! along it. Crossings are counted, so that an object that the line leaves and enters again has several parts on it.

use glam::DVec3;

use crate::state::{State, wide};

/// A half line through a scene.
#[derive(Clone, Debug, PartialEq)]
pub struct Way {
    /// Where it lies within the object: from and to these distances, ascending. The first part begins at the point; if
    /// there is none, the point lies outside, or the line never leaves an open surface.
    pub inside: Vec<[f64; 2]>,
    /// Cosine between the line and the normal of the triangle through which the first part ends; 1 without parts.
    pub cosine: f64,
    /// Distance to the first triangle of another object; infinite if there is none.
    pub other: f64,
}

/// The line from `from` along the unit direction `along`, up to the distance `limit`, through the scene that holds the
/// object of this number. The object lies behind its triangles; with `side` -1 in front of them.
pub fn way(state: &State, object: usize, from: DVec3, along: DVec3, side: f64, limit: f64) -> Way {
    // Shifted by far less than the accuracy of positions, so that the line meets no edge of a regular mesh exactly.
    let from = from + DVec3::new(0.61e-10, -0.37e-10, 0.83e-10);
    let data = &state.data;
    let own = state.objects[object].first.faces..state.objects[object].first.faces + state.objects[object].count.faces;
    let (mut crossings, mut other, mut node) = (Vec::new(), f64::INFINITY, 0);
    while let Some(bounds) = data.bounds_in_scene().get(node) {
        if !passes(wide(bounds.low) - from, wide(bounds.high) - from, along) {
            node = bounds.next as usize;
            continue;
        }
        let Some(corners) = data.triangles.get(bounds.face as usize) else {
            node += 1;
            continue;
        };
        node = bounds.next as usize;
        let corners = corners.map(|v| wide(data.in_scene()[v as usize]) - from);
        let Some((t, out)) = crossing(corners, along) else { continue };
        match own.contains(&(bounds.face as usize)) {
            true => crossings.push((t, out * side, corners)),
            false if t < limit => other = other.min(t),
            false => {}
        }
    }
    crossings.sort_by(|a, b| a.0.total_cmp(&b.0));
    // How many times the object encloses the point: each exit beyond the last entry is an enclosure.
    let mut depth: f64 = crossings.iter().map(|(_, out, _)| out).sum();
    let (mut inside, mut cosine, mut entered) = (Vec::new(), 1.0, (depth > 0.5).then_some(0.0));
    for (t, out, [a, b, c]) in crossings {
        if entered.is_some() != (depth - out > 0.5) {
            match entered.take() {
                Some(begin) if begin < limit => {
                    if inside.is_empty() {
                        cosine = (b - a).cross(c - a).normalize_or_zero().dot(along).abs();
                    }
                    inside.push([begin, t.min(limit)]);
                }
                Some(_) => {}
                None => entered = Some(t),
            }
        }
        depth -= out;
    }
    if inside.first().is_some_and(|[begin, _]| *begin > 0.0) {
        (inside, cosine) = (Vec::new(), 1.0);
    }
    Way { inside, cosine, other }
}

/// Whether the half line from the origin may meet a box: with a margin for rounding.
fn passes(low: DVec3, high: DVec3, along: DVec3) -> bool {
    let (mut near, mut far) = (0.0, f64::INFINITY);
    for k in 0..3 {
        let (low, high) = (low[k] - 1e-9, high[k] + 1e-9);
        if along[k] == 0.0 {
            if low > 0.0 || high < 0.0 {
                return false;
            }
            continue;
        }
        let (a, b) = (low / along[k], high / along[k]);
        (near, far) = (f64::max(near, a.min(b)), f64::min(far, a.max(b)));
    }
    near <= far + 1e-9
}

/// Distance to where the half line from the origin passes a triangle, and 1 if it passes along the normal, -1 if
/// against it. The volumes that the line spans with the common edge of two triangles are each other's negative to the
/// last bit, so that it passes one of the two.
fn crossing([a, b, c]: [DVec3; 3], along: DVec3) -> Option<(f64, f64)> {
    let volumes = [along.dot(b.cross(c)), along.dot(c.cross(a)), along.dot(a.cross(b))];
    let out = if volumes.iter().all(|&v| v > 0.0) {
        1.0
    } else if volumes.iter().all(|&v| v < 0.0) {
        -1.0
    } else {
        return None;
    };
    let sum: f64 = volumes.iter().sum();
    let t = [a, b, c].iter().zip(volumes).map(|(corner, v)| corner.dot(along) * v / sum).sum::<f64>();
    (t > 0.0).then_some((t, out))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_passes_a_triangle_from_either_side_and_not_behind_it() {
        let triangle = [[-1.0, -1.0, 2.0], [2.0, -1.0, 2.0], [-1.0, 2.0, 2.0]].map(DVec3::from_array);
        let [a, b, c] = triangle;
        let along = DVec3::new(0.1, 0.05, 1.0).normalize();
        let (t, out) = crossing(triangle, along).unwrap();
        assert!((t * along.z - 2.0).abs() < 1e-12 && out == 1.0, "{t} {out}");
        assert_eq!(crossing([a, c, b], along).map(|(_, out)| out), Some(-1.0));
        assert_eq!(crossing(triangle, -along), None);
        assert_eq!(crossing(triangle, DVec3::new(2.0, 0.0, 1.0).normalize()), None);
        assert!(passes(DVec3::splat(1.0), DVec3::splat(2.0), DVec3::splat(3f64.sqrt().recip())));
        assert!(!passes(DVec3::splat(1.0), DVec3::splat(2.0), DVec3::new(-0.6, 0.8, 0.0)));
        assert!(!passes(DVec3::splat(1.0), DVec3::splat(2.0), DVec3::X));
    }
}
