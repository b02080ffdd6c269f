//! What a camera sees: objects, textures, pixels, and local shading.

mod curvature;
mod local;
mod looks;
mod objects;
mod occlusion;
mod opaque;
mod pixels;
mod texture_blur;
mod textures;
