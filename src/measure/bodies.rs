//! Random walks through plain bodies, one medium a channel: the light that leaves through each triangle, for given
//! light that enters.

use glam::DVec3;

use crate::error::Result;
use crate::gpu::Device;
use crate::pipeline::plan::{Change, Goal, Options, ShadingMethod};
use crate::scene::{MOST_WALKS, Mesh, Preset, Scene};
use crate::session::run::Session;
use crate::session::walk::WalkControl;

/// A medium: reduced scattering and absorption coefficients, 1/length, and the relative index of refraction, inside
/// over outside.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Medium {
    /// sigma_s', at least 0.
    pub scattering: f64,
    /// sigma_a, at least 0; the sum of both is above 0.
    pub absorption: f64,
    /// The relative index of refraction.
    pub eta: f64,
}

impl Medium {
    /// A preset's media, one a channel.
    #[must_use]
    pub fn of(preset: &Preset) -> [Self; 3] {
        [0, 1, 2].map(|c| Self { scattering: preset.sigma_s_prime[c], absorption: preset.sigma_a[c], eta: preset.eta })
    }

    /// The same medium in a unit of length `by` times as long.
    #[must_use]
    pub fn scaled(self, by: f64) -> Self {
        Self { scattering: self.scattering * by, absorption: self.absorption * by, eta: self.eta }
    }

    /// Scattering over extinction, 0 to 1.
    #[must_use]
    pub fn albedo(self) -> f64 {
        self.scattering / (self.scattering + self.absorption)
    }

    /// The same medium with its mean free path as the unit of length.
    #[must_use]
    pub fn in_paths(self) -> Self {
        self.scaled(1.0 / (self.scattering + self.absorption))
    }
}

/// A mean with its standard error.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimate {
    /// The mean.
    pub mean: f64,
    /// The standard error of the mean.
    pub error: f64,
}

/// Directions of the light.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Lighting {
    /// From +z.
    Collimated,
    /// The same radiance from every direction.
    Constant,
}

/// Walks through bodies of these media.
#[derive(Clone, Copy)]
pub struct Walks<'a> {
    /// The device; `None` for the CPU, which counts the same bits.
    pub device: Option<&'a Device>,
    /// The medium of each channel.
    pub media: [Medium; 3],
    /// Photons of each channel, at least 1.
    pub photons: u64,
    /// Seed of the photons.
    pub seed: u64,
}

/// The light that left a body after one collision or more.
pub struct Left {
    /// Sum of the weights, and of their squares, that left through each triangle of the mesh, per channel; a photon
    /// enters with a weight of 1.
    pub moments: Vec<[[f64; 2]; 3]>,
    /// Photons of each channel.
    pub photons: f64,
}

impl Left {
    /// The share of the light that left through these triangles.
    #[must_use]
    pub fn through(&self, channel: usize, faces: impl Fn(usize) -> bool) -> Estimate {
        let own = self.moments.iter().enumerate().filter(|(face, _)| faces(*face));
        let [sum, squares] = own.fold([0.0; 2], |[a, b], (_, m)| [a + m[channel][0], b + m[channel][1]]);
        let mean = sum / self.photons;
        Estimate { mean, error: (squares - sum * mean).max(0.0).sqrt() / self.photons }
    }
}

/// A scene of one object, whose mesh another one replaces.
const BODY: &str = r#"
unit = "mm"
camera = { size = [1, 1] }
[[object]]
shape = "sphere"
size = 2
material = { preset = "marble" }
"#;

/// A ball around the origin of radius 1.
pub fn ball(detail: u32) -> Result<Mesh> {
    Ok(Scene::parse("ball", BODY, &[format!("object.0.detail={detail}")])?.objects.swap_remove(0).mesh)
}

/// A box around the origin of this width and this height in z. Its first two triangles are above, the next two below.
#[must_use]
pub fn box_of(width: f64, height: f64) -> Mesh {
    let size = DVec3::new(width, width, height);
    let corner = |k: usize| size * (DVec3::new((k & 1) as f64, ((k >> 1) & 1) as f64, (k >> 2) as f64) - 0.5);
    let squares = [[4, 5, 7, 6], [0, 2, 3, 1], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
    Mesh {
        positions: (0..8).map(corner).collect(),
        triangles: squares.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect(),
        input_face: (0..12).collect(),
        ..Mesh::default()
    }
}

impl Walks<'_> {
    /// The light that leaves this mesh, whose unit is that of the media; `entering` is the light that enters a triangle
    /// per area.
    pub fn leave(&self, mesh: &Mesh, lighting: Lighting, entering: impl Fn(usize) -> f64) -> Result<Left> {
        let list = |value: fn(&Medium) -> f64| format!("{:?}", self.media.each_ref().map(value));
        let light = match lighting {
            Lighting::Collimated => "{ type = 'directional', direction = [0, 0, 1], irradiance = 1, shadows = false }",
            Lighting::Constant => "{ type = 'environment', radiance = 1 }",
        };
        let (scattering, absorption) = (list(|medium| medium.scattering), list(|medium| medium.absorption));
        let eta = list(|medium| medium.eta);
        let photons = self.photons.clamp(1, MOST_WALKS.into());
        let sets = [
            format!("light=[{light}]"),
            format!("object.0.material={{ sigma_s_prime = {scattering}, sigma_a = {absorption}, eta = {eta} }}"),
            format!("transport.walks={photons}"),
        ];
        let mut scene = Scene::parse("body", BODY, &sets)?;
        scene.objects[0].mesh = mesh.clone();
        let options = Options { transport: ShadingMethod::Walk, goal: Goal::Radiosity, ..Options::default() };
        let mut session = Session::new(&scene, self.device, options)?;
        session.watch_walk(WalkControl { seed: (self.seed ^ (self.seed >> 32)) as u32, ..WalkControl::default() });
        session.walk_from(&(0..mesh.triangles.len()).map(|face| [entering(face); 3]).collect::<Vec<_>>());
        session.frame(Change::EVERYTHING)?;
        let exits = &session.state().data.exits;
        let moments = |place: usize| [0, 1, 2].map(|c| exits[place].moments(c));
        Ok(Left { moments: session.prepared().places(0).into_iter().map(moments).collect(), photons: photons as f64 })
    }
}
