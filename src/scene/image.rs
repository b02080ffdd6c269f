//! Reads images as linear values: OpenEXR, Radiance HDR, PNG and JPEG decoded from sRGB. Depth maps are read without
//! conversion.
//!
//! The size that a file states is checked before memory is allocated: against the maximum number of pixels, the file's
//! length, and the scene's memory limit.

mod chunks;
mod openexr;

pub(super) use openexr::read_exr;

use super::files::Files;
use image::codecs::hdr::HdrDecoder;
use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};
use std::io::{Cursor, Read};
use std::path::Path;

/// Size and pixels of an image file, rows from the top, or an error message.
pub(super) type Image = Result<([u32; 2], Vec<[f32; 3]>), String>;

/// Maximum texels of a texture: as many as the smallest devices can bind.
pub(super) const MOST_TEXELS: usize = 1 << 23;

/// Maximum bytes of pixels per byte of a file: above the ratio of deflated 1-bit images, and of deflated uniform images
/// that were transformed in squares.
const MOST_PACKED: u64 = 1 << 17;

/// Maximum memory that an image's metadata, such as a colour profile, may take, bytes.
const MOST_BESIDE: u64 = 64 << 20;

/// Bytes at the start of a Radiance file in which its format is looked for.
const LONGEST_HEAD: usize = 4096;

/// Checks the size of an image and takes memory for it: per pixel, `stored` bytes uncompressed in the file, `kept`
/// after reading, and `held` in addition while reading.
fn fits(
    files: &Files,
    size: [u64; 2],
    most: usize,
    [stored, kept, held]: [u64; 3],
    length: usize,
) -> Result<(), String> {
    let [width, height] = size;
    let pixels = width.saturating_mul(height);
    if pixels > most as u64 {
        return Err(format!("{width} x {height} pixels, more than {most}"));
    }
    if pixels.saturating_mul(stored) / MOST_PACKED > length as u64 {
        return Err(format!("{width} x {height} pixels in a file of {length} bytes"));
    }
    files.need(pixels.saturating_mul(held.saturating_add(kept))).map_err(|error| error.to_string())?;
    files.take(pixels * kept).map_err(|error| error.to_string())
}

/// Clamps the first `used` channels of every pixel to 0 to `most`; a line in `notes` says how many were beyond, and how
/// far. Fails with the index of the first pixel that is not finite.
pub(super) fn clamp<const N: usize>(
    pixels: &mut [[f32; N]],
    used: usize,
    most: f32,
    path: &Path,
    notes: &mut Vec<String>,
) -> Result<(), usize> {
    if let Some(place) = pixels.iter().position(|pixel| pixel[..used].iter().any(|x| !x.is_finite())) {
        return Err(place);
    }
    let (mut count, mut least, mut greatest) = (0, 0f32, most);
    for pixel in pixels.iter_mut().map(|pixel| &mut pixel[..used]) {
        count += usize::from(!pixel.iter().all(|x| (0.0..=most).contains(x)));
        for x in pixel {
            (least, greatest) = (least.min(*x), greatest.max(*x));
            *x = x.clamp(0.0, most);
        }
    }
    if count > 0 {
        let low = if least < 0.0 { format!(", the least {least:?}") } else { String::new() };
        let high = if greatest > most { format!(", the greatest {greatest:?}") } else { String::new() };
        notes.push(format!("clamped: {count} of {} pixels of {}{low}{high}", pixels.len(), path.display()));
    }
    Ok(())
}

