//! Films on disk: animated GIF files, which begin again without end.

use std::path::{Path, PathBuf};

use gif::{Encoder, Frame, Repeat};

use super::atomic_file::Pending;
use crate::error::{Error, Input, Result};
use crate::scene::Camera;

/// Whether the file of this name is a GIF.
#[must_use]
pub fn is_gif(path: &Path) -> bool {
    path.extension().is_some_and(|end| end.eq_ignore_ascii_case("gif"))
}

/// The shortest time of a frame, in hundredths of a second: browsers show shorter ones for a tenth of a second.
const SHORTEST: u32 = 2;

/// A GIF to which frames are added, in a file beside its own. Each has the 256 colours that suit it best.
pub struct Film {
    file: Pending,
    /// Writes to memory, which is emptied into the file.
    encoder: Encoder<Vec<u8>>,
    size: [u32; 2],
    fps: f64,
    /// The end of the last frame, in hundredths of a second.
    end: u32,
    frames: u32,
}

impl Film {
    /// An empty film; `fps` is its number of frames per second.
    pub fn new(path: &Path, size: [u32; 2], fps: f64) -> Result<Self> {
        let file = Pending::new(path)?;
        let [width, height] = size.map(|side| side as u16);
        let mut encoder = Encoder::new(Vec::new(), width, height, &[]).map_err(unencoded)?;
        encoder.set_repeat(Repeat::Infinite).map_err(unencoded)?;
        Ok(Self { file, encoder, size, fps, end: 0, frames: 0 })
    }

    /// An error if a GIF can't hold what this camera sees: its pixels are either opaque or transparent.
    pub fn check(camera: &Camera) -> Result<()> {
        if !camera.transparent {
            return Ok(());
        }
        let fault = Input::new("a GIF holds no partly transparent pixels").key("camera.background").found("\"none\"");
        Err(fault.expected("-o NAME-%04d.png, or another background").into())
    }

    /// An error if two frames have different sizes.
    pub fn check_sizes(before: [u32; 2], size: [u32; 2]) -> Result<()> {
        if size == before {
            return Ok(());
        }
        let [[w, h], [width, height]] = [size, before];
        let fault = Input::new("the frames of a GIF have one size").key("camera.size").found(format!("{w} x {h}"));
        Err(fault.expected(format!("{width} x {height}, as before")).into())
    }

    /// Adds a frame, as sRGB with three bytes a pixel.
    pub fn push(&mut self, size: [u32; 2], bytes: &[u8]) -> Result<()> {
        Self::check_sizes(self.size, size)?;
        self.frames += 1;
        let due = (100.0 * f64::from(self.frames) / self.fps).round() as u32;
        let delay = due.saturating_sub(self.end).clamp(SHORTEST, u16::MAX.into());
        self.end = self.end.saturating_add(delay);
        // The slowest search for its colours, which finds the best ones.
        let frame = Frame::from_rgb_speed(size[0] as u16, size[1] as u16, bytes, 1);
        self.encoder.write_frame(&Frame { delay: delay as u16, ..frame }).map_err(unencoded)?;
        self.file.add(&std::mem::take(self.encoder.get_mut()))
    }

    /// Ends the file and moves it to its path, or to another name in the same folder; returns where it is, None for a
    /// device.
    pub fn save(mut self, name: Option<&str>) -> Result<Option<PathBuf>> {
        self.file.add(&self.encoder.into_inner().map_err(unencoded)?)?;
        self.file.finish(name)
    }
}

fn unencoded(error: impl std::fmt::Display) -> Error {
    Input::new(format!("a GIF could not be encoded: {error}")).key("-o").into()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_are_on_disk_as_they_come() {
        let size = [4, 2];
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.gif");
        let files = || std::fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap());
        let film = |frames: u8| {
            let mut film = Film::new(&path, size, 10.0).unwrap();
            (0..frames).for_each(|frame| film.push(size, &[frame; 24]).unwrap());
            film
        };
        let begun = film(2);
        assert!(files().all(|file| file.metadata().unwrap().len() > 40) && !path.exists());
        drop(begun);
        assert_eq!(files().count(), 0);
        film(3).save(Some("b.gif")).unwrap();
        film(2).save(None).unwrap();
        let frames = |name: &str| {
            let mut film = gif::Decoder::new(std::fs::File::open(folder.path().join(name)).unwrap()).unwrap();
            std::iter::from_fn(|| film.read_next_frame().unwrap().map(|frame| frame.delay)).count()
        };
        assert_eq!((files().count(), frames("a.gif"), frames("b.gif")), (2, 2, 3));
    }
}
