//! Light arriving at the surface, and how much of it passes the boundary.

pub mod entry;
pub mod environment;
pub mod fresnel;
pub mod harmonics;
pub mod irradiance;
pub mod opaque;
pub mod shadow;
pub mod sky;
pub mod texture;
