//! The frames of an animation: playing them at their pace, and going to one.

use std::time::Instant;

use milkglass::error::Result;

use super::Viewer;
use super::outcome::Changed;

/// Frames per second where the scene does not give them.
const FPS: f64 = 24.0;

/// Whether an animation plays.
pub(super) struct Timeline {
    /// Since when it plays, and from which frame on.
    playing: Option<(Instant, f64)>,
    /// Whether it begins again after its last frame.
    pub(super) loops: bool,
}

impl Timeline {
    pub(super) fn new() -> Self {
        Self { playing: None, loops: true }
    }

    pub(super) fn plays(&self) -> bool {
        self.playing.is_some()
    }
}

/// The whole frame that is due `seconds` after frame `from`, and whether it is the end.
fn at([first, last]: [f64; 2], from: f64, seconds: f64, fps: f64, loops: bool) -> (f64, bool) {
    let frame = (from + seconds * fps).round();
    // The frame after the last one is the first one.
    let count = last - first + 1.0;
    match frame > last {
        true if loops => (first + (frame - first).rem_euclid(count), false),
        true => (last, true),
        false => (frame.max(first), false),
    }
}

impl Viewer {
    /// Plays the animation, or stops it; from its first frame if it is at its end.
    pub(super) fn play(&mut self) {
        let Some([first, last]) = self.edits.scene.frames else { return };
        let now = self.edits.frame();
        self.timeline.playing = match self.timeline.playing {
            Some(_) => None,
            None => Some((Instant::now(), if now >= last { first } else { now })),
        };
    }

    /// Goes to a frame within the animation.
    pub(super) fn go_to(&mut self, frame: f64) -> Result<Changed> {
        let Some([first, last]) = self.edits.scene.frames else { return Ok(Changed::Nothing) };
        let frame = frame.clamp(first, last);
        if frame == self.edits.frame() {
            return Ok(Changed::Nothing);
        }
        self.edits.set_frame(frame).map(|()| Changed::Scene)
    }

    /// Whether an animation plays.
    pub(in crate::cli::view) fn plays(&self) -> bool {
        self.timeline.plays()
    }

    /// Goes on to the frame that is due if an animation plays.
    pub(in crate::cli::view) fn tick(&mut self) -> Result<()> {
        let (Some((since, from)), Some(ends)) = (self.timeline.playing, self.edits.scene.frames) else {
            self.timeline.playing = None;
            return Ok(());
        };
        let fps = self.edits.number("fps").unwrap_or(FPS);
        let (frame, over) = at(ends, from, since.elapsed().as_secs_f64(), fps, self.timeline.loops);
        if over {
            self.timeline.playing = None;
        }
        let before = self.edits.state();
        match self.go_to(frame) {
            Ok(Changed::Nothing) => Ok(()),
            Ok(_) => {
                self.adopt(before);
                Ok(())
            }
            Err(error) => {
                self.timeline.playing = None;
                self.tell(error)
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_animation_plays_at_its_pace_and_begins_again_or_ends() {
        let ends = [2.0, 11.0];
        assert_eq!(at(ends, 2.0, 0.5, 10.0, true), (7.0, false));
        assert_eq!(at(ends, 2.0, 0.94, 10.0, true), (11.0, false));
        assert_eq!(at(ends, 2.0, 1.0, 10.0, true), (2.0, false));
        assert_eq!(at(ends, 2.0, 2.3, 10.0, true), (5.0, false));
        assert_eq!(at(ends, 2.0, 1.0, 10.0, false), (11.0, true));
        assert_eq!(at(ends, 0.0, 0.0, 10.0, false), (2.0, false));
    }
}
