//! Rejects objects that are too small beside their scene: a frame spans the whole scene, with the precision of `f32`.

use super::mesh::Mesh;
use super::object::Object;
use super::range::Checked;
use crate::error::Input;
use glam::DVec3;

/// The maximum number of mean free paths across the scene; denser materials are reduced to it.
pub const DENSEST: f64 = 1e6;
/// Maximum ratio of the scene's extent to an object's size: `f32` resolves positions to about 2^-24 of the scene, which
/// at this ratio is a hundredth of the object.
const WIDEST: f64 = 1e5;
/// The same for materials denser than [`DENSEST`], whose mean free path then grows with the scene: to at most a
/// ten-thousandth of the object.
const WIDEST_DENSE: f64 = 1e2;

/// Returns an error if an object is too small beside the whole scene.
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
            let why = if dense { " with a material as dense as that" } else { "" };
            let fault = fault.found(format!("{size:.4e} in a scene {extent:.4e} across"));
            return Err(fault.expected(format!("at most {most:e} times its size{why}")));
        }
    }
    Ok(())
}

/// The square root of a surface's area, or the longest of two edges of each triangle if that is longer. Unlike the
/// bounding box, neither depends on a speck far away.
fn size(mesh: &Mesh) -> f64 {
    // Relative to the bounding box, since fourth powers of small lengths underflow to 0.
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
