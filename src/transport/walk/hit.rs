//! Where a photon's flight meets the surface of its object, in step with `glsl/transport/walk/hit.glsl`: decisions,
//! bit for bit.

use crate::geometry::trace::{Nearest, Sight, cross, dot, meets, minus};
use crate::layout::{Buffers, NONE, UNFINISHED, WALK_MARGIN};

/// A flight's end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Meeting {
    /// Inside the medium.
    Free,
    /// At a triangle that is passed inward: the flight came out through a hole, or the surface overlaps itself.
    Lost,
    /// On this triangle of the object, with these weights of its corners, not normalised.
    At(usize, [f32; 3]),
}

/// From `origin` along the unit `way` for a distance of `path`. A triangle is passed outward where its normal is along
/// the way. Rounding may put the origin just outside: triangles that are passed outward count from a little below it,
/// others from a little above, and are no way out. A flat triangle is not met by a flight `from` it.
pub(crate) fn meeting(data: &Buffers, origin: [f32; 3], way: [f32; 3], path: f32, from: u32) -> Meeting {
    let params = &data.object_params[0];
    let ray = Sight::new(way);
    let m = ray.along.map(f32::abs);
    let main = if m[2] >= m[0].max(m[1]) {
        ray.along[2]
    } else if m[0] >= m[1] {
        ray.along[0]
    } else {
        ray.along[1]
    };
    let mut nearest =
        Nearest { face: UNFINISHED, weights: [0.0; 3], numerator: ray.square * path, denominator: ray.scale };
    let (mut way_out, mut node) = (true, 0);
    while node < params.nodes {
        let bounds = &data.bounds[node as usize];
        let met = meets(bounds.low, bounds.high, origin, &ray, &nearest);
        if met && bounds.face == NONE {
            node += 1;
            continue;
        }
        node = bounds.next - params.first_node;
        if !met {
            continue;
        }
        let face = bounds.face - params.first_face;
        if face == from {
            continue;
        }
        let corners = data.triangles[face as usize].map(|v| data.positions[v as usize]);
        let Some(found) = ray.pierce(corners.map(|corner| minus(corner, origin))) else { continue };
        let outward = (found.weights[0] + found.weights[1] + found.weights[2] > 0.0) == (main > 0.0);
        let (mine, its) = (found.numerator * nearest.denominator, nearest.numerator * found.denominator);
        // Of two at the same distance, as at an edge, a way out counts, else the lower number.
        let better = if outward == way_out { bounds.face < nearest.face } else { outward };
        // The origin's depth below the plane, and how much of it rounding explains.
        let normal = cross(minus(corners[1], corners[0]), minus(corners[2], corners[0]));
        let least = WALK_MARGIN * (normal[0].abs() + normal[1].abs() + normal[2].abs());
        let depth = dot(minus(corners[0], origin), normal);
        let counts =
            if outward { found.numerator > 0.0 || depth > -least } else { found.numerator > 0.0 && depth < -least };
        if counts && (mine < its || (mine == its && better)) {
            nearest = Nearest { face: bounds.face, ..found };
            way_out = outward;
        }
    }
    match nearest.face {
        _ if !way_out => Meeting::Lost,
        UNFINISHED => Meeting::Free,
        face => Meeting::At((face - params.first_face) as usize, nearest.weights),
    }
}
