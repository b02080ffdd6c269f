//! Images as linear numbers: OpenEXR, Radiance HDR, and PNG with its sRGB undone.

use std::path::Path;

/// Size and pixels of an image file, rows from the top, or what is wrong with it.
pub(super) type Image = Result<([u32; 2], Vec<[f32; 3]>), String>;

pub(super) fn read_exr(path: &Path) -> Image {
    let image = exr::prelude::read_first_rgba_layer_from_file(
        path,
        |size, _| (size.width(), vec![[0f32; 3]; size.area()]),
        |(width, pixels), at, (r, g, b, _): (f32, f32, f32, f32)| pixels[at.y() * *width + at.x()] = [r, g, b],
    );
    let (width, pixels) = image.map_err(|error| error.to_string())?.layer_data.channel_data.pixels;
    let height = pixels.len() / width.max(1);
    Ok(([width as u32, height as u32], pixels))
}

pub(super) fn read_hdr(path: &Path) -> Image {
    let image = decode(path)?.into_rgb32f();
    let size = [image.width(), image.height()];
    Ok((size, image.pixels().map(|pixel| pixel.0).collect()))
}

/// 8 or 16 bits a channel, or one channel of grey; opacity is passed over.
pub(super) fn read_png(path: &Path) -> Image {
    let image = decode(path)?.into_rgb16();
    let size = [image.width(), image.height()];
    let linear = |x: u16| {
        let x = f64::from(x) / 65535.0;
        let light = if x <= 0.040_45 { x / 12.92 } else { ((x + 0.055) / 1.055).powf(2.4) };
        light as f32
    };
    Ok((size, image.pixels().map(|pixel| pixel.0.map(linear)).collect()))
}

fn decode(path: &Path) -> Result<image::DynamicImage, String> {
    let reader = image::ImageReader::open(path).map_err(|error| error.to_string())?;
    reader.decode().map_err(|error| error.to_string())
}
