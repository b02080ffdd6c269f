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

/// A further layer of an OpenEXR file: a name, its channels' names, and one value a channel a pixel.
pub struct Layer {
    /// The layer's name, `irradiance`.
    pub name: &'static str,
    /// Its channels, each with a name and a value a pixel.
    pub channels: Vec<(&'static str, Vec<f32>)>,
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

    /// Writes a `.png` or an `.exr`, by the name's ending; the layers go to the EXR only.
    pub fn save(&self, path: &Path, exposure: f64, layers: &[Layer]) -> Result<()> {
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
            Kind::Exr => write_whole(path, |beside| self.exr(beside, layers)),
        }
    }

    fn exr(&self, path: &Path, layers: &[Layer]) -> std::result::Result<(), String> {
        use exr::prelude::*;
        let size = Vec2(self.width, self.height);
        let channel = |name: &str, values: Vec<f32>| AnyChannel::new(name, FlatSamples::F32(values));
        let color = |k: usize| self.pixels.iter().map(|p| p[k]).collect::<Vec<_>>();
        let mut channels: Vec<_> = [("R", 0), ("G", 1), ("B", 2)].map(|(name, k)| channel(name, color(k))).into();
        for layer in layers {
            for (name, values) in &layer.channels {
                channels.push(channel(&format!("{}.{name}", layer.name), values.clone()));
            }
        }
        let image = Image::from_channels(size, AnyChannels::sort(channels.into()));
        image.write().to_file(path).map_err(|e| e.to_string())
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
