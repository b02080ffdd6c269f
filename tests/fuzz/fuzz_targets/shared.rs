//! What the targets share: a limit on memory that holds for every allocation, and scenes of files in memory.

use cap::Cap;
use milkglass::pipeline::plan::{Change, Options};
use milkglass::session::run::{CapacityHints, Session};
use milkglass::scene::{Files, Scene};

/// What `--limit-memory` would be.
const LIMIT: u64 = 128 << 20;

/// Twice that is refused outright, which ends the run: estimates may be off, but not by so much.
#[global_allocator]
static MEMORY: Cap<std::alloc::System> = Cap::new(std::alloc::System, 256 << 20);

/// Loads a scene whose text names these files; what loads and is small has to be a frame of finite light of at least 0.
pub fn load(text: &str, files: &[(&str, &[u8])]) {
    let held = files.iter().map(|(name, bytes)| ((*name).into(), bytes.to_vec()));
    let Ok(scene) = Scene::parse_from("fuzz.toml", text, &[], &Files::held(held, LIMIT)) else { return };
    let faces: usize = scene.objects.iter().map(|object| object.mesh.triangles.len()).sum();
    let pixels = scene.camera.size[0] * scene.camera.size[1];
    if faces > 64 || pixels > 256 || scene.transport.subdivide > 0 {
        return;
    }
    let Ok(mut session) = Session::new(&scene, None, Options::default(), CapacityHints::default()) else { return };
    if session.frame(Change::EVERYTHING).is_ok() {
        let light = &session.state().data.radiosity;
        assert!(light.iter().flatten().all(|x| *x >= 0.0 && x.is_finite()), "radiosity {light:?}");
    }
}

/// The same of a file that is an environment, a texture, a map of sigma_0 or a map of layers.
#[allow(dead_code, reason = "not every target is of images")]
pub fn image(name: &str, bytes: &[u8]) {
    let ball = "[camera]\nsize = [4, 4]\n[[object]]\nshape = 'sphere'\ndetail = 0\n";
    let layer = "{ sigma_s = 1, sigma_t = 2, g = 0 }";
    let texts = [
        format!("{ball}material = {{ preset = 'marble' }}\n[[light]]\ntype = 'environment'\nimage = '{name}'\n"),
        format!("{ball}material = {{ preset = 'marble', texture = '{name}' }}\n"),
        format!(
            "{ball}material = {{ preset = 'marble' }}\n[object.material.layers]\nmaps = ['{name}']\nscale = 1\nlayer = [{layer}, {layer}]\n"
        ),
    ];
    texts.iter().for_each(|text| load(text, &[(name, bytes)]));
}
