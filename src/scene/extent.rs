//! Objects that are lost in their scene: a frame is as large as the scene, and `f32` has an end.

use super::mesh::Mesh;
use super::object::Object;
use super::range::Checked;
use crate::error::Input;
use glam::DVec3;

/// The most mean free paths that a frame takes across the scene: anything denser is brought down to that.
pub const DENSEST: f64 = 1e6;
/// How many times an object's size the scene may be: `f32` distinguishes positions to some 2^-24 of the scene, here a
/// hundredth of the object.
const WIDEST: f64 = 1e5;
/// The same where its material is denser than [`DENSEST`], so that its mean free path grows with the scene: to a
/// ten-thousandth of the object at most.
const WIDEST_DENSE: f64 = 1e2;

/// An error where an object is too small beside all of them.
pub(super) fn check(objects: &[Object]) -> Checked<()> {
    let (low, high) = super::bounds(objects);
    let extent = (high - low).max_element();
    for (number, object) in objects.iter().enumerate() {
        let material = &object.material;
        let extinction = |c: usize| material.sigma_s_prime[c] + material.sigma_a[c];
        let dense = material.opaque.is_none() && (0..3).any(|c| extinction(c) * extent > DENSEST);
        let (size, most) = (size(&object.mesh), if dense { WIDEST_DENSE } else { WIDEST });
        if extent > most * size {
            let fault = Input::new("the object is too small beside the whole scene").key(format!("object.{number}"));
            let why = if dense { ": its material is as dense as that" } else { "" };
            let fault = fault.found(format!("{size:.4e} in a scene {extent:.4e} across"));
            return Err(fault.expected(format!("at most {most:e} times its size{why}")));
        }
    }
    Ok(())
}

/// The root of a surface's area, or its longest edge where that is longer: unlike its box they know nothing of a speck
/// far away.
fn size(mesh: &Mesh) -> f64 {
    // Against the box's size, for squares of squares of small lengths are 0.
    let (low, high) = mesh.bounds();
    let whole = (high - low).max_element().max(f64::MIN_POSITIVE);
    let (mut twice, mut longest) = (0.0, 0.0);
    for [a, b, c] in (0..mesh.triangles.len()).filter_map(|face| mesh.corners(face)) {
        let [u, v]: [DVec3; 2] = [b - a, c - a].map(|edge| edge / whole);
        twice += u.cross(v).length();
        longest = f64::max(longest, u.length().max(v.length()));
    }
    f64::max((0.5 * twice).sqrt(), longest) * whole
}
