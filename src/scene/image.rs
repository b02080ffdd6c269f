//! Images as linear numbers: OpenEXR, Radiance HDR, and PNG with its sRGB undone; or as they are, where they hold depths.

use std::path::Path;

/// Size and pixels of an image file, rows from the top, or what is wrong with it.
pub(super) type Image = Result<([u32; 2], Vec<[f32; 3]>), String>;

/// Most pixels of a file: more are refused before any memory is taken for them.
const MOST_PIXELS: usize = 1 << 26;

fn few_enough(width: usize, height: usize) -> Result<(), String> {
    match width.checked_mul(height) {
        Some(pixels) if pixels <= MOST_PIXELS => Ok(()),
        _ => Err(format!("{width} x {height} pixels, more than {MOST_PIXELS}")),
    }
}

/// Whether all layers of an OpenEXR file, by its header, have few enough pixels.
fn check_exr(path: &Path) -> Result<(), String> {
    let meta = exr::meta::MetaData::read_from_file(path, false).map_err(|error| error.to_string())?;
    meta.headers.iter().try_for_each(|header| few_enough(header.layer_size.width(), header.layer_size.height()))
}

pub(super) fn read_exr(path: &Path) -> Image {
    check_exr(path)?;
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

/// Size, pixels of up to four channels with nothing undone, and how many there are.
pub(super) type Depths = Result<([u32; 2], Vec<[f32; 4]>, usize), String>;

/// Numbers of a .png (8 or 16 bits, 0 to 1) or .exr (channels R, G, B, A, or one alone) as they are, rows from the top;
/// none where the name ends otherwise.
pub(super) fn read_depths(path: &Path) -> Option<Depths> {
    let end = path.extension().and_then(|end| end.to_str()).unwrap_or_default().to_ascii_lowercase();
    match end.as_str() {
        "png" => Some(decode(path).map(|image| {
            let (channels, image) = (usize::from(image.color().channel_count()), image.into_rgba16());
            let size = [image.width(), image.height()];
            // Grey with opacity: two channels.
            let order = if channels == 2 { [0, 3, 3, 3] } else { [0, 1, 2, 3] };
            let share = |pixel: [u16; 4]| order.map(|c| (f64::from(pixel[c]) / 65535.0) as f32);
            (size, image.pixels().map(|pixel| share(pixel.0)).collect(), channels)
        })),
        "exr" => Some(exr_depths(path)),
        _ => None,
    }
}

fn exr_depths(path: &Path) -> Depths {
    check_exr(path)?;
    let layer = exr::prelude::read_first_flat_layer_from_file(path).map_err(|error| error.to_string())?.layer_data;
    let list = &layer.channel_data.list;
    let named = |name: &&str| list.iter().find(|channel| channel.name.eq_case_insensitive(name));
    let mut channels: Vec<_> = ["R", "G", "B", "A"].iter().map_while(named).collect();
    if channels.is_empty() {
        channels = list.iter().take(1).collect();
    }
    let mut pixels = vec![[0f32; 4]; layer.size.area()];
    for (c, channel) in channels.iter().enumerate() {
        let values = channel.sample_data.values_as_f32();
        pixels.iter_mut().zip(values).for_each(|(pixel, value)| pixel[c] = value);
    }
    Ok(([layer.size.width() as u32, layer.size.height() as u32], pixels, channels.len()))
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
    let open = || image::ImageReader::open(path).map_err(|error| error.to_string());
    let (width, height) = open()?.into_dimensions().map_err(|error| error.to_string())?;
    few_enough(width as usize, height as usize)?;
    open()?.decode().map_err(|error| error.to_string())
}
