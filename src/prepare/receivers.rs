//! Where light is evaluated: whether radiosity is computed at triangles and interpolated between vertices, or at the
//! points that the pixels show. By default whichever are fewer.

use super::coarse::Long;
use crate::scene::{Object, Receivers, Scene, Scheme};
use crate::state::LitAt;
use crate::state::options::{Goal, Options, ShadingMethod};

/// Whether the receivers are pixels, and the reason.
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
            return (false, "only --transport hierarchy has blocks of them".into());
        }
        _ if transport.scheme == Scheme::Links => return (false, "scheme links knows triangles only".into()),
        Receivers::Faces => return (false, "transport.receivers is faces".into()),
        Receivers::Pixels => return (true, "transport.receivers is pixels".into()),
        Receivers::Auto => format!("a picture takes {pixels} samples of pixels, the objects have {faces} triangles"),
    };
    if pixels < faces {
        return (true, why);
    }
    // Long triangles of an object that deforms are not divided.
    let long = |(number, object): (usize, &Object)| {
        let long = !object.deforms.is_empty() && Long::of(&object.mesh, &object.material).is_some();
        long.then(|| format!("object {number} deforms and has triangles that are too long to be receivers"))
    };
    scene.objects.iter().enumerate().find_map(long).map_or((false, why), |why| (true, why))
}

/// Whether opaque objects are lit at triangles, at pixels, or both.
#[must_use]
pub fn lit_at(scene: &Scene, options: Options) -> LitAt {
    match options.goal {
        Goal::Radiosity => LitAt::Faces,
        _ if scene.transport.receivers == Receivers::Faces => LitAt::Faces,
        Goal::Picture => LitAt::Pixels,
        Goal::Layers => LitAt::Both,
    }
}
