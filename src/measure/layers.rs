//! Cost and error of the march through layers: both integration rules by number of samples, and each approximation on
//! its own, at two picture sizes.

use glam::DVec3;
use rayon::prelude::*;

use super::interval::Interval;
use super::sample::Sample;
use crate::error::Result;
use crate::gpu::Device;
use crate::layers::relief::{self, Kept, full};
use crate::pipeline::plan::{Change, Options, ShadingMethod};
use crate::scene::{Integration, Light, Scene, Surface};
use crate::session::run::Session;
use crate::state::State;

/// Numbers of samples in table 2 of Francois et al. 2006.
pub const SAMPLES: [u32; 3] = [10, 50, 100];
/// Frames per second in that table, on a GeForce 7800 GTX at 800 x 600: samples, fish, gecko.
pub const PAPER: [(u32, f64, f64); 3] = [(10, 126.0, 120.0), (50, 51.0, 33.0), (100, 20.0, 16.0)];
/// Numbers of samples for the error curve, figure 14.
pub const SWEEP: [u32; 9] = [2, 4, 7, 10, 20, 35, 50, 100, 200];

/// Steps of the reference along a view ray, and along each part of a light's way.
const STEPS: u32 = 120;
const LEGS: u32 = 16;
/// Samples of the march that counts as converged.
const CONVERGED: u32 = 1000;
/// Seed of the sampled pixels and of the confidence intervals.
const SEED: u64 = 2006;
/// A pixel is lit from the front where the lights that reach its triangle give all but this share of its light.
const BEHIND: f64 = 0.01;

/// The pixels at which errors are measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Looks {
    /// Picture sizes, pixels. Times are measured at the first.
    pub sizes: [[u32; 2]; 2],
    /// Most pixels sampled in a picture, among those that show an object with layers.
    pub pixels: usize,
}

/// One integration rule at one number of samples.
#[derive(Clone, Debug)]
pub struct Line {
    /// The rule.
    pub rule: Integration,
    /// The number of samples.
    pub samples: u32,
    /// Relative L2 error against the same march by the exact rule with 1000 samples: the integration error alone.
    pub integration: f64,
    /// Relative L2 error against the layered volume, at each picture size.
    pub totals: [Interval; 2],
    /// Milliseconds of stage `relief`, minimum over the frames.
    pub relief: f64,
    /// Milliseconds of a frame with a new view, minimum over the frames.
    pub view: f64,
}

/// The scene with only the scattering in layers visible: black background, no reflections, black opaque surfaces.
fn bare(scene: &Scene) -> Scene {
    let mut scene = scene.clone();
    scene.camera.background = [0.0; 3];
    for object in &mut scene.objects {
        object.material.surface = Surface::default();
        object.material.opaque = object.material.opaque.map(|_| [0.0; 3]);
    }
    scene
}

fn with(scene: &Scene, rule: Integration, samples: u32) -> Scene {
    let mut scene = scene.clone();
    for layers in scene.objects.iter_mut().filter_map(|object| object.material.layers.as_mut()) {
        (layers.integration, layers.samples) = (rule, samples);
    }
    scene
}

fn session(scene: &Scene, device: Option<&Device>) -> Result<Session> {
    let options = Options { transport: ShadingMethod::None, ..Options::default() };
    let mut session = Session::new(scene, device, options)?;
    session.frame(Change::EVERYTHING)?;
    Ok(session)
}

/// About `most` of the pixels that show an object with layers, or all if there are fewer: seeded, evenly spread.
fn shown(state: &State, most: usize) -> Vec<usize> {
    let all: Vec<usize> =
        (0..state.data.hits.len()).filter(|&pixel| full(state, pixel, Kept::default(), 0, 0).is_some()).collect();
    let chosen = Sample::seeded(&vec![1.0; all.len()], &[], most, SEED).faces;
    chosen.into_iter().map(|k| all[k]).collect()
}

fn l2(found: &[[f64; 3]], reference: &[[f64; 3]]) -> Interval {
    Interval::l2(found, reference, SEED)
}

