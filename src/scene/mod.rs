//! The scene as the user wrote it, validated: objects and their materials, lights, a camera, and the settings of light
//! transport. It comes from a built-in text, a TOML file, or a mesh file alone.
//!
//! All values are `f64` in scene units; `unit_mm` is the length of one unit.

mod animate;
mod builtin;
mod camera;
mod choices;
mod deform;
mod extent;
mod file;
mod files;
mod image;
mod layers;
mod light;
mod local;
mod locate;
mod material;
mod mesh;
mod object;
mod overrides;
mod play;
mod preset;
mod range;
mod read;
mod skin;
mod studio;
mod surface;
mod text;
mod texture;
mod transport;
mod vector;
mod written;

pub use animate::numbered;
pub use builtin::BUILTIN;
pub use camera::{Camera, Tone};
pub use deform::Deform;
pub use extent::DENSEST;
pub use files::{Files, Memory, path_of_text, text_of_path, was_read};
pub use layers::{Depth, DepthMap, Integration, Layer, Layers, Phase};
pub use light::{Light, Sky, Source};
pub use local::{Cdrf, Kappa};
#[cfg(feature = "measure")]
pub(crate) use locate::{from_toml, line_of};
pub use material::{Fresnel, Material};
pub(crate) use mesh::vertex_normal;
pub use mesh::{Mesh, Shape};
pub use object::Object;
pub use preset::{LIQUIDS, LOOKS, PRESETS, Preset, Provenance};
pub use skin::{Pose, Rig};
pub use studio::{Studio, Up, ViewFrom, Wishes};
pub use surface::{Reflection, Surface};
pub use texture::{Side, Texture, Wrap};
pub use transport::{ClusterForm, Distance, Hierarchy, MOST_WALKS, Near, Oracle, Receivers, Scheme, Transport};

use crate::error::{Error, Input, Result};

use glam::DVec3;
use play::Play;
use std::path::PathBuf;
use std::sync::Arc;
use text::Text;

/// A validated scene: objects with their materials, lights, a camera, and settings of light transport.
///
/// It is plain data: load one, change what you like, and render it.
///
/// ```
/// use milkglass::Scene;
///
/// let mut scene = Scene::load("sphere")?;
/// scene.camera.size = [320, 240];
/// scene.camera.samples = 4;
/// scene.lights.truncate(1);
/// # Ok::<(), milkglass::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Scene {
    /// The built-in name, or the file name without its extension.
    pub name: String,
    /// Millimetres per scene unit, above 0.
    pub unit_mm: f64,
    /// The camera, fitted to the objects where the file omits position or target.
    pub camera: Camera,
    /// The lights, in the file's order; may be empty.
    pub lights: Vec<Light>,
    /// The objects, in the file's order; at least one.
    pub objects: Vec<Object>,
    /// Settings of light transport.
    pub transport: Transport,
    /// The first and the last frame of keyframes and animation; none where nothing has them.
    pub frames: Option<[f64; 2]>,
    /// Frames per second of the animation and of a GIF, 0.001 to 1e6.
    pub fps: f64,
    /// Repairs and warnings for the user, one per entry.
    pub report: Vec<String>,
    /// The memory limit, and the memory taken so far.
    pub memory: Memory,
    /// Its text and settings, to locate errors that are found later.
    pub origin: Arc<Origin>,
}

/// A scene's text and the settings applied to it.
#[derive(Debug)]
pub struct Origin {
    toml: String,
    file: PathBuf,
    folder: PathBuf,
    sets: Vec<String>,
}

impl Scene {
    /// Adds the file and line of its key to an input error, or the setting that gave the key its value.
    #[must_use]
    pub fn placed(&self, error: Error) -> Error {
        match error {
            Error::Input(fault) if fault.file.as_os_str().is_empty() && fault.key.is_some() => {
                read::place(fault, &self.origin.toml, &self.origin.file, &self.origin.sets).into()
            }
            other => other,
        }
    }

    /// Loads a built-in scene by its name, a mesh alone by its file (OBJ, PLY, STL or glTF), or a scene file (TOML).
    ///
    /// ```
    /// let scene = milkglass::Scene::load("sphere")?;
    /// assert_eq!(scene.objects.len(), 1);
    /// # Ok::<(), milkglass::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Error::Input`] names the file, line and key, what was found there and what was expected.
    pub fn load(name_or_path: &str) -> Result<Self> {
        Self::load_with(name_or_path, &[])
    }

