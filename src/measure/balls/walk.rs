//! Random walks in balls: light from +z, uniform over the disc that a ball shows it, or constant light.

use std::f64::consts::PI;

use glam::DVec3;

use crate::error::Result;
use crate::measure::bodies::{Estimate, Lighting, Walks, ball};
use crate::scene::Mesh;
use crate::shading::balls::{ANGLES, Curve};

/// Subdivision of the balls: triangles two degrees wide.
const DETAIL: u32 = 5;

/// The walk in balls of radius 1 that have the media of balls of these radii.
fn scaled<'a>(walks: &Walks<'a>, radii: [f64; 3]) -> Walks<'a> {
    let mut media = walks.media;
    media.iter_mut().zip(radii).for_each(|(medium, radius)| *medium = medium.scaled(radius));
    Walks { media, ..*walks }
}

/// Centroid and area of a triangle.
fn measured(mesh: &Mesh, face: usize) -> (DVec3, f64) {
    let [a, b, c] = mesh.corners(face).unwrap_or_default();
    ((a + b + c) / 3.0, 0.5 * (b - a).cross(c - a).length())
}

/// Light that leaves balls of these radii, one a channel, relative to `flat`, the light that leaves a plane under
/// normal incidence. All light that meets the ball enters; what passes straight through is left out.
pub fn curves(walks: &Walks<'_>, radii: [f64; 3], flat: [f64; 3]) -> Result<[Curve; 3]> {
    let mesh = ball(DETAIL)?;
    let faces: Vec<(DVec3, f64)> = (0..mesh.triangles.len()).map(|face| measured(&mesh, face)).collect();
    let enters = |face: usize| faces[face].0.normalize().z.max(0.0);
    let left = scaled(walks, radii).leave(&mesh, Lighting::Collimated, enters)?;
    let total: f64 = faces.iter().enumerate().map(|(face, (_, area))| area * enters(face)).sum();
    let bin = |face: usize| {
        let angle = faces[face].0.normalize().z.clamp(-1.0, 1.0).acos();
        ((angle / PI * ANGLES as f64) as usize).min(ANGLES - 1)
    };
    let mut areas = [0.0; ANGLES];
    faces.iter().enumerate().for_each(|(face, (_, area))| areas[bin(face)] += area);
    Ok([0, 1, 2].map(|c| {
        let own = |k: usize| (left.through(c, |face| bin(face) == k), total / (areas[k] * flat[c]));
        let all: Vec<(Estimate, f64)> = (0..ANGLES).map(own).collect();
        Curve {
            radius: radii[c],
            values: all.iter().map(|(share, scale)| share.mean * scale).collect(),
            errors: all.iter().map(|(share, scale)| share.error * scale).collect(),
        }
    }))
}

/// Share of the entering light that leaves balls of these radii, one a channel, under the same radiance from every
/// direction, without what passes straight through.
pub fn constant(walks: &Walks<'_>, radii: [f64; 3]) -> Result<[Estimate; 3]> {
    let left = scaled(walks, radii).leave(&ball(DETAIL)?, Lighting::Constant, |_| 1.0)?;
    Ok([0, 1, 2].map(|c| left.through(c, |_| true)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::measure::bodies::Medium;

    #[test]
    #[ignore = "slow: part of the full suite, `cargo test --release -- --include-ignored`"]
    fn without_absorption_all_light_leaves() {
        let medium = |scattering: f64| Medium { scattering, absorption: 0.0, eta: 1.4 };
        let walks = Walks { device: None, media: [2.0, 8.0, 1.0].map(medium), photons: 3000, seed: 7 };
        let radii = [15.0, 4.0, 0.01];
        let found = constant(&walks, radii).unwrap();
        // The third ball is clear: nearly all light passes straight through.
        assert!(found[..2].iter().all(|one| one.mean > 0.98) && found[2].mean < 0.1, "{found:?}");
        let balls = curves(&walks, radii, [1.0, 0.5, 1.0]).unwrap();
        let edge = |k: usize| (PI * k as f64 / ANGLES as f64).cos();
        let sum = |c: usize| (0..ANGLES).map(|k| balls[c].values[k] * 2.0 * (edge(k) - edge(k + 1))).sum::<f64>();
        assert!((sum(0) - 1.0).abs() < 0.01 && (sum(1) - 2.0).abs() < 0.02, "{} {}", sum(0), sum(1));
        // Red and green are balls of thirty free paths: bright towards the light, dim behind.
        for ball in &balls[..2] {
            assert!(ball.values[0] > 3.0 * ball.values[ANGLES - 1] && ball.errors[0] > 0.0);
        }
        assert!(balls == curves(&walks, radii, [1.0, 0.5, 1.0]).unwrap());
        assert!(balls != curves(&Walks { seed: 8, ..walks }, radii, [1.0, 0.5, 1.0]).unwrap());
    }
}
