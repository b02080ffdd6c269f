//! Films on disk: animated GIF files, which begin again without end.

use std::path::Path;

use gif::{Encoder, Frame, Repeat};

use super::atomic_file::encode_atomically;
use crate::error::{Error, Input, Result};
use crate::scene::Camera;

/// Whether the file of this name is a GIF.
#[must_use]
pub fn is_gif(path: &Path) -> bool {
    path.extension().is_some_and(|end| end.eq_ignore_ascii_case("gif"))
}

/// The shortest time of a frame, in hundredths of a second: browsers show shorter ones for a tenth of a second.
const SHORTEST: u32 = 2;

/// A GIF to which frames are added. Each has the 256 colours that suit it best.
pub struct Film {
    encoder: Encoder<Vec<u8>>,
    size: [u32; 2],
    fps: f64,
    /// The end of the last frame, in hundredths of a second.
    end: u32,
    frames: u32,
}

impl Film {
    /// An empty film; `fps` is its number of frames per second.
    pub fn new(size: [u32; 2], fps: f64) -> Result<Self> {
        let [width, height] = size.map(|side| side as u16);
        let mut encoder = Encoder::new(Vec::new(), width, height, &[]).map_err(unencoded)?;
        encoder.set_repeat(Repeat::Infinite).map_err(unencoded)?;
        Ok(Self { encoder, size, fps, end: 0, frames: 0 })
    }

    /// An error if a GIF can't hold what this camera sees: its pixels are either opaque or transparent.
    pub fn check(camera: &Camera) -> Result<()> {
        if !camera.transparent {
            return Ok(());
        }
        let fault = Input::new("a GIF holds no partly transparent pixels").key("camera.background").found("\"none\"");
        Err(fault.expected("-o NAME-%04d.png, or another background").into())
    }

    /// Adds a frame, as sRGB with three bytes a pixel.
    pub fn push(&mut self, size: [u32; 2], bytes: &[u8]) -> Result<()> {
        if size != self.size {
            let [[w, h], [width, height]] = [size, self.size];
            let fault = Input::new("the frames of a GIF have one size").key("camera.size").found(format!("{w} x {h}"));
            return Err(fault.expected(format!("{width} x {height}, as before")).into());
        }
        self.frames += 1;
        let due = (100.0 * f64::from(self.frames) / self.fps).round() as u32;
        let delay = due.saturating_sub(self.end).clamp(SHORTEST, u16::MAX.into());
        self.end = self.end.saturating_add(delay);
        // The slowest search for its colours, which finds the best ones.
        let frame = Frame::from_rgb_speed(size[0] as u16, size[1] as u16, bytes, 1);
        self.encoder.write_frame(&Frame { delay: delay as u16, ..frame }).map_err(unencoded)
    }

    /// Writes the file, which appears whole or not at all.
    pub fn save(self, path: &Path) -> Result<()> {
        let bytes = self.encoder.into_inner();
        encode_atomically(path, |file| {
            file.get_mut().append(&mut bytes.map_err(|error| error.to_string())?);
            Ok(())
        })
    }
}

fn unencoded(error: impl std::fmt::Display) -> Error {
    Input::new(format!("a GIF could not be encoded: {error}")).key("-o").into()
}