    /// The same, with `key=value` settings that change the scene, applied in order.
    ///
    /// ```
    /// let sets = ["object.0.material.preset=ketchup".to_string(), "camera.size=[64,64]".to_string()];
    /// let scene = milkglass::Scene::load_with("sphere", &sets)?;
    /// assert_eq!(scene.camera.size, [64, 64]);
    /// # Ok::<(), milkglass::Error>(())
    /// ```
    pub fn load_with(name_or_path: &str, sets: &[String]) -> Result<Self> {
        Self::load_at(name_or_path, sets, 0.0)
    }

    /// The same at `frame`, where values have keyframes.
    pub fn load_at(name_or_path: &str, sets: &[String], frame: f64) -> Result<Self> {
        Self::load_from(name_or_path, sets, frame, &Files::default())
    }

    /// The same, reading from `files` within their memory limit.
    pub fn load_from(name_or_path: &str, sets: &[String], frame: f64, files: &Files) -> Result<Self> {
        Self::of(Text::find(name_or_path, files)?, sets, frame, files)
    }

    /// Checks the text at `frame` without reading any other file; returns the picture's size.
    pub fn check_at(name_or_path: &str, sets: &[String], frame: f64) -> Result<[u32; 2]> {
        let text = Text::find(name_or_path, &Files::default())?;
        Ok(read::read(&text.toml, &text.file, sets, frame)?.framing.size())
    }

    /// What to say, where no GIF is made, of an `fps` that has no effect because nothing moves: an error if a setting
    /// gives it, a line if the file does.
    pub fn idle_fps(&self) -> Result<Option<String>> {
        let set = self.origin.sets.iter().any(|set| set.split('=').next().is_some_and(|key| key.trim() == "fps"));
        let given = || self.origin.toml.parse().is_ok_and(|table: toml::Table| table.contains_key("fps"));
        if self.frames.is_some() || !(set || given()) {
            return Ok(None);
        }
        let what = "has no effect: the scene has neither an animation nor keyframes";
        let fault = || Input::new(what).key("fps").found(self.fps).expected("an `animation`, keyframes, or a GIF");
        if set { Err(self.placed(fault().into())) } else { Ok(Some(format!("fps {what}, and no GIF is made"))) }
    }

    /// The text of the scene that [`Self::load_from`] loads by this name, and the animations of the mesh if it is that
    /// of a mesh alone: their names, and how long they last, in seconds.
    pub fn text(name_or_path: &str, files: &Files) -> Result<(String, Vec<(String, f64)>)> {
        let text = Text::find(name_or_path, files)?;
        let animations = if text.alone { mesh::animations(files, &text.file)? } else { Vec::new() };
        Ok((text.toml, animations))
    }

    /// Reads the text of a scene file, called `name` in messages, and applies the `key=value` settings in order.
    pub fn parse(name: &str, toml: &str, sets: &[String]) -> Result<Self> {
        Self::parse_from(name, toml, sets, &Files::default())
    }

    /// The same; `files` provides the files that the text names.
    pub fn parse_from(name: &str, toml: &str, sets: &[String], files: &Files) -> Result<Self> {
        let (name, file) = (name.to_owned(), PathBuf::from(name));
        Self::of(
            Text { name, toml: toml.to_owned(), file, folder: PathBuf::new(), alone: false, report: Vec::new() },
            sets,
            0.0,
            files,
        )
    }

