//! The form factor `F = int R_d dA` of a triangle seen from a point: section 4 of Mertens et al. 2003.
//!
//! Three ways to the same number, from expensive to cheap: [`exact`] (reference), [`edge`] (a line integral over
//! three edges), [`points`] (samples on the area); [`ladder`] selects between the last two. [`polygon`] is the form
//! factor of a near-planar cluster, [`uniform`] the method that the paper compares its own with. All are in `f64` and
//! in the caller's unit of length; `F` has no unit and lies in [0, total].

pub mod edge;
pub mod exact;
pub mod footprint;
pub mod gauss;
pub mod ladder;
pub mod points;
pub mod polygon;
pub mod uniform;

use crate::dipole::profile::Dipole;
use glam::DVec3;

/// How the distance between a source and a point of a lit triangle is measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Distance {
    /// `s_j^2 = |x_i - x_o|^2 + z_j^2`: a function of the distance alone. The default.
    Radial,
    /// Table 1 of the paper taken literally: the sources are displaced along the normal of the lit
    /// triangle. Equal to [`Self::Radial`] on a plane only; off it a source may touch the triangle.
    Table1 {
        /// Keep each source at least its depth `z_j` away from the triangle's plane. Without this
        /// the form factor is unbounded on curved meshes.
        clamp: bool,
    },
}

impl Distance {
    /// Heights of the real and the virtual source over the plane of the triangle, at least 0.
    ///
    /// `delta`: signed height of the receiving point over that plane, along its normal.
    #[must_use]
    #[inline]
    pub fn heights(self, delta: f64, dipole: &Dipole) -> [f64; 2] {
        let [z_real, z_virtual] = dipole.depths();
        match self {
            Self::Radial => [delta.hypot(z_real), delta.hypot(z_virtual)],
            Self::Table1 { clamp } => {
                let literal = [(delta + z_real).abs(), (delta - z_virtual).abs()];
                if clamp { [literal[0].max(z_real), literal[1].max(z_virtual)] } else { literal }
            }
        }
    }

    /// Squared distances of the two sources to one point of the triangle's plane.
    ///
    /// `d2`: squared distance of that point to the receiving point. `delta`: as in
    /// [`Self::heights`]; the radial convention does not use it.
    #[must_use]
    #[inline]
    pub fn squared(self, d2: f64, delta: f64, dipole: &Dipole) -> [f64; 2] {
        match self {
            Self::Radial => {
                let [z_real, z_virtual] = dipole.depths();
                [d2 + z_real * z_real, d2 + z_virtual * z_virtual]
            }
            Self::Table1 { .. } => {
                let in_plane = (d2 - delta * delta).max(0.0);
                let [real, virtual_] = self.heights(delta, dipole);
                [real * real + in_plane, virtual_ * virtual_ + in_plane]
            }
        }
    }
}

/// The vector area of a triangle with counter-clockwise corners: normal times area.
#[must_use]
#[inline]
pub fn vector_area(triangle: &[DVec3; 3]) -> DVec3 {
    0.5 * (triangle[1] - triangle[0]).cross(triangle[2] - triangle[0])
}
