//! The structs of layers beneath a surface, shared by host and device.

use bytemuck::{Pod, Zeroable};

use super::{Element, Record, Word};

records! { layer_records:
    /// The layers of one object. Lengths are internal.
    Layering {
        /// The object.
        object: u32,
        /// Its first layer in `layer_media`.
        first_layer: u32,
        /// Number of its layers, 1 to `MOST_LAYERS`.
        layers: u32,
        /// Its first entry in `islands`, `NONE` if its triangles are placed by `corner_uvs`.
        first_island: u32,
        /// Its first texel in `depths`.
        first_texel: u32,
        /// Width and height of its depth maps, in texels.
        size: [u32; 2],
        /// What they are beyond their edges: a `WRAP_`.
        wrap: u32,
        /// Steps along a ray.
        samples: u32,
        /// The greatest depth of the last layer's lower interface.
        deepest: f32,
        /// How long a ray is followed at most.
        reach: f32,
        /// Not 0 if light is summed by the left rule.
        paper: u32,
        /// Not 0 if phase functions are Henyey and Greenstein's, 0 if Schlick's.
        henyey: u32,
        /// Not 0 if light is multiplied by the Fresnel transmittance where it enters and leaves.
        fresnel: u32,
    }
    /// A layer, per internal length.
    Layer {
        /// Scattering coefficient.
        sigma_s: [f32; 3],
        /// Extinction coefficient.
        sigma_t: [f32; 3],
        /// The phase function's parameter.
        g: f32,
    }
    /// The places of a triangle's corners in depth maps laid out by islands, in texels: (0, 0) is the first texel's
    /// centre.
    Island {
        /// First corner.
        a: [f32; 2],
        /// Second corner.
        b: [f32; 2],
        /// Third corner.
        c: [f32; 2],
        /// Centre of the first texel of its island's margin; whole numbers.
        low: [f32; 2],
        /// Centre of the last one.
        high: [f32; 2],
    }
    /// The vertices of a cluster; each vertex belongs to the first triangle around it.
    VertexMoments {
        /// Their number.
        count: f32,
        /// Their centroid.
        center: [f32; 3],
        /// Sum of squares about it: xx, yy, zz.
        diagonal: [f32; 3],
        /// Sum of products about it: yz, zx, xy.
        mixed: [f32; 3],
    }
}
