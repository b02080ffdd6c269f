//! Extreme cases of single form factors: position of the point, shape of the triangle, medium.

use glam::DVec3;

use super::factor::{Media, Pair};
use super::meshes::turn;
use super::{Case, Kind, ZERO, within};

/// Ordinary media for a triangle of about unit size: with and without absorption, dense and thin.
const ORDINARY: [Media; 2] =
    [[[3.0, 0.01, 1.3], [30.0, 3.0, 1.5], [0.3, 0.03, 1.1]], [[3.0, 0.0, 1.3], [100.0, 0.0, 1.5], [0.01, 0.0, 1.3]]];
/// Mean free paths of a millionth of the triangle's size.
const DENSE: [Media; 1] = [[[1e6, 1e3, 1.3], [1e6, 0.0, 1.5], [1e6, 1e6, 1.3]]];
/// Mean free paths of a million times the triangle's size.
const THIN: [Media; 1] = [[[1e-6, 1e-9, 1.3], [1e-6, 0.0, 1.5], [1e-6, 1e-6, 1.3]]];

/// A well-shaped triangle, and one a thousand times as long as wide.
const SHAPES: [[[f64; 2]; 3]; 2] = [[[0.0, 0.0], [1.0, 0.1], [0.3, 0.9]], [[0.0, 0.0], [1.0, 0.0], [0.4, 1e-3]]];

/// The point with these barycentric weights.
fn at(triangle: &[DVec3; 3], weights: [f64; 3]) -> DVec3 {
    weights[0] * triangle[0] + weights[1] * triangle[1] + weights[2] * triangle[2]
}

/// Rotates and moves a planar triangle so that no coordinate is a round number.
fn placed(flat: [[f64; 2]; 3]) -> [DVec3; 3] {
    flat.map(|[x, y]| turn(DVec3::new(x, y, 0.0)) + DVec3::new(0.313, -0.771, 0.119))
}

/// Barycentric weights of a point, and an offset in the triangle's frame, z along its normal.
type Place = ([f64; 3], [f64; 3]);

/// All combinations of shapes, points and media.
fn pairs(shapes: &[[[f64; 2]; 3]], points: &[Place], media: &[Media]) -> Vec<Pair> {
    let mut list = Vec::new();
    for &shape in shapes {
        let triangle = placed(shape);
        for &(weights, offset) in points {
            let point = at(&triangle, weights) + turn(DVec3::from_array(offset));
            list.extend(media.iter().map(|&media| Pair { triangle, point, media }));
        }
    }
    list
}

const INSIDE: [Place; 3] =
    [([1.0 / 3.0, 1.0 / 3.0, 1.0 / 3.0], [0.0; 3]), ([0.2, 0.5, 0.3], [0.0; 3]), ([0.01, 0.01, 0.98], [0.0; 3])];
const EDGE: [Place; 3] = [([0.3, 0.7, 0.0], [0.0; 3]), ([0.0, 0.5, 0.5], [0.0; 3]), ([0.9, 0.0, 0.1], [0.0; 3])];
const VERTEX: [Place; 3] = [([1.0, 0.0, 0.0], [0.0; 3]), ([0.0, 1.0, 0.0], [0.0; 3]), ([0.0, 0.0, 1.0], [0.0; 3])];
const OFF: [Place; 5] = [
    ([0.3, 0.7 + 1e-7, -1e-7], [0.0; 3]),
    ([0.3, 0.7 - 1e-7, 1e-7], [0.0; 3]),
    ([0.3, 0.3, 0.4], [0.0, 0.0, 1e-7]),
    ([0.3, 0.7, 0.0], [0.0, 0.0, -1e-7]),
    ([1.0 + 2e-7, -1e-7, -1e-7], [0.0; 3]),
];

/// The reason of the cases at ordinary distances.
const NEAR_REASON: &str = "rounding of f32 alone with 12 nodes an edge; 6 nodes, as brute force takes, add up to 3e-6";

