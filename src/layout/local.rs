//! The structs of local shading, shared by host and device.

use bytemuck::{Pod, Zeroable};

use super::{Element, Record, Word};

records! { local_records:
    /// How a surface bends at a vertex, 1/length; positive where it is convex.
    Curvature {
        /// kappa, as `frame.kappa` says; at least 0.
        kappa: f32,
        /// Mean curvature H = (k1 + k2) / 2.
        mean: f32,
        /// Gaussian curvature K = k1 k2.
        gaussian: f32,
        /// 1 where it follows from the triangles round the vertex, 0 where it is the mean of the neighbours'.
        known: f32,
    }
}
