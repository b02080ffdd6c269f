//! The structs of diffusion on the shape, shared by host and device. A field has one value a channel.

use bytemuck::{Pod, Zeroable};

use super::{Element, Record, Word};

/// Elements of the small system of an object, a multiple of 64.
pub const SMALL_SYSTEM: usize = 1152;

records! { diffusion_records:
    /// The first collisions of the light that enters a triangle.
    Deposit {
        /// From the triangle's centroid to their mean place, red.
        red: [f32; 3],
        /// Green.
        green: [f32; 3],
        /// Blue.
        blue: [f32; 3],
        /// Irradiance that is scattered there.
        light: [f32; 3],
    }
    /// Where a cluster's layers are, and the charge of its single layer, per channel.
    LayerPlace {
        /// x of the middle.
        x: [f32; 3],
        /// y of the middle.
        y: [f32; 3],
        /// z of the middle.
        z: [f32; 3],
        /// Sum of b / z_b, b a triangle's value times its area.
        charge: [f32; 3],
    }
    /// First moment of a cluster's layers: sum of b (n + e / z_b), e from the middle.
    LayerFirst {
        /// Along x.
        x: [f32; 3],
        /// Along y.
        y: [f32; 3],
        /// Along z.
        z: [f32; 3],
    }
    /// Second moments of a cluster's layers: sum of b (e n + n e + e e / z_b) / 2; squares, or products.
    LayerSecond {
        /// xx, or yz.
        x: [f32; 3],
        /// yy, or zx.
        y: [f32; 3],
        /// zz, or xy.
        z: [f32; 3],
    }
}
