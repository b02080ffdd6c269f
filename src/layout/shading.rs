//! The structs of local shading, shared by host and device.

use bytemuck::{Pod, Zeroable};

use super::{Element, Record, Word};

records! { local_records:
    /// How a surface bends at a vertex, 1/length; positive where it is convex.
    Curvature {
        /// kappa, as `object_params.kappa` defines it, at least 0.
        kappa: f32,
        /// Mean curvature H = (k1 + k2) / 2.
        mean: f32,
        /// Gaussian curvature K = k1 k2.
        gaussian: f32,
        /// Mixed area around the vertex that they are means over; 0 if they are the mean of the neighbours'.
        area: f32,
    }
    /// Curvature measures of a cluster.
    CurvatureSum {
        /// Sum of mixed areas.
        area: f32,
        /// Integral of mean curvature over it, length.
        mean: f32,
        /// Integral of Gaussian curvature over it, radian^2.
        gaussian: f32,
    }
    /// An object whose light is blurred over its texture coordinates.
    Unwrapping {
        /// The object.
        object: u32,
        /// Its first texel in `texel_hits`, and in each sheet.
        first: u32,
        /// Texels a side.
        side: u32,
        /// Not 0 if the surface continues beyond the right edge at the left one, and beyond the bottom at the top.
        round: [u32; 2],
    }
    /// What a texel shows of an unwrapped surface.
    TexelHit {
        /// The triangle, or `NONE`.
        face: u32,
        /// Weight of its second corner.
        u: f32,
        /// Weight of its third corner.
        v: f32,
    }
}
