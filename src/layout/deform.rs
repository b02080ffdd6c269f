//! Records of deformations, and of vertices that follow joints.

use bytemuck::{Pod, Zeroable};

use super::{Element, Record, Word};

records! { deform_records:
    /// A deformation of an object's vertices.
    Deform {
        /// Which deformation: a `DEFORM_`.
        kind: u32,
        /// A morph's first element of `morphs`: that of the object's first vertex.
        first: u32,
        /// A point of the axis, a bump's middle, or the noise's origin.
        origin: [f32; 3],
        /// Of length 1: the axis, the direction that is bent, or a bump's.
        axis: [f32; 3],
        /// Of length 1 and across it: where a bend leans to.
        toward: [f32; 3],
        /// Height of the low end along the axis, from `origin`.
        low: f32,
        /// Length from the low end to the high one.
        extent: f32,
        /// Turns a length; or one over a bump's squared radius, or over the size of the noise's features.
        rate: f32,
        /// A bend's radius of curvature, a bump's height, the noise's amplitude, or a morph's weight.
        amount: f32,
    }
    /// A vertex that follows joints.
    SkinVertex {
        /// Its position in the frame in which it is bound.
        base: [f32; 3],
        /// Where the weights of its morph targets begin, from the object's first one.
        row: u32,
    }
    /// A joint that a vertex follows.
    SkinJoint {
        /// Its matrix, from the object's first one.
        matrix: u32,
        /// How much it counts; the sum over the joints of a vertex is 1.
        weight: f32,
    }
    /// The matrix of a joint: to the object's frame from the frame in which vertices are bound.
    SkinMatrix {
        /// The first row.
        x: [f32; 4],
        /// The second row.
        y: [f32; 4],
        /// The third row.
        z: [f32; 4],
    }
}
