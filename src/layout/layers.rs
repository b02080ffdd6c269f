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
        /// How they continue beyond their edges: a `WRAP_`.
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
    /// What scatters light once in an object, in those channels that share an index of refraction; the others have no
    /// `sigma_s`. Per internal length.
    ScatteringMedium {
        /// The object.
        object: u32,
        /// Relative index of refraction.
        eta: f32,
        /// How far beneath the surface light is followed along a view ray.
        reach: f32,
        /// Scattering coefficient.
        sigma_s: [f32; 3],
        /// Extinction coefficient.
        sigma_t: [f32; 3],
        /// Mean cosine of scattering.
        g: [f32; 3],
    }
    /// The refracted view ray beneath the point that a pixel shows, and what was found at its last sample.
    InnerRay {
        /// The unit direction, away from the eye.
        way: [f32; 3],
        /// Where it ends: at the surface, or after the medium's `reach`; 0 if no light comes along it.
        end: f32,
        /// Light that arrives at the last sample, times the phase function, but not attenuated.
        arrived: [f32; 3],
        /// Optical depth of its way there and on to the eye.
        depth: [f32; 3],
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
        /// Centre of the last texel of the margin.
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
