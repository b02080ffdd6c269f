//! Brute force in `f64` with near-exact form factors at a few receivers: the reference for the error of every method.

use glam::DVec3;
use rayon::prelude::*;

use crate::dipole::form_factor::exact::edge_form_fine;
use crate::dipole::form_factor::ladder::chi;
use crate::dipole::form_factor::points::{SIX, TWELVE, midpoint_moment, sampled, trace};
use crate::dipole::profile::Dipole;
use crate::error::{Input, Result};
use crate::layout::BufferId;
use crate::measure::estimate::Quality;
use crate::measure::norms::{Norms, norms};
use crate::measure::progress::Progress;
use crate::measure::sample::Sample;
use crate::session::run::Session;
use crate::state::{Distance, State, wide};
use crate::transport::diffusion::sums;

/// Limits of chi below which one sample with its second moment, 6 points and 12 points are within about 5e-6 of the
/// exact form factor; above the last limit, graded quadrature along the edges.
const RUNGS: [f64; 3] = [2e-3, 2e-2, 0.2];
/// sigma s beyond which a triangle contributes nothing next to near ones (e^-40 = 4e-18), so 12 points are enough for
/// any chi. If all light is that far away, the sum is accurate to a few digits only.
const FAINT: f64 = 40.0;
/// Parts along an edge of a triangle that is long against the distance over which radiosity changes.
const PARTS: usize = 8;

/// Radiosity at the centroids of these faces, for a state with known irradiance.
pub fn radiosity(state: &State, faces: &[usize]) -> Vec<[f64; 3]> {
    by_object(state, faces, alone)
}

/// Radiosity at these faces of one or several objects; `radiosity` computes it for a state of one translucent object.
pub fn by_object(state: &State, faces: &[usize], radiosity: fn(&State, &[usize]) -> Vec<[f64; 3]>) -> Vec<[f64; 3]> {
    if let [object] = state.objects.as_slice()
        && !object.opaque
    {
        return radiosity(state, faces);
    }
    let mut sums = vec![[0.0; 3]; faces.len()];
    for (number, object) in state.objects.iter().enumerate() {
        let mine = |k: &usize| state.object_of(faces[*k]) == number;
        let own: Vec<usize> = (0..faces.len()).filter(mine).collect();
        let local: Vec<usize> = own.iter().map(|&k| faces[k] - object.first.faces).collect();
        let values = if object.opaque {
            let albedo = state.data.object_params[number].albedo;
            let value =
                |&k: &usize| [0, 1, 2].map(|c| f64::from(albedo[c]) * f64::from(state.data.irradiance[faces[k]][c]));
            own.iter().map(value).collect()
        } else if own.is_empty() {
            Vec::new()
        } else {
            radiosity(&state.alone(number), &local)
        };
        own.into_iter().zip(values).for_each(|(k, value)| sums[k] = value);
    }
    sums
}

fn alone(state: &State, faces: &[usize]) -> Vec<[f64; 3]> {
    let data = &state.data;
    let center = |&face: &usize| {
        let [a, b, c] = data.triangles[face].map(|v| wide(data.positions[v as usize]));
        (a + b + c) / 3.0
    };
    at(state, &faces.iter().map(center).collect::<Vec<_>>())
}

/// Means of the radiosity over these faces, each by the centroids of `PARTS` squared equal parts.
fn means(state: &State, faces: &[usize]) -> Vec<[f64; 3]> {
    let part = |(i, j, third): (usize, usize, f64)| [i, j].map(|k| (k as f64 + third / 3.0) / PARTS as f64);
    let all = (0..PARTS).flat_map(|i| (0..PARTS - i).map(move |j| (i, j)));
    let upright = all.clone().map(|(i, j)| (i, j, 1.0));
    let weights: Vec<[f64; 2]> =
        upright.chain(all.filter(|(i, j)| i + j + 1 < PARTS).map(|(i, j)| (i, j, 2.0))).map(part).collect();
    let places = |&face: &usize| {
        let [a, b, c] = state.data.triangles[face].map(|v| wide(state.data.positions[v as usize]));
        weights.iter().map(move |[u, v]| a + *u * (b - a) + *v * (c - a)).collect::<Vec<_>>()
    };
    let values = at(state, &faces.iter().flat_map(places).collect::<Vec<_>>());
    let mean = |values: &[[f64; 3]]| [0, 1, 2].map(|c| values.iter().map(|x| x[c]).sum::<f64>() / values.len() as f64);
    values.chunks(PARTS * PARTS).map(mean).collect()
}

