//! The lights of a scene. Directions point towards the light, except a spot's, which points where it shines.

mod check;
mod facing;
mod file;
mod sky;
mod sun;

pub(super) use file::LightFile;
pub use sky::Sky;

use super::files::Files;
use super::range::Checked;
use glam::DVec3;
use std::path::Path;

/// A validated light: every number finite, every amount at least 0.
#[derive(Debug, Clone, PartialEq)]
pub struct Light {
    /// The kind of light, with its position and emission.
    pub source: Source,
    /// Whether objects cast shadows in its light; unused for an environment, which has `occlusion`.
    pub shadows: bool,
}

/// A kind of light, with its position and emission.
#[derive(Debug, Clone, PartialEq)]
pub enum Source {
    /// A light infinitely far away, such as the sun.
    Directional {
        /// Towards the light, length 1.
        direction: DVec3,
        /// Irradiance on a plane perpendicular to the direction, r g b, at least 0.
        irradiance: [f64; 3],
    },
    /// A point light with the same intensity in all directions.
    Point {
        /// Position, in scene units.
        position: DVec3,
        /// Intensity in W/sr, r g b, at least 0; falls off with the squared distance in scene units.
        intensity: [f64; 3],
    },
    /// A point light that shines into a cone.
    Spot {
        /// Position, in scene units.
        position: DVec3,
        /// The axis of the cone, away from the light, length 1.
        direction: DVec3,
        /// Intensity within the inner cone in W/sr, r g b, at least 0.
        intensity: [f64; 3],
        /// Angle to the axis up to which intensity is full, degrees, from 0 to 0.95 times `outer`.
        inner: f64,
        /// Angle to the axis from which intensity is 0, degrees, 1 to 90. In between it is multiplied by 3 t^2 - 2 t^3,
        /// t = (cos - cos outer) / (cos inner - cos outer).
        outer: f64,
    },
    /// A rectangle of constant radiance, as a grid of samples.
    Area {
        /// Its centre, in scene units.
        position: DVec3,
        /// One side, in scene units.
        edge_u: DVec3,
        /// The other; it shines to the side of `edge_u` x `edge_v`.
        edge_v: DVec3,
        /// Radiance, r g b, at least 0.
        radiance: [f64; 3],
        /// Whether it also shines to the other side.
        two_sided: bool,
        /// Samples along each side, 1 to 64.
        samples: u32,
    },
    /// Light from all around, infinitely far away.
    Environment {
        /// The radiance from every direction.
        sky: Sky,
        /// Occlusion rays per face, spread over the sphere; 0 for no occlusion.
        occlusion: u32,
    },
}

impl Light {
    /// Maximum number of samples of all lights of a scene together: some drivers end longer loops.
    pub const MOST_SAMPLES: usize = 16384;

    /// A light infinitely far away, with shadows; `direction` has length 1.
    pub fn directional(direction: DVec3, irradiance: [f64; 3]) -> Self {
        Self { source: Source::Directional { direction, irradiance }, shadows: true }
    }

    /// A light at a point, with shadows.
    pub fn point(position: DVec3, intensity: [f64; 3]) -> Self {
        Self { source: Source::Point { position, intensity }, shadows: true }
    }

    /// Positions in scene units: of an area light, the centres of its samples; none for a light infinitely far away.
    pub fn places(&self) -> Vec<DVec3> {
        match &self.source {
            Source::Directional { .. } | Source::Environment { .. } => Vec::new(),
            Source::Point { position, .. } | Source::Spot { position, .. } => vec![*position],
            Source::Area { position, edge_u, edge_v, samples, .. } => {
                let middle = |i: u32| (f64::from(i) + 0.5) / f64::from(*samples) - 0.5;
                let place = |i: u32, j: u32| *position + *edge_u * middle(i) + *edge_v * middle(j);
                (0..*samples).flat_map(|j| (0..*samples).map(move |i| place(i, j))).collect()
            }
        }
    }

    /// Number of samples: light records per face, and rays per face where there are shadows.
    pub fn samples(&self) -> usize {
        match &self.source {
            Source::Area { samples, .. } => (*samples as usize).pow(2),
            Source::Environment { occlusion, .. } => *occlusion as usize,
            _ => 1,
        }
    }

    /// Its colour: the irradiance, intensity or radiance of its brightest part.
    pub fn color(&self) -> [f64; 3] {
        match &self.source {
            Source::Directional { irradiance, .. } => *irradiance,
            Source::Point { intensity, .. } | Source::Spot { intensity, .. } => *intensity,
            Source::Area { radiance, .. } => *radiance,
            Source::Environment { sky, .. } => sky.brightest(),
        }
    }

    /// Reads its files, relative to `folder`; it is light number `index` of the scene.
    pub(super) fn load(&mut self, files: &Files, folder: &Path, index: usize, report: &mut Vec<String>) -> Checked<()> {
        match &mut self.source {
            Source::Environment { sky, .. } => sky.load(files, folder, &format!("light.{index}"), report),
            _ => Ok(()),
        }
    }

    /// Whether channel `c` is `ratio` times channel `lead` everywhere, within `slack`.
    pub fn proportional(&self, c: usize, lead: usize, ratio: f64, slack: f64) -> bool {
        let holds = |color: [f64; 3]| (color[c] - ratio * color[lead]).abs() <= slack;
        match &self.source {
            Source::Environment { sky, .. } => {
                let factor = sky.factor;
                sky.pixels.iter().all(|pixel| holds(std::array::from_fn(|c| f64::from(pixel[c]) * factor[c])))
            }
            _ => holds(self.color()),
        }
    }
}

#[cfg(test)]
mod tests;
