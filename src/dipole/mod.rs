//! The dipole of Mertens et al. 2003, Table 1: its profile, and the form factors of triangles under it.
//!
//! Plain mathematics in `f64`, below every transport that uses it; its counterpart in the shaders is `glsl/dipole`.

pub mod derivatives;
pub mod form_factor;
pub mod profile;

/// Squared distance, summed from x to z in `f32`, because decisions use it: the same bits as `distance2` in
/// `near.glsl`.
pub fn distance2(a: [f32; 3], b: [f32; 3]) -> f32 {
    let d = [a[0] - b[0], a[1] - b[1], a[2] - b[2]];
    d[0] * d[0] + d[1] * d[1] + d[2] * d[2]
}
