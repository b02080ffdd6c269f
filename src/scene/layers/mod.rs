//! Layers beneath a surface (Francois et al. 2006): the coefficients of each, and the depth of its lower interface.

mod map;
mod pattern;

pub use map::DepthMap;

use super::files::Files;
use super::range::{self, Checked};
use super::texture::Wrap;
use super::vector::Rgb;
use super::{Mesh, locate};
use crate::error::Input;
use serde::Deserialize;
use std::path::Path;

/// Maximum number of layers.
const MOST_LAYERS: usize = 16;
/// Maximum number of samples along a ray.
const MOST_SAMPLES: i64 = 1000;

/// Validated layers, from the surface down.
#[derive(Debug, Clone, PartialEq)]
pub struct Layers {
    /// The layers, 1 to 16.
    pub layers: Vec<Layer>,
    /// The depths of their lower interfaces.
    pub map: DepthMap,
    /// Samples along a ray, 1 to 1000: ends of steps, and with exact integration also crossings of interfaces.
    pub samples: u32,
    /// How light is integrated along the ray.
    pub integration: Integration,
    /// The phase function.
    pub phase: Phase,
    /// Bounds the plane fit: vertices beyond the distance at which transmittance through the first layer falls to this
    /// are ignored. Above 0 and below 1.
    pub epsilon: f64,
    /// Whether light is multiplied by the Fresnel transmittance where it enters and leaves.
    pub fresnel: bool,
}

/// One layer.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Layer {
    /// Scattering coefficient per scene unit, r g b, at least 0.
    pub sigma_s: [f64; 3],
    /// Extinction coefficient per scene unit, r g b, at least `sigma_s`.
    pub sigma_t: [f64; 3],
    /// Parameter of the phase function, -0.999 to 0.999; above 0 is forward.
    pub g: f64,
}

/// How light is integrated along a ray.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Integration {
    /// Exponentials between samples and interfaces, integrated in closed form.
    #[default]
    Exact,
    /// Algorithm 1: the value at the beginning of each step, times its length.
    Paper,
}

/// The phase function.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Phase {
    /// Schlick's, with `g` as his k, as published.
    #[default]
    Schlick,
    /// Schlick's, with `g` as the mean cosine.
    SchlickMean,
    /// Henyey and Greenstein's, with `g` as the mean cosine.
    HenyeyGreenstein,
}

/// What a map's largest value stands for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Deserialize)]
#[serde(rename_all = "lowercase")]
#[cfg_attr(feature = "cli", derive(clap::ValueEnum))]
pub enum Depth {
    /// The greatest depth: it is white.
    #[default]
    Bright,
    /// The surface: the greatest depth is black.
    Dark,
}

/// `material.layers`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LayersFile {
    maps: Option<Vec<String>>,
    depth: Option<Depth>,
    scale: Option<f64>,
    wrap: Option<Wrap>,
    samples: Option<i64>,
    #[serde(default)]
    integration: Integration,
    #[serde(default)]
    phase: Phase,
    epsilon: Option<f64>,
    #[serde(default)]
    fresnel: bool,
    #[serde(default)]
    layer: Vec<LayerFile>,
}

/// `material.layers.layer`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct LayerFile {
    sigma_s: Rgb,
    sigma_t: Rgb,
    #[serde(default)]
    g: f64,
    thickness: Option<f64>,
}

impl Layers {
    /// Checks the table under `key`; coefficients are multiplied by `per_unit`. Files are read later.
    pub(super) fn check(file: &LayersFile, key: &str, per_unit: f64) -> Checked<Self> {
        let at = |name: &str| format!("{key}.{name}");
        let channels = 4 * file.maps.as_ref().map_or(MOST_LAYERS / 4, Vec::len);
        if channels == 0 {
            let fault = Input::new("there are no maps").key(at("maps")).found("an empty list");
            return Err(fault.expected("a map for every four layers, or a thickness in each layer instead"));
        }
        if !(1..=channels.min(MOST_LAYERS)).contains(&file.layer.len()) {
            let what = if file.layer.is_empty() { "there are no layers" } else { "more layers than channels" };
            let fault = Input::new(what).key(at("layer")).found(format!("{} layers", file.layer.len()));
            return Err(fault.expected(format!("1 to {}, four a map", channels.min(MOST_LAYERS))));
        }
        let layer = |(index, layer): (usize, &LayerFile)| layer.check(&at(&format!("layer.{index}")), per_unit);
        let layers = file.layer.iter().enumerate().map(layer).collect::<Checked<Vec<Layer>>>()?;
        let samples = file.samples.unwrap_or(32);
        if !(1..=MOST_SAMPLES).contains(&samples) {
            let fault = Input::new("out of range").key(at("samples")).found(samples);
            return Err(fault.expected(format!("a whole number from 1 to {MOST_SAMPLES}")));
        }
        let within = |x: f64| x > 0.0 && x < 1.0;
        let epsilon = range::number(&at("epsilon"), file.epsilon.unwrap_or(0.01), within, "above 0 and below 1")?;
        Ok(Self {
            layers,
            map: file.map(key)?,
            samples: samples.unsigned_abs() as u32,
            integration: file.integration,
            phase: file.phase,
            epsilon,
            fresnel: file.fresnel,
        })
    }

