//! Whether radiosity is computed at the triangles and blended between their vertices, or at the very places that the
//! pixels show: whichever are fewer, unless the scene says.

use crate::scene::{Receivers, Scene, Scheme};
use crate::state::LitAt;
use crate::state::options::{Goal, Options, ShadingMethod};

/// Whether the receivers are the pixels, and why.
#[must_use]
pub fn by_pixel(scene: &Scene, options: Options) -> (bool, String) {
    let transport = &scene.transport;
    let faces: usize =
        scene.objects.iter().filter(|o| o.material.opaque.is_none()).map(|o| o.mesh.triangles.len()).sum();
    let [width, height] = scene.camera.size.map(|n| n as usize);
    let pixels = width * height * scene.camera.samples as usize;
    let why = match transport.receivers {
        _ if options.goal == Goal::Radiosity => return (false, "no picture is asked for".into()),
        _ if options.transport.is_local() => return (false, "no light is carried to any".into()),
        _ if options.transport != ShadingMethod::Hierarchy => {
            return (false, "only the hierarchy has blocks of them".into());
        }
        _ if transport.scheme == Scheme::Links => return (false, "scheme links knows triangles only".into()),
        Receivers::Faces => return (false, "transport.receivers is faces".into()),
        Receivers::Pixels => return (true, "transport.receivers is pixels".into()),
        Receivers::Auto => format!("a picture takes {pixels} samples of pixels, the objects have {faces} triangles"),
    };
    (pixels < faces, why)
}

/// Where light that arrives at opaque objects is looked at.
#[must_use]
pub fn lit_at(scene: &Scene, options: Options) -> LitAt {
    match options.goal {
        Goal::Radiosity => LitAt::Faces,
        _ if scene.transport.receivers == Receivers::Faces => LitAt::Faces,
        Goal::Picture => LitAt::Pixels,
        Goal::Layers => LitAt::Both,
    }
}
