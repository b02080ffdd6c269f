//! Builds the state that a frame works on from a scene.

pub(crate) mod blocks;
mod borders;
pub(crate) mod camera;
pub(crate) mod coarse;
pub(crate) mod compactness;
pub(crate) mod diffusion;
pub mod diffusion_validity;
pub(crate) mod layers;
pub mod lights;
pub mod material;
pub mod pixel_lights;
pub mod place;
pub(crate) mod reach;
pub mod receivers;
pub(crate) mod rounding;
pub mod scene;
pub mod shading;
pub mod shape;
pub mod single_scattering;
mod skins;
pub mod sky_cells;
pub(crate) mod texture_charts;
pub(crate) mod textures;
pub mod units;
mod wide;
