//! Two kinds of error per material: the numerical error of our radiosity against brute force over the same triangles,
//! and the model error of the dipole against a random walk that makes none of its approximations.

use crate::dipole::profile::Dipole;
use crate::error::Result;
use crate::gpu::Device;
use crate::lighting::fresnel;
use crate::measure::balls::walk as ball_walk;
use crate::measure::bodies::{Estimate, Lighting, Medium, Walks};
use crate::measure::flat::{beyond, slab};
use crate::measure::norms::worst;
use crate::measure::reference::verify;
use crate::pipeline::plan::{Change, Goal, Options};
use crate::scene::{Preset, Scene};
use crate::session::run::Session;
use crate::shading::balls::{ANGLES, angle, dipole as ball};

/// The size of the measurement.
#[derive(Clone, Copy, Debug)]
pub struct Effort {
    /// Photons per random walk and channel.
    pub photons: u64,
    /// Faces at which the numerical error is measured.
    pub samples: usize,
    /// Subdivision level of the ball used for the numerical error.
    pub detail: u32,
    /// Seed of the random walks and of the face sample.
    pub seed: u64,
}

/// Thickness of the slab and radius of the ball, in mean free paths.
pub const PATHS: f64 = 5.0;

/// One quantity by the dipole and by the random walk.
#[derive(Clone, Copy, Debug)]
pub struct Pair {
    /// The dipole's value.
    pub dipole: f64,
    /// The random walk's estimate.
    pub walk: Estimate,
}

impl Pair {
    /// The model's error, relative to the random walk.
    #[must_use]
    pub fn error(&self) -> f64 {
        self.dipole / self.walk.mean - 1.0
    }
}

/// The model's error for one channel of a material; all quantities are relative to the light that entered.
#[derive(Clone, Debug)]
pub struct Model {
    /// Reduced albedo, 0 to 1.
    pub albedo: f64,
    /// Diffuse reflectance of a half-space, under collimated and under constant light.
    pub plane: [Pair; 2],
    /// Transmittance of a slab of [`PATHS`] mean free paths under constant light.
    pub slab: Pair,
    /// Light that leaves a ball, with [`PATHS`] mean free paths as its radius, under constant light.
    pub constant: Pair,
    /// The same ball under collimated light: relative L2 difference between dipole and walk over its surface,
    /// with the walk's noise taken off.
    pub ball: f64,
    /// Relative L2 norm of the walk's standard error for that ball.
    pub noise: f64,
}

/// The model's error for each channel of a preset.
pub fn models(preset: &Preset, device: Option<&Device>, effort: Effort) -> Result<[Model; 3]> {
    let media = Medium::of(preset);
    let walks = Walks { device, media, photons: effort.photons, seed: effort.seed };
    let boundary = fresnel::boundary(fresnel::diffuse_internal_exact(preset.eta));
    let dipoles = media.map(|medium| Dipole::new(medium.scattering, medium.absorption, boundary));
    let sizes = media.map(|medium| PATHS / (medium.scattering + medium.absorption));
    let planes = [slab(&walks, f64::INFINITY, Lighting::Collimated)?, slab(&walks, f64::INFINITY, Lighting::Constant)?];
    let slabs = slab(&walks, PATHS, Lighting::Constant)?;
    let constants = ball_walk::constant(&walks, sizes)?;
    let curves = ball_walk::curves(&walks, sizes, dipoles.each_ref().map(Dipole::total))?;
    let norm = |value: &dyn Fn(usize) -> f64| (0..ANGLES).map(|k| angle(k).sin() * value(k).powi(2)).sum::<f64>();
    Ok([0, 1, 2].map(|c| {
        let (dipole, walked, by_dipole) = (&dipoles[c], &curves[c], ball::curve(&dipoles[c], sizes[c]));
        // On a sphere, points at chord length s to s + ds cover an area of 2 pi s ds, as in a plane, up to the
        // diameter.
        let all = dipole.total() - beyond(dipole, 2.0 * sizes[c]);
        let noise = norm(&|k| walked.errors[k]);
        let whole = (norm(&|k| walked.values[k]) - noise).max(f64::MIN_POSITIVE);
        let apart = norm(&|k| by_dipole.values[k] - walked.values[k]);
        Model {
            albedo: media[c].albedo(),
            plane: planes.each_ref().map(|flat| Pair { dipole: dipole.total(), walk: flat[c].back }),
            slab: Pair { dipole: beyond(dipole, sizes[c]), walk: slabs[c].through },
            constant: Pair { dipole: all, walk: constants[c] },
            ball: ((apart - noise).max(0.0) / whole).sqrt(),
            noise: (noise / whole).sqrt(),
        }
    }))
}

/// The numerical error for a preset: L2 of the radiosity of a ball in the sun at the default tolerance, worst
/// channel. Its radius is [`PATHS`] mean free paths, averaged over the channels.
pub fn numerical(preset: &Preset, device: Option<&Device>, effort: Effort) -> Result<f64> {
    let paths = [0, 1, 2].map(|c| 1.0 / (preset.sigma_s_prime[c] + preset.sigma_a[c]));
    let size = 2.0 * PATHS * paths.iter().sum::<f64>() / 3.0;
    let sets = [
        format!("object.0.material.preset={}", preset.name),
        format!("object.0.size={size}"),
        format!("object.0.detail={}", effort.detail),
        "camera.size=[1, 1]".into(),
    ];
    let options = Options { goal: Goal::Radiosity, ..Options::default() };
    let mut session = Session::new(&Scene::load_with("sphere", &sets)?, device, options)?;
    session.frame(Change::EVERYTHING)?;
    Ok(worst(&verify(&mut session, effort.samples, effort.seed)?).l2)
}

#[cfg(test)]
mod rare {
    use super::*;

    #[test]
    #[ignore = "rare: part of .ci/full, `cargo test --release -- --include-ignored`"]
    fn the_model_errs_by_much_more_than_the_numbers() {
        let effort = Effort { photons: 10_000, samples: 40, detail: 2, seed: 1 };
        let marble = Preset::named("marble").unwrap();
        let [_, found, _] = models(marble, None, effort).unwrap();
        // Low absorption and many scattering events: the dipole is within 10 %, and the walk's noise is below that.
        for pair in &found.plane {
            assert!(pair.error().abs() < 0.1 && pair.walk.error < 0.02, "{found:?}");
        }
        // A ball lets more light out than a plane; the dipole instead drops all light beyond the diameter.
        assert!(found.constant.walk.mean > found.plane[1].walk.mean, "{found:?}");
        assert!(found.constant.dipole < found.plane[1].dipole && found.constant.error() < -0.1, "{found:?}");
        assert!((0.005..0.5).contains(&found.ball) && found.noise < 0.1, "{found:?}");
        assert!(found.slab.walk.mean > 0.0 && found.slab.dipole > 0.0, "{found:?}");
        // Ketchup's blue channel absorbs nearly everything, so diffusion does not apply.
        let [_, _, dark] = models(Preset::named("ketchup").unwrap(), None, effort).unwrap();
        assert!(dark.plane[1].error().abs() > found.plane[1].error().abs(), "{dark:?}");
        let numerical = numerical(marble, None, effort).unwrap();
        assert!(numerical < 2e-3 && numerical < 0.2 * found.ball, "{numerical}");
    }
}
