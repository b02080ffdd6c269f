//! Random numbers and directions about an axis, in the order of `glsl/geometry/random.glsl`, so that every device finds
//! the same bits. Tests are beside the walk's arithmetic.

use super::deform::turn;
use super::exact::{inverse, root};

/// Four random integers from four integers: pcg4d of Jarzynski and Olano 2020, "Hash Functions for GPU Rendering".
#[must_use]
pub fn random4(a: u32, b: u32, c: u32, d: u32) -> [u32; 4] {
    let [mut x, mut y, mut z, mut w] = [a, b, c, d].map(|n| n.wrapping_mul(1_664_525).wrapping_add(1_013_904_223));
    for round in 0..2 {
        if round == 1 {
            [x, y, z, w] = [x, y, z, w].map(|n| n ^ (n >> 16));
        }
        x = x.wrapping_add(y.wrapping_mul(w));
        y = y.wrapping_add(z.wrapping_mul(x));
        z = z.wrapping_add(x.wrapping_mul(y));
        w = w.wrapping_add(y.wrapping_mul(z));
    }
    [x, y, z, w]
}

/// One of 2^23 numbers in (0, 1).
#[must_use]
pub fn unit_random(bits: u32) -> f32 {
    ((bits >> 9) * 2 + 1) as f32 * (1.0 / 16_777_216.0)
}

/// Two unit vectors across an axis and across each other (Duff et al. 2017).
#[must_use]
pub fn across_axis(axis: [f32; 3]) -> [[f32; 3]; 2] {
    let s = if axis[2] >= 0.0 { 1.0 } else { -1.0 };
    let a = -s * inverse(1.0 + s * axis[2]);
    let b = axis[0] * axis[1] * a;
    [[1.0 + s * axis[0] * axis[0] * a, s * b, -s * axis[0]], [b, s + axis[1] * axis[1] * a, -axis[1]]]
}

/// The direction with this cosine to an axis and this azimuth (in turns) about it.
#[must_use]
pub fn about(axis: [f32; 3], cosine: f32, turns: f32) -> [f32; 3] {
    let [right, up] = across_axis(axis);
    let across = root(1.0 - cosine * cosine);
    let [sine, cos] = turn(turns);
    std::array::from_fn(|k| cosine * axis[k] + across * (cos * right[k] + sine * up[k]))
}
