//! Light arriving at the surface, and how much of it passes the boundary.

pub mod boundary;
pub mod environment;
pub mod fresnel;
pub mod harmonics;
pub mod irradiance;
pub mod leaving;
pub mod opaque_faces;
pub mod pixel_light;
pub mod shadow;
pub mod sky;
pub mod texture;
pub mod texture_in;
