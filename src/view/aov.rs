//! Layers beside the picture in an OpenEXR file, for compositing and inspection: floats, and integers for values that
//! must not be blended.

use std::path::Path;

use exr::prelude::{
    AnyChannel, AnyChannels, Encoding, FlatSamples, Image, ImageAttributes, Layer as ExrLayer, LayerAttributes,
    SmallVec, WritableImage,
};

use super::atomic_file::encode_atomically;
use super::picture::Picture;
use crate::error::Result;

/// The values of one channel, row by row from the top.
#[derive(Clone, Debug, PartialEq)]
pub enum Samples {
    /// Linear, in the scene's units.
    Float(Vec<f32>),
    /// Indices, where all ones means none; or counts.
    Whole(Vec<u32>),
}

/// A layer: its name, and its channels by name.
#[derive(Clone, Debug, PartialEq)]
pub struct Layer {
    /// The name, without spaces.
    pub name: &'static str,
    /// The channels.
    pub channels: Vec<(&'static str, Samples)>,
    /// What a reader must know about the layer: its `comments` in the file.
    pub comment: Option<&'static str>,
}

impl Layer {
    /// A layer of three floats per pixel.
    #[must_use]
    pub fn vector(name: &'static str, channels: [&'static str; 3], values: &[[f32; 3]]) -> Self {
        let one = |c: usize| (channels[c], Samples::Float(values.iter().map(|v| v[c]).collect()));
        Self { name, channels: (0..3).map(one).collect(), comment: None }
    }

    /// A layer of one value per pixel.
    #[must_use]
    pub fn single(name: &'static str, channel: &'static str, samples: Samples) -> Self {
        Self { name, channels: vec![(channel, samples)], comment: None }
    }
}

/// Writes the picture as the layer `picture`, followed by the other layers.
pub fn save(picture: &Picture, layers: &[Layer], path: &Path) -> Result<()> {
    let size = (picture.width, picture.height);
    let mut first = Layer::vector("picture", ["R", "G", "B"], &picture.pixels);
    first.channels.extend(picture.alpha.clone().map(|alpha| ("A", Samples::Float(alpha))));
    let layer = |layer: &Layer| {
        let channel = |(name, samples): &(&'static str, Samples)| {
            let flat = match samples {
                Samples::Float(values) => FlatSamples::F32(values.clone()),
                Samples::Whole(values) => FlatSamples::U32(values.clone()),
            };
            AnyChannel::new(*name, flat)
        };
        let channels: SmallVec<[AnyChannel<FlatSamples>; 4]> = layer.channels.iter().map(channel).collect();
        let mut attributes = LayerAttributes::named(layer.name);
        attributes.comments = layer.comment.map(Into::into);
        ExrLayer::new(size, attributes, Encoding::FAST_LOSSLESS, AnyChannels::sort(channels))
    };
    let all: Vec<_> = std::iter::once(&first).chain(layers).map(layer).collect();
    let image = Image::from_layers(ImageAttributes::with_size(size), all);
    encode_atomically(path, |file| image.write().non_parallel().to_buffered(file).map_err(|e| e.to_string()))
}
