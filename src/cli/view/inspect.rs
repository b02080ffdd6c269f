//! What the window shows in place of light: layers of `render --aov`, and the pictures of `render --view`.

use std::path::Path;

use milkglass::error::{Input, Result};
use milkglass::internals::gpu::{Buffer, Device, Timing};
use milkglass::internals::pipeline::plan::{Change, Mode, Options, ShadingMethod};
use milkglass::internals::session::aov::layers;
use milkglass::internals::session::cluster_view::clusters;
use milkglass::internals::session::curvature_view::{CurvatureView, curvature_view};
use milkglass::internals::session::run::Session;
use milkglass::internals::view::aov::{Layer as Values, Samples};
use milkglass::internals::view::picture::Picture;
use milkglass::scene::Scene;

use crate::cli::render::{curvature_rows, level_rows, ramp_rows};
use crate::cli::samples::Samples as Progress;
use crate::cli::sequence::shoot;

/// What is shown of the scene.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Layer {
    #[default]
    Light,
    /// The layer of this name that `render --aov` writes.
    Values(&'static str),
    Curvature,
    /// The clusters that light the picked point.
    Clusters,
}

/// All layers with their names.
pub(super) const LAYERS: [(&str, Layer); 10] = [
    ("light", Layer::Light),
    ("irradiance", Layer::Values("irradiance")),
    ("shadows", Layer::Values("shadows")),
    ("radiosity", Layer::Values("radiosity")),
    ("normal", Layer::Values("normal")),
    ("error_estimate", Layer::Values("error_estimate")),
    ("depth", Layer::Values("depth")),
    ("links", Layer::Values("links")),
    ("curvature, kappa", Layer::Curvature),
    ("clusters", Layer::Clusters),
];

/// Renders layers; the session is kept until one needs other options.
pub(super) struct Inspector {
    device: Device,
    session: Option<(Options, Session)>,
    picture: Picture,
    /// The layer as the window shows it, four bytes a pixel.
    bytes: Vec<u32>,
    /// Rows of a table that says what the colours mean, the colour last: `#rrggbb`.
    pub(super) legend: Vec<Vec<String>>,
}

impl Inspector {
    pub(super) fn new(device: &Device) -> Self {
        let picture = Picture::plain(0, 0, Vec::new());
        Self { device: device.clone(), session: None, picture, bytes: Vec::new(), legend: Vec::new() }
    }

    /// Renders a layer of a scene with these options, for the picked pixel, and returns the times of its steps.
    pub(super) fn render(
        &mut self,
        scene: &Scene,
        options: Options,
        layer: Layer,
        pick: [u32; 2],
    ) -> Result<Vec<Timing>> {
        let wanted = match layer {
            Layer::Light => return Ok(Vec::new()),
            Layer::Values(name) => {
                options.carries(name)?;
                options.with_layers()
            }
            Layer::Curvature => Options { transport: ShadingMethod::Cdrf, ..options },
            Layer::Clusters => Options { transport: ShadingMethod::Hierarchy, mode: Mode::Keep, ..options },
        };
        let (known, mut session) = match self.session.take() {
            Some((known, mut session)) if known == wanted => {
                session.show(scene).map_err(|error| scene.placed(error))?;
                (known, session)
            }
            _ => (wanted, Session::new(scene, Some(&self.device), wanted)?),
        };
        let times = session.frame(Change::default())?;
        session.finished_rays()?;
        (self.picture, self.legend) = match layer {
            Layer::Curvature => {
                let (picture, view) = curvature_view(&mut session)?;
                (picture, headed(["kappa, 1/mm", "1 / kappa, mm"], curvature_rows(&view, scene.unit_mm)))
            }
            Layer::Clusters => {
                let (picture, emitters) = clusters(&mut session, pick)?;
                (picture, headed(["level", "emitters", "triangles"], level_rows(&emitters)))
            }
            Layer::Light | Layer::Values(_) => {
                let all = layers(&mut session)?;
                let chosen = all.iter().find(|known| Layer::Values(known.name) == layer);
                let none = || Input::new("the scene has nothing for this layer, as it is rendered").key("layer");
                let depth = all.iter().find_map(|known| match known.channels.first() {
                    Some((_, Samples::Float(depth))) if known.name == "depth" => Some(depth),
                    _ => None,
                });
                let seen = |pixel: usize| depth.is_some_and(|depth| depth[pixel].is_finite());
                paint(chosen.ok_or_else(none)?, scene, seen)
            }
        };
        let packed = |rgb: &[u8]| u32::from_le_bytes([rgb[0], rgb[1], rgb[2], 0]);
        self.bytes = self.picture.bytes().chunks_exact(3).map(packed).collect();
        self.session = Some((known, session));
        Ok(times)
    }

