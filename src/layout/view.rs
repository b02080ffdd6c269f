//! The structs of pictures, shared by host and device.

use bytemuck::{Pod, Zeroable};

use super::{Element, Record, Word};

records! { view_records:
    /// The camera: the ray through (x, y) in [-1,1]^2 runs along `forward + x right + y up`, not normalised.
    Camera {
        /// The eye.
        origin: [f32; 3],
        /// Half the picture's width at unit distance.
        right: [f32; 3],
        /// Half the picture's height at unit distance.
        up: [f32; 3],
        /// The unit viewing direction.
        forward: [f32; 3],
        /// Picture width in pixels.
        width: u32,
        /// Picture height in pixels.
        height: u32,
        /// Twice how far to the right of the pixels' centres their rays pass, in pixels.
        shift_x: f32,
        /// Twice how far below.
        shift_y: f32,
        /// Linear radiance where nothing is hit, in the scene's units.
        background: [f32; 3],
        /// Not 0 if the environment is seen instead.
        environment: u32,
        /// Factor from internal radiance to that of the scene's units.
        radiance: f32,
        /// Number of samples a pixel.
        samples: u32,
        /// Share of this frame's sample in the mean so far: 1 for the first, then 1/2, 1/3, ...
        weight: f32,
        /// Which of the samples this frame is, from 0.
        sample_number: u32,
        /// Number of `pixel_lights` that light; the rays of reflections follow them.
        lights: u32,
        /// Words of `pixel_lit` for each pixel: a bit for each of those that casts shadows.
        shadow_words: u32,
    }
    /// What a primary ray hits.
    Hit {
        /// The triangle; `NONE` where the ray meets none, `UNFINISHED` where the driver ended its walk early.
        face: u32,
        /// Barycentric weight of the triangle's second corner.
        u: f32,
        /// Barycentric weight of the triangle's third corner.
        v: f32,
        /// Distance along the ray in multiples of its (unnormalised) direction.
        depth: f32,
    }
}
