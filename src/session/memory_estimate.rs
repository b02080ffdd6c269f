//! An estimate of a session's memory, so that a scene that needs too much is refused before anything is allocated.

use crate::error::{Input, Result};
use crate::prepare::lights::with_sun;
use crate::scene::{Light, Scene};
use crate::state::options::{Goal, Options, ShadingMethod};

/// Bytes per triangle, with its part of the tree, its light and its lists, on the host and on a device that shares
/// its memory: two million take 2.4 GB.
const TRIANGLE: u64 = 1200;
/// Bytes per pixel, with its layers.
const PIXEL: u64 = 160;
/// Bytes per texel of transport texture-blur.
const TEXEL: u64 = 200;

/// An error if a session of this scene would not fit the remaining memory.
pub(crate) fn check(scene: &Scene, options: Options) -> Result<()> {
    let triangles: u64 = scene.objects.iter().map(|object| object.mesh.triangles.len() as u64).sum();
    let rays: u64 = with_sun(&scene.lights).iter().map(|light| Light::samples(light) as u64).sum();
    let [width, height] = if options.goal == Goal::Radiosity { [0, 0] } else { scene.camera.size.map(u64::from) };
    let blurred = if options.transport == ShadingMethod::TextureBlur { scene.objects.len() as u64 } else { 0 };
    let texels = blurred * u64::from(scene.transport.blur_texture).pow(2);
    let bytes = triangles * (TRIANGLE + rays / 8) + width * height * (PIXEL + rays / 8) + texels * TEXEL;
    scene.memory.need(bytes).map_err(|error| {
        let what = format!("{}: a frame does not fit the memory", scene.name);
        let found = format!("{triangles} triangles, {width} x {height} pixels, {texels} texels: {error}");
        Input::new(what).found(found).expected("fewer of them, or a larger --limit-memory").into()
    })
}
