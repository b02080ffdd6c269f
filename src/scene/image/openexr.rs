//! Reads OpenEXR files: the colours, or else the grey, of the layer that most likely is the picture, and channels
//! without conversion.

use super::{Depths, Image, chunks, fits};
use crate::scene::files::Files;
use exr::image::read::read;
use exr::meta::BlockDescription;
use exr::meta::attribute::EnvironmentMap;
use exr::meta::header::Header;
use exr::prelude::{Image as Decoded, *};
use std::io::Cursor;
use std::path::Path;
use std::result::Result;

/// Names of layers that stand for the whole picture where there are others beside them.
const WHOLE: [&str; 3] = ["combined", "beauty", "rgba"];
/// Maximum number of channels or layers that a message lists.
const LISTED: usize = 12;

/// Reads the bytes of a file and checks the size of every layer by its header.
fn open(files: &Files, path: &Path, most: usize, kept: u64) -> Result<(Vec<u8>, MetaData), String> {
    let bytes = files.read(path, 1).map_err(|error| error.to_string())?;
    let mut cursor = Cursor::new(&bytes);
    let meta = MetaData::read_from_buffered(&mut cursor, false).map_err(|error| error.to_string())?;
    let headers = cursor.position() as usize;
    // The exr reader checks the parts' own headers only, and would read the samples of a deep pixel as pixels.
    if meta.requirements.has_deep_data {
        return Err("deep data, which is not supported".into());
    }
    for header in &meta.headers {
        let size = [header.layer_size.width() as u64, header.layer_size.height() as u64];
        let stored = header.channels.bytes_per_pixel as u64;
        fits(files, size, most, [stored, kept, 2 * stored], bytes.len())?;
        // A tile may be larger than the picture; the reader allocates as much of it as the file claims to hold.
        if let BlockDescription::Tiles(tiles) = header.blocks {
            let [width, height] = [tiles.tile_size.width() as u64, tiles.tile_size.height() as u64];
            let pixels = width.saturating_mul(height);
            if pixels > most as u64 {
                return Err(format!("tiles of {width} x {height} pixels, more than {most}"));
            }
            files.need(pixels.saturating_mul(2 * stored)).map_err(|error| error.to_string())?;
        }
    }
    chunks::check(files, &bytes, headers, &meta)?;
    Ok((bytes, meta))
}

/// A layer that can be shown.
struct Shown {
    /// Its name; empty for channels without one.
    name: String,
    /// Its channels: red, green and blue, or one.
    channels: Vec<Text>,
}

impl Shown {
    /// Less for a layer that is more likely meant to be seen: one without a name, then [`WHOLE`], then others; of each
    /// kind colours before grey.
    fn rank(&self) -> usize {
        let last = self.name.rsplit('.').next().unwrap_or_default().to_lowercase();
        let named = match last.as_str() {
            "" => 0,
            last if WHOLE.contains(&last) => 2,
            _ => 4,
        };
        named + usize::from(self.channels.len() == 1)
    }

    /// All such layers of a file, by rank: `R`, `G` and `B`, or else `Y`, in either case, after a name and a dot if
    /// they belong to one.
    fn all(meta: &MetaData) -> Vec<Self> {
        let mut all: Vec<Self> = Vec::new();
        for header in &meta.headers {
            let part = header.own_attributes.layer_name.as_ref().map(ToString::to_string).unwrap_or_default();
            let split = |channel: &ChannelDescription| {
                let name = channel.name.to_string();
                let (above, last) = name.rsplit_once('.').unwrap_or(("", name.as_str()));
                (above.to_owned(), last.to_ascii_uppercase(), channel.name.clone())
            };
            let names: Vec<_> = header.channels.list.iter().map(split).collect();
            let mut above: Vec<&str> = names.iter().map(|(above, ..)| above.as_str()).collect();
            above.dedup();
            for above in above {
                let named =
                    |last: &str| names.iter().find(|name| name.0 == above && name.1 == last).map(|name| &name.2);
                let colors: Option<Vec<Text>> = ["R", "G", "B"].into_iter().map(|last| named(last).cloned()).collect();
                let grey = || named("Y").map(|name| vec![name.clone()]);
                let Some(channels) = colors.or_else(grey) else { continue };
                // The reader takes the first part that has these channels.
                if !all.iter().any(|other| other.channels == channels) {
                    let name = if above.is_empty() && meta.headers.len() > 1 { part.clone() } else { above.to_owned() };
                    all.push(Self { name, channels });
                }
            }
        }
        all.sort_by_key(Self::rank);
        all
    }
}

