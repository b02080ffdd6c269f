//! Internal units: the scene has unit extent, and the brightest light gives an irradiance of about 1. Both factors
//! are powers of two, so that conversion loses nothing.

use glam::DVec3;

use crate::scene::Mesh;

/// Conversion between internal units and the scene's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Units {
    /// The scene's point at the internal origin.
    pub center: DVec3,
    /// Internal length of one scene unit.
    pub length: f64,
    /// Scene irradiance of an internal irradiance of 1.
    pub light: f64,
}

impl Units {
    /// For these meshes; the light unit is 1.
    #[must_use]
    pub fn of<'a>(meshes: impl Iterator<Item = &'a Mesh> + Clone) -> Self {
        let positions = || meshes.clone().flat_map(|mesh| &mesh.positions).copied();
        let low = positions().fold(DVec3::INFINITY, DVec3::min);
        let high = positions().fold(DVec3::NEG_INFINITY, DVec3::max);
        let extent = (high - low).max_element();
        let length = if extent.is_finite() && extent > 0.0 { (-extent.log2().ceil()).exp2() } else { 1.0 };
        let center = if extent.is_finite() { 0.5 * (low + high) } else { DVec3::ZERO };
        Self { center, length, light: 1.0 }
    }

    /// Converts a point from the scene to internal units.
    #[must_use]
    pub fn inside(&self, point: DVec3) -> DVec3 {
        (point - self.center) * self.length
    }

    /// Converts a point from internal units to the scene.
    #[must_use]
    pub fn outside(&self, point: DVec3) -> DVec3 {
        point / self.length + self.center
    }

    /// Scene radiance of an internal radiance of 1, for pictures. It is limited to 2^126, so that a picture of a lamp
    /// of 1e30 W/sr right at the object is too dark rather than infinite.
    #[must_use]
    pub fn radiance(&self) -> f32 {
        self.light.min(f64::exp2(126.0)) as f32
    }
}