/// Reads a Radiance file; pixels are divided by its `EXPOSURE` and `COLORCORR`. Its first line, `#?` and a name that
/// depends on who wrote it, may be missing.
pub(super) fn read_hdr(files: &Files, path: &Path, most: usize) -> Image {
    let bytes = bytes(files, path)?;
    let marked = bytes.starts_with(b"#?");
    let first =
        if marked { bytes.iter().position(|byte| *byte == b'\n').map_or(bytes.len(), |end| end + 1) } else { 0 };
    let rest = &bytes[first..];
    if !marked && !rest[..rest.len().min(LONGEST_HEAD)].windows(7).any(|word| word == b"FORMAT=") {
        return Err("neither `#?` nor a line FORMAT= at its start".into());
    }
    let decoder = HdrDecoder::new((&b"#?RADIANCE\n"[..]).chain(rest)).map_err(|error| error.to_string())?;
    let meta = decoder.metadata();
    let factor = [0, 1, 2]
        .map(|c| meta.exposure.unwrap_or(1.0) * meta.color_correction.map_or(1.0, |rgb| [rgb.0, rgb.1, rgb.2][c]));
    if factor.iter().any(|f| !f.is_normal() || *f < 0.0) {
        return Err(format!("an exposure and colour correction of {factor:?}"));
    }
    // Runs repeat a pixel without limit, so that the file's length bounds nothing: `stored` is 0.
    fits(files, [meta.width.into(), meta.height.into()], most, [0, 16, 32], bytes.len())?;
    let image = DynamicImage::from_decoder(decoder).map_err(|error| error.to_string())?.into_rgb32f();
    let light = |pixel: [f32; 3]| [0, 1, 2].map(|c| pixel[c] / factor[c]);
    Ok(([image.width(), image.height()], image.pixels().map(|pixel| light(pixel.0)).collect()))
}

/// Size, unconverted pixels of up to four channels, and the number of channels.
pub(super) type Depths = Result<([u32; 2], Vec<[f32; 4]>, usize), String>;

/// Reads unconverted values of a .png (8 or 16 bits, scaled to 0 to 1) or .exr (channels R, G, B, A, or a single one),
/// rows from the top; `None` for other extensions.
pub(super) fn read_depths(files: &Files, path: &Path, most: usize) -> Option<Depths> {
    let end = path.extension().and_then(|end| end.to_str()).unwrap_or_default().to_ascii_lowercase();
    match end.as_str() {
        "png" => {
            Some(bytes(files, path).and_then(|bytes| decode(files, &bytes, ImageFormat::Png, most)).map(|image| {
                let (channels, image) = (usize::from(image.color().channel_count()), image.into_rgba16());
                let size = [image.width(), image.height()];
                // Two channels are grey and alpha.
                let order = if channels == 2 { [0, 3, 3, 3] } else { [0, 1, 2, 3] };
                let share = |pixel: [u16; 4]| order.map(|c| (f64::from(pixel[c]) / 65535.0) as f32);
                (size, image.pixels().map(|pixel| share(pixel.0)).collect(), channels)
            }))
        }
        "exr" => Some(openexr::depths(files, path, most)),
        _ => None,
    }
}

fn bytes(files: &Files, path: &Path) -> Result<Vec<u8>, String> {
    files.read(path, 1).map_err(|error| error.to_string())
}

/// Reads a PNG of 8 or 16 bits per channel, in colour or grey, or a JPEG; alpha is ignored.
pub(super) fn read_packed(files: &Files, path: &Path) -> Image {
    unpack(files, &bytes(files, path)?)
}

/// The same for the bytes of a file; a JPEG is recognised by the first ones.
pub(super) fn unpack(files: &Files, bytes: &[u8]) -> Image {
    let format = if bytes.starts_with(&[0xff, 0xd8]) { ImageFormat::Jpeg } else { ImageFormat::Png };
    let image = decode(files, bytes, format, MOST_TEXELS)?.into_rgb16();
    let size = [image.width(), image.height()];
    let linear = |x: u16| {
        let x = f64::from(x) / 65535.0;
        let light = if x <= 0.040_45 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) };
        light as f32
    };
    Ok((size, image.pixels().map(|pixel| pixel.0.map(linear)).collect()))
}

/// Checks that a PNG's palettes hold 1 to 256 whole colours, as the decoder assumes. A chunk is its length in four
/// bytes, a name in four, that many bytes, and a checksum in four.
fn whole_palettes(bytes: &[u8]) -> Result<(), String> {
    let mut rest = bytes.get(8..).unwrap_or_default();
    while let Some((head, body)) = rest.split_first_chunk::<8>() {
        let length = u32::from_be_bytes([head[0], head[1], head[2], head[3]]) as usize;
        if head[4..] == *b"PLTE" && (!length.is_multiple_of(3) || !(3..=768).contains(&length)) {
            return Err(format!("a palette of {length} bytes, not of 1 to 256 colours of three bytes"));
        }
        rest = body.get(length.saturating_add(4)..).unwrap_or_default();
    }
    Ok(())
}

