//! A scene as a file.

use super::{Scene, overrides, range::Checked};
use crate::error::Result;
use std::path::Path;
use toml::Table;

impl Scene {
    /// The text of its file with `key=value` settings in place of those that it was loaded with; comments are lost.
    pub fn written(&self, sets: &[String]) -> Result<String> {
        // The text has been parsed before, so this does not fail.
        let mut table: Table = toml::from_str(&self.origin.toml).unwrap_or_default();
        let done: Checked<()> = sets.iter().try_for_each(|set| overrides::apply(&mut table, set));
        done?;
        Ok(toml::to_string(&table).unwrap_or_default())
    }

    /// The folder that paths in its text are relative to; empty for the current one.
    pub fn folder(&self) -> &Path {
        &self.origin.folder
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_written_scene_is_the_scene() {
        let sets = ["object.0.material.scale=2.5".to_string(), "camera.fov=20".into()];
        let scene = Scene::load_with("twist", &sets).unwrap();
        let read = Scene::parse("again", &scene.written(&sets).unwrap(), &[]).unwrap();
        assert_eq!((read.camera, read.frames), (scene.camera.clone(), scene.frames));
        assert_eq!((read.objects[0].material.clone(), read.lights), (scene.objects[0].material.clone(), scene.lights));
        assert!(Scene::load("twist").unwrap().camera != scene.camera);
    }
}
