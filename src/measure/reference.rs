//! Brute force in `f64` with near-exact form factors at a few receivers: what every method's error is measured against.

use glam::DVec3;
use rayon::prelude::*;

use crate::layout::Slot;
use crate::error::Result;
use crate::measure::norms::{Norms, norms};
use crate::render::run::Session;
use crate::state::{Distance, State, wide};
use crate::transport::form_factor::exact::edge_form_exact;
use crate::transport::form_factor::ladder::chi;
use crate::transport::form_factor::points::{midpoint_moment, trace};
use crate::transport::profile::Dipole;

/// chi below which one sample with its second moment is exact enough (its relative error is about chi^2).
const FAR: f64 = 1e-4;

/// Seeded faces, in rising order: `count` different ones, or all there are.
pub fn sample(faces: usize, count: usize, seed: u64) -> Vec<usize> {
    let mut state = seed;
    let mut next = || {
        state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    };
    if count >= faces {
        return (0..faces).collect();
    }
    let mut chosen = std::collections::BTreeSet::new();
    while chosen.len() < count {
        chosen.insert((next() % faces as u64) as usize);
    }
    chosen.into_iter().collect()
}

/// Radiosity at the centroids of these faces of a state whose irradiance is known.
pub fn radiosity(state: &State, faces: &[usize]) -> Vec<[f64; 3]> {
    let data = &state.data;
    let dipoles = [0, 1, 2].map(|channel| Dipole::of(&data.frame[0], channel));
    let distance = match state.distance {
        Distance::Radial => crate::transport::form_factor::Distance::Radial,
        Distance::Table1 => crate::transport::form_factor::Distance::Table1 { clamp: true },
    };
    let corners = |face: usize| data.triangles[face].map(|v| wide(data.positions[v as usize]));
    let emitters: Vec<([DVec3; 3], f64)> = (0..data.triangles.len())
        .map(|face| {
            let triangle = corners(face);
            (triangle, trace(&triangle))
        })
        .collect();
    faces
        .par_iter()
        .map(|&receiver| {
            let x = corners(receiver).iter().sum::<DVec3>() / 3.0;
            let mut sum = [0.0; 3];
            for (face, (triangle, tau)) in emitters.iter().enumerate() {
                let light = data.irradiance[face];
                let d2 = x.distance_squared(triangle.iter().sum::<DVec3>() / 3.0);
                for (channel, dipole) in dipoles.iter().enumerate().filter(|(channel, _)| light[*channel] != 0.0) {
                    let nearest = if state.distance == Distance::Radial {
                        (d2 + dipole.z_real * dipole.z_real).sqrt()
                    } else {
                        (d2.sqrt() - dipole.z_virtual).max(dipole.z_real)
                    };
                    let far = chi(*tau, dipole.sigma, nearest) < FAR;
                    let factor = if far {
                        midpoint_moment(triangle, x, dipole, distance)
                    } else {
                        edge_form_exact(triangle, data.triangles[face], x, dipole, distance)
                    };
                    sum[channel] += f64::from(light[channel]) * factor;
                }
            }
            sum
        })
        .collect()
}

/// The error of a session's last frame at `count` seeded receivers, per channel.
pub fn verify(session: &mut Session, count: usize, seed: u64) -> Result<[Norms; 3]> {
    session.fetch(&[Slot::irradiance, Slot::radiosity, Slot::clusters])?;
    let state = session.state();
    let faces = sample(state.data.triangles.len(), count, seed);
    let reference = radiosity(state, &faces);
    let area = |&face: &usize| f64::from(state.data.clusters[state.data.leaves[face] as usize].area);
    let areas: Vec<f64> = faces.iter().map(area).collect();
    let values: Vec<[f64; 3]> = faces.iter().map(|&face| state.data.radiosity[face].map(f64::from)).collect();
    Ok(norms(&areas, &values, &reference))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sample_is_seeded_and_has_no_repeats() {
        let a = sample(1000, 100, 7);
        assert_eq!(a, sample(1000, 100, 7));
        assert_ne!(a, sample(1000, 100, 8));
        assert!(a.windows(2).all(|w| w[0] < w[1]) && a.len() == 100);
        assert_eq!(sample(5, 100, 7), vec![0, 1, 2, 3, 4]);
    }
}
