//! Cost and error of the march through layers: both integration rules by number of samples, and each approximation on
//! its own.

use glam::DVec3;
use rayon::prelude::*;

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

/// Midpoint steps of the reference along a view ray, and along each light path.
const STEPS: u32 = 240;
const LEGS: u32 = 40;
/// Samples of the march that counts as converged.
const CONVERGED: u32 = 1000;

/// One integration rule at one number of samples.
#[derive(Clone, Debug)]
pub struct Line {
    /// The rule.
    pub rule: Integration,
    /// The number of samples.
    pub samples: u32,
    /// Relative L2 error against the same march by the exact rule with 1000 samples: the integration error alone.
    pub integration: f64,
    /// Relative L2 error against the layered volume.
    pub total: f64,
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

/// At most `most` pixels that show an object with layers, evenly spaced in the list of all of them.
fn shown(state: &State, most: usize) -> Vec<usize> {
    let all: Vec<usize> =
        (0..state.data.hits.len()).filter(|&pixel| full(state, pixel, Kept::default(), 0, 0).is_some()).collect();
    let step = all.len().div_ceil(most.max(1)).max(1);
    all.into_iter().skip(step / 2).step_by(step).collect()
}

/// Relative L2 error: root of the sum of squared differences over that of the reference.
fn l2(found: &[[f64; 3]], reference: &[[f64; 3]]) -> f64 {
    let square = |values: &mut dyn Iterator<Item = f64>| values.map(|x| x * x).sum::<f64>();
    let apart = square(&mut found.iter().flatten().zip(reference.iter().flatten()).map(|(a, b)| a - b));
    (apart / square(&mut reference.iter().flatten().copied()).max(1e-300)).sqrt()
}

fn at(session: &mut Session, pixels: &[usize]) -> Result<Vec<[f64; 3]>> {
    let picture = session.picture()?;
    Ok(pixels.iter().map(|&pixel| picture.pixels[pixel].map(f64::from)).collect())
}

/// Reference radiance at these pixels: the layered volume, with the march's approximations that `kept` names.
fn reference(state: &State, pixels: &[usize], kept: Kept) -> Vec<[f64; 3]> {
    pixels.par_iter().filter_map(|&pixel| full(state, pixel, kept, STEPS, LEGS)).collect()
}

/// Measures both rules at each number of samples, the paper's rule first: errors at up to `pixels` pixels, times over
/// `repeat` frames.
pub fn rules(
    scene: &Scene,
    device: Option<&Device>,
    samples: &[u32],
    pixels: usize,
    repeat: usize,
) -> Result<Vec<Line>> {
    let scene = bare(scene);
    let host = session(&with(&scene, Integration::Exact, 1), None)?;
    let pixels = shown(host.state(), pixels);
    let truth = reference(host.state(), &pixels, Kept::default());
    let converged = at(&mut session(&with(&scene, Integration::Exact, CONVERGED), device)?, &pixels)?;
    // Frames of the two rules alternate, so that other load on the machine slows both.
    let mut lines = [Vec::new(), Vec::new()];
    for &samples in samples {
        let rules = [Integration::Paper, Integration::Exact];
        let [paper, exact] = rules.map(|rule| session(&with(&scene, rule, samples), device));
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
            let (integration, total) = (l2(&found, &converged), l2(&found, &truth));
            let [relief, view] = least[k];
            lines[k].push(Line { rule, samples, integration, total, relief, view });
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
    let of = |&count: &u32| {
        let mut scene = bare(scene);
        scene.lights = (0..count).map(|k| Light { shadows: false, ..light(k, count) }).collect();
        session(&scene, device)
    };
    let mut sessions = counts.iter().map(of).collect::<Result<Vec<_>>>()?;
    let mut least = vec![f64::INFINITY; counts.len()];
    for _ in 0..repeat.max(1) {
        for (session, least) in sessions.iter_mut().zip(&mut least) {
            let times = session.frame(Change::VIEW)?;
            *least = least.min(times.iter().filter(|t| t.name == relief::STAGE.name).map(|t| t.milliseconds).sum());
        }
    }
    Ok(counts.iter().copied().zip(least).collect())
}

/// Deviation of times from linear growth with a number, 0 if linear: the largest relative distance of a time from the
/// straight line fitted by least squares of relative distances.
#[must_use]
pub fn uneven(times: &[(u32, f64)]) -> f64 {
    // Fits time = a + b n, each equation divided by its time.
    let sums = times.iter().fold([0.0; 5], |s, &(n, time)| {
        let (p, q) = (1.0 / time, f64::from(n) / time);
        [s[0] + p * p, s[1] + p * q, s[2] + q * q, s[3] + p, s[4] + q]
    });
    let [pp, pq, qq, p, q] = sums;
    let area = pp * qq - pq * pq;
    let (a, b) = ((p * qq - q * pq) / area, (q * pp - p * pq) / area);
    times.iter().map(|&(n, time)| ((a + b * f64::from(n)) / time - 1.0).abs()).fold(0.0, f64::max)
}

/// Relative L2 error against the layered volume at up to `pixels` pixels, with a name: of each approximation of the
/// march on its own, of all three together, and of the converged march, which makes all of them.
pub fn approximations(scene: &Scene, pixels: usize) -> Result<Vec<(&'static str, f64)>> {
    let host = session(&with(&bare(scene), Integration::Exact, 1), None)?;
    let pixels = shown(host.state(), pixels);
    let none = Kept::default();
    let truth = reference(host.state(), &pixels, none);
    let cases = [
        ("planar entry alone", Kept { planar_entry: true, ..none }),
        ("averaged thickness alone", Kept { mean_depths: true, ..none }),
        ("depth and place in tangent space alone", Kept { tangent_space: true, ..none }),
        ("all three", Kept { planar_entry: true, mean_depths: true, tangent_space: true }),
    ];
    let mut errors = cases.map(|(name, kept)| (name, l2(&reference(host.state(), &pixels, kept), &truth))).to_vec();
    let march = at(&mut session(&with(&bare(scene), Integration::Exact, CONVERGED), None)?, &pixels)?;
    errors.push(("the march itself, converged", l2(&march, &truth)));
    Ok(errors)
}

#[cfg(test)]
mod tests {
    use super::uneven;

    #[test]
    fn what_grows_evenly_is_told_from_what_does_not() {
        assert!(uneven(&[(1, 3.0), (2, 5.0), (8, 17.0)]) < 1e-12);
        let square = uneven(&[(1, 1.0), (2, 4.0), (4, 16.0), (8, 64.0)]);
        assert!(square > 0.3, "{square}");
    }
}
