//! A mesh alone in its studio: the flags of `render` that are about it, and the scene of each frame.

use clap::Args;

use super::{SceneArguments, finite};
use milkglass::error::{Input, Result};
use milkglass::scene::{Scene, Studio, Up, ViewFrom, Wishes};

/// What `render` takes for a mesh alone.
#[derive(Args, Clone)]
pub struct BareArguments {
    /// A mesh alone: its material, as `milkglass materials` lists them.
    #[arg(long, value_name = "NAME")]
    preset: Option<String>,
    /// A mesh alone: its largest extent in mm [default: 20; of skin 40].
    #[arg(long, value_name = "MM")]
    size_mm: Option<f64>,
    /// Samples per pixel, 1 to 64 [default: the scene's; for a mesh alone 8].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=64))]
    samples: Option<u32>,
    /// What is shown where no object is: `none` for a transparent picture, `environment`, or a linear radiance
    /// `[r,g,b]` [default: the scene's].
    #[arg(long, value_name = "NONE|...")]
    background: Option<String>,
    /// A mesh alone: the axis that points upwards [default: guessed from its shape].
    #[arg(long, value_enum)]
    up: Option<Up>,
    /// A mesh alone: where the camera stands: front, back, left, right, top, or azimuth and elevation in degrees.
    #[arg(long, value_name = "VIEW|AZ,EL", allow_hyphen_values = true)]
    view_from: Option<ViewFrom>,
    /// A mesh alone: it stands on a dark table, and casts its shadow there.
    #[arg(long)]
    ground: bool,
    /// A mesh alone: an image of the surroundings that lights it, `.exr` or `.hdr`.
    #[arg(long, value_name = "FILE")]
    #[arg(value_parser = super::paths::any_path())]
    environment: Option<String>,
    /// N frames from all around, `-o name-%04d.png` or `-o name.gif`: the camera goes round, and with it the lights of
    /// a mesh alone.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=10000))]
    turntable: Option<u32>,
}

/// The scene of each frame.
pub struct Subject {
    /// The scene's name, its settings and frame.
    pub scenes: SceneArguments,
    /// The studio, if the scene is a mesh alone.
    studio: Option<Studio>,
    /// Number of frames around the mesh, if the camera turns.
    turns: Option<u32>,
}

impl BareArguments {
    /// The number of frames around the mesh, if the camera is to turn.
    pub fn turns(&self) -> Option<u32> {
        self.turntable
    }

    /// The arguments as words of a command line that makes the same scene, without `--turntable`.
    #[cfg(feature = "window")]
    pub fn words(&self) -> Vec<String> {
        let value = |flag: &str, value: Option<String>| value.map(|value| format!("{flag}={value}"));
        let words = [
            value("--preset", self.preset.clone()),
            value("--size-mm", self.size_mm.map(|size| format!("{size:?}"))),
            value("--samples", self.samples.map(|samples| samples.to_string())),
            value("--background", self.background.clone()),
            value("--up", self.up.map(|up| if matches!(up, Up::Y) { "y" } else { "z" }.to_string())),
            value("--view-from", self.view_from.map(|view| format!("{:?},{:?}", view.azimuth, view.elevation))),
            self.ground.then(|| "--ground".to_string()),
            value("--environment", self.environment.clone()),
        ];
        words.into_iter().flatten().collect()
    }

    /// The scene, in a studio if it is a mesh alone; says what is assumed then. `pixels`: the picture's size, if given.
    pub fn subject(&self, mut scenes: SceneArguments, pixels: Option<[u32; 2]>) -> Result<Subject> {
        let wishes = Wishes {
            preset: self.preset.clone(),
            size_mm: self.size_mm,
            samples: self.samples,
            pixels,
            up: self.up,
            view: self.view_from,
            ground: self.ground,
            environment: self.environment.clone(),
        };
        finite(scenes.frame)?;
        scenes.sets.extend(self.background.iter().map(|background| format!("camera.background={background}")));
        super::paths::announce_pipe(std::path::Path::new(&scenes.scene));
        let studio = Studio::around(&scenes.scene, &scenes.sets(), scenes.frame, &scenes.memory.files(), wishes)?;
        match &studio {
            Some(studio) => studio.told.iter().for_each(|line| tell!("{line}")),
            None => {
                self.only_for_meshes(&scenes.scene)?;
                scenes.sets.extend(self.samples.map(|samples| format!("camera.samples={samples}")));
            }
        }
        Ok(Subject { scenes, studio, turns: self.turntable })
    }

    /// Returns an error if a flag is given that only a mesh alone has.
    fn only_for_meshes(&self, scene: &str) -> Result<()> {
        let flags = [
            ("--preset", self.preset.is_some(), "--set object.0.material.preset=NAME"),
            ("--size-mm", self.size_mm.is_some(), "--set object.0.size=SIZE, in the scene's unit"),
            ("--up", self.up.is_some(), "--set 'object.0.rotation=[-90, 0, 0]'"),
            ("--view-from", self.view_from.is_some(), "--set 'camera.position=[X, Y, Z]'"),
            ("--ground", self.ground, "an [[object]] with `shape = \"plane\"` and an opaque material"),
            ("--environment", self.environment.is_some(), "a [[light]] with `type = \"environment\"`"),
        ];
        match flags.into_iter().find(|(_, given, _)| *given) {
            Some((flag, _, instead)) => {
                let fault = Input::new("only for a mesh alone").key(flag).found(format!("{scene}, which is a scene"));
                Err(fault.expected(instead).into())
            }
            None => Ok(()),
        }
    }
}

impl Subject {
    /// The scene at its frame; reports repairs to it.
    pub fn load(&self) -> Result<Scene> {
        let scene = self.at(self.scenes.frame)?;
        scene.report.iter().chain(&scene.idle_fps()?).for_each(|line| tell!("{line}"));
        Ok(scene)
    }

    /// Checks that the values at a frame are valid; returns the picture's size.
    pub fn check(&self, frame: f64) -> Result<[u32; 2]> {
        match &self.studio {
            Some(studio) => studio.check(&self.scenes.sets(), self.turn_and_frame(frame).1),
            None => self.scenes.check(self.turn_and_frame(frame).1),
        }
    }

    /// The scene at a frame, without a report.
    pub fn at(&self, frame: f64) -> Result<Scene> {
        let (turn, frame) = self.turn_and_frame(frame);
        if let Some(studio) = &self.studio {
            return studio.scene(turn, &self.scenes.sets(), frame, &self.scenes.memory.files());
        }
        let mut scene = self.scenes.at(frame)?;
        if turn != 0.0 {
            let (low, high) = scene.bounds();
            scene.camera = scene.camera.turned((low + high) / 2.0, turn);
        }
        Ok(scene)
    }

    /// How far the camera is turned at a frame, degrees, and the frame of the mesh.
    fn turn_and_frame(&self, frame: f64) -> (f64, f64) {
        match self.turns {
            Some(turns) => (360.0 * frame / f64::from(turns), self.scenes.frame),
            None => (0.0, frame),
        }
    }
}
