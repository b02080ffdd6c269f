//! Layers beneath a surface: closed forms, plans, pictures, and the command line.

mod bake;
mod eval;
mod frames;
mod inputs;
mod measured;
mod ramps;
mod reference;
mod seams;
mod single;
mod single_frames;
mod slab;

use milkglass::internals::pipeline::plan::{Change, Options};
use milkglass::internals::session::run::Session;
use milkglass::scene::Scene;

/// A built-in scene with these settings.
fn scene(name: &str, sets: &[&str]) -> Scene {
    Scene::load_with(name, &sets.iter().map(|set| set.to_string()).collect::<Vec<_>>()).unwrap()
}

/// A session on the CPU after its first frame.
fn session(scene: &Scene, options: Options) -> Session {
    let mut session = Session::new(scene, None, options).unwrap();
    session.frame(Change::EVERYTHING).unwrap();
    session
}
