//! Shared by the targets: a limit on all allocated memory, and scenes loaded from files in memory.

use cap::Cap;
use milkglass::internals::pipeline::plan::{Change, Options};
use milkglass::internals::session::run::Session;
use milkglass::scene::{Files, Scene};

/// Stands for the value of `--limit-memory`.
const LIMIT: u64 = 128 << 20;

/// The allocator fails beyond twice the limit, which ends the run: memory estimates may be off by less than that.
#[global_allocator]
static MEMORY: Cap<std::alloc::System> = Cap::new(std::alloc::System, 256 << 20);

/// Loads a scene whose text names these files; a small scene that loads must give finite radiosity of at least 0.
pub fn load(text: &str, files: &[(&str, &[u8])]) {
    let held = files.iter().map(|(name, bytes)| ((*name).into(), bytes.to_vec()));
    let Ok(mut scene) = Scene::parse_from("fuzz.toml", text, &[], &Files::held(held, LIMIT)) else { return };
    let faces: usize = scene.objects.iter().map(|object| object.mesh.triangles.len()).sum();
    let pixels = scene.camera.size[0] * scene.camera.size[1];
    if faces > 64 || pixels > 256 || scene.transport.subdivide > 0 {
        return;
    }
    // Dividing long triangles takes a thousand times as long as all else, so few inputs do it.
    let divides = files.iter().map(|(_, bytes)| bytes.len()).sum::<usize>() % 32 == 0;
    if !divides {
        scene.transport.divided = true;
    }
    let Ok(mut session) = Session::new(&scene, None, Options::default()) else { return };
    if divides {
        return;
    }
    if session.frame(Change::EVERYTHING).is_ok() {
        let light = &session.state().data.radiosity;
        assert!(light.iter().flatten().all(|x| *x >= 0.0 && x.is_finite()), "radiosity {light:?}");
    }
}

/// As `load`, with the file as an environment, as a texture and as a map of layers.
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

/// As `load`, with the file as a mesh, with each of these endings of its material; and as a scene by itself.
#[allow(dead_code, reason = "not every target is of meshes")]
pub fn mesh(name: &str, bytes: &[u8], materials: &[&str]) {
    let light = "[camera]\nsize = [4, 4]\n[[light]]\ntype = 'directional'\ndirection = [1, 2, 3]\nirradiance = 1\n";
    for material in materials {
        let object = format!("[[object]]\nmesh = '{name}'\nsize = 20\nmaterial = {{ preset = 'marble'{material} }}\n");
        load(&format!("{light}{object}"), &[(name, bytes)]);
    }
    alone(name, bytes, &[]);
}

/// Loads a file as a scene by itself, with these settings.
#[allow(dead_code, reason = "not every target is of meshes")]
pub fn alone(name: &str, bytes: &[u8], sets: &[String]) {
    let files = Files::held([(name.into(), bytes.to_vec())], LIMIT);
    let small = ["camera.size=[4,4]".to_string()];
    let _ = Scene::load_from(name, &[&small[..], sets].concat(), 7.0, &files);
}