fn at(session: &mut Session, pixels: &[usize]) -> Result<Vec<[f64; 3]>> {
    let picture = session.picture()?;
    Ok(pixels.iter().map(|&pixel| picture.pixels[pixel].map(f64::from)).collect())
}

/// Reference radiance at these pixels: the layered volume, with the march's approximations that `kept` names.
fn reference(state: &State, pixels: &[usize], kept: Kept) -> Vec<[f64; 3]> {
    pixels.par_iter().filter_map(|&pixel| full(state, pixel, kept, STEPS, LEGS)).collect()
}

/// The bare scene at each picture size.
fn sized(scene: &Scene, looks: Looks) -> [Scene; 2] {
    looks.sizes.map(|size| {
        let mut scene = bare(scene);
        scene.camera.size = size;
        scene
    })
}

/// Measures both rules at each number of samples, the paper's rule first: times over `repeat` frames.
pub fn rules(
    scene: &Scene,
    device: Option<&Device>,
    samples: &[u32],
    looks: Looks,
    repeat: usize,
) -> Result<Vec<Line>> {
    let scenes = sized(scene, looks);
    let truth = |scene: &Scene| -> Result<_> {
        let host = session(&with(scene, Integration::Exact, 1), None)?;
        let pixels = shown(host.state(), looks.pixels);
        let truth = reference(host.state(), &pixels, Kept::default());
        Ok((pixels, truth))
    };
    let [scene, other] = &scenes;
    let [(pixels, truth), (others, other_truth)] = [truth(scene)?, truth(other)?];
    let converged = at(&mut session(&with(scene, Integration::Exact, CONVERGED), device)?, &pixels)?;
    // Frames of the two rules alternate, so that other load on the machine slows both.
    let mut lines = [Vec::new(), Vec::new()];
    for &samples in samples {
        let rules = [Integration::Paper, Integration::Exact];
        let [paper, exact] = rules.map(|rule| session(&with(scene, rule, samples), device));
        let mut sessions = [paper?, exact?];
        let mut least = [[f64::INFINITY; 2]; 2];
        for _ in 0..repeat.max(1) {
            for (session, [least_relief, view]) in sessions.iter_mut().zip(&mut least) {
                let times = session.frame(Change::VIEW)?;
                let own = times.iter().filter(|step| step.name == relief::STAGE.name);
                let own = own.map(|step| step.milliseconds).sum();
                let all = times.iter().map(|step| step.milliseconds).sum();
                (*least_relief, *view) = (least_relief.min(own), view.min(all));
            }
        }
        for (k, rule) in rules.into_iter().enumerate() {
            let found = at(&mut sessions[k], &pixels)?;
            let there = at(&mut session(&with(other, rule, samples), device)?, &others)?;
            let (integration, totals) = (l2(&found, &converged).value, [l2(&found, &truth), l2(&there, &other_truth)]);
            let [relief, view] = least[k];
            lines[k].push(Line { rule, samples, integration, totals, relief, view });
        }
    }
    Ok(lines.concat())
}

/// Cost by number of lights: milliseconds of stage `relief` for each number of point lights around the scene's first
/// object. Frames of all counts alternate; each time is the minimum over `repeat` frames.
pub fn by_lights(scene: &Scene, device: Option<&Device>, counts: &[u32], repeat: usize) -> Result<Vec<(u32, f64)>> {
    let (low, high) = scene.objects[0].mesh.bounds();
    let (middle, radius) = ((low + high) / 2.0, 2.0 * (high - low).length());
    let light = |k: u32, count: u32| {
        let turn = std::f64::consts::TAU * f64::from(k) / f64::from(count);
        Light::point(middle + radius * DVec3::new(turn.cos(), 0.5, turn.sin()), [radius * radius / f64::from(count); 3])
    };
    let opened = |&count: &u32| {
        let mut scene = bare(scene);
        scene.lights = (0..count).map(|k| Light { shadows: false, ..light(k, count) }).collect();
        session(&scene, device)
    };
    let mut sessions = counts.iter().map(opened).collect::<Result<Vec<_>>>()?;
    let mut least = vec![f64::INFINITY; counts.len()];
    for _ in 0..repeat.max(1) {
        for (session, least) in sessions.iter_mut().zip(&mut least) {
            let times = session.frame(Change::VIEW)?;
            *least = least.min(times.iter().filter(|t| t.name == relief::STAGE.name).map(|t| t.milliseconds).sum());
        }
    }
    Ok(counts.iter().copied().zip(least).collect())
}

