//! What the viewer writes: pictures, layers, the scene, traces, and the command that repeats the picture.

use std::path::{Path, PathBuf};

use milkglass::error::Result;
use milkglass::measure::profile::trace;

use super::Viewer;
use super::outcome::{Message, Output};
use crate::cli::run_args::quoted;
use crate::cli::view::frames::Progress;
use crate::cli::view::inspect::Layer;
use crate::cli::write;

impl Viewer {
    /// Writes the requested file, once its content is there, and tells its name.
    pub(super) fn write(&mut self) -> Result<()> {
        let whole = self.frames.progress == Progress::Whole;
        let Some(output) = self.output.take_if(|output| whole || !output.waits()) else { return Ok(()) };
        match self.save(output) {
            Ok(file) => self.message = Some(Message { text: format!("saved {}", file.display()), wrong: false }),
            Err(error) => self.tell(error)?,
        }
        Ok(())
    }

    /// Writes `SCENE-N` with the first number that is free.
    fn save(&mut self, output: Output) -> Result<PathBuf> {
        let scene = &self.edits.scene;
        // Paths in a scene are relative to its file.
        let folder = if output == Output::Scene { scene.folder() } else { Path::new("") };
        let mut names = (1..).map(|number| folder.join(format!("{}-{number}.{}", scene.name, output.ending())));
        let file = names.find(|file| !file.exists()).unwrap_or_default();
        let light = self.frames.layer() == Layer::Light;
        match output {
            Output::Png | Output::Exr if !light => self.frames.inspector.save(&file)?,
            Output::Png | Output::Exr => self.frames.full().save(&file)?,
            Output::Scene => write(&file, self.edits.written()?)?,
            Output::Trace => {
                let (device, frames) = (&self.device, &self.frames.history.frames);
                let events = trace([&scene.name, device.name(), device.driver()], frames, &|_| Vec::new());
                write(&file, format!("{events}\n"))?;
            }
        }
        Ok(file)
    }

    /// The command that renders the picture.
    pub(super) fn command(&self) -> String {
        let [width, height] = self.edits.scene.camera.size;
        let mut output = vec![format!("--frame={}", self.edits.frame()), format!("--size={width}x{height}")];
        let end = match self.frames.layer() {
            Layer::Light => "png",
            Layer::Values(_) => {
                output.push("--aov".into());
                "exr"
            }
            Layer::Curvature => {
                output.push("--view=curvature".into());
                "png"
            }
            Layer::Clusters => {
                output.extend(["--view=clusters".into(), format!("--pick={},{}", self.pick[0], self.pick[1])]);
                "png"
            }
        };
        output.extend(["-o".to_owned(), format!("{}.{end}", self.edits.scene.name)]);
        let words = self.words.iter().cloned().chain(self.options.words()).chain(self.edits.arguments());
        let all: Vec<String> = words.chain(output).map(|word| quoted(&word)).collect();
        format!("milkglass render {}", all.join(" "))
    }
}
