//! The animation that a scene plays, with every mesh that has one of its name.

use super::locate;
use super::range::{self, Checked};
use crate::error::Input;

/// Frames per second, if the scene gives none.
const FPS: f64 = 24.0;

/// An animation, at a frame.
#[derive(Debug, Clone)]
pub(super) struct Play {
    name: String,
    /// Seconds from its start.
    pub time: f64,
    /// The frame at which it ends in the mesh in which it is longest.
    pub last: f64,
    fps: f64,
    /// Whether a mesh has it.
    played: bool,
    /// Names of the animations that the meshes have.
    known: Vec<String>,
}

impl Play {
    /// Checks the number of frames per second, which has a default.
    pub fn fps(fps: Option<f64>) -> Checked<f64> {
        range::number("fps", fps.unwrap_or(FPS), |fps| (1e-3..=1e6).contains(&fps), "0.001 to 1e6 frames per second")
    }

    /// The animation of this name at a frame.
    pub fn at(name: String, fps: f64, frame: f64) -> Self {
        Self { name, time: frame / fps, last: 0.0, fps, played: false, known: Vec::new() }
    }

    /// The number of the animation among those of a mesh, which have lengths in seconds.
    pub fn find(&mut self, animations: Vec<(String, f64)>) -> Option<usize> {
        let found = animations.iter().position(|(name, _)| name.eq_ignore_ascii_case(&self.name));
        self.played |= found.is_some();
        self.last = found.map_or(self.last, |number| self.last.max(animations[number].1 * self.fps));
        for (name, _) in animations {
            if !self.known.contains(&name) {
                self.known.push(name);
            }
        }
        found
    }

    /// Returns an error if no mesh has the animation.
    pub fn check_played(&self) -> Checked<()> {
        if self.played {
            return Ok(());
        }
        let known: Vec<&str> = self.known.iter().map(String::as_str).collect();
        let what = locate::with_suggestion("no mesh of the scene has this animation", &self.name, &known);
        let expected = match known.as_slice() {
            [] => "a glTF file with animations".to_owned(),
            names => names.join(", "),
        };
        Err(Input::new(what).key("animation").found(&self.name).expected(expected))
    }
}
