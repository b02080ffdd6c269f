//! Depth maps: for each point of a surface the depths of the layers' lower interfaces.

use super::{Depth, pattern};
use crate::error::Input;
use crate::scene::files::Files;
use crate::scene::image::{MOST_TEXELS, clamp, read_depths};
use crate::scene::range::Checked;
use crate::scene::texture::{MOST_SIDE, Wrap};
use std::path::Path;
use std::sync::Arc;

/// A depth that no ray reaches, for channels beyond the last layer.
pub const BOTTOMLESS: f32 = 1e30;

/// Depths of the layers' lower interfaces, each at least that of the layer before.
#[derive(Debug, Clone, PartialEq)]
pub struct DepthMap {
    /// Width and height, in texels; 1 x 1 where the depths are the same everywhere.
    pub size: [u32; 2],
    /// Depths in scene units, rows from the top; the i-th run of width x height texels has layers 4 i to 4 i + 3.
    /// Channels beyond the last layer are 1e30.
    pub texels: Arc<Vec<[f32; 4]>>,
    /// How the map continues beyond its edges.
    pub wrap: Wrap,
    /// The greatest depth of the last layer's lower interface, scene units.
    pub deepest: f64,
    /// Whether depths vary, so that the mesh needs texture coordinates.
    pub mapped: bool,
    source: Source,
}

/// The files to read, and what their values mean.
#[derive(Debug, Clone, PartialEq)]
struct Source {
    maps: Vec<String>,
    layers: usize,
    scale: f64,
    depth: Depth,
}

impl DepthMap {
    /// Layers of uniform thickness, scene units; `None` if all are 0.
    #[must_use]
    pub fn constant(thick: &[f64]) -> Option<Self> {
        let mut depths = vec![[BOTTOMLESS; 4]; thick.len().div_ceil(4)];
        let mut depth = 0.0;
        for (layer, thick) in thick.iter().enumerate() {
            depth += thick;
            depths[layer / 4][layer % 4] = depth as f32;
        }
        let source = Source { maps: Vec::new(), layers: thick.len(), scale: 1.0, depth: Depth::Bright };
        let texels = Arc::new(depths);
        let map = Self { size: [1, 1], texels, wrap: Wrap::Clamp, deepest: depth, mapped: false, source };
        (depth > 0.0).then_some(map)
    }

    /// A map of `depths` in scene units, row by row from the top, all layers of a texel together; a depth less than
    /// that of the layer before is set to the latter. `None` if the last layer's depth is 0 everywhere.
    #[must_use]
    pub fn new(size: [u32; 2], layers: usize, depths: &[f64], wrap: Wrap) -> Option<Self> {
        let places = size[0] as usize * size[1] as usize;
        let mut texels = vec![[BOTTOMLESS; 4]; places * layers.div_ceil(4)];
        let mut deepest = 0.0;
        for (place, column) in depths.chunks_exact(layers).take(places).enumerate() {
            let mut before = 0f64;
            for (layer, &depth) in column.iter().enumerate() {
                before = before.max(depth);
                texels[layer / 4 * places + place][layer % 4] = before as f32;
            }
            deepest = f64::max(deepest, before);
        }
        let source = Source { maps: Vec::new(), layers, scale: 1.0, depth: Depth::Bright };
        let map = Self { size, texels: Arc::new(texels), wrap, deepest, mapped: true, source };
        (deepest > 0.0).then_some(map)
    }

    /// Maps that are still to be read, by name.
    pub(super) fn unread(maps: &[String], layers: usize, scale: f64, depth: Depth, wrap: Wrap) -> Self {
        let source = Source { maps: maps.to_vec(), layers, scale, depth };
        Self { size: [0, 0], texels: Arc::default(), wrap, deepest: 0.0, mapped: true, source }
    }

