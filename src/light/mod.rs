//! Light arriving at the surface, and how much of it passes the boundary.

pub mod fresnel;
pub mod irradiance;