/// Extreme receivers, shapes and media.
pub(super) static CASES: &[Case] = &[
    Case {
        name: "form factor, inside a triangle",
        fallback: "none: the edge form has no branch for inside, edge and vertex",
        bound: within(4e-7, 1e-6),
        brute: within(2e-6, 1e-5),
        reason: NEAR_REASON,
        kind: Kind::Factors(|| pairs(&SHAPES, &INSIDE, &ORDINARY)),
    },
    Case {
        name: "form factor, on an edge",
        fallback: "none: an edge through the foot adds exactly nothing",
        bound: within(5e-7, 1.5e-6),
        brute: within(8e-7, 3e-6),
        reason: NEAR_REASON,
        kind: Kind::Factors(|| pairs(&SHAPES, &EDGE, &ORDINARY)),
    },
    Case {
        name: "form factor, on a vertex",
        fallback: "none: the two edges through the foot add exactly nothing",
        bound: within(3e-7, 1e-6),
        brute: within(8e-7, 5e-6),
        reason: NEAR_REASON,
        kind: Kind::Factors(|| pairs(&SHAPES, &VERTEX, &ORDINARY)),
    },
    Case {
        name: "form factor, 1e-7 off",
        fallback: "none: the form factor is continuous there",
        bound: within(4e-7, 2e-6),
        brute: within(8e-7, 3e-6),
        reason: NEAR_REASON,
        kind: Kind::Factors(|| pairs(&SHAPES, &OFF, &ORDINARY)),
    },
    Case {
        name: "form factor, sliver of 1e-6",
        fallback: "what cancels to below 0 counts as 0, within rounding of the truth; beyond chi = 1e-3 one sample",
        bound: within(3e-7, 1e-6),
        brute: within(3e-7, 1.5e-6),
        reason: "its edges cancel to 1e-6 of themselves, the rounding of each stays: 2^-24 of R_full, a few times",
        kind: Kind::Factors(|| {
            let shapes = [[[0.0, 0.0], [1.0, 0.0], [0.4, 1e-6]], [[0.0, 0.0], [1.0, 0.0], [1.0, 1e-6]]];
            let points = [
                ([0.3, 0.3, 0.4], [0.0; 3]),
                ([0.5, 0.5, 0.0], [0.0; 3]),
                ([1.0, 0.0, 0.0], [0.0; 3]),
                ([0.3, 0.3, 0.4], [0.0, 0.0, 0.3]),
                ([0.3, 0.3, 0.4], [0.0, 0.4, 0.0]),
                ([3.0, -2.0, 0.0], [0.0; 3]),
            ];
            pairs(&shapes, &points, &ORDINARY)
        }),
    },
    Case {
        name: "form factor, zero area",
        fallback: "it is 0: a triangle without area has no normal and no edges that count",
        bound: within(1.5e-8, 5e-8),
        brute: ZERO,
        reason: "a line askew may gain an area of 2^-24 of its length squared when its corners are rounded to f32",
        kind: Kind::Factors(|| {
            let mut list = Vec::new();
            for corners in [[[0.3; 3]; 3], [[0.0; 3], [1.0, 0.0, 0.0], [1.0, 0.0, 0.0]], [[0.0; 3], [1.0; 3], [2.0; 3]]]
            {
                let triangle = corners.map(DVec3::from_array);
                for point in [triangle[0], DVec3::new(0.2, 0.1, 0.7)] {
                    list.extend(ORDINARY.iter().map(|&media| Pair { triangle, point, media }));
                }
            }
            list
        }),
    },
    Case {
        name: "form factor, 1e6 triangles away",
        fallback: "beyond chi = 1e-3 one sample with its second moment: the edges would cancel to nothing",
        bound: within(5e-16, 1e-15),
        brute: within(4e-16, 8e-16),
        reason: "F is below 2e-14 of R_full; rounding corners to 2^-24 of the distance is 6 % of the triangle",
        kind: Kind::Factors(|| {
            pairs(
                &SHAPES[..1],
                &[([0.3, 0.3, 0.4], [0.0, 0.0, 1e6]), ([0.3, 0.3, 0.4], [8e5, 6e5, 0.0])],
                &[ORDINARY[1], THIN[0]],
            )
        }),
    },
    Case {
        name: "form factor, mean free path 1e-6 of the triangle, inside",
        fallback: "none; a mean free path is 16 steps of f32 at the size of the triangle",
        bound: within(3e-4, 1e-3),
        brute: within(3e-4, 8e-4),
        reason: "rounding the corners to 2^-24 of the triangle moves the point by 0.06 mean free paths from the plane",
        kind: Kind::Factors(|| pairs(&SHAPES[..1], &INSIDE, &DENSE)),
    },
    Case {
        name: "form factor, mean free path 1e-6 of the triangle, on an edge or vertex",
        fallback: "none; a mean free path is 16 steps of f32 at the size of the triangle",
        bound: within(2e-2, 8e-2),
        brute: within(2e-2, 6e-2),
        reason: "rounding moves an edge by up to 0.1 mean free paths, over which F changes by half of that share",
        kind: Kind::Factors(|| {
            let mut list = pairs(&SHAPES[..1], &EDGE, &DENSE);
            list.extend(pairs(&SHAPES[..1], &VERTEX, &DENSE));
            list
        }),
    },
    Case {
        name: "form factor, mean free path 1e6 of the triangle",
        fallback: "none",
        bound: within(1.5e-19, 4e-19),
        brute: within(1.5e-19, 3e-19),
        reason: "F is below 1e-13 of R_full",
        kind: Kind::Factors(|| {
            let points: Vec<_> = INSIDE.into_iter().chain(EDGE).chain(VERTEX).collect();
            pairs(&SHAPES, &points, &THIN)
        }),
    },
    Case {
        name: "form factor, alpha' 0",
        fallback: "it is 0: what is absorbed at once does not come back",
        bound: ZERO,
        brute: ZERO,
        reason: "the strength alpha' / (4 pi) is 0",
        kind: Kind::Factors(|| pairs(&SHAPES, &INSIDE, &[[[0.0, 3.0, 1.3], [0.0, 1e-6, 1.5], [0.0, 1e6, 1.0]]])),
    },
    Case {
        name: "form factor, alpha' 1-1e-9, and sigma_a of 1e6 sigma_s'",
        fallback: "none",
        bound: within(2e-7, 5e-7),
        brute: within(3e-7, 1e-6),
        reason: NEAR_REASON,
        kind: Kind::Factors(|| {
            let media = [[[3.0, 3e-9, 1.3], [30.0, 3e-8, 1.0], [3e-6, 3.0, 1.3]]];
            let points: Vec<_> = INSIDE.into_iter().chain(EDGE).collect();
            pairs(&SHAPES, &points, &media)
        }),
    },
    Case {
        name: "form factor, eta 0.7, 1, 1.0001, 2.4 and 4",
        fallback: "none: F_int is a closed form with a series near 1; below 1 the sides swap",
        bound: within(3e-7, 1e-6),
        brute: within(5e-7, 1.5e-6),
        reason: NEAR_REASON,
        kind: Kind::Factors(|| {
            let media = [0.7, 1.0, 1.0001, 2.4, 4.0].map(|eta| [[3.0, 0.01, eta], [30.0, 1.0, eta], [1.0, 0.0, eta]]);
            pairs(&SHAPES, &[INSIDE[1], EDGE[0]], &media)
        }),
    },
];
