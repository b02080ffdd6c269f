//! The front door: a session, and its picture.

use std::path::Path;

use super::antialiasing::picture;
use super::capacity::CapacityHints;
use super::run::{Session, unfinished};
use crate::error::Result;
use crate::geometry::trace::UNFINISHED;
use crate::gpu::{Buffer, Device};
use crate::layout::BufferId;
use crate::pipeline::plan::{Change, Options};
use crate::prepare::camera::tones;
use crate::scene::Scene;
use crate::view::picture::{Picture, is_png, metered, save_png};

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

    /// Which objects' trees are rebuilt for their deformed shape, and why.
    #[must_use]
    pub fn rebuilt(&self) -> Vec<String> {
        let grown = self.prepared.spoilt.iter().enumerate().filter_map(|(object, growth)| Some((object, (*growth)?)));
        let says = |(object, growth)| {
            format!("object {object}: deformed, its clusters would be {growth:.2} times as wide; tree rebuilt")
        };
        grown.map(says).collect()
    }

    /// Whether each layered object's depth maps are repacked by islands or used unchanged, and why.
    #[must_use]
    pub fn maps(&self) -> &[String] {
        &self.prepared.maps
    }

    /// Runs what has changed since the last frame, and returns the picture with the camera's size, samples, exposure
    /// and tone curve. The first call runs everything.
    ///
    /// Between calls change the scene with [`Session::set_lights`], [`Session::set_camera`] or [`Session::show`]; the
    /// picture is the one that a new session would render.
    pub fn render(&mut self) -> Result<Picture> {
        if self.scene.camera.samples == 1 {
            self.frame(Change::default())?;
        }
        picture(self)
    }

    /// The picture: of the last frame, or the mean over all samples after [`Session::sample`].
    pub fn picture(&mut self) -> Result<Picture> {
        self.meter()?;
        self.fetch(&[BufferId::hits, self.pixels()])?;
        self.check_rays()?;
        let data = &self.prepared.state.data;
        let pixels = if self.sampled() { data.mean.clone() } else { data.radiance.clone() };
        let camera = &self.scene.camera;
        let [width, height] = camera.size.map(|n| n as usize);
        Ok(Picture { width, height, pixels, alpha: self.alpha(), exposure: camera.exposure, tone: camera.tone })
    }

    /// Writes the picture as [`Picture::save`] does; an opaque PNG is exposed where the stages run.
    pub fn save(&mut self, path: &Path) -> Result<()> {
        if is_png(path) && !self.scene.camera.transparent {
            let size = self.scene.camera.size.map(|n| n as usize);
            return save_png(path, size, &self.shown()?);
        }
        self.picture()?.save(path)
    }

    /// The same picture as sRGB, 8 bits a channel, row by row from the top: [`Picture::bytes`], found where the stages
    /// run.
    pub fn shown(&mut self) -> Result<Vec<u8>> {
        self.tone()?;
        self.fetch(&[BufferId::hits, BufferId::shown])?;
        self.check_rays()?;
        let rgb = |pixel: &u32| (0..3).map(move |c| (pixel >> (8 * c)) as u8).collect::<Vec<_>>();
        Ok(self.prepared.state.data.shown.iter().flat_map(rgb).collect())
    }

    /// The same picture left on the device, four bytes a pixel, the last of them 0; none on the CPU. Nothing is
    /// checked: see [`Session::finished_rays`].
    pub fn shown_on_device(&mut self) -> Result<Option<&Buffer>> {
        self.tone()?;
        Ok(self.gpu.as_ref().and_then(|gpu| gpu.buffer(BufferId::shown)))
    }

    /// Puts another picture of its size, four bytes a pixel, in the place of what [`Session::shown_on_device`] returns,
    /// until that is called again; none on the CPU.
    pub fn show_instead(&mut self, bytes: &[u32]) -> Result<Option<&Buffer>> {
        self.prepared.state.data.shown = bytes.to_vec();
        self.send(&[BufferId::shown])?;
        Ok(self.gpu.as_ref().and_then(|gpu| gpu.buffer(BufferId::shown)))
    }

    /// The buffer of the picture.
    fn pixels(&self) -> BufferId {
        if self.sampled() { BufferId::mean } else { BufferId::radiance }
    }

    /// Sets the exposure by the picture of the last frame, if the camera is metered: to one that was held, or by what
    /// is seen of translucent objects, or of all if none is seen.
    fn meter(&mut self) -> Result<()> {
        if !self.scene.camera.metered {
            return Ok(());
        }
        let exposure = match self.held {
            Some(held) => held,
            None => {
                self.fetch(&[BufferId::hits, self.pixels()])?;
                let (state, data) = (&self.prepared.state, &self.prepared.state.data);
                let pixels = if self.sampled() { &data.mean } else { &data.radiance };
                let brightness = |opaque: bool| -> Vec<f32> {
                    let seen = |face: u32| {
                        face < data.triangles.len() as u32
                            && (opaque || !state.objects[state.object_of(face as usize)].opaque)
                    };
                    let seen = data.hits.iter().zip(pixels).filter(|(hit, _)| seen(hit.face));
                    seen.map(|(_, pixel)| pixel.iter().copied().fold(0.0, f32::max)).collect()
                };
                let translucent = brightness(false);
                metered(if translucent.is_empty() { brightness(true) } else { translucent }, self.scene.camera.tone)
            }
        };
        if exposure == self.scene.camera.exposure {
            return Ok(());
        }
        self.scene.camera.exposure = exposure;
        tones(&mut self.prepared.state, &self.scene.camera);
        self.send(&[BufferId::tones])
    }

    /// The exposure of the last picture that was shown, where the camera is metered; none before the first.
    #[must_use]
    pub fn metered(&self) -> Option<f64> {
        let camera = &self.scene.camera;
        (camera.metered && camera.exposure != 1.0).then_some(camera.exposure)
    }

    /// Where the camera is metered, gives all pictures this exposure, or each its own again.
    pub fn hold_exposure(&mut self, exposure: Option<f64>) {
        self.held = exposure;
    }

    /// Exposes the picture of the last frame.
    fn tone(&mut self) -> Result<()> {
        self.meter()?;
        let steps = self.plan.steps(&self.prepared.state, Change::TONE);
        self.run(&steps).map(drop)
    }

    /// An error if a driver has ended a pixel's ray of the last frame early.
    pub fn finished_rays(&mut self) -> Result<()> {
        self.fetch(&[BufferId::hits])?;
        self.check_rays()
    }

    /// The same for hits that have been fetched.
    fn check_rays(&self) -> Result<()> {
        if self.prepared.state.data.hits.iter().any(|hit| hit.face == UNFINISHED) {
            return Err(unfinished("tracing a ray through the tree", "use a mesh with fewer overlapping parts"));
        }
        Ok(())
    }
}