    /// Reads the maps, relative to `folder`; `key` is their key, for errors.
    pub(super) fn load(&mut self, files: &Files, folder: &Path, key: &str, report: &mut Vec<String>) -> Checked<()> {
        if self.source.maps.is_empty() || !self.texels.is_empty() {
            return Ok(());
        }
        let source = &self.source;
        let images = source.maps.iter().enumerate().map(|(k, name)| match pattern::of(name) {
            Some(image) => Ok(image),
            None => read(files, &folder.join(name), key, (source.layers - 4 * k).min(4), report),
        });
        let images = images.collect::<Checked<Vec<_>>>()?;
        let size = images[0].0;
        if let Some(k) = images.iter().position(|(other, _)| *other != size) {
            let [w, h] = images[k].0;
            let fault = Input::new("maps of several sizes").key(key).found(format!("{} is {w} x {h}", source.maps[k]));
            return Err(fault.expected(format!("{} x {}, as the first", size[0], size[1])));
        }

        // Convert values to depths, and count those above the layer before.
        let direct = |value: f32| match source.depth {
            Depth::Bright => source.scale * f64::from(value),
            Depth::Dark => source.scale * (1.0 - f64::from(value)),
        };
        let (places, layers) = (size[0] as usize * size[1] as usize, source.layers);
        let needed = files.need((places * (8 * layers + 16 * layers.div_ceil(4))) as u64);
        needed.map_err(|error| Input::new("the maps are too large").key(key).found(error))?;
        let depths: Vec<f64> =
            (0..places * layers).map(|k| direct(images[k % layers / 4].1[k / layers][k % layers % 4])).collect();
        let rising = depths.chunks_exact(layers).flat_map(|column| column.windows(2)).filter(|p| p[1] < p[0]).count();
        if rising > 0 {
            let total = depths.len();
            report.push(format!(
                "layers: {rising} of {total} depths lay above the layer before and were brought down to it"
            ));
        }
        let Some(made) = Self::new(size, layers, &depths, self.wrap) else {
            let fault = Input::new("the maps say that every layer lies at the surface").key(key);
            return Err(fault.found("depth 0 everywhere").expected("a depth above 0 somewhere"));
        };
        *self = Self { source: source.clone(), ..made };
        Ok(())
    }
}

/// Reads the size and texels of a file that has `layers` layers; `key` is the maps' key, for errors.
fn read(
    files: &Files,
    path: &Path,
    key: &str,
    layers: usize,
    report: &mut Vec<String>,
) -> Checked<([u32; 2], Vec<[f32; 4]>)> {
    let at = |what: String| Input::new(what).key(key);
    let image = read_depths(files, path, MOST_TEXELS / 2);
    let image = image.unwrap_or_else(|| Err("its name does not end in .png or .exr".into()));
    let (size, mut texels, channels) =
        image.map_err(|error| at(format!("{}: the map cannot be read", path.display())).found(error))?;
    if channels < layers {
        let fault = at(format!("{}: more layers than channels", path.display()));
        return Err(fault.found(format!("{channels} channels")).expected(format!("{layers}, one a layer")));
    }
    if texels.is_empty() || texels.len() > MOST_TEXELS / 2 || size.iter().any(|&side| side > MOST_SIDE) {
        let fault = at(format!("{}: the map has too few or too many texels", path.display()));
        let found = format!("{} x {}", size[0], size[1]);
        return Err(fault
            .found(found)
            .expected(format!("1 to {} texels, at most {MOST_SIDE} a side", MOST_TEXELS / 2)));
    }
    // Channels that no layer uses are not checked.
    if let Err(place) = clamp(&mut texels, layers, 1.0, path, report) {
        let (x, y, found) = (place % size[0] as usize, place / size[0] as usize, &texels[place][..layers]);
        let fault = at(format!("{}: texel ({x}, {y}), from the top left, is no share of a depth", path.display()));
        return Err(fault.found(format!("{found:?}")).expected("numbers from 0 to 1"));
    }
    Ok((size, texels))
}