    /// The layer on the device, and its size.
    pub(super) fn shown(&mut self) -> Result<Option<([u32; 2], &Buffer)>> {
        let Some((_, session)) = &mut self.session else { return Ok(None) };
        let size = session.scene().camera.size;
        Ok(session.show_instead(&self.bytes)?.map(|buffer| (size, buffer)))
    }

    /// Writes the layer: `.png` as it is shown; `.exr` with the picture and all layers, if it is a layer of `--aov`.
    pub(super) fn save(&mut self, file: &Path) -> Result<()> {
        match &mut self.session {
            Some((options, session)) if options.estimate && file.extension().is_some_and(|end| end == "exr") => {
                shoot(session, true, file, Progress::hidden()).map(drop)
            }
            _ => self.picture.save(file),
        }
    }
}

/// Rows under a head.
fn headed<const N: usize>(head: [&str; N], rows: Vec<Vec<String>>) -> Vec<Vec<String>> {
    std::iter::once(head.map(str::to_owned).to_vec()).chain(rows).collect()
}

/// A layer as a picture: colours and directions as they are, numbers by a scale of colours between their 5th and 95th
/// percentile.
fn paint(layer: &Values, scene: &Scene, seen: impl Fn(usize) -> bool) -> (Picture, Vec<Vec<String>>) {
    let channels: Vec<Vec<f64>> = layer
        .channels
        .iter()
        .map(|(_, samples)| match samples {
            Samples::Float(values) => values.iter().copied().map(f64::from).collect(),
            Samples::Whole(values) => values.iter().copied().map(f64::from).collect(),
        })
        .collect();
    let camera = &scene.camera;
    let [width, height] = camera.size.map(|side| side as usize);
    let pixels = 0..width * height;
    let vector = |pixel: usize| [0, 1, 2].map(|c| channels[c][pixel]);
    match layer.name {
        "irradiance" | "radiosity" => {
            let pixels = pixels.map(|pixel| vector(pixel).map(|x| x as f32)).collect();
            let picture = Picture::plain(width, height, pixels);
            (Picture { exposure: camera.exposure, tone: camera.tone, ..picture }, Vec::new())
        }
        "normal" => {
            let color = |[x, y, z]: [f64; 3]| {
                if [x, y, z] == [0.0; 3] { [0.0; 3] } else { [x, y, z].map(|x| (0.5 + 0.5 * x) as f32) }
            };
            (Picture::plain(width, height, pixels.map(|pixel| color(vector(pixel))).collect()), Vec::new())
        }
        "shadows" => {
            // What lies in shadow is darker than what is lit, and brighter than where there is nothing.
            let grey = |pixel: usize| if seen(pixel) { 0.02 + 0.98 * channels[0][pixel] as f32 } else { 0.0 };
            (Picture::plain(width, height, pixels.map(|pixel| [grey(pixel); 3]).collect()), Vec::new())
        }
        _ => {
            let most = |pixel: usize| channels.iter().map(|channel| channel[pixel]).fold(0.0, f64::max);
            let shown = |x: &f64| *x > 0.0 && x.is_finite();
            let values: Vec<f64> = pixels.map(most).collect();
            let mut sorted: Vec<f64> = values.iter().copied().filter(shown).collect();
            sorted.sort_by(f64::total_cmp);
            let at = |share: f64| sorted.get((sorted.len() as f64 * share) as usize).copied().unwrap_or(0.0);
            let ramp = CurvatureView { ends: [at(0.05), at(0.95)], apart: [0.0; 2] };
            let pixels = values.iter().map(|x| if shown(x) { ramp.color(*x) } else { [0.0; 3] }).collect();
            let rows = ramp_rows(&ramp).into_iter().map(|(x, color)| vec![format!("{x:.2e}"), color]).collect();
            (Picture::plain(width, height, pixels), rows)
        }
    }
}
