//! Internal units: the scene has unit extent, and the brightest light gives an irradiance of about 1. Both factors
//! are powers of two, so that conversion loses nothing.

use glam::{DMat3, DQuat, DVec3};

use crate::scene::Object;

/// The middle of an object's bounding box at rest, in its own frame.
fn middle(object: &Object) -> DVec3 {
    let (low, high) = object.mesh.bounds();
    0.5 * (low + high)
}

/// Conversion between internal units and the scene's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Units {
    /// The point at the internal origin, of the scene or of an object's own frame.
    pub center: DVec3,
    /// Internal length of one scene unit.
    pub length: f64,
    /// Scene irradiance of an internal irradiance of 1.
    pub light: f64,
}

impl Units {
    /// For these objects at rest; the light unit is 1. An object that is turned counts as the ball around its bounding
    /// box, so that turning it further changes nothing.
    #[must_use]
    pub fn of(objects: &[Object]) -> Self {
        let boxes = objects.iter().map(|object| {
            let (low, high) = object.mesh.bounds();
            let half = 0.5 * (high - low);
            let half = if object.rotation == DQuat::IDENTITY { half } else { DVec3::splat(half.length()) };
            (object.placed(middle(object)), half)
        });
        let low = boxes.clone().fold(DVec3::INFINITY, |low, (at, half)| low.min(at - half));
        let high = boxes.fold(DVec3::NEG_INFINITY, |high, (at, half)| high.max(at + half));
        let extent = (high - low).max_element();
        let length = if extent.is_finite() && extent > 0.0 { (-extent.log2().ceil()).exp2() } else { 1.0 };
        let center = match objects {
            [only] => only.placed(middle(only)),
            _ => 0.5 * (low + high),
        };
        Self { center: if extent.is_finite() { center } else { DVec3::ZERO }, length, light: 1.0 }
    }

    /// The units of an object's own frame, in which light is carried: centred there, of the scene's length.
    #[must_use]
    pub fn own(&self, object: &Object) -> Self {
        Self { center: middle(object), ..*self }
    }

    /// What turns internal positions of an object's own frame, then shifts them, to the scene's internal positions.
    #[must_use]
    pub fn placement(&self, object: &Object) -> (DMat3, DVec3) {
        (DMat3::from_quat(object.rotation), self.inside(object.placed(middle(object))))
    }

    /// Converts a point from the scene, or from the object's own frame, to internal units.
    #[must_use]
    pub fn inside(&self, point: DVec3) -> DVec3 {
        (point - self.center) * self.length
    }

    /// Converts a point from internal units back.
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