/// Reads the first layer by rank, in colours or grey; says in `notes` which of several layers it is.
pub(in crate::scene) fn read_exr(files: &Files, path: &Path, most: usize, notes: &mut Vec<String>) -> Image {
    let (bytes, meta) = open(files, path, most, 12)?;
    let cube = |header: &Header| header.own_attributes.environment_map == Some(EnvironmentMap::Cube);
    if meta.headers.iter().any(cube) {
        return Err("a cube map (`envmap` is cube), where an image of latitude and longitude can be read".into());
    }
    let names = meta.headers.iter().flat_map(|header| &header.channels.list).map(|channel| channel.name.to_string());
    let names: Vec<String> = names.collect();
    let layers = Shown::all(&meta);
    let Some(Shown { name, channels }) = layers.first() else {
        let more = names.len().saturating_sub(LISTED);
        let more = if more > 0 { format!(" and {more} more") } else { String::new() };
        return Err(format!(
            "channels {}{more}; R, G and B, or Y, are read",
            names[..names.len().min(LISTED)].join(", ")
        ));
    };
    if layers.len() > 1 {
        let all: Vec<_> = layers.iter().take(LISTED).map(|layer| format!("`{}`", layer.name)).collect();
        notes.push(format!("{}: layer `{name}` of {}: {}", path.display(), layers.len(), all.join(", ")));
    }

    let blank = |size: Vec2<usize>| (size.width(), vec![[0f32; 3]; size.area()]);
    let reader = read().no_deep_data().largest_resolution_level();
    let fault = |error: Error| error.to_string();
    let (width, pixels) = match channels.as_slice() {
        [r, g, b] => {
            let reader = reader.specific_channels().required(r.clone()).required(g.clone()).required(b.clone());
            let reader = reader.collect_pixels(
                |size, _| blank(size),
                |(width, pixels), at, (r, g, b): (f32, f32, f32)| pixels[at.y() * *width + at.x()] = [r, g, b],
            );
            let reader = reader.first_valid_layer().all_attributes().non_parallel();
            reader.from_buffered(Cursor::new(bytes)).map_err(fault)?.layer_data.channel_data.pixels
        }
        [y, ..] => {
            if names.iter().any(|name| ["RY", "BY"].contains(&name.as_str())) {
                notes.push(format!("{}: grey: its colours, channels RY and BY, are not read", path.display()));
            }
            let reader = reader.specific_channels().required(y.clone()).collect_pixels(
                |size, _| blank(size),
                |(width, pixels), at, (y,): (f32,)| pixels[at.y() * *width + at.x()] = [y; 3],
            );
            let reader = reader.first_valid_layer().all_attributes().non_parallel();
            reader.from_buffered(Cursor::new(bytes)).map_err(fault)?.layer_data.channel_data.pixels
        }
        [] => return Err("a layer without channels".into()),
    };
    let height = pixels.len() / width.max(1);
    Ok(([width as u32, height as u32], pixels))
}

