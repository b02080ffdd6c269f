//! Roots, quotients and refraction in `f32` additions, multiplications and comparisons, in the order of
//! `glsl/geometry/exact.glsl`, so that every device finds the same bits. Tests are beside the walk's arithmetic.

use super::trace::dot;

/// 1 / x for x above 0, to 1e-7.
#[must_use]
pub fn inverse(x: f32) -> f32 {
    let mut y = f32::from_bits(0x7ef3_11c7u32.wrapping_sub(x.to_bits()));
    for _ in 0..3 {
        y *= 2.0 - x * y;
    }
    y
}

/// Square root, to 2e-7; 0 for numbers up to 1e-30.
#[must_use]
pub fn root(x: f32) -> f32 {
    let h = 0.5 * x;
    let mut y = f32::from_bits(0x5f37_5a86u32.wrapping_sub(x.to_bits() >> 1));
    for _ in 0..3 {
        y *= 1.5 - h * y * y;
    }
    if x > 1e-30 { x * y } else { 0.0 }
}

/// A vector scaled to unit length.
#[must_use]
pub fn unit(v: [f32; 3]) -> [f32; 3] {
    let by = inverse(root(dot(v, v)));
    v.map(|x| x * by)
}

/// A vector of nearly unit length, brought nearer to it.
#[must_use]
pub fn kept_unit(v: [f32; 3]) -> [f32; 3] {
    let by = 1.5 - 0.5 * dot(v, v);
    v.map(|x| x * by)
}

/// The cosine inside for one outside; 0 where nothing passes.
#[must_use]
pub fn inside(eta: f32, outer: f32) -> f32 {
    if eta == 1.0 { outer } else { root(1.0 - (1.0 - outer * outer) * inverse(eta * eta)) }
}

/// The direction inside of light from `toward`; both unit, `normal` out of the medium.
#[must_use]
pub fn refracted(eta: f32, toward: [f32; 3], normal: [f32; 3]) -> [f32; 3] {
    let outer = dot(toward, normal);
    let by = if eta == 1.0 { 1.0 } else { inverse(eta) };
    let along = outer * by - inside(eta, outer);
    kept_unit(kept_unit(std::array::from_fn(|k| along * normal[k] - by * toward[k])))
}
