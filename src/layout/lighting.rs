//! The structs of light arriving, shared by host and device.

use bytemuck::{Pod, Zeroable};

use super::{Element, Record, Word};

records! { light_records:
    /// A light, one sample of a light that has an area, or one ray to the environment. Directions point towards it.
    Light {
        /// Which kind of light: a `LIGHT_`.
        kind: u32,
        /// The unit direction towards the light, or its position.
        place: [f32; 3],
        /// Irradiance on a perpendicular plane, or intensity along the axis; scaled so that the brightest face has
        /// about 1.
        color: [f32; 3],
        /// The unit direction in which a spot or a sample of an area shines.
        axis: [f32; 3],
        /// Spot: 1 - cos of the angle within which all its intensity arrives.
        inner: f32,
        /// Spot: 1 - cos of the angle outside which nothing arrives. Sun of an environment: 1 - cos of its radius.
        outer: f32,
        /// The number of its bit in `lit`, or `pixel_lit`; `NONE` if it casts no shadow.
        shadow: u32,
        /// One edge of an area of which each pixel sees another point; `place` is its centre.
        edge_u: [f32; 3],
        /// The other edge of the area.
        edge_v: [f32; 3],
        /// Which of its light's points, or rays to the environment, of one sample of a pixel this is.
        number: u32,
        /// How many of them there are.
        of: u32,
    }
    /// The texture coordinates of a triangle's corners: (0, 0) is the texture's upper left corner, (1, 1) its lower
    /// right one. If the texture repeats, whole repetitions are taken off, so that the least is from 0 to 1, or to 2 if
    /// mirrored.
    CornerUvs {
        /// First corner.
        a: [f32; 2],
        /// Second corner.
        b: [f32; 2],
        /// Third corner.
        c: [f32; 2],
    }
    /// The faces and the light of one dispatch of shadow rays.
    Rays {
        /// The faces' object.
        object: u32,
        /// First face, among those of all objects.
        first: u32,
        /// Number of faces.
        count: u32,
        /// The light.
        light: u32,
    }
    /// A cell of the octahedral map of directions, from which rays to where the environment is bright are drawn: by the
    /// alias method, with whole numbers.
    SkyCell {
        /// Of 65,536 draws of this cell, those that it keeps.
        kept: u32,
        /// The cell that takes the others.
        other: u32,
        /// The density of its draws on the map: the probability divided by the area.
        density: f32,
    }
    /// Integrals over the polar angle t of one row of the environment's image, times sin t.
    SkyRow {
        /// Of 1, cos t, sin t.
        first: [f32; 3],
        /// Of cos t squared, sin t cos t, sin t squared.
        second: [f32; 3],
    }
    /// Integrals over the azimuth a of one column of the environment's image.
    SkyColumn {
        /// Of 1, sin a, -cos a: x and z of the direction.
        first: [f32; 3],
        /// Of -sin a cos a and sin a squared - cos a squared: xz and xx - zz.
        second: [f32; 2],
    }
}
