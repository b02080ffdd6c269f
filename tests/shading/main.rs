//! What a camera sees: objects, textures, pixels, and local shading.

#[path = "../devices/mod.rs"]
mod devices;
#[path = "../shell/mod.rs"]
mod shell;

mod curvature;
mod local;
mod looks;
mod objects;
mod occlusion;
mod opaque;
mod pixels;
mod texture_blur;
mod textures;