/// Radiosity at points on the surface of a one-object state with known irradiance; `places` are in internal units.
pub fn at(state: &State, places: &[DVec3]) -> Vec<[f64; 3]> {
    let data = &state.data;
    let dipoles = [0, 1, 2].map(|channel| Dipole::of(&data.object_params[0], channel));
    let distance = match state.distance {
        Distance::Radial => crate::dipole::form_factor::Distance::Radial,
        Distance::Table1 => crate::dipole::form_factor::Distance::Table1 { clamp: true },
    };
    let corners = |face: usize| data.triangles[face].map(|v| wide(data.positions[v as usize]));
    let emitters: Vec<Emitter> = (0..data.triangles.len()).map(|face| Emitter::new(corners(face))).collect();
    let pair = |x: DVec3, face: usize, dipole: &Dipole| {
        let emitter = &emitters[face];
        let d = x - emitter.center;
        let nearest = match state.distance {
            Distance::Radial => (d.length_squared() + dipole.z_real * dipole.z_real).sqrt(),
            Distance::Table1 => (d.length() - dipole.z_virtual).max(dipole.z_real),
        };
        let chi = chi(emitter.moment_trace, dipole.sigma, nearest);
        match RUNGS.iter().position(|&limit| chi < limit) {
            Some(0) if state.distance == Distance::Radial => emitter.far(d, dipole),
            Some(0) => midpoint_moment(&emitter.corners, x, dipole, distance),
            Some(1) => sampled(&emitter.corners, x, dipole, distance, &SIX),
            Some(_) => sampled(&emitter.corners, x, dipole, distance, &TWELVE),
            None if dipole.sigma * (nearest - emitter.reach) > FAINT => {
                sampled(&emitter.corners, x, dipole, distance, &TWELVE)
            }
            None => edge_form_fine(&emitter.corners, data.triangles[face], x, dipole, distance),
        }
    };
    let progress = Progress::new(places.len());
    places
        .par_iter()
        .map(|&x| {
            let mut sum = [0.0; 3];
            for (face, light) in data.irradiance.iter().enumerate() {
                for (channel, dipole) in dipoles.iter().enumerate().filter(|(channel, _)| light[*channel] != 0.0) {
                    sum[channel] += f64::from(light[channel]) * pair(x, face, dipole);
                }
            }
            progress.step();
            sum
        })
        .collect()
}

/// An emitting triangle with what is precomputed for its pairs.
struct Emitter {
    corners: [DVec3; 3],
    center: DVec3,
    area: f64,
    edges: [DVec3; 3],
    moment_trace: f64,
    /// Distance from the centroid to the farthest corner.
    reach: f64,
}

impl Emitter {
    fn new(corners: [DVec3; 3]) -> Self {
        let [a, b, c] = corners;
        let center = (a + b + c) / 3.0;
        Self {
            corners,
            center,
            reach: corners.into_iter().map(|corner| corner.distance(center)).fold(0.0, f64::max),
            area: 0.5 * (b - a).cross(c - a).length(),
            edges: [b - a, c - b, a - c],
            moment_trace: trace(&corners),
        }
    }

    /// One sample with the second moment, radial distances: [`midpoint_moment`] with precomputed geometry.
    fn far(&self, d: DVec3, dipole: &Dipole) -> f64 {
        let along: f64 = self.edges.iter().map(|edge| edge.dot(d).powi(2)).sum::<f64>() / 36.0;
        let source = |z: f64| {
            let s2 = d.length_squared() + z * z;
            let s = s2.sqrt();
            let a = dipole.sigma * s;
            let first = (3.0 + 3.0 * a + a * a) * self.moment_trace;
            let second = (15.0 + 15.0 * a + 6.0 * a * a + a * a * a) * along / s2;
            z * (-a).exp() / (s2 * s) * ((1.0 + a) + 0.5 * (second - first) / s2)
        };
        self.area * dipole.strength * (source(dipole.z_real) + source(dipole.z_virtual))
    }
}

/// A frame's result at these faces of an object: its radiosity or, if an equation was solved, the equation's left side.
fn found(state: &State, faces: &[usize]) -> Vec<[f64; 3]> {
    match state.objects[0].solves() {
        true => sums::applied(state, faces),
        false => faces.iter().map(|&face| state.data.radiosity[face].map(f64::from)).collect(),
    }
}

/// The exact result: the radiosity or, if an equation is to be solved, the equation's right side.
fn wanted(state: &State, faces: &[usize]) -> Vec<[f64; 3]> {
    if state.objects[0].solves() { sums::source(state, faces) } else { alone(state, faces) }
}

