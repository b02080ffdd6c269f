//! Pictures on disk: linear OpenEXR, or PNG after exposure and the sRGB curve.

use std::path::{Path, PathBuf};

use crate::error::{Input, Result};

/// A picture in memory.
#[derive(Clone, Debug)]
pub struct Picture {
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
    /// Linear radiance, row by row from the top.
    pub pixels: Vec<[f32; 3]>,
}

/// The sRGB transfer curve, from linear 0..1 to encoded 0..1.
pub fn encode(linear: f64) -> f64 {
    let x = linear.clamp(0.0, 1.0);
    if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
}

impl Picture {
    /// Eight bits a channel: exposure, then the sRGB curve, rounded.
    pub fn bytes(&self, exposure: f64) -> Vec<u8> {
        let byte = |x: &f32| (encode(f64::from(*x) * exposure) * 255.0 + 0.5) as u8;
        self.pixels.iter().flat_map(|pixel| pixel.iter().map(byte)).collect()
    }

    /// Writes a `.png` or an `.exr`, by the name's ending.
    pub fn save(&self, path: &Path, exposure: f64) -> Result<()> {
        match kind(path)? {
            Kind::Png => write_whole(path, |beside| {
                let size = (self.width as u32, self.height as u32);
                image::save_buffer_with_format(
                    beside,
                    &self.bytes(exposure),
                    size.0,
                    size.1,
                    image::ExtendedColorType::Rgb8,
                    image::ImageFormat::Png,
                )
                .map_err(|e| e.to_string())
            }),
            Kind::Exr => write_whole(path, |beside| self.exr(beside)),
        }
    }

    fn exr(&self, path: &Path) -> std::result::Result<(), String> {
        let pixel = |x: usize, y: usize| {
            let [r, g, b] = self.pixels[y * self.width + x];
            (r, g, b)
        };
        exr::prelude::write_rgb_file(path, self.width, self.height, pixel).map_err(|e| e.to_string())
    }
}

enum Kind {
    Png,
    Exr,
}

fn kind(path: &Path) -> Result<Kind> {
    match path.extension().and_then(|e| e.to_str()).map(str::to_ascii_lowercase).as_deref() {
        Some("png") => Ok(Kind::Png),
        Some("exr") => Ok(Kind::Exr),
        other => Err(Input::new("a picture's name says its format")
            .key("-o")
            .found(other.map_or_else(|| "no ending".to_string(), |e| format!(".{e}")))
            .expected(".png or .exr")
            .into()),
    }
}

/// Checks before any work that a picture of this name could be written.
pub fn check(path: &Path) -> Result<()> {
    kind(path).map(|_| ())
}

/// Lets `write` fill a file beside `path`, then moves it there: a reader never sees half of it.
pub fn write_whole(path: &Path, write: impl FnOnce(&Path) -> std::result::Result<(), String>) -> Result<()> {
    let mut name = std::ffi::OsString::from(".");
    name.push(path.file_name().unwrap_or_default());
    name.push(format!(".{}.part", std::process::id()));
    let beside: PathBuf = path.with_file_name(name);
    let done = write(&beside).and_then(|()| std::fs::rename(&beside, path).map_err(|e| e.to_string()));
    done.map_err(|what| {
        let _ = std::fs::remove_file(&beside);
        Input::new(format!("could not be written: {what}")).file(path).into()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_curve_meets_its_standard_values() {
        assert_eq!(encode(0.0), 0.0);
        assert!((encode(1.0) - 1.0).abs() < 1e-12);
        assert!((encode(0.5) - 0.735_356_98).abs() < 1e-6);
        assert!((encode(0.003_130_8) - 12.92 * 0.003_130_8).abs() < 1e-6);
        assert_eq!(encode(f64::NAN).to_bits(), f64::NAN.to_bits());
    }

    #[test]
    fn a_failed_write_leaves_nothing() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        let failed = write_whole(&path, |beside| {
            std::fs::write(beside, "half").unwrap();
            Err("disk full".into())
        });
        assert!(failed.unwrap_err().to_string().contains("disk full"));
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