/// Reads channels R, G, B and A, or a single one, unconverted.
pub(super) fn depths(files: &Files, path: &Path, most: usize) -> Depths {
    let (bytes, _) = open(files, path, most, 16)?;
    let reader = read().no_deep_data().largest_resolution_level().all_channels();
    let reader = reader.first_valid_layer().all_attributes().non_parallel();
    let image: Decoded<Layer<AnyChannels<FlatSamples>>> =
        reader.from_buffered(Cursor::new(bytes)).map_err(|error| error.to_string())?;
    let layer = image.layer_data;
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

#[cfg(test)]
mod tests {
    use super::*;
    use exr::prelude::{Layer, LayerAttributes};

    /// A part: its name, and its channels.
    type Part<'a> = (&'a str, &'a [(&'a str, f32)]);

    /// A file of parts, each with channels of one pixel by name.
    fn file(parts: &[Part<'_>], envmap: Option<EnvironmentMap>) -> Vec<u8> {
        let layer = |(name, channels): &Part<'_>| {
            let channels = channels.iter().map(|(name, x)| AnyChannel::new(*name, FlatSamples::F32(vec![*x])));
            let attributes = LayerAttributes {
                layer_name: Text::new_or_none(name).filter(|_| !name.is_empty()),
                environment_map: envmap,
                ..LayerAttributes::default()
            };
            Layer::new((1, 1), attributes, Encoding::UNCOMPRESSED, AnyChannels::sort(channels.collect()))
        };
        let attributes = ImageAttributes::new(IntegerBounds::from_dimensions((1, 1)));
        let mut bytes = Cursor::new(Vec::new());
        let image = Decoded::from_layers(attributes, parts.iter().map(layer).collect::<Vec<_>>());
        image.write().to_buffered(&mut bytes).expect("written");
        bytes.into_inner()
    }

    fn pixel(bytes: Vec<u8>) -> (Result<[f32; 3], String>, Vec<String>) {
        let files = Files::held([("a.exr".into(), bytes)], 1 << 20);
        let mut notes = Vec::new();
        let read = read_exr(&files, Path::new("a.exr"), 1, &mut notes);
        (read.map(|(_, pixels)| pixels[0]), notes)
    }

    #[test]
    fn colours_come_first_then_grey_and_layers_by_name() {
        let cases: [(&[Part<'_>], [f32; 3], &[&str]); 6] = [
            (&[("", &[("Y", 0.5)])], [0.5; 3], &[]),
            (&[("", &[("A", 1.0), ("y", 0.5)])], [0.5; 3], &[]),
            (&[("", &[("beauty.B", 3.0), ("beauty.G", 2.0), ("beauty.R", 1.0), ("Z", 9.0)])], [1.0, 2.0, 3.0], &[]),
            (
                &[(
                    "",
                    &[
                        ("N.B", 7.0),
                        ("N.G", 7.0),
                        ("N.R", 7.0),
                        ("V.Combined.R", 1.0),
                        ("V.Combined.G", 2.0),
                        ("V.Combined.B", 3.0),
                    ],
                )],
                [1.0, 2.0, 3.0],
                &["a.exr: layer `V.Combined` of 2: `V.Combined`, `N`"],
            ),
            (&[("depth", &[("Z", 7.0)]), ("sky", &[("b", 3.0), ("g", 2.0), ("r", 1.0)])], [1.0, 2.0, 3.0], &[]),
            (
                &[("", &[("BY", 0.1), ("RY", 0.2), ("Y", 0.5)])],
                [0.5; 3],
                &["a.exr: grey: its colours, channels RY and BY, are not read"],
            ),
        ];
        for (parts, expected, said) in cases {
            let (found, notes) = pixel(file(parts, None));
            assert_eq!((found, notes), (Ok(expected), said.iter().map(ToString::to_string).collect()), "{parts:?}");
        }
        let (found, _) = pixel(file(&[("", &[("A", 1.0), ("Z", 1.0), ("uv.x", 1.0)])], None));
        assert_eq!(found, Err("channels A, Z, uv.x; R, G and B, or Y, are read".into()));
    }

    #[test]
    fn a_cube_is_no_latitude_and_longitude() {
        let colors: &[(&str, f32)] = &[("B", 1.0), ("G", 1.0), ("R", 1.0)];
        let (found, _) = pixel(file(&[("", colors)], Some(EnvironmentMap::Cube)));
        assert!(found.is_err_and(|words| words.starts_with("a cube map")));
        let (found, _) = pixel(file(&[("", colors)], Some(EnvironmentMap::LatitudeLongitude)));
        assert_eq!(found, Ok([1.0; 3]));
    }
}