fn decode(files: &Files, bytes: &[u8], format: ImageFormat, most: usize) -> Result<DynamicImage, String> {
    if format == ImageFormat::Png {
        whole_palettes(bytes)?;
    }
    let mut reader = ImageReader::with_format(Cursor::new(bytes), format);
    // The decoder unpacks metadata such as colour profiles before the pixels: limit the memory for it.
    let mut limits = Limits::default();
    limits.max_alloc = Some(files.memory().left().min(MOST_BESIDE));
    reader.limits(limits);
    let decoder = reader.into_decoder().map_err(|error| error.to_string())?;
    let (width, height) = decoder.dimensions();
    let stored = u64::from(decoder.color_type().bits_per_pixel() / 8);
    fits(files, [width.into(), height.into()], most, [stored, 16, 32], bytes.len())?;
    DynamicImage::from_decoder(decoder).map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_was_multiplied_into_a_radiance_file_is_undone() {
        let file = |lines: &str| {
            let head = format!("#?RADIANCE\n{lines}FORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n");
            [head.as_bytes(), &[128, 64, 32, 129]].concat()
        };
        let names = ["plain", "bright", "tinted", "zero"];
        let lines = ["", "EXPOSURE=2\nEXPOSURE=2\n", "COLORCORR=1 2 4\nEXPOSURE=0.5\n", "EXPOSURE=0\n"];
        let files = Files::held(names.iter().zip(lines).map(|(name, lines)| (name.into(), file(lines))), 1 << 20);
        let pixel = |name: &str| read_hdr(&files, Path::new(name), 1).map(|(_, pixels)| pixels[0]);
        assert_eq!(pixel("plain"), Ok([1.0, 0.5, 0.25]));
        assert_eq!(pixel("bright"), Ok([0.25, 0.125, 0.0625]));
        assert_eq!(pixel("tinted"), Ok([2.0, 0.5, 0.125]));
        assert!(pixel("zero").is_err_and(|words| words.contains("exposure")));
    }

    #[test]
    fn a_radiance_file_begins_with_any_name_or_none() {
        for first in ["#?RGBE\n", "#?AUTOPANO pro\n", "#?\n", "", "# made by hand\n"] {
            let head = format!("{first}FORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 1\n");
            let files = Files::held([("a".into(), [head.as_bytes(), &[128, 64, 32, 129]].concat())], 1 << 20);
            let read = read_hdr(&files, Path::new("a"), 1).map(|(_, pixels)| pixels[0]);
            assert_eq!(read, Ok([1.0, 0.5, 0.25]), "{first:?}");
        }
    }

    #[test]
    fn what_is_out_of_range_is_clamped_and_counted() {
        let clamped = |values: &[[f32; 2]], most: f32| {
            let (mut values, mut notes) = (values.to_vec(), Vec::new());
            clamp(&mut values, 1, most, Path::new("a.exr"), &mut notes).map(|()| (values, notes))
        };
        let all = [[-3e-6, -9.0], [0.5, 0.0], [1.0005, 0.0]];
        let line = "clamped: 2 of 3 pixels of a.exr, the least -3e-6, the greatest 1.0005";
        assert_eq!(clamped(&all, 1.0), Ok((vec![[0.0, -9.0], [0.5, 0.0], [1.0, 0.0]], vec![line.into()])));
        let line = "clamped: 1 of 3 pixels of a.exr, the least -3e-6";
        assert_eq!(clamped(&all, f32::MAX), Ok((vec![[0.0, -9.0], [0.5, 0.0], [1.0005, 0.0]], vec![line.into()])));
        assert_eq!(clamped(&all[1..2], 1.0), Ok((all[1..2].to_vec(), Vec::new())));
        for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            assert_eq!(clamped(&[[0.0; 2], [bad, 0.0]], 1.0), Err(1));
        }
    }
}
