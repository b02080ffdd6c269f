//! Pictures on disk: linear OpenEXR, or PNG after exposure, tone curve and sRGB transfer curve.

use std::path::Path;

use exr::prelude::{Image, SpecificChannels, Vec2, WritableImage};

pub use super::atomic_file::write_atomically;
use super::atomic_file::{encode_atomically, is_device};
use crate::error::{Input, Result};
use crate::scene::Tone;

/// A picture in memory: linear radiance, and how a PNG shows it.
///
/// ```
/// use milkglass::Picture;
///
/// let grey = Picture { width: 2, height: 1, pixels: vec![[0.5; 3]; 2], exposure: 2.0, tone: Default::default() };
/// assert_eq!(grey.bytes(), [255; 6]);
/// ```
#[derive(Clone, Debug)]
pub struct Picture {
    /// Width in pixels.
    pub width: usize,
    /// Height in pixels.
    pub height: usize,
    /// Linear radiance, row by row from the top.
    pub pixels: Vec<[f32; 3]>,
    /// Factor on radiance before the tone curve of a PNG, above 0.
    pub exposure: f64,
    /// Tone curve of a PNG.
    pub tone: Tone,
}

/// The sRGB transfer curve, from linear 0..1 to encoded 0..1.
pub fn encode(linear: f64) -> f64 {
    let x = linear.clamp(0.0, 1.0);
    if x <= 0.003_130_8 { 12.92 * x } else { 1.055 * x.powf(1.0 / 2.4) - 0.055 }
}

/// The filmic curve (Hable 2010), from exposed radiance to 0..1: h(2 x) / h(11.2), which is 1 from x = 5.6 on.
/// h(x) = (x (0.15 x + 0.05) + 0.004) / (x (0.15 x + 0.5) + 0.06) - 1 / 15.
pub fn filmic(exposed: f64) -> f64 {
    let curve = |x: f64| (x * (0.15 * x + 0.05) + 0.004) / (x * (0.15 * x + 0.5) + 0.06) - 1.0 / 15.0;
    curve(2.0 * exposed.clamp(0.0, 5.6)) / curve(11.2)
}

/// The share of the pixels of translucent objects that a metered exposure shows no brighter than `METERED_SHOWN`.
const METERED_SHARE: f64 = 0.98;
/// An sRGB value just below white.
const METERED_SHOWN: f64 = 245.0 / 255.0;
/// The range of a metered exposure.
const METERED_RANGE: [f64; 2] = [1e-30, 1e30];

/// The exposure at which at least 98 % of these pixels, each by its brightest channel, are shown at most as 245 of 255;
/// rounded down to a sixteenth of a stop, so that devices whose pixels differ in last bits expose alike. 1 if there are
/// no pixels, or if the one that decides is black.
#[must_use]
pub fn metered(mut brightest: Vec<f32>, tone: Tone) -> f64 {
    if brightest.is_empty() {
        return 1.0;
    }
    let at = ((brightest.len() - 1) as f64 * METERED_SHARE) as usize;
    let radiance = f64::from(*brightest.select_nth_unstable_by(at, f32::total_cmp).1);
    if radiance.is_nan() || radiance <= 0.0 {
        return 1.0;
    }
    let shown = |exposed: f64| encode(if tone == Tone::Filmic { filmic(exposed) } else { exposed });
    // Both curves rise from 0 to 1 within 0 to 5.6.
    let (mut below, mut above) = (0.0, 5.6);
    for _ in 0..60 {
        let middle = 0.5 * (below + above);
        *if shown(middle) < METERED_SHOWN { &mut below } else { &mut above } = middle;
    }
    let stops = (above / radiance).clamp(METERED_RANGE[0], METERED_RANGE[1]).log2();
    ((16.0 * stops).floor() / 16.0).exp2()
}

/// A channel's radiance as sRGB: exposure, tone curve, sRGB curve, rounding.
pub(super) fn byte(radiance: f32, exposure: f64, tone: Tone) -> u8 {
    let exposed = f64::from(radiance) * exposure;
    (encode(if tone == Tone::Filmic { filmic(exposed) } else { exposed }) * 255.0 + 0.5) as u8
}

/// Writes sRGB bytes, row by row from the top, as `.png`. The file appears whole or not at all.
pub fn save_png(path: &Path, [width, height]: [usize; 2], bytes: &[u8]) -> Result<()> {
    let (color, format) = (image::ExtendedColorType::Rgb8, image::ImageFormat::Png);
    encode_atomically(path, |file| {
        image::write_buffer_with_format(file, bytes, width as u32, height as u32, color, format)
            .map_err(|e| e.to_string())
    })
}

/// Whether the file of a picture of this name is a PNG, with 8 bits a channel.
#[must_use]
pub fn is_png(path: &Path) -> bool {
    matches!(kind(path), Ok(Kind::Png))
}

impl Picture {
    /// Linear radiance, shown as it is: exposure 1, no tone curve.
    pub fn plain(width: usize, height: usize, pixels: Vec<[f32; 3]>) -> Self {
        Self { width, height, pixels, exposure: 1.0, tone: Tone::Clip }
    }

    /// The picture as sRGB, 8 bits per channel, row by row from the top: exposure, tone curve, sRGB curve, rounding.
    pub fn bytes(&self) -> Vec<u8> {
        let shown = |x: &f32| byte(*x, self.exposure, self.tone);
        self.pixels.iter().flat_map(|pixel| pixel.iter().map(shown)).collect()
    }

    /// Writes a `.png` (sRGB, 8 bits per channel) or a linear `.exr`; the extension decides, and a device such as
    /// `/dev/stdout` gets a PNG. The file appears whole or not at all.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<()> {
        let path = path.as_ref();
        match kind(path)? {
            Kind::Png => save_png(path, [self.width, self.height], &self.bytes()),
            Kind::Exr => encode_atomically(path, |file| {
                let pixel = |at: Vec2<usize>| {
                    let [r, g, b] = self.pixels[at.y() * self.width + at.x()];
                    (r, g, b)
                };
                let image = Image::from_channels((self.width, self.height), SpecificChannels::rgb(pixel));
                image.write().non_parallel().to_buffered(file).map_err(|e| e.to_string())
            }),
        }
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
        None if is_device(path) => Ok(Kind::Png),
        other => Err(Input::new("a picture's name says its format")
            .key("-o")
            .found(other.map_or_else(|| "no ending".to_string(), |e| format!(".{e}")))
            .expected(".png or .exr")
            .into()),
    }
}

/// Checks the picture's extension before any work is done.
pub fn check(path: &Path) -> Result<()> {
    kind(path).map(|_| ())
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
    fn the_filmic_curve_rises_from_0_to_1() {
        assert!(filmic(0.0).abs() < 1e-15 && (filmic(5.6) - 1.0).abs() < 1e-15 && filmic(1e300) == filmic(5.6));
        // Hable's own numbers: A 0.15, B 0.5, C 0.1, D 0.2, E 0.02, F 0.3.
        let hable =
            |x: f64| (x * (0.15 * x + 0.1 * 0.5) + 0.2 * 0.02) / (x * (0.15 * x + 0.5) + 0.2 * 0.3) - 0.02 / 0.3;
        let values: Vec<f64> = (0..=100).map(|i| filmic(0.056 * f64::from(i))).collect();
        assert!(values.windows(2).all(|pair| pair[0] < pair[1]));
        assert!((values[50] - hable(5.6) / hable(11.2)).abs() < 1e-12);
    }
}