/// The errors of a frame's radiosity at some receivers.
pub struct Checked {
    /// Error norms per channel.
    pub norms: [Norms; 3],
    /// The quality of the error estimate, if there is one and no equation was solved.
    pub estimate: Option<Quality>,
    /// If an equation was solved: the L2 of the radiosity's estimated error over that of the radiosity, per channel.
    pub bound: Option<[f64; 3]>,
}

/// Error norms of a session's last frame at `count` seeded receivers, and the quality of its error estimate. For
/// diffusion, which solves an equation, the norms are those of the residual.
pub fn check(session: &mut Session, count: usize, seed: u64) -> Result<Checked> {
    session.sharpen()?;
    session.fetch(&[BufferId::irradiance, BufferId::radiosity, BufferId::clusters, BufferId::estimate])?;
    session.fetch(&[BufferId::positions, BufferId::deposits, BufferId::solution])?;
    let state = session.state();
    if state.objects.iter().all(|object| object.opaque) {
        let fault = Input::new("light enters no object, so there is nothing to verify").key("object");
        return Err(fault.expected("at least one object that is not opaque").into());
    }
    let data = &state.data;
    let sample = receivers(state, count, seed);
    let faces = &sample.faces;
    let (values, mut reference) = (by_object(state, faces, found), by_object(state, faces, wanted));
    // The centroid of a long triangle does not stand for all of it: the reference is the mean over the triangle.
    let long = session.left_long();
    let known: Vec<usize> = (0..faces.len()).filter(|&k| long.get(faces[k]) == Some(&true)).collect();
    if !state.method.solves() && !known.is_empty() {
        let own: Vec<usize> = known.iter().map(|&k| faces[k]).collect();
        known.iter().zip(by_object(state, &own, means)).for_each(|(&k, mean)| reference[k] = mean);
    }
    let estimates: Vec<[f64; 3]> = match state.method.estimate {
        true => faces.iter().map(|&face| data.estimate[face].map(f64::from)).collect(),
        false => Vec::new(),
    };
    let solves = state.method.solves();
    let bound = (solves && state.method.estimate).then(|| {
        let sum = |value: &dyn Fn(usize) -> f64| -> f64 {
            sample.counts.iter().zip(0..).map(|(count, k)| count * value(k).powi(2)).sum()
        };
        [0, 1, 2].map(|c| {
            let whole = sum(&|k| f64::from(data.radiosity[faces[k]][c]));
            (sum(&|k| estimates[k][c]) / whole.max(f64::MIN_POSITIVE)).sqrt()
        })
    });
    let estimate = (!solves && state.method.estimate).then(|| {
        let error = |(value, b): (&[f64; 3], &[f64; 3])| [0, 1, 2].map(|c| (value[c] - b[c]).abs());
        let errors: Vec<[f64; 3]> = values.iter().zip(&reference).map(error).collect();
        Quality::of(&sample.counts, &estimates, &errors)
    });
    Ok(Checked { norms: norms(&sample, &values, &reference), estimate, bound })
}

/// A seeded sample of the faces of translucent objects; the state's radiosity, which may be rough, guides it.
pub fn receivers(state: &State, count: usize, seed: u64) -> Sample {
    let data = &state.data;
    let known: Vec<(usize, usize)> =
        state.faces().filter(|(face, _)| !state.objects[state.object_of(*face)].opaque).collect();
    let areas: Vec<f64> = known.iter().map(|&(_, leaf)| f64::from(data.clusters[leaf].area)).collect();
    let light: Vec<[f64; 3]> = known.iter().map(|&(face, _)| data.radiosity[face].map(f64::from)).collect();
    let mut sample = Sample::seeded(&areas, &light, count, seed);
    sample.faces.iter_mut().for_each(|face| *face = known[*face].0);
    sample
}

/// The error norms alone, per channel.
pub fn verify(session: &mut Session, count: usize, seed: u64) -> Result<[Norms; 3]> {
    Ok(check(session, count, seed)?.norms)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_quick_far_field_is_the_plain_one() {
        let corners = [DVec3::ZERO, DVec3::new(1.0, 0.1, 0.0), DVec3::new(0.2, 0.9, 0.3)];
        let dipole = Dipole::new(2.0, 0.3, 2.6);
        for x in [DVec3::new(3.0, 1.0, 0.5), DVec3::new(-1.0, 4.0, 2.0)] {
            let emitter = Emitter::new(corners);
            let plain = midpoint_moment(&corners, x, &dipole, crate::dipole::form_factor::Distance::Radial);
            assert!((emitter.far(x - emitter.center, &dipole) / plain - 1.0).abs() < 1e-12);
        }
    }
}