    /// Reports how many triangles have no area in the maps; an error if every triangle is such.
    pub(super) fn check_mesh(&self, mesh: &Mesh, key: &str, report: &mut Vec<String>) -> Checked<()> {
        let Some(uvs) = mesh.uvs.as_ref().filter(|_| self.map.mapped) else { return Ok(()) };
        let flat = |[a, b, c]: &&[[f64; 2]; 3]| (b[0] - a[0]) * (c[1] - a[1]) == (b[1] - a[1]) * (c[0] - a[0]);
        let count = uvs.iter().filter(flat).count();
        if count == uvs.len() {
            let fault = Input::new("the mesh's texture coordinates lie on a line in every triangle");
            return Err(fault.key(format!("{key}.maps")).expected("texture coordinates that span an area"));
        }
        if count > 0 {
            let total = uvs.len();
            report.push(format!(
                "layers: {count} of {total} triangles have no area in the maps: there depths do not vary"
            ));
        }
        Ok(())
    }
}

impl LayerFile {
    fn check(&self, key: &str, per_unit: f64) -> Checked<Layer> {
        let at = |name: &str| format!("{key}.{name}");
        let (scattering, extinction) = (self.sigma_s.0, self.sigma_t.0);
        let zero_up = "numbers of at least 0, per mm";
        range::channels(&at("sigma_s"), scattering, |x| x >= 0.0, zero_up)?;
        range::channels(&at("sigma_t"), extinction, |x| x >= 0.0, zero_up)?;
        if let Some(c) = (0..3).find(|&c| extinction[c] < scattering[c]) {
            let fault = Input::new("extinction is less than scattering").key(at("sigma_t"));
            let fault = fault.found(format!("{} in channel {}", extinction[c], ["r", "g", "b"][c]));
            return Err(fault.expected(format!("at least sigma_s, {}", scattering[c])));
        }
        let g = range::number(&at("g"), self.g, |g| g.abs() <= 0.999, "-0.999 to 0.999")?;
        let scaled = |name: &str, values: [f64; 3]| {
            range::channels(&at(name), values.map(|x| x * per_unit), |_| true, "a finite number after unit and scale")
        };
        Ok(Layer { sigma_s: scaled("sigma_s", scattering)?, sigma_t: scaled("sigma_t", extinction)?, g })
    }
}

impl LayersFile {
    /// Depths from maps, which are read later, or uniform ones.
    fn map(&self, key: &str) -> Checked<DepthMap> {
        let at = |name: &str| format!("{key}.{name}");
        let count = self.layer.len();
        let Some(maps) = &self.maps else {
            let idle =
                [("depth", self.depth.is_some()), ("scale", self.scale.is_some()), ("wrap", self.wrap.is_some())];
            if let Some((name, _)) = idle.into_iter().find(|(_, given)| *given) {
                return Err(Input::new("there are no maps").key(at(name)).expected("`maps` beside it"));
            }
            let thick = |(index, layer): (usize, &LayerFile)| {
                let key = at(&format!("layer.{index}.thickness"));
                let Some(value) = layer.thickness else {
                    let fault = Input::new("missing: without maps every layer needs it").key(key);
                    return Err(fault.expected("a number of at least 0, scene units"));
                };
                range::number(&key, value, |x| (0.0..=range::LARGEST).contains(&x), "0 to 1e9 scene units")
            };
            let thick = self.layer.iter().enumerate().map(thick).collect::<Checked<Vec<f64>>>()?;
            return DepthMap::constant(&thick).ok_or_else(|| {
                let fault = Input::new("the layers have no thickness").key(at("layer")).found("0 in all");
                fault.expected("a thickness above 0 in at least one")
            });
        };
        if let Some(index) = self.layer.iter().position(|layer| layer.thickness.is_some()) {
            let fault = Input::new("the maps say how thick a layer is").key(at(&format!("layer.{index}.thickness")));
            return Err(fault.expected("either maps or thickness"));
        }
        if maps.len() > count.div_ceil(4) {
            let fault = Input::new("more maps than the layers need").key(at("maps"));
            return Err(fault.found(format!("{} maps", maps.len())).expected(format!("{}", count.div_ceil(4))));
        }
        if let Some(name) = maps.iter().find(|name| name.starts_with("builtin:") && !pattern::is(name)) {
            let what = locate::with_suggestion("no map of this name is built in", name, &pattern::NAMES);
            return Err(Input::new(what).key(at("maps")).found(name).expected(pattern::NAMES.join(", ")));
        }
        let Some(scale) = self.scale else {
            let fault = Input::new("missing: the depth that the maps' largest values stand for").key(at("scale"));
            return Err(fault.expected("a number above 0, scene units"));
        };
        let scale = range::number(&at("scale"), scale, |x| x > 0.0 && x <= range::LARGEST, "above 0, to 1e9")?;
        let depth = self.depth.unwrap_or_default();
        Ok(DepthMap::unread(maps, count, scale, depth, self.wrap.unwrap_or_default()))
    }
}

impl Layers {
    /// Reads the maps, relative to `folder`.
    pub(super) fn load(&mut self, files: &Files, folder: &Path, key: &str, report: &mut Vec<String>) -> Checked<()> {
        self.map.load(files, folder, &format!("{key}.maps"), report)
    }
}