    fn of(text: Text, sets: &[String], frame: f64, files: &Files) -> Result<Self> {
        let draft = read::read(&text.toml, &text.file, sets, frame)?;
        let mut report = text.report;

        // Meshes, scaled and placed, and their textures.
        let several = draft.objects.len() > 1;
        let most = draft.objects.iter().map(object::Draft::most_triangles).sum::<u64>();
        files.need(most.saturating_mul(Mesh::BYTES)).map_err(|error| {
            let fault = Input::new("the shapes do not fit the memory").key("object");
            let fault = fault.found(format!("up to {most} triangles: {error}")).expected("a smaller `detail`");
            read::place(fault, &text.toml, &text.file, sets)
        })?;
        let mut frames = draft.frames;
        let mut play = draft.animation.map(|name| Play::at(name, draft.fps, frame));
        let mut objects = Vec::with_capacity(draft.objects.len());
        for (index, mut object) in draft.objects.into_iter().enumerate() {
            let mut notes = Vec::new();
            let mesh = object.mesh(files, &text.folder, index, &draft.transport, play.as_mut(), &mut notes);
            let mesh = mesh.map_err(|fault| match fault.file.as_os_str().is_empty() {
                true => read::place(fault, &text.toml, &text.file, sets),
                false => fault,
            })?;
            report.extend(notes.into_iter().map(|note| if several { format!("object {index}: {note}") } else { note }));
            let deforms = object.deforms.iter().map(|draft| draft.on(&mesh)).collect();
            let (rotation, position) = object.placement();
            objects.push(Object { mesh, rotation, position, material: object.material, deforms });
        }

        if let Some(play) = play {
            play.check_played().map_err(|fault| read::place(fault, &text.toml, &text.file, sets))?;
            frames = animate::both(frames, Some([0.0, play.last]));
        }
        extent::check(&objects).map_err(|fault| read::place(fault, &text.toml, &text.file, sets))?;

        // Camera: fitting it needs the meshes.
        let (low, high) = bounds(&objects);
        let camera = draft.framing.fit(low, high);
        let camera = camera.map_err(|fault| read::place(fault, &text.toml, &text.file, sets))?;

        // Lights last: their placement checks need the meshes.
        let mut lights = draft.lights;
        for (index, light) in lights.iter_mut().enumerate() {
            let loaded = light.load(files, &text.folder, index, &mut report);
            let loaded = loaded.and_then(|()| light.check_outside(&objects, index));
            loaded.map_err(|fault| read::place(fault, &text.toml, &text.file, sets))?;
        }
        report.extend(without_effect(&camera, &lights, &objects));
        let origin = Arc::new(Origin { toml: text.toml, file: text.file, folder: text.folder, sets: sets.to_vec() });
        Ok(Self {
            origin,
            name: text.name,
            unit_mm: draft.unit_mm,
            camera,
            lights,
            objects,
            transport: Transport { divided: draft.transport.receivers == Receivers::Faces, ..draft.transport },
            frames,
            fps: draft.fps,
            report,
            memory: files.memory(),
        })
    }
}

impl Scene {
    /// The lowest and highest corner of the bounding box of all objects, in scene units.
    pub fn bounds(&self) -> (DVec3, DVec3) {
        bounds(&self.objects)
    }

    /// Fails if a light lies inside a medium, as loading a scene file does.
    pub fn check_lights(&self) -> Result<()> {
        let mut all = self.lights.iter().enumerate();
        all.try_for_each(|(index, light)| light.check_outside(&self.objects, index)).map_err(Into::into)
    }
}

/// Lines about what has no effect on the picture.
fn without_effect(camera: &Camera, lights: &[Light], objects: &[Object]) -> Vec<String> {
    let misses =
        |(index, light): (usize, &Light)| Some(format!("light {index} lights nothing: {}", light.misses(objects)?));
    let mut lines: Vec<String> = lights.iter().enumerate().filter_map(misses).collect();
    if camera.aperture > 0.0 && camera.samples == 1 {
        lines.push("camera.aperture blurs nothing: the picture has one sample a pixel (camera.samples)".to_owned());
    }
    if lights.is_empty() {
        lines.push("dark: the scene has no [[light]]".to_owned());
    }
    lines
}

fn bounds(objects: &[Object]) -> (DVec3, DVec3) {
    let both = |(low, high): (DVec3, DVec3), (a, b): (DVec3, DVec3)| (low.min(a), high.max(b));
    objects.iter().map(Object::bounds).reduce(both).unwrap_or_default()
}

/// The scene of a mesh alone.
fn around_mesh(path: &str) -> String {
    // Escape `%`, which would stand for the frame's number.
    around(&format!("mesh = {}", toml::Value::String(path.replace('%', "%%"))))
}

/// The scene of one object, whose source this line names: marble, 20 mm across, one light, a fitted camera.
fn around(source: &str) -> String {
    format!(
        "unit = \"mm\"\n\n\
         [[light]]\ntype = \"directional\"\ndirection = [0.35, 0.6, 0.75]\nirradiance = 3.0\n\n\
         [[object]]\n{source}\nsize = 20\nmaterial = {{ preset = \"marble\" }}\n"
    )
}

#[cfg(test)]
mod tests;