/// The longest time per light, over the time per light of the first count: 1 if no light costs more because there are
/// others.
#[must_use]
pub fn dearer(times: &[(u32, f64)]) -> f64 {
    let each = || times.iter().map(|&(n, time)| time / f64::from(n));
    each().fold(0.0, f64::max) / each().next().unwrap_or(f64::NAN)
}

/// The march's approximations at one picture size.
#[derive(Clone, Debug)]
pub struct Approximations {
    /// Relative L2 error against the layered volume, with a name: of each approximation of the march on its own, of all
    /// together, and of the converged march, which makes all of them.
    pub errors: Vec<(&'static str, Interval)>,
    /// The error of the converged march over the pixels that are lit from the front.
    pub front: Interval,
    /// Share of the volume's light at the sampled pixels that is due to lights that do not reach the visible triangle,
    /// 0 to 1: it comes through thin parts, from behind.
    pub behind: f64,
    /// Number of sampled pixels, and of those lit from the front.
    pub pixels: [usize; 2],
}

/// Measures the approximations at each picture size.
pub fn approximations(scene: &Scene, looks: Looks) -> Result<[Approximations; 2]> {
    let [a, b] = sized(scene, looks).map(|scene| approximations_of(&scene, looks.pixels));
    Ok([a?, b?])
}

fn approximations_of(scene: &Scene, pixels: usize) -> Result<Approximations> {
    let host = session(&with(scene, Integration::Exact, 1), None)?;
    let pixels = shown(host.state(), pixels);
    let none = Kept::default();
    let truth = reference(host.state(), &pixels, none);
    let shadowed = reference(host.state(), &pixels, Kept { triangle_shadow: true, ..none });
    let cases = [
        ("planar entry alone", Kept { planar_entry: true, ..none }),
        ("averaged thickness alone", Kept { mean_depths: true, ..none }),
        ("depth and place in tangent space alone", Kept { tangent_space: true, ..none }),
        ("all four", Kept::ALL),
    ];
    let mut errors = vec![("shadows of the visible triangle alone", l2(&shadowed, &truth))];
    errors.extend(cases.map(|(name, kept)| (name, l2(&reference(host.state(), &pixels, kept), &truth))));
    let march = at(&mut session(&with(scene, Integration::Exact, CONVERGED), None)?, &pixels)?;
    errors.push(("the march itself, converged", l2(&march, &truth)));

    let light = |pixel: &[f64; 3]| pixel.iter().sum::<f64>();
    let in_front = |k: &usize| light(&shadowed[*k]) >= (1.0 - BEHIND) * light(&truth[*k]);
    let front: Vec<usize> = (0..pixels.len()).filter(in_front).collect();
    let at_front = |values: &[[f64; 3]]| front.iter().map(|&k| values[k]).collect::<Vec<_>>();
    let all: f64 = truth.iter().map(light).sum();
    Ok(Approximations {
        errors,
        front: l2(&at_front(&march), &at_front(&truth)),
        behind: 1.0 - shadowed.iter().map(light).sum::<f64>() / all.max(1e-300),
        pixels: [pixels.len(), front.len()],
    })
}

#[cfg(test)]
mod tests {
    use super::dearer;

    #[test]
    fn the_dearest_light_is_found() {
        assert_eq!(dearer(&[(1, 3.0), (2, 5.0), (8, 17.0)]), 1.0);
        assert_eq!(dearer(&[(1, 1.0), (2, 4.0), (4, 16.0), (8, 64.0)]), 8.0);
        assert!(dearer(&[]).is_nan());
    }
}
