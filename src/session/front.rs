//! The front door: a session, and its picture.

use super::antialiasing::picture;
use super::capacity::CapacityHints;
use super::run::{Session, unfinished};
use crate::error::Result;
use crate::geometry::trace::UNFINISHED;
use crate::gpu::Device;
use crate::layout::BufferId;
use crate::pipeline::plan::{Change, Options};
use crate::scene::Scene;
use crate::view::picture::Picture;

impl Session {
    /// Prepares a scene for a device, or for the CPU if there is none.
    ///
    /// # Errors
    ///
    /// [`crate::Error::Input`] if the scene can't be rendered this way (file, line and key are named);
    /// [`crate::Error::Device`] if the device lacks memory or fails.
    pub fn new(scene: &Scene, device: Option<&Device>, options: Options) -> Result<Self> {
        Self::with_capacity(scene, device, options, CapacityHints::default()).map_err(|error| scene.placed(error))
    }

    /// Runs what has changed since the last frame, and returns the picture with the camera's size, samples, exposure
    /// and tone curve. The first call runs everything.
    ///
    /// Between calls change the scene with [`Session::set_lights`], [`Session::set_camera`] or [`Session::show`]; the
    /// picture is the one that a new session would render.
    pub fn render(&mut self) -> Result<Picture> {
        self.frame(Change::default())?;
        let picture = picture(self)?;
        self.shift([0.0; 2])?;
        Ok(picture)
    }

    /// The picture of the last frame, with one sample per pixel; [`Session::render`] takes all.
    pub fn picture(&mut self) -> Result<Picture> {
        self.fetch(&[BufferId::hits, BufferId::radiance])?;
        let data = &self.prepared.state.data;
        if data.hits.iter().any(|hit| hit.face == UNFINISHED) {
            return Err(unfinished("tracing a ray through the tree", "use a mesh with fewer overlapping parts"));
        }
        let camera = &self.scene.camera;
        let [width, height] = camera.size.map(|n| n as usize);
        Ok(Picture { width, height, pixels: data.radiance.clone(), exposure: camera.exposure, tone: camera.tone })
    }
}
