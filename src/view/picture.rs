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
/// let grey = Picture { exposure: 2.0, ..Picture::plain(2, 1, vec![[0.5; 3]; 2]) };
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
    /// The share of each pixel that shows an object, 0 to 1, which its radiance is multiplied by already; none where
    /// the picture is opaque.
    pub alpha: Option<Vec<f32>>,
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

/// Writes sRGB bytes, row by row from the top, as `.png`: three a pixel, or four, the last of which is alpha. The file
/// appears whole or not at all.
pub fn save_png(path: &Path, [width, height]: [usize; 2], bytes: &[u8]) -> Result<()> {
    let alpha = bytes.len() == 4 * width * height;
    let color = if alpha { image::ExtendedColorType::Rgba8 } else { image::ExtendedColorType::Rgb8 };
    let format = image::ImageFormat::Png;
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
    /// Linear radiance, opaque, shown as it is: exposure 1, no tone curve.
    pub fn plain(width: usize, height: usize, pixels: Vec<[f32; 3]>) -> Self {
        Self { width, height, pixels, alpha: None, exposure: 1.0, tone: Tone::Clip }
    }

    /// The picture as sRGB, 8 bits per channel, row by row from the top: exposure, tone curve, sRGB curve, rounding.
    /// What is transparent stands before black.
    pub fn bytes(&self) -> Vec<u8> {
        let shown = |x: &f32| byte(*x, self.exposure, self.tone);
        self.pixels.iter().flat_map(|pixel| pixel.iter().map(shown)).collect()
    }

    /// The same with alpha, four bytes a pixel: the colours are those of the objects alone, not multiplied by alpha.
    fn straight(&self, alpha: &[f32]) -> Vec<u8> {
        let pixels = self.pixels.iter().zip(alpha);
        let shown = |(pixel, &alpha): (&[f32; 3], &f32)| {
            let [r, g, b] = pixel.map(|x| byte(if alpha > 0.0 { x / alpha } else { 0.0 }, self.exposure, self.tone));
            [r, g, b, (f64::from(alpha) * 255.0 + 0.5) as u8]
        };
        pixels.flat_map(shown).collect()
    }

    /// Writes a `.png` (sRGB, 8 bits per channel) or a linear `.exr`; the extension decides, and a device such as
    /// `/dev/stdout` gets a PNG. The colours of a transparent picture are multiplied by alpha in an EXR and not in a
    /// PNG, as these formats define. The file appears whole or not at all.
    pub fn save(&self, path: impl AsRef<Path>) -> Result<()> {
        let path = path.as_ref();
        match kind(path)? {
            Kind::Png => {
                let bytes = self.alpha.as_ref().map_or_else(|| self.bytes(), |alpha| self.straight(alpha));
                save_png(path, [self.width, self.height], &bytes)
            }
            Kind::Exr => encode_atomically(path, |file| {
                let size = (self.width, self.height);
                let place = |at: Vec2<usize>| at.y() * self.width + at.x();
                let color = |at: Vec2<usize>| self.pixels[place(at)].into();
                match &self.alpha {
                    None => Image::from_channels(size, SpecificChannels::rgb(color))
                        .write()
                        .non_parallel()
                        .to_buffered(file),
                    Some(alpha) => {
                        let pixel = |at: Vec2<usize>| {
                            let (r, g, b) = color(at);
                            (r, g, b, alpha[place(at)])
                        };
                        let image = Image::from_channels(size, SpecificChannels::rgba(pixel));
                        image.write().non_parallel().to_buffered(file)
                    }
                }
                .map_err(|e| e.to_string())
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
            .expected(".png or .exr; .gif with --frames or --turntable")
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
